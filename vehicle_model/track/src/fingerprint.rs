//! A number that tells two cars or two tracks apart: FNV-1a (Fowler, Noll, Vo; 64 bit) over the
//! bits of what they are made of. Computed values have no part in it: sines differ in their last
//! bit between platforms.

/// Hash of several numbers in their order, such as the fingerprints of a car and a track.
#[must_use]
pub fn fingerprint(words: &[u64]) -> u64 {
    let mut hash = Fnv1a::new();
    for word in words {
        hash.write(*word);
    }
    hash.finish()
}

/// FNV-1a, 64 bit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fnv1a(u64);

impl Fnv1a {
    /// The hash of nothing.
    pub(crate) fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    /// Takes a word behind what it holds.
    pub(crate) fn write(&mut self, word: u64) {
        for byte in word.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }

    /// The hash with these numbers behind what it holds.
    pub(crate) fn with(mut self, values: &[f64]) -> Self {
        for value in values {
            // + 0.0 makes the two zeros one.
            self.write((value + 0.0).to_bits());
        }
        self
    }

    /// The hash of all so far.
    pub(crate) fn finish(self) -> u64 {
        self.0
    }
}
