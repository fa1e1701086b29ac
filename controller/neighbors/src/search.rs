//! The search in the tree: depth first, the nearest box first, within a reach that shrinks.

use super::{Below, LEAF, Leaf, Node, Point, Tree, WIDTH};

/// Points more than asked for that a search holds before it drops the farthest.
const SPARE: usize = 40;
/// Up to this many surplus points are removed one at a time; beyond it a partial selection is faster.
const FEW: usize = 6;

/// Points of a leaf that are compared at once.
const BLOCK: usize = 8;

/// A neighbour as one number: the bits of its squared distance, which order as what is not
/// negative does, then its index.
type Neighbor = u64;

#[inline(always)]
fn neighbor(squared: f32, index: u32) -> Neighbor {
    (Neighbor::from(squared.to_bits()) << u32::BITS) | Neighbor::from(index)
}

/// Neighbours found, and the memory of the search.
#[derive(Debug, Clone, Default)]
pub struct Found {
    /// Boxes yet to be looked into, with their squared distances.
    open: Vec<(f32, Below)>,
    /// The nearest points so far, and some that may turn out not to be.
    near: Vec<Neighbor>,
    indices: Vec<u32>,
}

impl Found {
    /// Room for `count` neighbours.
    #[must_use]
    pub fn new(count: usize) -> Self {
        Self {
            open: Vec::with_capacity(512),
            near: Vec::with_capacity(count + SPARE + LEAF),
            indices: Vec::with_capacity(count),
        }
    }

    /// Finds the `count` nearest points with a squared distance of at most `limit`.
    #[inline(always)]
    pub fn nearest(&mut self, tree: &Tree, query: &Point, count: usize, limit: f32) {
        // Points farther than this are none of the nearest; ties are broken by index at last.
        let mut reach = limit;
        self.near.clear();
        self.open.clear();
        self.open.extend(tree.nodes.first().map(|_| (0.0, Below::Node(0))));
        while let Some((distance, below)) = self.open.pop() {
            if distance > reach {
                continue;
            }
            match below {
                Below::Leaf(leaf) => {
                    self.take(&tree.leaves[leaf as usize], query, reach);
                    if self.near.len() > count + SPARE {
                        reach = self.keep(count);
                    }
                }
                Below::Node(node) => self.note(&tree.nodes[node as usize], query, reach),
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
    #[must_use]
    pub fn indices(&self) -> &[u32] {
        &self.indices
    }

    /// Notes the boxes of a node that are within reach, the nearest on top: what it holds may spare
    /// the others. Branch-free: every entry is written, and the length advances only if it is near.
    #[inline(always)]
    fn note(&mut self, node: &Node, query: &Point, reach: f32) {
        let mut len = self.open.len();
        let (mut least, mut top) = (f32::INFINITY, len);
        self.open.resize(len + WIDTH, (0.0, Below::Leaf(0)));
        for (squared, below) in node.distances(query).iter().zip(&node.below).take(node.len) {
            self.open[len] = (*squared, *below);
            (least, top) = if *squared < least { (*squared, len) } else { (least, top) };
            len += usize::from(*squared <= reach);
        }
        self.open.truncate(len);
        if top + 1 < len {
            self.open.swap(top, len - 1);
        }
    }

    /// Takes the points of a leaf that are within reach, likewise.
    #[inline(always)]
    fn take(&mut self, leaf: &Leaf, query: &Point, reach: f32) {
        let squared = leaf.distances(query);
        let (blocks, _) = squared.as_chunks::<BLOCK>();
        let (indices, _) = leaf.indices.as_chunks::<BLOCK>();
        let mut free = leaf.len;
        for (squared, indices) in blocks.iter().zip(indices) {
            // One by one only those that are near: of most leaves a few. Two bits each: of single ones the
            // compiler makes no vector instructions, as the first of them would be the comparison itself.
            let mut near = 0_u32;
            for (i, squared) in squared.iter().enumerate() {
                near |= if *squared <= reach { 3 << (2 * i) } else { 0 };
            }
            // Free places are infinitely far away, and so may be the reach.
            near &= (1 << (2 * free.min(BLOCK))) - 1;
            free = free.saturating_sub(BLOCK);
            while near != 0 {
                let i = near.trailing_zeros() as usize / 2 % BLOCK;
                self.near.push(neighbor(squared[i], indices[i]));
                near &= near - 1;
                near &= near - 1;
            }
        }
    }

    /// Keeps the `count` nearest points; returns the squared distance of the farthest of them.
    fn keep(&mut self, count: usize) -> f32 {
        let (_, farthest, _) = self.near.select_nth_unstable(count - 1);
        let reach = f32::from_bits((*farthest >> u32::BITS) as u32);
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
