//! A number that tells two tracks apart: FNV-1a (Fowler, Noll, Vo; 64 bit) over the bits of
//! what a track is made of. Computed positions have no part in it: sines differ in their last bit
//! between platforms.

/// FNV-1a, 64 bit, fed with floating-point numbers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fnv1a(u64);

impl Fnv1a {
    /// The hash of nothing.
    pub(super) fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    /// The hash with these numbers behind what it holds.
    pub(super) fn with(mut self, values: &[f64]) -> Self {
        for value in values {
            // + 0.0 makes the two zeros one.
            for byte in (value + 0.0).to_bits().to_le_bytes() {
                self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
            }
        }
        self
    }

    /// The hash of all numbers so far.
    pub(super) fn finish(self) -> u64 {
        self.0
    }
}
