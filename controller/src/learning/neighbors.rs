//! Exact nearest neighbours in the regression's space: a balanced k-d tree in flat arrays.
//!
//! Built once when a lap closes; a query allocates nothing. Same result as a linear scan,
//! ties broken by index.

/// Dimensions: v_x, v_y, omega_z, a, delta, scaled by the square root of the metric.
pub(crate) const DIMENSIONS: usize = 5;
/// Ranges of this size are scanned.
const LEAF: usize = 8;

/// A point of the tree.
pub(crate) type Point = [f64; DIMENSIONS];

/// A neighbour: squared distance and the index given at construction.
pub(crate) type Neighbor = (f64, u32);

/// Balanced tree: the median of a range splits it, left below, right above.
#[derive(Debug, Clone, Default)]
pub(crate) struct Tree {
    points: Vec<(Point, u32)>,
    /// Axis split at each median.
    axes: Vec<u8>,
}

impl Tree {
    /// A tree of all points.
    pub(crate) fn new(points: impl Iterator<Item = Point>) -> Self {
        let mut points: Vec<(Point, u32)> = points.zip(0..).collect();
        let mut axes = vec![0; points.len()];
        split(&mut points, &mut axes);
        Self { points, axes }
    }

    /// The `count` nearest points with squared distance below `limit`, into `found`, in no
    /// particular order.
    pub(crate) fn nearest(
        &self,
        query: &Point,
        count: usize,
        limit: f64,
        found: &mut Vec<Neighbor>,
    ) {
        found.clear();
        let mut search = Search { query, count, limit, found };
        search.range(&self.points, &self.axes);
        // A fixed order makes sums over neighbours reproducible.
        found.sort_unstable_by(order);
    }
}

fn order(a: &Neighbor, b: &Neighbor) -> std::cmp::Ordering {
    a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
}

fn split(points: &mut [(Point, u32)], axes: &mut [u8]) {
    if points.len() <= LEAF {
        return;
    }
    let axis = widest(points);
    let middle = points.len() / 2;
    points
        .select_nth_unstable_by(middle, |a, b| a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1)));
    // DIMENSIONS fits any integer.
    axes[middle] = axis as u8;
    let (below, rest) = points.split_at_mut(middle);
    let (axes_below, axes_rest) = axes.split_at_mut(middle);
    split(below, axes_below);
    split(&mut rest[1..], &mut axes_rest[1..]);
}

/// Axis along which the points spread most.
fn widest(points: &[(Point, u32)]) -> usize {
    let spread = |axis: usize| {
        let values = points.iter().map(|p| p.0[axis]);
        let (low, high) = values
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        high - low
    };
    (0..DIMENSIONS).max_by(|&a, &b| spread(a).total_cmp(&spread(b))).unwrap_or(0)
}

/// A search in progress; `found` is a heap with the farthest neighbour on top.
struct Search<'a> {
    query: &'a Point,
    count: usize,
    limit: f64,
    found: &'a mut Vec<Neighbor>,
}

impl Search<'_> {
    fn range(&mut self, points: &[(Point, u32)], axes: &[u8]) {
        if points.len() <= LEAF {
            for point in points {
                self.consider(point);
            }
            return;
        }
        let middle = points.len() / 2;
        let axis = usize::from(axes[middle]);
        let difference = self.query[axis] - points[middle].0[axis];
        let below = (&points[..middle], &axes[..middle]);
        let above = (&points[middle + 1..], &axes[middle + 1..]);
        let (near, far) = if difference < 0.0 { (below, above) } else { (above, below) };
        self.range(near.0, near.1);
        self.consider(&points[middle]);
        // `<=` keeps points as far as the farthest in play: ties are broken by index.
        if difference * difference <= self.reach() {
            self.range(far.0, far.1);
        }
    }

    /// Squared distance beyond which no point can enter.
    fn reach(&self) -> f64 {
        if self.found.len() < self.count { self.limit } else { self.found[0].0 }
    }

    fn consider(&mut self, point: &(Point, u32)) {
        let squared: f64 = point.0.iter().zip(self.query).map(|(p, q)| (p - q) * (p - q)).sum();
        let candidate = (squared, point.1);
        if squared >= self.limit {
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
        for n in [0, 1, 7, 9, 100, 1000] {
            // Coarse values make ties likely.
            let points: Vec<Point> = (0..n)
                .map(|_| [(); DIMENSIONS].map(|()| f64::from(rng.random_range(0..6)) * 0.5))
                .collect();
            let tree = Tree::new(points.iter().copied());
            for count in [1, 5, 40] {
                for limit in [0.3, 2.0, f64::INFINITY] {
                    let query = [(); DIMENSIONS].map(|()| rng.random_range(0.0..3.0));
                    let mut scan: Vec<Neighbor> = points
                        .iter()
                        .zip(0..)
                        .map(|(p, i)| {
                            (p.iter().zip(&query).map(|(p, q)| (p - q) * (p - q)).sum(), i)
                        })
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
