//! Datagrams no LCM sender makes, over a real socket: the receiver lives, delivers none of them,
//! and loses no message of an honest sender.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "code of tests")]

use std::time::Duration;

use common::datagrams::{cases, fragment, noise, short};
use common::{MULTICAST, URL, isolated};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use transport::{Filter, Inbox, Transport};

mod common;

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
        let cases = cases("CMD");
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
