//! States and commands: between the messages and the controller's own types.

use controller::{Config, Measurement, Plan, Pose};
use lcm_types::{
    ActuationCommand, ActuationReport, ArmToken, BootId, Frenet, Header, LapIndex, MonoTime,
    SeqNumber, VehicleState, crc, plan_step,
};
use vehicle_model::{CarParams, GlobalState, Input, State, Track};

/// Measurement times this near to a whole number of periods are whole numbers of periods. \[ns\]
const ROUNDING_NS: f64 = 1.0;

/// What both ends call a track: the CRC-32 of its fingerprint. \[-\]
#[must_use]
pub fn track_id(track: &Track) -> i64 {
    crc::id(track.fingerprint())
}

/// What both ends call a car: the CRC-32 of its fingerprint. \[-\]
#[must_use]
pub fn car_id(car: &CarParams) -> i64 {
    crc::id(car.fingerprint())
}

/// What both ends call a configuration: the CRC-32 of the values of its [`Config::identity`]. \[-\]
#[must_use]
pub fn config_id(config: &Config) -> i64 {
    // Numbers and words alone: there is nothing that does not serialise.
    crc::of(&serde_json::to_vec(&config.identity()).unwrap_or_default()).into()
}

/// Nanoseconds of a time in seconds.
#[must_use]
#[expect(clippy::cast_possible_truncation, reason = "centuries fit")]
pub fn nanoseconds(seconds: f64) -> i64 {
    (seconds * 1e9).round() as i64
}

/// Seconds of a time since the first measurement.
///
/// A whole number of periods is counted, not divided, so that a simulation in lock-step has the
/// bits of the offline race's clock.
#[must_use]
pub fn seconds(nanoseconds: i64, period: f64) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "exact for a hundred days")]
    let exact = nanoseconds as f64;
    let count = (exact / (period * 1e9)).round();
    let whole = count * period;
    if (whole * 1e9 - exact).abs() <= ROUNDING_NS { whole } else { exact / 1e9 }
}

/// A state as the car measures it, both in the track's frame and in the world's.
#[must_use]
pub fn state_message(
    h: Header,
    measured: MonoTime,
    x: &State,
    applied: Input,
    track: &Track,
    lap: LapIndex,
) -> VehicleState {
    let pose = track.to_global(x);
    VehicleState {
        meas_utime: h.utime,
        meas_mono_ns: measured.as_ns(),
        valid: VehicleState::POSE | VehicleState::VEL | VehicleState::FRENET | VehicleState::STEER,
        quality: VehicleState::GOOD,
        x: pose.x,
        y: pose.y,
        yaw: pose.psi,
        vx: x.v_x,
        vy: x.v_y,
        yaw_rate: x.omega_z,
        steer: applied.delta,
        frenet: Frenet {
            s: x.s,
            e_y: x.e_y,
            e_psi: x.e_psi,
            kappa: track.kappa(x.s),
            lap: lap.get(),
            track_id: track_id(track),
        },
        h,
        ..VehicleState::default()
    }
}

/// Where the car is: the source's own track coordinates if they are of this track, else its pose
/// in the world. `None` if the message holds neither, or no velocities.
#[must_use]
pub fn pose(state: &VehicleState, track_id: i64) -> Option<Pose> {
    let has = |bit| state.valid & bit != 0;
    if !has(VehicleState::VEL) {
        return None;
    }
    let (v_x, v_y, omega_z) = (state.vx, state.vy, state.yaw_rate);
    if has(VehicleState::FRENET) && state.frenet.track_id == track_id {
        let Frenet { s, e_y, e_psi, .. } = state.frenet;
        return Some(Pose::Frenet(State { v_x, v_y, omega_z, e_psi, s, e_y }));
    }
    has(VehicleState::POSE).then(|| {
        let (x, y, psi) = (state.x, state.y, state.yaw);
        Pose::Global(GlobalState { x, y, psi, v_x, v_y, omega_z })
    })
}

/// Whether the numbers that the controller reads are numbers.
#[must_use]
pub fn is_finite(pose: &Pose) -> bool {
    match pose {
        Pose::Frenet(x) => x.is_finite(),
        Pose::Global(g) => g.is_finite(),
    }
}

/// The controller's measurement, `since_first_ns` after the first one.
#[must_use]
pub fn measurement(
    pose: Pose,
    since_first_ns: i64,
    period: f64,
    applied: Option<Input>,
) -> Measurement {
    Measurement { time: seconds(since_first_ns, period), pose, applied }
}

/// The state a command answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct AnsweredState {
    /// Its sender.
    pub boot_id: BootId,
    /// Its number.
    pub seq: SeqNumber,
    /// When it was measured, its sender's clock.
    pub measured: MonoTime,
}

impl AnsweredState {
    /// Of this state.
    #[must_use]
    pub fn of(state: &VehicleState) -> Self {
        Self {
            boot_id: state.h.sender_start(),
            seq: state.h.number(),
            measured: MonoTime::from_ns(state.meas_mono_ns),
        }
    }
}

/// A command to the car.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommandDraft<'a> {
    /// The state it answers.
    pub answered: AnsweredState,
    /// `MODE_…` of [`ActuationCommand`].
    pub mode: i8,
    /// What to apply.
    pub input: Input,
    /// What to apply if no further command comes; its first input is this period's.
    pub plan: Option<&'a Plan>,
    /// Control period. \[s\]
    pub period: f64,
    /// How long the command may be used. \[us\]
    pub valid_for_us: i32,
    /// The bridge's grant, if any is heard.
    pub arm_token: ArmToken,
}

impl CommandDraft<'_> {
    /// The message; the fallback plan reaches as far as the command is valid.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "the fallback plan is in single precision")]
    pub fn message(&self, h: Header) -> ActuationCommand {
        let inputs = self.plan.map_or(&[][..], |plan| &plan.u);
        let steps = (f64::from(self.valid_for_us) * 1e-6 / self.period).ceil().clamp(0.0, 200.0);
        #[expect(clippy::cast_sign_loss, reason = "from 0 to 200")]
        let inputs = &inputs[..inputs.len().min(steps as usize)];
        ActuationCommand {
            h,
            state_boot_id: self.answered.boot_id.get(),
            state_seq: self.answered.seq.get(),
            state_mono_ns: self.answered.measured.as_ns(),
            valid_for_us: self.valid_for_us,
            arm_token: self.arm_token.get(),
            enable: self.mode == ActuationCommand::MODE_DRIVE,
            mode: self.mode,
            accel: self.input.a,
            steer: self.input.delta,
            n_plan: inputs.len() as i16,
            plan_dt: self.period as f32,
            plan_accel: inputs.iter().map(|u| u.a as f32).collect(),
            plan_steer: inputs.iter().map(|u| u.delta as f32).collect(),
            ..ActuationCommand::default()
        }
    }
}

/// What a command asks for `age` seconds after it came, and whether that is its own input or its fallback
/// plan ([`ActuationReport::COMMAND`], [`ActuationReport::PLAN`]), by the rule of [`plan_step`]. `None` when
/// it is dead, or asks for no driving.
#[must_use]
pub fn input_at(command: &ActuationCommand, age: f64) -> Option<(Input, i8)> {
    let drives = command.enable && command.mode == ActuationCommand::MODE_DRIVE;
    if !drives || age > f64::from(command.valid_for_us) * 1e-6 {
        return None;
    }
    let now = Input { a: command.accel, delta: command.steer };
    let dt = f64::from(command.plan_dt);
    let steps = command.plan_accel.len().min(command.plan_steer.len());
    let Some(step) = plan_step(nanoseconds(age), nanoseconds(dt), dt, steps) else {
        return Some((now, ActuationReport::COMMAND));
    };
    let planned = command.plan_accel.get(step).zip(command.plan_steer.get(step));
    let planned = planned.map(|(a, delta)| Input { a: f64::from(*a), delta: f64::from(*delta) });
    Some((planned.unwrap_or(now), ActuationReport::PLAN))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_comes_back_in_the_same_bits_in_either_frame() {
        let track = Track::builtin("l").unwrap();
        let x = State { v_x: 2.1, v_y: -0.03, omega_z: 0.7, e_psi: 0.1, s: 7.3, e_y: -0.2 };
        let mut sent = state_message(
            Header::default(),
            MonoTime::from_ns(5),
            &x,
            Input::default(),
            &track,
            LapIndex::new(2),
        );
        assert_eq!(pose(&sent, track_id(&track)), Some(Pose::Frenet(x)));
        sent.frenet.track_id += 1;
        let Some(Pose::Global(global)) = pose(&sent, track_id(&track)) else {
            panic!("another track's coordinates");
        };
        let back = track.to_frenet(&global, Some(7.0));
        assert!((back.to_vector() - x.to_vector()).norm() < 1e-9, "{back:?}");
        sent.valid = VehicleState::VEL;
        assert_eq!(pose(&sent, track_id(&track)), None);
    }

    #[test]
    fn the_limits_have_the_bits_of_their_report() {
        use vehicle_model::Limit;
        let bits = [
            (Limit::Steering, ActuationReport::STEERING),
            (Limit::SteeringRate, ActuationReport::STEERING_RATE),
            (Limit::Acceleration, ActuationReport::ACCELERATION),
            (Limit::Jerk, ActuationReport::ACCELERATION_RATE),
            (Limit::SpeedCap, ActuationReport::SPEED_CAP),
            (Limit::NotFinite, ActuationReport::NOT_FINITE),
        ];
        assert!(bits.iter().all(|(limit, bit)| *limit as i32 == *bit));
    }

    #[test]
    fn whole_periods_have_the_bits_of_the_offline_clock() {
        for period in [0.1, 0.01, 0.04, 1.0 / 30.0] {
            for n in 0..20_000 {
                let time = f64::from(n) * period;
                assert_eq!(seconds(nanoseconds(time), period).to_bits(), time.to_bits(), "{n}");
            }
        }
        assert_eq!(seconds(150_000_123, 0.1), 0.150_000_123);
    }

    #[test]
    fn a_command_leads_into_its_plan_and_then_dies() {
        let u = |a: f64| Input { a, delta: -a };
        let plan = Plan { x: Vec::new(), u: (0..10).map(|i| u(f64::from(i))).collect() };
        let order = CommandDraft {
            answered: AnsweredState::default(),
            mode: ActuationCommand::MODE_DRIVE,
            input: u(0.0),
            plan: Some(&plan),
            period: 0.1,
            valid_for_us: 250_000,
            arm_token: ArmToken::NONE,
        };
        let mut command = order.message(Header::default());
        assert_eq!(command.n_plan, 3);
        assert_eq!(input_at(&command, 0.1), Some((u(0.0), ActuationReport::COMMAND)));
        assert_eq!(input_at(&command, 0.13), Some((u(1.0), ActuationReport::PLAN)));
        assert_eq!(input_at(&command, 0.24), Some((u(2.0), ActuationReport::PLAN)));
        assert_eq!(input_at(&command, 0.26), None);
        command.enable = false;
        assert_eq!(input_at(&command, 0.0), None);
    }
}
