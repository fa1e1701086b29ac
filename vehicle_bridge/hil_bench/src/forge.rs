//! Messages of somebody who listens and has no key: well-formed, with a checksum, unsigned.

use lcm_types::{
    Checked as _, Frenet, Header, Heartbeat, Message as _, OperatorCommand, VehicleState, channels,
};

use super::attack::{AHEAD, STRANGER, Sniffed};
use super::fault::Forged;

/// How far a forged state is off to the left. \[m\]
const ASIDE: f64 = 0.3;

/// The forged message with this number and its channel; none before what it needs was sniffed.
pub(super) fn message(
    what: Forged,
    number: u32,
    sniffed: &Sniffed,
    mono_ns: i64,
) -> Option<(&'static str, Vec<u8>)> {
    let sender = "attacker@bench".to_owned();
    let seq = i64::from(number);
    let h = Header { utime: mono_ns / 1000, mono_ns, seq, boot_id: STRANGER, sender };
    let mut bytes = Vec::new();
    match what {
        Forged::Heartbeat => {
            let beat = Heartbeat { h, state: Heartbeat::RUNNING, ..Heartbeat::default() };
            beat.encode_into(&mut bytes).ok()?;
            Some(("HB/lmpc", bytes))
        }
        Forged::Order => {
            let orders =
                [OperatorCommand::ESTOP_RESET, OperatorCommand::ARM, OperatorCommand::START];
            let order = OperatorCommand {
                h,
                command: orders[number as usize % orders.len()],
                request_id: seq,
                arm_token: sniffed.token,
                ..OperatorCommand::default()
            };
            order.seal_into(&mut bytes).ok()?;
            Some((channels::OPERATOR, bytes))
        }
        Forged::State => {
            let mut state = VehicleState::open(&sniffed.state).ok()?;
            state.h.seq += AHEAD;
            (state.h.mono_ns, state.meas_mono_ns) = (mono_ns, mono_ns);
            state.frenet = Frenet { e_y: state.frenet.e_y + ASIDE, ..state.frenet };
            state.seal_into(&mut bytes).ok()?;
            Some((channels::STATE, bytes))
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]
    use super::*;

    #[test]
    fn a_forged_message_is_well_formed_and_says_what_was_sniffed() {
        let mut sniffed = Sniffed::default();
        assert_eq!(message(Forged::State, 1, &sniffed, 5), None, "nothing to copy yet");
        let h = Header { boot_id: 3, seq: 7, ..Header::default() };
        let mut bytes = Vec::new();
        VehicleState { h, ..VehicleState::default() }.seal_into(&mut bytes).unwrap();
        sniffed.note(channels::STATE, &bytes, 0);
        let mut bytes = Vec::new();
        Heartbeat { arm_token: 9, ..Heartbeat::default() }.encode_into(&mut bytes).unwrap();
        sniffed.note("HB/bridge", &bytes, 0);
        let (channel, bytes) = message(Forged::State, 1, &sniffed, 5).unwrap();
        let state = VehicleState::open(&bytes).unwrap();
        assert_eq!((channel, state.h.boot_id, state.h.seq), (channels::STATE, 3, 7 + AHEAD));
        assert!((state.frenet.e_y - ASIDE).abs() < 1e-12);
        let orders = [3, 4, 5].map(|number| {
            let (_, bytes) = message(Forged::Order, number, &sniffed, 5).unwrap();
            let order = OperatorCommand::open(&bytes).unwrap();
            (order.command, order.arm_token)
        });
        let all = [OperatorCommand::ESTOP_RESET, OperatorCommand::ARM, OperatorCommand::START];
        assert_eq!(orders, all.map(|command| (command, 9)));
    }
}
