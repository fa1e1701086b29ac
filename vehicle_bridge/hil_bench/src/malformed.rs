//! Datagrams no LCM sender makes: what a receiver has to survive.

use super::wire::fragment as part_of;

/// What is wrong, and the datagrams.
pub type MalformedMessage = (&'static str, Vec<Vec<u8>>);

/// A datagram of a short message: number, and what follows it.
#[must_use]
pub fn short(sequence: u32, rest: &[u8]) -> Vec<u8> {
    [b"LC02", &sequence.to_be_bytes()[..], rest].concat()
}

/// A fragment: number and size of its message, its offset, which of how many it is, its content.
#[must_use]
pub fn fragment(
    sequence: u32,
    size: u32,
    offset: u32,
    number: u16,
    count: u16,
    rest: &[u8],
) -> Vec<u8> {
    part_of(sequence, (size, offset), (number, count), rest)
}

/// All cases, those with a channel on `channel`. None of them holds a whole message.
#[must_use]
pub fn cases(channel: &str) -> Vec<MalformedMessage> {
    let part = |text: &str| text.as_bytes().to_vec();
    let head = |rest: &str| [channel, rest].concat().into_bytes();
    let other = |magic: &[u8]| [magic, b"\0\0\0\x01", &head("\0payload")].concat();
    let first = |size, rest: &[u8]| fragment(9, size, 0, 0, 2, rest);
    vec![
        ("no byte at all", vec![vec![]]),
        ("one byte", vec![part("L")]),
        ("the magic alone", vec![part("LC02")]),
        ("a cut header", vec![part("LC02\0\0\0")]),
        ("a header and no channel", vec![short(1, b"")]),
        ("a channel without its end", vec![short(1, &head(""))]),
        ("a long channel without its end", vec![short(1, &[b'A'; 200])]),
        ("64 kB of channel without its end", vec![short(1, &[b'A'; 65_000])]),
        ("an empty channel", vec![short(1, b"\0payload")]),
        ("a channel of 64 bytes", vec![short(1, &[&[b'A'; 64][..], b"\0payload"].concat())]),
        ("a channel that is not UTF-8", vec![short(1, b"\xff\xfe\0payload")]),
        ("a channel with a line break", vec![short(1, &head("\n\0payload"))]),
        ("another magic", vec![other(b"LC04")]),
        ("the magic backwards", vec![other(b"20CL")]),
        ("a cut fragment header", vec![part("LC03\0\0\0\x01\0\0\0\x05\0\0\0\0\0\0\0")]),
        ("a message of 4 GiB", vec![first(u32::MAX, &head("\0part"))]),
        ("a message above the limit", vec![first((1 << 20) + 1, &head("\0part"))]),
        ("no fragments", vec![fragment(9, 8, 0, 0, 0, &head("\0part"))]),
        ("a fragment beyond the last", vec![fragment(9, 8, 0, 2, 2, b"part")]),
        ("65,535 fragments", vec![fragment(9, 1 << 20, 0, 0, u16::MAX, &head("\0part"))]),
        (
            "a part behind the end",
            vec![first(8, &head("\0part")), fragment(9, 8, 9, 1, 2, b"part")],
        ),
        ("an offset that wraps", vec![fragment(9, 8, u32::MAX, 1, 2, b"part")]),
        ("a first fragment without a channel's end", vec![first(8, &head(""))]),
        ("a message of no byte with a part", vec![fragment(9, 0, 0, 0, 1, &head("\0part"))]),
        ("a part twice, another never", vec![first(8, &head("\0part")), first(8, &head("\0part"))]),
        (
            "parts one over the other",
            vec![
                fragment(10, 12, 0, 0, 3, &head("\0part")),
                fragment(10, 12, 4, 1, 3, b"part"),
                fragment(10, 12, 4, 2, 3, b"part"),
            ],
        ),
        (
            "sizes at odds",
            vec![fragment(11, 8, 0, 0, 2, &head("\0part")), fragment(11, 9, 4, 1, 2, b"part")],
        ),
        (
            "counts at odds",
            vec![fragment(12, 8, 0, 0, 2, &head("\0part")), fragment(12, 8, 4, 1, 3, b"part")],
        ),
    ]
}
