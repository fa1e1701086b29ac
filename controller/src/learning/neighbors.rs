//! Exact nearest neighbours in the regression's space: a k-d tree with leaves of points side by
//! side and a box around the points of every node.
//!
//! It grows lap by lap: a point goes down to its leaf, and a full leaf is split at its median. The
//! boxes prune, not the splitting planes: laps lie close together, most of the space is empty, and
//! where the car is faster than ever the query itself lies in the empty part. A query allocates
//! nothing. Same result as a linear scan, ties broken by index, whatever the shape of the tree.

/// Dimensions: v_x, v_y, omega_z, a, delta, scaled by the square root of the metric.
pub(crate) const DIMENSIONS: usize = 5;
/// Points of a leaf.
const LEAF: usize = 32;
/// Points more than asked for that a search holds before it drops the farthest.
const SPARE: usize = 16;
/// Points too many that are dropped one by one, which is faster than to select the others.
const FEW: usize = 6;

/// A point of the tree.
pub(crate) type Point = [f64; DIMENSIONS];

/// A neighbour as one number: the bits of its squared distance, which order as what is not
/// negative does, then its index.
type Neighbor = u128;

#[inline(always)]
fn neighbor(squared: f64, index: u32) -> Neighbor {
    (Neighbor::from(squared.to_bits()) << u32::BITS) | Neighbor::from(index)
}

/// The tree; the root is the first node, siblings are adjacent.
#[derive(Debug, Clone, Default)]
pub(crate) struct Tree {
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
    len: u32,
}

#[derive(Debug, Clone)]
struct Node {
    low: Point,
    high: Point,
    below: Below,
}

/// What is below a node.
#[derive(Debug, Clone, Copy)]
enum Below {
    Leaf {
        leaf: u32,
    },
    /// The first of two children; points below `value` go to it.
    Split {
        first: u32,
        axis: u8,
        value: f64,
    },
}

/// Points by axis; unused places are infinitely far away.
#[derive(Debug, Clone)]
struct Leaf {
    points: [[f64; LEAF]; DIMENSIONS],
    indices: [u32; LEAF],
    len: usize,
}

impl Node {
    fn over(leaf: u32) -> Self {
        let (low, high) = ([f64::INFINITY; DIMENSIONS], [f64::NEG_INFINITY; DIMENSIONS]);
        Self { low, high, below: Below::Leaf { leaf } }
    }

    fn include(&mut self, point: &Point) {
        for ((low, high), p) in self.low.iter_mut().zip(&mut self.high).zip(point) {
            *low = low.min(*p);
            *high = high.max(*p);
        }
    }

    /// Squared distance to the box. Rounded like that to a point and summed in the same order,
    /// it is never greater than that to a point inside.
    #[inline(always)]
    fn distance(&self, query: &Point) -> f64 {
        let mut squared = 0.0;
        for ((low, high), q) in self.low.iter().zip(&self.high).zip(query) {
            let (under, over) = (low - q, q - high);
            let gap = if under > over { under } else { over };
            let gap = if gap > 0.0 { gap } else { 0.0 };
            squared += gap * gap;
        }
        squared
    }

    /// Axis along which the points spread most.
    fn widest(&self) -> usize {
        let spread = |axis: usize| self.high[axis] - self.low[axis];
        (0..DIMENSIONS).max_by(|&a, &b| spread(a).total_cmp(&spread(b))).unwrap_or(0)
    }
}

impl Leaf {
    fn new() -> Self {
        Self { points: [[f64::INFINITY; LEAF]; DIMENSIONS], indices: [0; LEAF], len: 0 }
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
    fn distances(&self, query: &Point) -> [f64; LEAF] {
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
    /// Adds points; their indices go on from those of the points before.
    pub(crate) fn extend(&mut self, points: &[Point]) {
        if self.nodes.is_empty() {
            self.nodes.push(Node::over(0));
            self.leaves.push(Leaf::new());
        }
        // In leaps through the lap: points in the order they were driven would make a lopsided
        // tree.
        let n = points.len();
        let leap = (1..=n).find(|leap| 5 * leap >= 3 * n && coprime(*leap, n)).unwrap_or(1);
        let mut i = 0;
        for _ in 0..n {
            // The number of samples fits: 4e9 are more than memory holds.
            self.insert(&points[i], self.len + i as u32);
            i = (i + leap) % n;
        }
        self.len += n as u32;
    }

    fn insert(&mut self, point: &Point, index: u32) {
        let mut at = 0;
        loop {
            let node = &mut self.nodes[at];
            node.include(point);
            match node.below {
                Below::Split { first, axis, value } => {
                    at = first as usize + usize::from(point[usize::from(axis)] >= value);
                }
                Below::Leaf { leaf } if self.leaves[leaf as usize].len < LEAF => {
                    return self.leaves[leaf as usize].push(point, index);
                }
                Below::Leaf { leaf } => self.split(at, leaf as usize),
            }
        }
    }

    /// Turns a full leaf into two half-full ones.
    fn split(&mut self, at: usize, leaf: usize) {
        let axis = self.nodes[at].widest();
        let full = std::mem::replace(&mut self.leaves[leaf], Leaf::new());
        let mut order: [usize; LEAF] = std::array::from_fn(|i| i);
        let value = |i: usize| full.points[axis][i];
        order.sort_unstable_by(|&i, &j| {
            value(i).total_cmp(&value(j)).then(full.indices[i].cmp(&full.indices[j]))
        });
        let first = self.nodes.len() as u32;
        let other = self.leaves.len() as u32;
        self.leaves.push(Leaf::new());
        for (leaf, half) in [(leaf as u32, &order[..LEAF / 2]), (other, &order[LEAF / 2..])] {
            let mut node = Node::over(leaf);
            for &i in half {
                node.include(&full.point(i));
                self.leaves[leaf as usize].push(&full.point(i), full.indices[i]);
            }
            self.nodes.push(node);
        }
        // DIMENSIONS fits any integer.
        let value = value(order[LEAF / 2]);
        self.nodes[at].below = Below::Split { first, axis: axis as u8, value };
    }
}

/// Squared distance of two points, summed as the tree sums it.
#[inline(always)]
pub(crate) fn squared_distance(a: &Point, b: &Point) -> f64 {
    a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + (a - b) * (a - b))
}

fn coprime(a: usize, b: usize) -> bool {
    if b == 0 { a == 1 } else { coprime(b, a % b) }
}

/// Neighbours found, and the memory of the search.
#[derive(Debug, Clone, Default)]
pub(crate) struct Found {
    /// Nodes yet to be looked into, with the squared distances of their boxes.
    open: Vec<(f64, u32)>,
    /// The nearest points so far, and some that may turn out not to be.
    near: Vec<Neighbor>,
    indices: Vec<u32>,
}

impl Found {
    /// Room for `count` neighbours.
    pub(crate) fn new(count: usize) -> Self {
        Self {
            open: Vec::with_capacity(128),
            near: Vec::with_capacity(count + SPARE + LEAF),
            indices: Vec::with_capacity(count),
        }
    }

    /// Finds the `count` nearest points with a squared distance of at most `limit`.
    #[inline(always)]
    pub(crate) fn nearest(&mut self, tree: &Tree, query: &Point, count: usize, limit: f64) {
        // Points farther than this are none of the nearest; ties are broken by index at last.
        let mut reach = limit;
        self.near.clear();
        self.open.clear();
        self.open.extend(tree.nodes.first().map(|_| (0.0, 0)));
        while let Some((distance, at)) = self.open.pop() {
            if distance > reach {
                continue;
            }
            match tree.nodes[at as usize].below {
                Below::Leaf { leaf } => {
                    self.take(&tree.leaves[leaf as usize], query, reach);
                    if self.near.len() > count + SPARE {
                        reach = self.keep(count);
                    }
                }
                Below::Split { first, .. } => {
                    let children = [0, 1].map(|i| {
                        let child = first + i;
                        (tree.nodes[child as usize].distance(query), child)
                    });
                    // The nearer one on top: what it holds may spare the other.
                    let [a, b] = children;
                    self.open.extend(if b.0 < a.0 { [a, b] } else { [b, a] });
                }
            }
        }
        if self.near.len() > count + FEW {
            self.keep(count);
        }
        self.drop_farthest(count);
        self.indices.clear();
        // The low bits are the index.
        self.indices.extend(self.near.iter().map(|neighbor| *neighbor as u32));
        // A fixed order makes sums over neighbours reproducible.
        self.indices.sort_unstable();
    }

    /// Indices of the neighbours, in rising order.
    pub(crate) fn indices(&self) -> &[u32] {
        &self.indices
    }

    /// Takes the points of a leaf that are within reach.
    #[inline(always)]
    fn take(&mut self, leaf: &Leaf, query: &Point, reach: f64) {
        let squared = leaf.distances(query);
        // One by one only where there is any.
        let near = squared.iter().fold(0, |near, squared| near + u32::from(*squared <= reach));
        if near == 0 {
            return;
        }
        for (squared, index) in squared.iter().zip(&leaf.indices).take(leaf.len) {
            if *squared <= reach {
                self.near.push(neighbor(*squared, *index));
            }
        }
    }

    /// Keeps the `count` nearest points; returns the squared distance of the farthest of them.
    fn keep(&mut self, count: usize) -> f64 {
        let (_, farthest, _) = self.near.select_nth_unstable(count - 1);
        let reach = f64::from_bits((*farthest >> u32::BITS) as u64);
        self.near.truncate(count);
        reach
    }

    /// Drops the farthest points until `count` are left: where they are few.
    #[inline(always)]
    fn drop_farthest(&mut self, count: usize) {
        while self.near.len() > count {
            let (mut farthest, mut at) = (0, 0);
            for (i, neighbor) in self.near.iter().enumerate() {
                if *neighbor > farthest {
                    (farthest, at) = (*neighbor, i);
                }
            }
            self.near.swap_remove(at);
        }
    }
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
            let points: Vec<Point> = (0..n)
                .map(|_| [(); DIMENSIONS].map(|()| f64::from(rng.random_range(0..6)) * 0.5))
                .collect();
            let mut tree = Tree::default();
            // In parts, as laps come.
            for part in points.chunks(1 + n / 3) {
                tree.extend(part);
            }
            for count in [1, 5, 40] {
                for limit in [0.3, 2.0, f64::INFINITY] {
                    let query = [(); DIMENSIONS].map(|()| rng.random_range(0.0..3.0));
                    let mut scan: Vec<(f64, u32)> = points
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
