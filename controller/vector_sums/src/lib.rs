//! Sums in independent lanes, of one length whatever the processor: the compiler makes vector
//! instructions of what it has, and the bits are the same on every machine.
#![forbid(unsafe_code)]
// The same bits on every machine: no function of the platform's mathematical library.
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

/// Lanes of a sum.
const LANES: usize = 8;

/// Inner product.
#[must_use]
#[inline(always)]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a_chunks, b_chunks) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest = a_chunks.remainder().iter().zip(b_chunks.remainder());
    let mut sums = [0.0; LANES];
    for (a, b) in a_chunks.zip(b_chunks) {
        for l in 0..LANES {
            sums[l] += a[l] * b[l];
        }
    }
    rest.fold(total(sums), |sum, (a, b)| sum + a * b)
}

/// Inner products of one vector with several at once, which are no shorter.
#[must_use]
#[inline(always)]
pub fn dots<const K: usize>(a: &[f64], columns: [&[f64]; K]) -> [f64; K] {
    const NARROW: usize = 4;
    let (blocks, rest) = a.as_chunks::<NARROW>();
    let (mut blocks_of, mut rest_of) = ([&[][..]; K], [&[][..]; K]);
    for k in 0..K {
        let (blocks_k, rest_k) = columns[k][..a.len()].as_chunks::<NARROW>();
        blocks_of[k] = &blocks_k[..blocks.len()];
        rest_of[k] = rest_k;
    }
    let mut sums = [[0.0; NARROW]; K];
    for (at, a) in blocks.iter().enumerate() {
        for k in 0..K {
            let (mut sum, b) = (sums[k], blocks_of[k][at]);
            for l in 0..NARROW {
                sum[l] += a[l] * b[l];
            }
            sums[k] = sum;
        }
    }
    let mut found = [0.0; K];
    for k in 0..K {
        let [a, b, c, d] = sums[k];
        let rest = rest.iter().zip(rest_of[k]);
        found[k] = rest.fold((a + c) + (b + d), |sum, (a, b)| sum + a * b);
    }
    found
}

/// Sum.
#[must_use]
#[inline(always)]
pub fn sum(values: &[f64]) -> f64 {
    let chunks = values.chunks_exact(LANES);
    let rest = chunks.remainder().iter();
    let mut sums = [0.0; LANES];
    for values in chunks {
        for l in 0..LANES {
            sums[l] += values[l];
        }
    }
    rest.fold(total(sums), |sum, value| sum + value)
}

/// 0 if all values are finite, and NaN otherwise: a factor of 0 leaves 0 of what is finite.
#[must_use]
#[inline(always)]
pub fn naught(values: &[f64]) -> f64 {
    const NARROW: usize = 4;
    let chunks = values.chunks_exact(NARROW);
    let rest: f64 = chunks.remainder().iter().map(|value| value * 0.0).sum();
    let mut sums = [0.0; NARROW];
    for values in chunks {
        for l in 0..NARROW {
            sums[l] += values[l] * 0.0;
        }
    }
    rest + (sums[0] + sums[1]) + (sums[2] + sums[3])
}

/// Sum of the lanes, half to half.
#[inline(always)]
fn total(sums: [f64; LANES]) -> f64 {
    let four: [f64; 4] = std::array::from_fn(|l| sums[l] + sums[l + 4]);
    let two = [four[0] + four[2], four[1] + four[3]];
    two[0] + two[1]
}
