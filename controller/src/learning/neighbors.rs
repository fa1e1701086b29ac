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

/// A point of the tree.
pub(crate) type Point = [f64; DIMENSIONS];

/// A neighbour: squared distance and the index given at construction.
pub(crate) type Neighbor = (f64, u32);

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
    fn distance(&self, query: &Point) -> f64 {
        let mut squared = 0.0;
        for ((low, high), q) in self.low.iter().zip(&self.high).zip(query) {
            let gap = (low - q).max(q - high).max(0.0);
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

    /// The `count` nearest points with squared distance below `limit`, into `found`, nearest
    /// first.
    pub(crate) fn nearest(
        &self,
        query: &Point,
        count: usize,
        limit: f64,
        found: &mut Vec<Neighbor>,
    ) {
        found.clear();
        if let Some(root) = self.nodes.first() {
            Search { tree: self, query, count, limit, found }.below(root);
        }
        // A fixed order makes sums over neighbours reproducible.
        found.sort_unstable_by(order);
    }
}

/// Squared distance of two points, summed as the tree sums it.
pub(crate) fn squared_distance(a: &Point, b: &Point) -> f64 {
    a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + (a - b) * (a - b))
}

fn coprime(a: usize, b: usize) -> bool {
    if b == 0 { a == 1 } else { coprime(b, a % b) }
}

fn order(a: &Neighbor, b: &Neighbor) -> std::cmp::Ordering {
    a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
}

/// A search in progress; `found` is a heap with the farthest neighbour on top.
struct Search<'a> {
    tree: &'a Tree,
    query: &'a Point,
    count: usize,
    limit: f64,
    found: &'a mut Vec<Neighbor>,
}

impl Search<'_> {
    fn below(&mut self, node: &Node) {
        let tree = self.tree;
        match node.below {
            Below::Leaf { leaf } => self.leaf(&tree.leaves[leaf as usize]),
            Below::Split { first, .. } => {
                let [a, b] = [0, 1].map(|i| &tree.nodes[first as usize + i]);
                let (mut near, mut far) =
                    ((a.distance(self.query), a), (b.distance(self.query), b));
                if far.0 < near.0 {
                    (near, far) = (far, near);
                }
                for (distance, node) in [near, far] {
                    // `<=` keeps points as far as the farthest in play: ties are broken by index.
                    if distance <= self.reach() {
                        self.below(node);
                    }
                }
            }
        }
    }

    /// Squared distance beyond which no point can enter.
    fn reach(&self) -> f64 {
        if self.found.len() < self.count { self.limit } else { self.found[0].0 }
    }

    fn leaf(&mut self, leaf: &Leaf) {
        let distances = leaf.distances(self.query);
        for (squared, index) in distances.into_iter().zip(leaf.indices).take(leaf.len) {
            if squared <= self.reach() {
                self.consider((squared, index));
            }
        }
    }

    fn consider(&mut self, candidate: Neighbor) {
        if candidate.0 >= self.limit {
            return;
        }
        if self.found.len() < self.count {
            self.found.push(candidate);
            self.rise();
        } else if order(&candidate, &self.found[0]).is_lt() {
            self.found[0] = candidate;
            self.sink();
        }
    }

    fn rise(&mut self) {
        let mut i = self.found.len() - 1;
        while i > 0 {
            let parent = (i - 1) / 2;
            if order(&self.found[i], &self.found[parent]).is_le() {
                break;
            }
            self.found.swap(i, parent);
            i = parent;
        }
    }

    fn sink(&mut self) {
        let (mut i, n) = (0, self.found.len());
        loop {
            let left = 2 * i + 1;
            if left >= n {
                break;
            }
            let right = left + 1;
            let child = if right < n && order(&self.found[right], &self.found[left]).is_gt() {
                right
            } else {
                left
            };
            if order(&self.found[child], &self.found[i]).is_le() {
                break;
            }
            self.found.swap(i, child);
            i = child;
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
                    let mut scan: Vec<Neighbor> = points
                        .iter()
                        .zip(0..)
                        .map(|(p, i)| (squared_distance(p, &query), i))
                        .filter(|(squared, _)| *squared < limit)
                        .collect();
                    scan.sort_unstable_by(order);
                    scan.truncate(count);
                    let mut found = Vec::new();
                    tree.nearest(&query, count, limit, &mut found);
                    assert_eq!(found, scan);
                }
            }
        }
    }
}
