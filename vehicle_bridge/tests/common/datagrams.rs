//! Datagrams no LCM sender makes.
#![allow(dead_code, reason = "not every test sends them")]

use std::net::{Ipv4Addr, UdpSocket};

const GROUP: (Ipv4Addr, u16) = (Ipv4Addr::new(239, 255, 76, 67), 7667);

pub(crate) fn short(sequence: u32, rest: &[u8]) -> Vec<u8> {
    [b"LC02", &sequence.to_be_bytes()[..], rest].concat()
}

pub(crate) fn fragment(
    sequence: u32,
    size: u32,
    offset: u32,
    number: u16,
    count: u16,
    rest: &[u8],
) -> Vec<u8> {
    let (size, offset) = (size.to_be_bytes(), offset.to_be_bytes());
    let (number, count) = (number.to_be_bytes(), count.to_be_bytes());
    [b"LC03", &sequence.to_be_bytes()[..], &size, &offset, &number, &count, rest].concat()
}

/// Each case: what is wrong, and the datagrams. None of them holds a whole message.
pub(crate) fn cases() -> Vec<(&'static str, Vec<Vec<u8>>)> {
    let part = |text: &str| text.as_bytes().to_vec();
    let first = |size, rest: &str| fragment(9, size, 0, 0, 2, &part(rest));
    vec![
        ("no byte at all", vec![vec![]]),
        ("one byte", vec![part("L")]),
        ("the magic alone", vec![part("LC02")]),
        ("a cut header", vec![part("LC02\0\0\0")]),
        ("a header and no channel", vec![short(1, b"")]),
        ("a channel without its end", vec![short(1, b"CMD")]),
        ("a long channel without its end", vec![short(1, &[b'A'; 200])]),
        ("64 kB of channel without its end", vec![short(1, &[b'A'; 65_000])]),
        ("an empty channel", vec![short(1, b"\0payload")]),
        ("a channel of 64 bytes", vec![short(1, &[&[b'A'; 64][..], b"\0payload"].concat())]),
        ("a channel that is not UTF-8", vec![short(1, b"\xff\xfe\0payload")]),
        ("a channel with a line break", vec![short(1, b"CMD\n\0payload")]),
        ("another magic", vec![part("LC04\0\0\0\x01CMD\0payload")]),
        ("the magic backwards", vec![part("20CL\0\0\0\x01CMD\0payload")]),
        ("a cut fragment header", vec![part("LC03\0\0\0\x01\0\0\0\x05\0\0\0\0\0\0\0")]),
        ("a message of 4 GiB", vec![first(u32::MAX, "CMD\0part")]),
        ("a message above the limit", vec![first((1 << 20) + 1, "CMD\0part")]),
        ("no fragments", vec![fragment(9, 8, 0, 0, 0, b"CMD\0part")]),
        ("a fragment beyond the last", vec![fragment(9, 8, 0, 2, 2, b"part")]),
        ("65,535 fragments", vec![fragment(9, 1 << 20, 0, 0, u16::MAX, b"CMD\0part")]),
        ("a part behind the end", vec![first(8, "CMD\0part"), fragment(9, 8, 9, 1, 2, b"part")]),
        ("an offset that wraps", vec![fragment(9, 8, u32::MAX, 1, 2, b"part")]),
        ("a first fragment without a channel's end", vec![first(8, "CMD")]),
        ("a message of no byte with a part", vec![fragment(9, 0, 0, 0, 1, b"CMD\0part")]),
        ("a part twice, another never", vec![first(8, "CMD\0part"), first(8, "CMD\0part")]),
        (
            "parts one over the other",
            vec![
                fragment(10, 12, 0, 0, 3, b"CMD\0part"),
                fragment(10, 12, 4, 1, 3, b"part"),
                fragment(10, 12, 4, 2, 3, b"part"),
            ],
        ),
        (
            "sizes at odds",
            vec![fragment(11, 8, 0, 0, 2, b"CMD\0part"), fragment(11, 9, 4, 1, 2, b"part")],
        ),
        (
            "counts at odds",
            vec![fragment(12, 8, 0, 0, 2, b"CMD\0part"), fragment(12, 8, 4, 1, 3, b"part")],
        ),
    ]
}

pub(crate) fn noise() -> UdpSocket {
    let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)).unwrap();
    socket.connect(GROUP).unwrap();
    socket
}
