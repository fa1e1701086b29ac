//! Numbers of a seed: a run can be repeated.

use rand::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64;

/// Where the numbers come from.
pub(super) type Random = Pcg64;

/// The numbers of a seed.
pub(super) fn of(seed: u64) -> Random {
    Pcg64::seed_from_u64(seed)
}

/// Bytes.
pub(super) fn bytes(random: &mut Random, count: usize) -> Vec<u8> {
    let mut bytes = vec![0; count];
    random.fill_bytes(&mut bytes);
    bytes
}
