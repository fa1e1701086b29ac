//! The two kinds of LCM datagrams, big-endian.
//!
//! Short: `LC02`, sequence (u32), channel, NUL, message.
//! Fragment: `LC03`, sequence (u32), size of the message (u32), offset of this part (u32), number of
//! this fragment (u16), number of fragments (u16), in fragment 0 channel and NUL, part.

use lcm_types::channels;

const SHORT: [u8; 4] = *b"LC02";
const FRAGMENT: [u8; 4] = *b"LC03";
const SHORT_HEADER: usize = 8;
const FRAGMENT_HEADER: usize = 20;

/// Largest channel, NUL and message of a short datagram, as liblcm sends them. \[B\]
pub(super) const MAX_SHORT: usize = 65_499;
/// Largest part of a fragment, as liblcm sends them; in fragment 0 channel and NUL included. \[B\]
pub(super) const MAX_PART: usize = 65_487;

/// A datagram of the right shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Datagram<'a> {
    Short { sequence: u32, channel: &'a str, payload: &'a [u8] },
    Fragment(Fragment<'a>),
}

/// A part of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Fragment<'a> {
    pub(super) sequence: u32,
    /// Of the whole message.
    pub(super) size: u32,
    pub(super) offset: u32,
    pub(super) number: u16,
    /// Fragments of the message.
    pub(super) count: u16,
    /// In fragment 0.
    pub(super) channel: Option<&'a str>,
    pub(super) part: &'a [u8],
}

/// Reads a datagram; `None` if it has not the shape of one.
pub(super) fn parse(bytes: &[u8]) -> Option<Datagram<'_>> {
    let (magic, rest) = bytes.split_first_chunk()?;
    let (sequence, rest) = u32_of(rest)?;
    match *magic {
        SHORT => {
            let (channel, payload) = channel_of(rest)?;
            Some(Datagram::Short { sequence, channel, payload })
        }
        FRAGMENT => {
            let (size, rest) = u32_of(rest)?;
            let (offset, rest) = u32_of(rest)?;
            let (number, rest) = u16_of(rest)?;
            let (count, rest) = u16_of(rest)?;
            let (channel, part) = match number {
                0 => channel_of(rest).map(|(channel, part)| (Some(channel), part))?,
                _ => (None, rest),
            };
            let end = u64::from(offset) + part.len() as u64;
            let possible = number < count && end <= u64::from(size);
            let fragment = Fragment { sequence, size, offset, number, count, channel, part };
            possible.then_some(Datagram::Fragment(fragment))
        }
        _ => None,
    }
}

fn u32_of(bytes: &[u8]) -> Option<(u32, &[u8])> {
    bytes.split_first_chunk().map(|(word, rest)| (u32::from_be_bytes(*word), rest))
}

fn u16_of(bytes: &[u8]) -> Option<(u16, &[u8])> {
    bytes.split_first_chunk().map(|(word, rest)| (u16::from_be_bytes(*word), rest))
}

/// The channel up to its NUL, and what follows.
fn channel_of(bytes: &[u8]) -> Option<(&str, &[u8])> {
    let window = &bytes[..bytes.len().min(channels::MAX_LENGTH + 1)];
    let end = window.iter().position(|byte| *byte == 0)?;
    let channel = std::str::from_utf8(&bytes[..end]).ok()?;
    channels::is_valid(channel).then_some((channel, &bytes[end + 1..]))
}

/// Header of a short datagram.
pub(super) fn short_header(sequence: u32) -> [u8; SHORT_HEADER] {
    let mut header = [0; SHORT_HEADER];
    header[..4].copy_from_slice(&SHORT);
    header[4..].copy_from_slice(&sequence.to_be_bytes());
    header
}

/// Header of a fragment.
pub(super) fn fragment_header(fragment: &Fragment<'_>) -> [u8; FRAGMENT_HEADER] {
    let mut header = [0; FRAGMENT_HEADER];
    header[..4].copy_from_slice(&FRAGMENT);
    header[4..8].copy_from_slice(&fragment.sequence.to_be_bytes());
    header[8..12].copy_from_slice(&fragment.size.to_be_bytes());
    header[12..16].copy_from_slice(&fragment.offset.to_be_bytes());
    header[16..18].copy_from_slice(&fragment.number.to_be_bytes());
    header[18..].copy_from_slice(&fragment.count.to_be_bytes());
    header
}

/// Cuts a message into fragments as liblcm does; the channel and its NUL count in fragment 0.
pub(super) fn fragments<'a>(
    sequence: u32,
    channel: &'a str,
    payload: &'a [u8],
) -> impl Iterator<Item = Fragment<'a>> {
    let first = (MAX_PART - channel.len() - 1).min(payload.len());
    let rest = payload.len() - first;
    // A message is at most 1 MiB: sizes and counts fit their fields.
    let count = u16::try_from(1 + rest.div_ceil(MAX_PART)).unwrap_or(u16::MAX);
    let size = u32::try_from(payload.len()).unwrap_or(u32::MAX);
    (0..count).map(move |number| {
        let start = match number {
            0 => 0,
            n => first + (usize::from(n) - 1) * MAX_PART,
        };
        let end = if number == 0 { first } else { (start + MAX_PART).min(payload.len()) };
        Fragment {
            sequence,
            size,
            offset: u32::try_from(start).unwrap_or(u32::MAX),
            number,
            count,
            channel: (number == 0).then_some(channel),
            part: &payload[start..end],
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_datagram_is_read() {
        let bytes = [&short_header(7)[..], b"CH\0abc"].concat();
        let expected = Datagram::Short { sequence: 7, channel: "CH", payload: b"abc" };
        assert_eq!(parse(&bytes), Some(expected));
    }

    #[test]
    fn fragments_hold_the_message_and_are_read() {
        for size in [65_485, 65_486, 130_971, 130_972, 1 << 20] {
            let payload: Vec<u8> = (0..size).map(|i| (i % 251) as u8).collect();
            let mut joined = Vec::new();
            for fragment in fragments(9, "CH", &payload) {
                let channel: &[u8] = if fragment.channel.is_some() { b"CH\0" } else { b"" };
                let bytes = [&fragment_header(&fragment)[..], channel, fragment.part].concat();
                assert!(bytes.len() <= FRAGMENT_HEADER + MAX_PART);
                assert_eq!(parse(&bytes), Some(Datagram::Fragment(fragment)));
                assert_eq!(fragment.offset as usize, joined.len());
                joined.extend_from_slice(fragment.part);
            }
            assert_eq!(joined, payload);
        }
    }

    #[test]
    fn any_bytes_are_a_datagram_or_none() {
        use rand::{RngExt, SeedableRng};
        let mut rng = rand_pcg::Pcg64::seed_from_u64(1);
        let mut read = 0;
        for _ in 0..200_000 {
            let size = rng.random_range(0..80);
            let mut bytes: Vec<u8> = (0..size).map(|_| rng.random_range(0..8) * 31).collect();
            let magic = [SHORT, FRAGMENT][rng.random_range(0..2)];
            let end = bytes.len().min(4);
            bytes[..end].copy_from_slice(&magic[..end]);
            read += usize::from(parse(&bytes).is_some());
        }
        assert!(read > 1000, "{read}");
    }
}
