//! Fragments in every order, twice, never, and at odds with each other.

use std::net::{Ipv4Addr, SocketAddrV4};

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::*;
use crate::datagram::fragments;

fn sender(port: u16) -> SocketAddrV4 {
    SocketAddrV4::new(Ipv4Addr::LOCALHOST, port)
}

fn at(ns: i64) -> MonoTime {
    MonoTime::from_ns(ns)
}

/// `payload` in parts of `size` bytes.
fn cut<'a>(sequence: u32, payload: &'a [u8], size: usize) -> Vec<Fragment<'a>> {
    let parts: Vec<&[u8]> = payload.chunks(size).collect();
    let mut offset = 0;
    let mut out = Vec::new();
    for (number, part) in parts.iter().enumerate() {
        out.push(Fragment {
            sequence,
            size: payload.len() as u32,
            offset,
            number: number as u16,
            count: parts.len() as u16,
            channel: (number == 0).then_some("CH"),
            part,
        });
        offset += part.len() as u32;
    }
    out
}

fn bytes(count: usize) -> Vec<u8> {
    (0..count).map(|i| (i % 253) as u8).collect()
}

#[test]
fn any_order_with_repetitions_gives_the_message_once() {
    let payload = bytes(10_000);
    let mut rng = Pcg64::seed_from_u64(2);
    for round in 0..200 {
        let mut reassembly = Reassembly::default();
        let mut parts = cut(round, &payload, 700);
        let copies = parts.clone();
        parts.extend(copies.iter().skip(1).step_by(3));
        for i in (1..parts.len()).rev() {
            parts.swap(i, rng.random_range(0..=i));
        }
        let mut whole = 0;
        for part in &parts {
            if let Outcome::Complete { channel, payload: got } =
                reassembly.insert(sender(1), part, at(0))
            {
                assert_eq!((channel, got), ("CH", &payload[..]));
                whole += 1;
            }
        }
        assert_eq!(whole, 1);
    }
}

#[test]
fn a_repeated_part_never_stands_for_a_missing_one() {
    let payload = bytes(3000);
    let parts = cut(1, &payload, 1000);
    let mut reassembly = Reassembly::default();
    assert_eq!(reassembly.insert(sender(1), &parts[0], at(0)), Outcome::Incomplete);
    assert_eq!(reassembly.insert(sender(1), &parts[1], at(0)), Outcome::Incomplete);
    assert_eq!(reassembly.insert(sender(1), &parts[1], at(0)), Outcome::Duplicate);
    assert!(matches!(
        reassembly.insert(sender(1), &parts[2], at(0)),
        Outcome::Complete { payload: p, .. } if p == payload
    ));
}

#[test]
fn overlapping_parts_are_refused() {
    let payload = bytes(3000);
    let mut parts = cut(1, &payload, 1000);
    parts[2].offset = 1000; // the lengths still add up to the size
    let mut reassembly = Reassembly::default();
    reassembly.insert(sender(1), &parts[0], at(0));
    reassembly.insert(sender(1), &parts[1], at(0));
    assert_eq!(reassembly.insert(sender(1), &parts[2], at(0)), Outcome::Refused);
}

#[test]
fn parts_at_odds_with_the_first_are_refused_and_do_no_harm() {
    let payload = bytes(3000);
    let parts = cut(1, &payload, 1000);
    let mut reassembly = Reassembly::default();
    reassembly.insert(sender(1), &parts[0], at(0));
    let other_size = Fragment { size: 4000, ..parts[1] };
    let other_count = Fragment { count: 9, ..parts[1] };
    assert_eq!(reassembly.insert(sender(1), &other_size, at(0)), Outcome::Refused);
    assert_eq!(reassembly.insert(sender(1), &other_count, at(0)), Outcome::Refused);
    reassembly.insert(sender(1), &parts[1], at(0));
    assert!(matches!(reassembly.insert(sender(1), &parts[2], at(0)), Outcome::Complete { .. }));
}

#[test]
fn what_is_too_large_is_refused_before_memory_is_taken() {
    let part = [0; 10];
    let first = Fragment {
        sequence: 1,
        size: u32::MAX,
        offset: 0,
        number: 0,
        count: 2,
        channel: Some("CH"),
        part: &part,
    };
    let mut reassembly = Reassembly::default();
    assert_eq!(reassembly.insert(sender(1), &first, at(0)), Outcome::Refused);
    let many = Fragment { size: 1 << 20, count: u16::MAX, ..first };
    assert_eq!(reassembly.insert(sender(1), &many, at(0)), Outcome::Refused);
    assert!(reassembly.partials.is_empty());
    let largest = Fragment { size: MAX_MESSAGE as u32, ..first };
    assert_eq!(reassembly.insert(sender(1), &largest, at(0)), Outcome::Incomplete);
}

#[test]
fn memory_is_bounded_and_a_flood_does_not_take_the_place_of_others() {
    let payload = bytes(200_000);
    let mut reassembly = Reassembly::default();
    let mine: Vec<Fragment<'_>> = fragments(1, "CH", &payload).collect();
    reassembly.insert(sender(1), &mine[0], at(0));
    for sequence in 0..3000 {
        let flood: Vec<Fragment<'_>> = fragments(sequence, "X", &payload).collect();
        reassembly.insert(sender(2), &flood[0], at(0));
    }
    assert_eq!(reassembly.partials.len(), MAX_PARTIAL);
    assert_eq!(reassembly.given_up().evicted, 3000 - (MAX_PARTIAL as u64 - 1));
    let mut complete = false;
    for part in &mine[1..] {
        complete = matches!(reassembly.insert(sender(1), part, at(0)), Outcome::Complete { .. });
    }
    assert!(complete);
}

#[test]
fn old_parts_are_given_up() {
    let payload = bytes(2000);
    let parts = cut(1, &payload, 1000);
    let mut reassembly = Reassembly::default();
    reassembly.insert(sender(1), &parts[0], at(0));
    assert_eq!(reassembly.insert(sender(1), &parts[1], at(EXPIRY_NS + 1)), Outcome::Incomplete);
    assert_eq!(reassembly.given_up().expired, 1);
    // The first part again: now the message is whole.
    let again = reassembly.insert(sender(1), &parts[0], at(EXPIRY_NS + 2));
    assert!(matches!(again, Outcome::Complete { .. }));
}

#[test]
fn random_fragments_are_taken_or_refused() {
    let mut rng = Pcg64::seed_from_u64(3);
    let payload = bytes(5000);
    let mut reassembly = Reassembly::default();
    for now in 0..100_000 {
        let size = rng.random_range(0..4000_u32);
        let offset = rng.random_range(0..=size);
        let length = rng.random_range(0..=size - offset) as usize;
        let count = rng.random_range(1..6);
        let number = rng.random_range(0..count);
        let fragment = Fragment {
            sequence: rng.random_range(0..20),
            size,
            offset,
            number,
            count,
            channel: (number == 0).then_some("CH"),
            part: &payload[..length],
        };
        reassembly.insert(sender(rng.random_range(0..4)), &fragment, at(now * 10_000));
        assert!(reassembly.partials.len() <= MAX_PARTIAL);
    }
}
