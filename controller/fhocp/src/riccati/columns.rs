//! Loops over arrays in blocks of one length whatever the processor: the compiler makes vector instructions
//! of what it has.

/// Numbers that are computed at once.
const LANES: usize = 4;

/// Sets each number of `out` to a function of the numbers at the same place of all of `of`, which are no
/// shorter.
#[inline(always)]
pub(super) fn each<const I: usize>(out: &mut [f64], of: [&[f64]; I], f: impl Fn([f64; I]) -> f64) {
    let count = out.len();
    let (blocks, rest) = out.as_chunks_mut::<LANES>();
    let mut blocks_of = [&[][..]; I];
    let mut rest_of = [&[][..]; I];
    for i in 0..I {
        let (blocks_i, rest_i) = of[i][..count].as_chunks::<LANES>();
        blocks_of[i] = &blocks_i[..blocks.len()];
        rest_of[i] = &rest_i[..rest.len()];
    }
    for (at, out) in blocks.iter_mut().enumerate() {
        let mut block = [[0.0; LANES]; I];
        for i in 0..I {
            block[i] = blocks_of[i][at];
        }
        for lane in 0..LANES {
            let mut values = [0.0; I];
            for i in 0..I {
                values[i] = block[i][lane];
            }
            out[lane] = f(values);
        }
    }
    for (at, out) in rest.iter_mut().enumerate() {
        let mut values = [0.0; I];
        for i in 0..I {
            values[i] = rest_of[i][at];
        }
        *out = f(values);
    }
}

/// Greatest magnitude, or `least`.
#[inline(always)]
pub(super) fn greatest(values: &[f64], least: f64) -> f64 {
    let (blocks, rest) = values.as_chunks::<LANES>();
    let mut most = [least; LANES];
    for block in blocks {
        for (most, value) in most.iter_mut().zip(block) {
            *most = if value.abs() > *most { value.abs() } else { *most };
        }
    }
    most.iter().chain(rest).fold(least, |a, b| if b.abs() > a { b.abs() } else { a })
}
