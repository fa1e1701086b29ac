//! Products of small matrices, column by column: the inner loop runs down a column, so that it
//! becomes vector instructions of whatever width the caller is compiled for. Multiplications and
//! additions stay apart: the result has the same bits on every processor.

use nalgebra::{ArrayStorage, SMatrix};

/// A B.
#[expect(clippy::needless_range_loop, reason = "an iterator that skips the first is not unrolled")]
#[inline(always)]
pub(super) fn product<const R: usize, const K: usize, const C: usize>(
    a: &SMatrix<f64, R, K>,
    b: &SMatrix<f64, K, C>,
) -> SMatrix<f64, R, C> {
    let mut out = [[0.0; R]; C];
    for (out, b) in out.iter_mut().zip(&b.data.0) {
        // The first one is not added to zeros: that would be an addition more.
        let mut sum = [0.0; R];
        for r in 0..R {
            sum[r] = a.data.0[0][r] * b[0];
        }
        for k in 1..K {
            for r in 0..R {
                sum[r] += a.data.0[k][r] * b[k];
            }
        }
        *out = sum;
    }
    SMatrix::from_array_storage(ArrayStorage(out))
}

/// A'.
#[inline(always)]
pub(super) fn transpose<const R: usize, const C: usize>(
    a: &SMatrix<f64, R, C>,
) -> SMatrix<f64, C, R> {
    let columns = &a.data.0;
    let out = std::array::from_fn(|r| std::array::from_fn(|c| columns[c][r]));
    SMatrix::from_array_storage(ArrayStorage(out))
}
