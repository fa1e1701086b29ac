//! From bytes to an offer: size, type and checksum.

use lcm_types::{
    ActuationCommand, ArmToken, BootId, Checked as _, Message as _, MonoTime, SeqNumber,
};
use vehicle_model::Input;

use super::command::{DecodedCommand, PLAN, Reject};
use super::rules::Rules;

/// No command is longer. \[B\]
const LONGEST: usize = 4096;
/// Fingerprint and checksum. \[B\]
const SHORTEST: usize = 12;

/// A command as received; `host` is the end of `sender` of programs on this host.
///
/// # Errors
/// [`Reject::Size`], [`Reject::Fingerprint`], [`Reject::Crc`].
pub fn decode(
    bytes: &[u8],
    arrival: MonoTime,
    rules: &Rules,
    host: &str,
) -> Result<DecodedCommand, Reject> {
    if !(SHORTEST..=LONGEST).contains(&bytes.len()) {
        return Err(Reject::Size);
    }
    if !bytes.starts_with(&ActuationCommand::FINGERPRINT.to_be_bytes()) {
        return Err(Reject::Fingerprint);
    }
    let c = ActuationCommand::open(bytes).map_err(|_| Reject::Crc)?;
    let mut since = arrival;
    if c.h.sender.rsplit('@').next() == Some(host) {
        since = since.min(c.h.sent());
    }
    let ours = BootId::new(c.state_boot_id) == rules.boot_id;
    if ours {
        since = since.min(MonoTime::from_ns(c.state_mono_ns));
    }
    let mut plan = [Input::default(); PLAN];
    let asked = c.plan_accel.iter().zip(&c.plan_steer);
    for (u, (a, delta)) in plan.iter_mut().zip(asked) {
        *u = Input { a: f64::from(*a), delta: f64::from(*delta) };
    }
    Ok(DecodedCommand {
        boot_id: c.h.sender_start(),
        seq: c.h.number(),
        arrival,
        since,
        answers: ours.then_some(SeqNumber::new(c.state_seq)),
        token: ArmToken::new(c.arm_token),
        drives: c.enable && c.mode == ActuationCommand::MODE_DRIVE,
        estop: c.mode == ActuationCommand::MODE_ESTOP,
        input: Input { a: c.accel, delta: c.steer },
        valid_for_ns: i64::from(c.valid_for_us) * 1000,
        plan,
        n_plan: c.plan_accel.len().min(c.plan_steer.len()).min(PLAN),
        plan_dt: f64::from(c.plan_dt),
    })
}
