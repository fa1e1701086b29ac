//! Datagrams nobody should send.

use lcm_types::{ActuationCommand, Checked as _, Header, channels};
use rand::RngExt as _;

use super::random::{self, Random};
use super::wire::{fragment, parts};

/// Boot id of the second controller.
pub(super) const STRANGER: i64 = 0x00c0_ffee;

/// Junk of one of eight kinds, some of it made from a good datagram.
pub(super) fn junk(good: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = good.to_vec();
    match random.random_range(0..8) {
        0 => {
            let length = random.random_range(0..200);
            return random::bytes(random, length);
        }
        1 => {
            let bit = random.random_range(0..8 * bytes.len().max(1));
            if let Some(byte) = bytes.get_mut(bit / 8) {
                *byte ^= 1 << (bit % 8);
            }
        }
        2 => bytes.truncate(random.random_range(0..good.len().max(1))),
        // A channel without an end, short and long.
        3 => return [b"LC02\0\0\0\x01".as_slice(), &[b'A'; 3]].concat(),
        4 => return [b"LC02\0\0\0\x01".as_slice(), &[b'A'; 200]].concat(),
        5 => return fragment(7, (u32::MAX, 0), (0, u16::MAX), b"LMPC/CMD\0xxxx"),
        // A part of the real message under a number of its own, beyond and within its size.
        6 => return fragment(8, (100, u32::MAX - 10), (1, 2), &random::bytes(random, 50)),
        _ => {
            let message = parts(good).map_or(&[][..], |(_, message)| message);
            let half = message.len() / 2;
            let content = [channels::COMMAND.as_bytes(), b"\0", &message[..half]].concat();
            let size = u32::try_from(message.len()).unwrap_or(0);
            return fragment(9, (size, 0), (0, 2), &content);
        }
    }
    bytes
}

/// The first of two fragments; the second never comes.
pub(super) fn incomplete(sequence: u32, size: u32, random: &mut Random) -> Vec<u8> {
    let content = [b"STORM\0".as_slice(), &random::bytes(random, 200)].concat();
    fragment(sequence, (size, 0), (0, 2), &content)
}

/// A well-formed command of a second controller, without a grant.
pub(super) fn stranger(seq: i64, mono_ns: i64) -> Vec<u8> {
    let sender = "second@bench".to_owned();
    let h = Header { utime: mono_ns / 1000, mono_ns, seq, boot_id: STRANGER, sender };
    let command = ActuationCommand {
        h,
        valid_for_us: 100_000,
        enable: true,
        mode: ActuationCommand::MODE_DRIVE,
        accel: 1.0,
        steer: 0.3,
        plan_dt: 0.01,
        ..ActuationCommand::default()
    };
    let mut bytes = Vec::new();
    // Strings without NUL always encode.
    let _ = command.seal_into(&mut bytes);
    bytes
}
