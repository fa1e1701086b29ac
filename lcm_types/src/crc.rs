//! The checksum LCM lacks: CRC-32 (IEEE 802.3, as zlib computes it) in a message's last field.

use crate::Error;

/// Bytes the checksum takes: an `int32_t`. \[B\]
pub const SIZE: usize = 4;

/// CRC-32 of `bytes`, equal to Python's `zlib.crc32`.
///
/// ```
/// assert_eq!(lcm_types::crc::of(b"123456789"), 0xcbf4_3926); // the check value of the standard
/// ```
#[must_use]
pub fn of(bytes: &[u8]) -> u32 {
    crc32fast::hash(bytes)
}

/// The number by which both ends of a network name a thing with this fingerprint (a track, a car):
/// the CRC-32 of its little-endian bytes.
#[must_use]
pub fn id(fingerprint: u64) -> i64 {
    of(&fingerprint.to_le_bytes()).into()
}

/// Writes the checksum of all bytes before them into the last four bytes.
pub fn seal(bytes: &mut [u8]) {
    if let Some((body, end)) = bytes.split_last_chunk_mut::<SIZE>() {
        *end = of(body).to_be_bytes();
    }
}

/// Checks the last four bytes against all bytes before them; `name` is for the error.
///
/// # Errors
/// [`Error::Short`] below four bytes, [`Error::Crc`] if the checksum does not fit.
pub fn check(name: &'static str, bytes: &[u8]) -> Result<(), Error> {
    let Some((body, end)) = bytes.split_last_chunk::<SIZE>() else {
        return Err(Error::Short {
            field: name.into(),
            offset: 0,
            needed: SIZE,
            left: bytes.len(),
        });
    };
    let (found, expected) = (u32::from_be_bytes(*end), of(body));
    if found == expected { Ok(()) } else { Err(Error::Crc { name, found, expected }) }
}
