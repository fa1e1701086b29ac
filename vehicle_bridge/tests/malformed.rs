//! Datagrams no LCM sender makes, over a real socket: the receiver lives, delivers none of them,
//! and loses no message of an honest sender.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "code of tests")]

use std::net::{Ipv4Addr, UdpSocket};
use std::time::Duration;

use common::{MULTICAST, URL, isolated};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use vehicle_bridge::transport::{self, Filter, Inbox, Transport};

mod common;

const GROUP: (Ipv4Addr, u16) = (Ipv4Addr::new(239, 255, 76, 67), 7667);

fn short(sequence: u32, rest: &[u8]) -> Vec<u8> {
    [b"LC02", &sequence.to_be_bytes()[..], rest].concat()
}

fn fragment(
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
fn cases() -> Vec<(&'static str, Vec<Vec<u8>>)> {
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

fn noise() -> UdpSocket {
    let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)).unwrap();
    socket.connect(GROUP).unwrap();
    socket
}

/// Sends one honest message and takes it out again.
fn honest(network: &dyn Transport, inbox: &Inbox, number: u32, after: &str) {
    network.publish("CMD", &number.to_be_bytes()).unwrap();
    let received = inbox.wait(Duration::from_secs(20));
    let payload = received.unwrap_or_else(|| panic!("nothing came after {after}")).payload;
    assert_eq!(payload, number.to_be_bytes(), "after {after}");
}

#[test]
fn malformed_datagrams_are_counted_and_do_no_harm() {
    isolated("malformed_datagrams_are_counted_and_do_no_harm", MULTICAST, URL, || {
        let cases = cases();
        assert!(cases.len() >= 24);
        let network = transport::open(URL, None).unwrap();
        let inbox = Inbox::queue(100);
        network.subscribe(Filter::All, inbox.sink()).unwrap();
        let noise = noise();
        for (number, (what, datagrams)) in (0..).zip(&cases) {
            let before = network.statistics();
            for datagram in datagrams {
                noise.send(datagram).unwrap();
            }
            honest(&*network, &inbox, number, what);
            let after = network.statistics();
            let seen = |s: &transport::Statistics| s.malformed + s.fragments;
            assert!(seen(&after) > seen(&before), "{what} was not counted");
            assert_eq!(inbox.take(), None, "{what} was delivered");
        }
        assert_eq!(network.statistics().lost, 0);
    });
}

#[test]
fn fragments_out_of_order_or_twice_make_the_message_once() {
    isolated("fragments_out_of_order_or_twice_make_the_message_once", MULTICAST, URL, || {
        let network = transport::open(URL, None).unwrap();
        let inbox = Inbox::queue(100);
        network.subscribe(Filter::All, inbox.sink()).unwrap();
        let noise = noise();
        let parts = [
            fragment(1, 12, 0, 0, 3, b"CMD\0part"),
            fragment(1, 12, 4, 1, 3, b"PART"),
            fragment(1, 12, 8, 2, 3, b"last"),
        ];
        for order in [vec![2, 1, 0], vec![1, 1, 2, 2, 0], vec![0, 2, 0, 1]] {
            for index in &order {
                noise.send(&parts[*index]).unwrap();
            }
            let received = inbox.wait(Duration::from_secs(20)).unwrap();
            assert_eq!(received.payload, b"partPARTlast", "{order:?}");
        }
        honest(&*network, &inbox, 1, "the fragments");
    });
}

#[test]
fn a_flood_of_beginnings_and_noise_is_survived() {
    isolated("a_flood_of_beginnings_and_noise_is_survived", MULTICAST, URL, || {
        let network = transport::open(URL, None).unwrap();
        let inbox = Inbox::queue(100);
        network.subscribe(Filter::channel("CMD"), inbox.sink()).unwrap();
        let noise = noise();
        let mut rng = Pcg64::seed_from_u64(11);
        for number in 0..300 {
            // Forty per tick: beginnings of 1 MiB, cut and flipped copies of real datagrams, junk.
            for index in 0..40_u32 {
                let sequence = number * 40 + index;
                let mut bytes = match index % 4 {
                    0 => fragment(sequence, 1 << 20, 0, 0, 17, b"CMD\0part"),
                    1 => short(sequence, b"CMD"),
                    2 => (0..rng.random_range(0..90)).map(|_| rng.random()).collect(),
                    _ => short(sequence, b"OTHER\0payload"),
                };
                if index % 4 == 3 {
                    let bit = rng.random_range(0..8 * 8);
                    bytes[bit / 8] ^= 1 << (bit % 8);
                }
                noise.send(&bytes).unwrap();
            }
            honest(&*network, &inbox, number, "noise");
        }
        let statistics = network.statistics();
        assert!(statistics.malformed >= 3000, "{statistics:?}");
        assert!(statistics.evicted + statistics.expired > 2000, "{statistics:?}");
    });
}
