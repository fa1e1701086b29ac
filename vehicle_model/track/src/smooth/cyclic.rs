//! Cholesky factor of a banded matrix whose band closes on itself around the corners.
//!
//! The rows are kept from their first entry that may differ from zero up to the diagonal. The
//! last rows, which the corners fill, are kept whole; all others are as long as the band.

/// The last rows of a factor fade away from the corners. Entries below this are zero: they change no
/// result, and processors take a hundred times as long over numbers below 1e-308.
const LEAST: f64 = 1e-200;

/// The value, or zero if it is below all that counts.
fn cut(value: f64) -> f64 {
    if value.abs() < LEAST { 0.0 } else { value }
}

/// A symmetric positive definite matrix, or its factor.
pub(super) struct Cyclic {
    /// Row i from its first column to i.
    rows: Vec<Vec<f64>>,
    /// Entries reach this far from the diagonal, counted around the corners.
    band: usize,
}

impl Cyclic {
    /// The zero matrix of n rows, whose entries stay within `band` of the diagonal, counted
    /// around the corners.
    pub(super) fn zero(n: usize, band: usize) -> Self {
        let first = |i: usize| if i + band >= n { 0 } else { i.saturating_sub(band) };
        Self { rows: (0..n).map(|i| vec![0.0; i + 1 - first(i)]).collect(), band }
    }

    /// First column of row i.
    fn first(&self, i: usize) -> usize {
        i + 1 - self.rows[i].len()
    }

    /// Adds to the entry (i, j) and its mirror image; i and j at most `band` apart.
    pub(super) fn add(&mut self, i: usize, j: usize, value: f64) {
        let (row, column) = (i.max(j), i.min(j));
        let first = self.first(row);
        self.rows[row][column - first] += value;
    }

    /// The factor L of L L' = self.
    pub(super) fn factor(mut self) -> Self {
        for i in 0..self.rows.len() {
            let (done, rest) = self.rows.split_at_mut(i);
            let row = &mut rest[0];
            let first = i + 1 - row.len();
            for j in first..i {
                let above = &done[j];
                let start = first.max(j + 1 - above.len());
                let offset = start + above.len() - (j + 1);
                let product: f64 = row[start - first..j - first]
                    .iter()
                    .zip(&above[offset..])
                    .map(|(a, b)| a * b)
                    .sum();
                row[j - first] = cut((row[j - first] - product) / above[above.len() - 1]);
            }
            let square: f64 = row[..i - first].iter().map(|a| a * a).sum();
            row[i - first] = (row[i - first] - square).sqrt();
        }
        self
    }

    /// Solution of L L' z = b, in place of b.
    pub(super) fn solve(&self, b: &mut [f64]) {
        for (i, row) in self.rows.iter().enumerate() {
            let first = self.first(i);
            let (before, diagonal) = row.split_at(i - first);
            let product: f64 = before.iter().zip(&b[first..i]).map(|(a, z)| a * z).sum();
            b[i] = (b[i] - product) / diagonal[0];
        }
        for (i, row) in self.rows.iter().enumerate().rev() {
            let first = self.first(i);
            let (before, diagonal) = row.split_at(i - first);
            let z = b[i] / diagonal[0];
            b[i] = z;
            for (target, a) in b[first..i].iter_mut().zip(before) {
                *target -= a * z;
            }
        }
    }

    /// Of the inverse of L L', the entries where L may differ from zero (Takahashi, Fagan and
    /// Chen, 1973).
    pub(super) fn inverse(&self) -> Self {
        let n = self.rows.len();
        let mut z = Self::zero(n, self.band);
        let mut below = Vec::with_capacity(2 * self.band);
        for j in (0..n).rev() {
            below.clear();
            let corners = n.saturating_sub(self.band).max(j + 1);
            below.extend((j + 1..(j + 1 + self.band).min(corners)).chain(corners..n));
            let diagonal = self.entry(j, j);
            let mut own = 1.0 / diagonal;
            for &i in &below {
                let product: f64 = below.iter().map(|&k| z.entry(i, k) * self.entry(k, j)).sum();
                z.add(i, j, cut(-product / diagonal));
                own += product / diagonal * self.entry(i, j);
            }
            z.add(j, j, own / diagonal);
        }
        z
    }

    /// The entry (i, j).
    pub(super) fn entry(&self, i: usize, j: usize) -> f64 {
        let (row, column) = (i.max(j), i.min(j));
        let first = self.first(row);
        if column < first { 0.0 } else { self.rows[row][column - first] }
    }
}

#[cfg(test)]
mod tests {
    use super::Cyclic;

    #[test]
    fn the_solution_satisfies_the_equations() {
        let (n, band) = (23, 3);
        let fill = || {
            let mut a = Cyclic::zero(n, band);
            for i in 0..n {
                a.add(i, i, 9.0 + i as f64);
                for d in 1..=band {
                    a.add(i, (i + d) % n, 0.3 * d as f64 - 0.1 * (i % 4) as f64);
                }
            }
            a
        };
        let a = fill();
        assert!(a.entry(0, n - 2) != 0.0, "the corners are filled");
        let b: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        let mut z = b.clone();
        fill().factor().solve(&mut z);
        for (i, b) in b.iter().enumerate() {
            let product: f64 = z.iter().enumerate().map(|(j, z)| a.entry(i, j) * z).sum();
            assert!((product - b).abs() < 1e-12, "row {i}: {product} {b}");
        }
        let inverse = fill().factor().inverse();
        for j in 0..n {
            let mut column = vec![0.0; n];
            column[j] = 1.0;
            fill().factor().solve(&mut column);
            for d in 0..=band {
                let i = (j + d) % n;
                let error = inverse.entry(i, j) - column[i];
                assert!(error.abs() < 1e-13, "({i}, {j}): {error}");
            }
        }
    }
    #[test]
    fn what_fades_from_the_corners_ends_at_zero() {
        let n = 3000;
        let mut a = Cyclic::zero(n, 2);
        for i in 0..n {
            a.add(i, i, 3.0);
            a.add(i, (i + 1) % n, -0.9);
            a.add(i, (i + 2) % n, 0.2);
        }
        let factor = a.factor();
        let inverse = factor.inverse();
        for entry in factor.rows.iter().chain(&inverse.rows).flatten() {
            assert!(*entry == 0.0 || entry.is_normal(), "{entry:e}");
        }
    }
}
