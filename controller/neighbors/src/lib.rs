//! Exact nearest neighbours in the regression's space: a tree of boxes with leaves of points side by
//! side. The boxes below a node lie side by side too, for the lanes of the processor's vectors.
//!
//! It grows lap by lap: a point goes down to the leaf whose box is nearest, and a full leaf is split
//! at its median. Laps lie close together and most of the space is empty; where the car is faster
//! than ever the query itself lies in the empty part. A query allocates nothing. Same result as a
//! linear scan, ties broken by index, whatever the shape of the tree.
//!
//! Points have single precision: with a thousand laps a search is as fast as its memory, and two
//! samples whose distances agree to 1e-6 are as good as each other.
#![forbid(unsafe_code)]
// The same bits on every machine: no function of the platform's mathematical library.
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod search;

use std::ops::{Add, Mul, Sub};

pub use search::Found;

/// Dimensions: v_x, v_y, omega_z, a, delta, scaled by the square root of the metric.
pub const DIMENSIONS: usize = 5;
/// Points of a leaf.
const LEAF: usize = 48;
/// Boxes below a node.
const WIDTH: usize = 8;

/// A point of the tree.
pub type Point = [f32; DIMENSIONS];

/// The tree; the root is the first node.
#[derive(Debug, Clone, Default)]
pub struct Tree {
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
    len: u32,
}

/// Boxes by axis, and what is in them; unused places have none.
#[derive(Debug, Clone)]
struct Node {
    low: [[f32; WIDTH]; DIMENSIONS],
    high: [[f32; WIDTH]; DIMENSIONS],
    below: [Below; WIDTH],
    len: usize,
}

/// What is in a box.
#[derive(Debug, Clone, Copy)]
enum Below {
    Leaf(u32),
    Node(u32),
}

/// Points by axis; unused places are infinitely far away.
#[derive(Debug, Clone)]
struct Leaf {
    points: [[f32; LEAF]; DIMENSIONS],
    indices: [u32; LEAF],
    len: usize,
}

impl Node {
    fn new() -> Self {
        Self {
            low: [[f32::INFINITY; WIDTH]; DIMENSIONS],
            high: [[f32::NEG_INFINITY; WIDTH]; DIMENSIONS],
            below: [Below::Leaf(0); WIDTH],
            len: 0,
        }
    }

    fn push(&mut self, below: Below) -> usize {
        self.below[self.len] = below;
        self.len += 1;
        self.len - 1
    }

    fn include(&mut self, place: usize, point: &Point) {
        for ((low, high), p) in self.low.iter_mut().zip(&mut self.high).zip(point) {
            low[place] = low[place].min(*p);
            high[place] = high[place].max(*p);
        }
    }

    /// Makes the box that of these points alone.
    fn enclose(&mut self, place: usize, leaf: &Leaf) {
        for (low, high) in self.low.iter_mut().zip(&mut self.high) {
            (low[place], high[place]) = (f32::INFINITY, f32::NEG_INFINITY);
        }
        (0..leaf.len).for_each(|i| self.include(place, &leaf.point(i)));
    }

    /// Squared distances to the boxes. Rounded like those to points and summed in the same order,
    /// they are never greater than those to the points inside.
    #[inline(always)]
    fn distances(&self, query: &Point) -> [f32; WIDTH] {
        let mut squared = [0.0; WIDTH];
        for ((low, high), q) in self.low.iter().zip(&self.high).zip(query) {
            for ((sum, low), high) in squared.iter_mut().zip(low).zip(high) {
                let (under, over) = (low - q, q - high);
                let gap = if under > over { under } else { over };
                let gap = if gap > 0.0 { gap } else { 0.0 };
                *sum += gap * gap;
            }
        }
        squared
    }

    /// The box nearest to a point.
    fn nearest(&self, point: &Point) -> usize {
        let squared = self.distances(point);
        (0..self.len).min_by(|&i, &j| squared[i].total_cmp(&squared[j])).unwrap_or(0)
    }

    /// Axis along which a box is longest.
    fn longest(&self, place: usize) -> usize {
        let length = |axis: usize| self.high[axis][place] - self.low[axis][place];
        (0..DIMENSIONS).max_by(|&a, &b| length(a).total_cmp(&length(b))).unwrap_or(0)
    }
}

impl Leaf {
    fn new() -> Self {
        Self { points: [[f32::INFINITY; LEAF]; DIMENSIONS], indices: [0; LEAF], len: 0 }
    }

    fn point(&self, i: usize) -> Point {
        std::array::from_fn(|axis| self.points[axis][i])
    }

    fn push(&mut self, point: &Point, index: u32) {
        for (axis, p) in self.points.iter_mut().zip(point) {
            axis[self.len] = *p;
        }
        self.indices[self.len] = index;
        self.len += 1;
    }

    /// Squared distances of all places, free ones infinite.
    #[inline(always)]
    fn distances(&self, query: &Point) -> [f32; LEAF] {
        let mut squared = [0.0; LEAF];
        for (axis, q) in self.points.iter().zip(query) {
            for (sum, p) in squared.iter_mut().zip(axis) {
                *sum += (p - q) * (p - q);
            }
        }
        squared
    }
}

impl Tree {
    /// Adds a point; its index is the number of points before it.
    pub fn push(&mut self, point: &Point) {
        if self.nodes.is_empty() {
            let mut root = Node::new();
            root.push(Below::Leaf(0));
            self.nodes.push(root);
            self.leaves.push(Leaf::new());
        }
        self.insert(point, self.len);
        // The number of samples fits: 4e9 are more than memory holds.
        self.len += 1;
    }

    fn insert(&mut self, point: &Point, index: u32) {
        let mut at = 0;
        loop {
            let node = &mut self.nodes[at];
            let place = node.nearest(point);
            node.include(place, point);
            match node.below[place] {
                Below::Node(below) => at = below as usize,
                Below::Leaf(leaf) if self.leaves[leaf as usize].len < LEAF => {
                    return self.leaves[leaf as usize].push(point, index);
                }
                Below::Leaf(leaf) => self.split(at, place, leaf),
            }
        }
    }

    /// Turns a full leaf into two half-full ones: side by side, or in a node of their own where
    /// this one is full.
    fn split(&mut self, at: usize, place: usize, leaf: u32) {
        let axis = self.nodes[at].longest(place);
        let full = std::mem::replace(&mut self.leaves[leaf as usize], Leaf::new());
        let mut order: [usize; LEAF] = std::array::from_fn(|i| i);
        let value = |i: usize| full.points[axis][i];
        order.sort_unstable_by(|&i, &j| {
            value(i).total_cmp(&value(j)).then(full.indices[i].cmp(&full.indices[j]))
        });
        let other = self.leaves.len() as u32;
        self.leaves.push(Leaf::new());
        for (leaf, half) in [(leaf, &order[..LEAF / 2]), (other, &order[LEAF / 2..])] {
            for &i in half {
                self.leaves[leaf as usize].push(&full.point(i), full.indices[i]);
            }
        }
        let (at, place) = if self.nodes[at].len < WIDTH {
            (at, place)
        } else {
            let below = self.nodes.len();
            let mut node = Node::new();
            node.push(Below::Leaf(leaf));
            self.nodes[at].below[place] = Below::Node(below as u32);
            self.nodes.push(node);
            (below, 0)
        };
        let node = &mut self.nodes[at];
        node.enclose(place, &self.leaves[leaf as usize]);
        let beside = node.push(Below::Leaf(other));
        node.enclose(beside, &self.leaves[other as usize]);
    }
}

/// Squared distance of two points, summed as the tree sums it.
#[must_use]
#[inline(always)]
pub fn squared_distance<T>(a: &[T; DIMENSIONS], b: &[T; DIMENSIONS]) -> T
where
    T: Copy + Default + Add<Output = T> + Sub<Output = T> + Mul<Output = T>,
{
    a.iter().zip(b).fold(T::default(), |sum, (a, b)| sum + (*a - *b) * (*a - *b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn same_neighbors_as_a_linear_scan() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(1);
        let mut found = Found::new(5);
        for n in [0, 1, 7, 33, 100, 1000, 5000] {
            // Coarse values make ties likely.
            let mut coarse = || 0.5 * f32::from(rng.random_range(0..6_u8));
            let points: Vec<Point> = (0..n).map(|_| [(); DIMENSIONS].map(|()| coarse())).collect();
            let mut tree = Tree::default();
            points.iter().for_each(|point| tree.push(point));
            for count in [1, 5, 40] {
                for limit in [0.3, 2.0, f32::INFINITY] {
                    let query = [(); DIMENSIONS].map(|()| rng.random_range(0.0..3.0));
                    let mut scan: Vec<(f32, u32)> = points
                        .iter()
                        .zip(0..)
                        .map(|(p, i)| (squared_distance(p, &query), i))
                        .filter(|(squared, _)| *squared <= limit)
                        .collect();
                    scan.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                    scan.truncate(count);
                    let mut indices: Vec<u32> = scan.iter().map(|(_, i)| *i).collect();
                    indices.sort_unstable();
                    found.nearest(&tree, &query, count, limit);
                    assert_eq!(found.indices(), indices);
                }
            }
        }
    }
}
