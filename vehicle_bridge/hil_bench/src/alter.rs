//! Messages made wrong, by a seed: the same run has the same faults.

use lcm_types::{ActuationCommand, OperatorCommand, VehicleState, channels};
use rand::RngExt as _;
use rand_distr::StandardNormal;

use super::fault::{Action, Field};
use super::random::Random;

/// Applies a fault that changes what a message says; whether it did. Checksums are made anew, so
/// that only what is said is wrong.
pub(super) fn message(
    action: &Action,
    channel: &str,
    bytes: &mut Vec<u8>,
    memory: &mut Memory,
    random: &mut Random,
) -> bool {
    match action {
        Action::Corrupt { bits } => {
            for _ in 0..*bits {
                let bit = random.random_range(0..8 * bytes.len().max(1));
                if let Some(byte) = bytes.get_mut(bit / 8) {
                    *byte ^= 1 << (bit % 8);
                }
            }
            true
        }
        Action::Fingerprint {} => {
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
}

fn resealed<M: lcm_types::Checked>(
    bytes: &mut Vec<u8>,
    change: impl FnOnce(&mut M) -> bool,
) -> bool {
    let Ok(mut message) = M::open(bytes) else { return false };
    change(&mut message) && message.seal_into(bytes).is_ok()
}

#[expect(clippy::cast_possible_truncation, reason = "ages of a run")]
fn header(action: &Action, h: &mut lcm_types::Header, memory: &mut Memory) -> bool {
    match action {
        Action::Stale { ms } => h.mono_ns -= (ms * 1e6) as i64,
        Action::WallClock { jump_s } => {
            memory.flip = !memory.flip;
            let jump = (jump_s * 1e6) as i64;
            h.utime += if memory.flip { jump } else { -jump };
        }
        _ => return false,
    }
    true
}

fn command(
    action: &Action,
    m: &mut ActuationCommand,
    memory: &mut Memory,
    random: &mut Random,
) -> bool {
    if let Action::Freeze {} = action {
        let old = memory.command.get_or_insert_with(|| m.clone());
        (m.accel, m.steer) = (old.accel, old.steer);
        return true;
    }
    header(action, &mut m.h, memory)
        || field(action, random, |name| match name {
            Field::Accel => Some(&mut m.accel),
            Field::Steer => Some(&mut m.steer),
            _ => None,
        })
}

#[expect(clippy::cast_possible_truncation, reason = "ages of a run")]
fn state(action: &Action, m: &mut VehicleState, memory: &mut Memory, random: &mut Random) -> bool {
    match action {
        Action::Freeze {} => {
            let old = memory.state.get_or_insert_with(|| m.clone());
            let (h, meas) = (m.h.clone(), (m.meas_utime, m.meas_mono_ns));
            *m = VehicleState { h, meas_utime: meas.0, meas_mono_ns: meas.1, ..old.clone() };
            return true;
        }
        Action::Stale { ms } => m.meas_mono_ns -= (ms * 1e6) as i64,
        _ => {}
    }
    header(action, &mut m.h, memory)
        || field(action, random, |name| match name {
            Field::Vx => Some(&mut m.vx),
            Field::Vy => Some(&mut m.vy),
            Field::YawRate => Some(&mut m.yaw_rate),
            Field::EY => Some(&mut m.frenet.e_y),
            Field::EPsi => Some(&mut m.frenet.e_psi),
            Field::S => Some(&mut m.frenet.s),
            Field::Accel | Field::Steer => None,
        })
}

fn field<'m>(
    action: &Action,
    random: &mut Random,
    place: impl FnOnce(Field) -> Option<&'m mut f64>,
) -> bool {
    let (name, change): (Field, Box<dyn FnOnce(f64) -> f64 + '_>) = match *action {
        Action::Nan { field } => (field, Box::new(|_| f64::NAN)),
        Action::Set { field, value } => (field, Box::new(move |_| value)),
        Action::Bias { field, value } => (field, Box::new(move |old| old + value)),
        Action::Noise { field, sigma } => {
            let kick: f64 = sigma * random.sample::<f64, _>(StandardNormal);
            (field, Box::new(move |old| old + kick))
        }
        _ => return false,
    };
    let Some(place) = place(name) else { return false };
    *place = change(*place);
    true
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

    fn altered(action: &Action) -> Result<ActuationCommand, lcm_types::Error> {
        let (mut bytes, mut memory) = (sealed(), Memory::default());
        assert!(message(action, channels::COMMAND, &mut bytes, &mut memory, &mut random::of(1)));
        ActuationCommand::open(&bytes)
    }

    #[test]
    fn only_what_is_said_is_wrong() {
        assert!(altered(&Action::Nan { field: Field::Accel }).unwrap().accel.is_nan());
        assert_eq!(altered(&Action::Bias { field: Field::Accel, value: 0.5 }).unwrap().accel, 1.5);
        assert_eq!(altered(&Action::Stale { ms: 300.0 }).unwrap().h.mono_ns, -300_000_000);
        assert!(matches!(altered(&Action::Corrupt { bits: 1 }), Err(lcm_types::Error::Crc { .. })));
        assert!(matches!(
            altered(&Action::Fingerprint {}),
            Err(lcm_types::Error::Fingerprint { .. })
        ));
    }
}
