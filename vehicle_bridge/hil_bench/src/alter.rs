//! Messages made wrong, by a seed: the same run has the same faults.

use lcm_types::{ActuationCommand, OperatorCommand, VehicleState, channels};
use rand::RngExt as _;

use super::fault::{FaultKind, Field};
use super::field::FieldMemory;
use super::random::Random;

/// Applies a fault that changes what a message says; whether it did. Checksums are made anew, so
/// that only what is said is wrong.
pub(super) fn message(
    action: &FaultKind,
    channel: &str,
    bytes: &mut Vec<u8>,
    memory: &mut Memory,
    random: &mut Random,
) -> bool {
    match action {
        FaultKind::Corrupt { bits } => {
            for _ in 0..*bits {
                let bit = random.random_range(0..8 * bytes.len().max(1));
                if let Some(byte) = bytes.get_mut(bit / 8) {
                    *byte ^= 1 << (bit % 8);
                }
            }
            true
        }
        FaultKind::Fingerprint {} => {
            if let Some(byte) = bytes.get_mut(7) {
                *byte ^= 0x5a;
            }
            lcm_types::crc::seal(bytes);
            true
        }
        _ => match channel {
            channels::STATE => {
                resealed::<VehicleState>(bytes, |m| state(action, m, memory, random))
            }
            channels::COMMAND => {
                resealed::<ActuationCommand>(bytes, |m| command(action, m, memory, random))
            }
            channels::OPERATOR => {
                resealed::<OperatorCommand>(bytes, |m| header(action, &mut m.h, memory))
            }
            _ => false,
        },
    }
}

/// What faults remember of earlier messages.
#[derive(Debug, Clone, Default)]
pub(super) struct Memory {
    state: Option<VehicleState>,
    command: Option<ActuationCommand>,
    flip: bool,
    field: FieldMemory,
    drift_ns: Option<i64>,
}

fn resealed<M: lcm_types::Checked>(
    bytes: &mut Vec<u8>,
    change: impl FnOnce(&mut M) -> bool,
) -> bool {
    let Ok(mut message) = M::open(bytes) else { return false };
    change(&mut message) && message.seal_into(bytes).is_ok()
}

#[expect(clippy::cast_possible_truncation, reason = "ages of a run")]
fn header(action: &FaultKind, h: &mut lcm_types::Header, memory: &mut Memory) -> bool {
    match action {
        FaultKind::Stale { ms } => h.mono_ns -= (ms * 1e6) as i64,
        FaultKind::WallClock { jump_s } => {
            memory.flip = !memory.flip;
            let jump = (jump_s * 1e6) as i64;
            h.utime += if memory.flip { jump } else { -jump };
        }
        FaultKind::ClockDrift { ppm } => {
            let first = *memory.drift_ns.get_or_insert(h.mono_ns);
            let ahead = ((h.mono_ns - first) as f64 * ppm * 1e-6) as i64;
            h.mono_ns += ahead;
            h.utime += ahead / 1000;
        }
        _ => return false,
    }
    true
}

fn command(
    action: &FaultKind,
    m: &mut ActuationCommand,
    memory: &mut Memory,
    random: &mut Random,
) -> bool {
    if let FaultKind::Freeze {} = action {
        let old = memory.command.get_or_insert_with(|| m.clone());
        (m.accel, m.steer) = (old.accel, old.steer);
        return true;
    }
    if let FaultKind::Ttl { ms } = action {
        #[expect(clippy::cast_possible_truncation, reason = "times of a run")]
        let valid = (ms * 1e3) as i32;
        m.valid_for_us = valid;
        return true;
    }
    let now_ns = m.h.mono_ns;
    header(action, &mut m.h, memory)
        || field(action, (now_ns, &mut memory.field), random, |name| match name {
            Field::Accel => Some(&mut m.accel),
            Field::Steer => Some(&mut m.steer),
            _ => None,
        })
}

#[expect(clippy::cast_possible_truncation, reason = "ages of a run")]
fn state(
    action: &FaultKind,
    m: &mut VehicleState,
    memory: &mut Memory,
    random: &mut Random,
) -> bool {
    match action {
        FaultKind::Freeze {} => {
            let old = memory.state.get_or_insert_with(|| m.clone());
            let (h, meas) = (m.h.clone(), (m.meas_utime, m.meas_mono_ns));
            *m = VehicleState { h, meas_utime: meas.0, meas_mono_ns: meas.1, ..old.clone() };
            return true;
        }
        FaultKind::Stale { ms } => m.meas_mono_ns -= (ms * 1e6) as i64,
        FaultKind::ClockDrift { ppm } => {
            let first = memory.drift_ns.unwrap_or(m.h.mono_ns);
            m.meas_mono_ns += ((m.meas_mono_ns - first) as f64 * ppm * 1e-6) as i64;
        }
        _ => {}
    }
    let now_ns = m.h.mono_ns;
    header(action, &mut m.h, memory)
        || field(action, (now_ns, &mut memory.field), random, |name| match name {
            Field::Vx => Some(&mut m.vx),
            Field::Vy => Some(&mut m.vy),
            Field::YawRate => Some(&mut m.yaw_rate),
            Field::EY => Some(&mut m.frenet.e_y),
            Field::EPsi => Some(&mut m.frenet.e_psi),
            Field::S => Some(&mut m.frenet.s),
            Field::X => Some(&mut m.x),
            Field::Y => Some(&mut m.y),
            Field::Yaw => Some(&mut m.yaw),
            Field::Accel | Field::Steer => None,
        })
}

fn field<'m>(
    action: &FaultKind,
    (now_ns, memory): (i64, &mut FieldMemory),
    random: &mut Random,
    place: impl FnOnce(Field) -> Option<&'m mut f64>,
) -> bool {
    let Some(place) = action.field().and_then(place) else { return false };
    let changed = action.change(*place, now_ns, memory, random);
    *place = changed.unwrap_or(*place);
    changed.is_some()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]

    use super::*;
    use crate::random;
    use lcm_types::Checked as _;

    fn sealed() -> Vec<u8> {
        let mut bytes = Vec::new();
        ActuationCommand { accel: 1.0, ..ActuationCommand::default() }
            .seal_into(&mut bytes)
            .unwrap();
        bytes
    }

    fn altered(action: &FaultKind) -> Result<ActuationCommand, lcm_types::Error> {
        let (mut bytes, mut memory) = (sealed(), Memory::default());
        assert!(message(action, channels::COMMAND, &mut bytes, &mut memory, &mut random::of(1)));
        ActuationCommand::open(&bytes)
    }

    #[test]
    fn only_what_is_said_is_wrong() {
        assert!(altered(&FaultKind::Nan { field: Field::Accel }).unwrap().accel.is_nan());
        assert_eq!(
            altered(&FaultKind::Bias { field: Field::Accel, value: 0.5 }).unwrap().accel,
            1.5
        );
        assert_eq!(altered(&FaultKind::Stale { ms: 300.0 }).unwrap().h.mono_ns, -300_000_000);
        assert!(matches!(
            altered(&FaultKind::Corrupt { bits: 1 }),
            Err(lcm_types::Error::Crc { .. })
        ));
        assert!(matches!(
            altered(&FaultKind::Fingerprint {}),
            Err(lcm_types::Error::Fingerprint { .. })
        ));
    }
}
