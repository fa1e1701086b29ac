//! FNV-1a, 64 bit: guards saved states against damage and derives tokens. Not cryptographic.

const OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
const PRIME: u64 = 0x0000_0100_0000_01b3;

/// FNV-1a hash of a byte string (Fowler, Noll, Vo).
#[must_use]
pub(crate) fn fnv1a(bytes: &[u8]) -> u64 {
    fnv1a_from(OFFSET, bytes)
}

fn fnv1a_from(start: u64, bytes: &[u8]) -> u64 {
    bytes.iter().fold(start, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(PRIME))
}

/// A GUID that depends on every byte: two hashes with different starts, in the usual form.
#[must_use]
pub(crate) fn guid(bytes: &[u8]) -> String {
    let (high, low) = (fnv1a(bytes), fnv1a_from(!OFFSET, bytes));
    let text = format!("{high:016x}{low:016x}");
    let part = |a: usize, b: usize| &text[a..b];
    format!("{{{}-{}-{}-{}-{}}}", part(0, 8), part(8, 12), part(12, 16), part(16, 20), part(20, 32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matches_the_published_test_vectors() {
        assert_eq!(fnv1a(b""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(fnv1a(b"a"), 0xaf63_dc4c_8601_ec8c);
        assert_eq!(fnv1a(b"foobar"), 0x8594_4171_f739_67e8);
    }
}
