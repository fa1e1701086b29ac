//! Malformed and forged datagrams.

use lcm_types::{ActuationCommand, Checked as _, Header, Heartbeat, Message as _, channels};
use rand::RngExt as _;

use super::fault::{FaultKind, Token};
use super::forge;
use super::proxy::Active;
use super::random::{self, Random};
use super::wire::{fragment, parts};

/// Boot id of the second controller.
pub(super) const STRANGER: i64 = 0x00c0_ffee;

/// Numbers an impostor is ahead of the source: the source's own are then old. \[-\]
pub(super) const AHEAD: i64 = 50;

/// The last messages that went through, as who listens has them.
#[derive(Debug, Default)]
pub(super) struct Sniffed {
    /// The source's command.
    pub(super) command: Vec<u8>,
    /// The bridge's state.
    pub(super) state: Vec<u8>,
    /// The bridge's arm token. \[-\]
    pub(super) token: i64,
}

impl Sniffed {
    /// Keeps a message that went to the car (`to` 1) or to the controller (0).
    pub(super) fn note(&mut self, channel: &str, message: &[u8], to: usize) {
        match (channel, to) {
            (channels::COMMAND, 1) => message.clone_into(&mut self.command),
            (channels::STATE, 0) => message.clone_into(&mut self.state),
            ("HB/bridge", 0) => {
                self.token = Heartbeat::decode(message).map_or(self.token, |beat| beat.arm_token);
            }
            _ => {}
        }
    }
}

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

/// Sends what a fault sends by itself and is due; how many messages that were.
pub(super) fn send(
    active: &mut Active,
    sniffed: &Sniffed,
    time: i64,
    mut out: impl FnMut(&str, &[u8]),
) -> u32 {
    let genuine = || sniffed.command.as_slice();
    match active.fault.action {
        FaultKind::Storm { rate_hz, bytes } => {
            let channel = active.fault.channel.clone().unwrap_or_else(|| "STORM".to_owned());
            let count = due(&mut active.next_ns, time, rate_hz);
            let content = random::bytes(&mut active.random, bytes);
            (0..count).for_each(|_| out(&channel, &content));
            count
        }
        FaultKind::SecondController { rate_hz, token } => {
            let count = due(&mut active.next_ns, time, rate_hz);
            for _ in 0..count {
                if token == Token::Impostor {
                    impostor(genuine(), &mut out);
                    continue;
                }
                let token = match token {
                    Token::None | Token::Impostor => 0,
                    Token::Guessed => active.random.random(),
                    Token::Stolen => {
                        ActuationCommand::open(genuine()).map_or(0, |command| command.arm_token)
                    }
                };
                let seq = i64::from(active.count);
                active.count += 1;
                out(channels::COMMAND, &stranger(STRANGER, seq, token, time));
            }
            count
        }
        FaultKind::Forge { message, rate_hz } => {
            let count = due(&mut active.next_ns, time, rate_hz);
            for _ in 0..count {
                active.count += 1;
                if let Some((channel, bytes)) = forge::message(message, active.count, sniffed, time)
                {
                    out(channel, &bytes);
                }
            }
            count
        }
        FaultKind::CommandStorm { rate_hz, senders } => {
            let count = due(&mut active.next_ns, time, rate_hz);
            for _ in 0..count {
                let number = active.count;
                active.count += 1;
                match number.checked_rem(senders) {
                    None => out(channels::COMMAND, genuine()),
                    Some(sender) => {
                        let boot_id = STRANGER + i64::from(sender);
                        let seq = i64::from(number / senders);
                        out(channels::COMMAND, &stranger(boot_id, seq, 0, time));
                    }
                }
            }
            count
        }
        _ => 0,
    }
}

/// How many messages of this rate are due; never a burst of more than a hundred.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "rates are bounded")]
fn due(next_ns: &mut i64, time: i64, rate_hz: f64) -> u32 {
    let interval = (1e9 / rate_hz).max(1.0) as i64;
    *next_ns = if *next_ns == 0 { time } else { (*next_ns).max(time - 100 * interval) };
    let count = ((time - *next_ns) / interval).clamp(0, 100) as u32;
    *next_ns += i64::from(count) * interval;
    count
}

/// A command that passes for one of the source's, some numbers ahead of it.
fn impostor(genuine: &[u8], out: &mut impl FnMut(&str, &[u8])) {
    let Ok(mut command) = ActuationCommand::open(genuine) else { return };
    command.h.seq += AHEAD;
    (command.accel, command.steer) = (1.0, 0.3);
    let mut bytes = Vec::new();
    if command.seal_into(&mut bytes).is_ok() {
        out(channels::COMMAND, &bytes);
    }
}

/// A well-formed command of another start than the source's.
fn stranger(boot_id: i64, seq: i64, arm_token: i64, mono_ns: i64) -> Vec<u8> {
    let sender = "second@bench".to_owned();
    let h = Header { utime: mono_ns / 1000, mono_ns, seq, boot_id, sender };
    let command = ActuationCommand {
        h,
        arm_token,
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
