//! What was heard so far.

use std::collections::BTreeMap;

use lcm_types::{
    ActuationCommand, ActuationReport, Checked as _, Header, Heartbeat, LapResult, Message as _,
    MpcTelemetry, OperatorAck, OperatorCommand, Track, VehicleState, channels,
};

use super::stream::Stream;
use super::{CarSeen, OrderAnswer, OrderSeen, ProgramSeen, Snapshot, StepSeen, TrackSeen};
use safety::BridgeState;

/// A program silent for longer may be gone. \[s\]
const SILENCE_S: f64 = 0.5;
/// Channels told apart; what else is said is not shown. \[-\]
const CHANNELS: usize = 256;

/// Everything heard so far.
#[derive(Debug, Default)]
pub struct Watch {
    streams: BTreeMap<String, Stream>,
    track: Option<Track>,
    state: Option<(VehicleState, i64)>,
    report: Option<ActuationReport>,
    programs: BTreeMap<String, (Heartbeat, i64)>,
    order: Option<(OrderSeen, i64)>,
    step: Option<MpcTelemetry>,
    worst_us: i32,
    stop: Option<String>,
}

impl Watch {
    /// A message that arrived.
    pub fn take(&mut self, channel: &str, payload: &[u8], arrival_ns: i64) {
        if self.streams.len() >= CHANNELS && !self.streams.contains_key(channel) {
            return;
        }
        let read = self.read(channel, payload, arrival_ns);
        let stream = self.streams.entry(channel.to_owned()).or_default();
        stream.take(payload.len(), arrival_ns);
        match read {
            Some(Ok(h)) => stream.read(&h),
            Some(Err(_)) => stream.puzzle(),
            None => {}
        }
    }

    /// The header of a message of ours; `None` on channels that are not.
    fn read(
        &mut self,
        channel: &str,
        bytes: &[u8],
        arrival_ns: i64,
    ) -> Option<Result<Header, lcm_types::Error>> {
        Some(match channel {
            channels::STATE => VehicleState::open(bytes).map(|state| {
                let h = state.h.clone();
                self.state = Some((state, arrival_ns));
                h
            }),
            channels::ACTUATION => ActuationReport::open(bytes).map(|report| {
                let h = report.h.clone();
                self.report = Some(report);
                h
            }),
            channels::COMMAND | channels::COMMAND_DRY => ActuationCommand::open(bytes).map(|c| c.h),
            channels::TELEMETRY => MpcTelemetry::decode(bytes).map(|step| {
                self.worst_us = self.worst_us.max(step.total_us);
                let h = step.h.clone();
                self.step = Some(step);
                h
            }),
            channels::LAP => LapResult::decode(bytes).map(|lap| lap.h),
            channels::TRACK => Track::open(bytes).map(|track| {
                let h = track.h.clone();
                self.track = Some(track);
                h
            }),
            channels::OPERATOR => OperatorCommand::open(bytes).map(|order| {
                self.order(&order, arrival_ns);
                order.h
            }),
            channels::OPERATOR_ACK => OperatorAck::decode(bytes).map(|ack| {
                self.answer(&ack);
                ack.h
            }),
            other => {
                let name = other.strip_prefix(channels::HEARTBEAT)?;
                Heartbeat::decode(bytes).map(|beat| {
                    let stop = beat.detail.split("; ").find_map(|d| d.strip_prefix("last stop: "));
                    if name == "bridge" {
                        self.stop = stop.map(str::to_owned).or(self.stop.take());
                    }
                    let h = beat.h.clone();
                    self.programs.insert(name.to_owned(), (beat, arrival_ns));
                    h
                })
            }
        })
    }

    fn order(&mut self, order: &OperatorCommand, arrival_ns: i64) {
        let known = self.order.take().filter(|(o, _)| o.request_id == order.request_id);
        let answers = known.map(|(o, _)| o.answers).unwrap_or_default();
        let name = match order.command {
            OperatorCommand::ARM => "arm".to_owned(),
            OperatorCommand::DISARM => "disarm".to_owned(),
            OperatorCommand::START => "start".to_owned(),
            OperatorCommand::STOP => "stop".to_owned(),
            OperatorCommand::ESTOP => "estop".to_owned(),
            OperatorCommand::ESTOP_RESET => "reset".to_owned(),
            OperatorCommand::SET_SPEED_CAP => format!("speed-cap {} m/s", order.value),
            other => format!("unknown ({other})"),
        };
        let (sender, deadman, request_id) =
            (order.h.sender.clone(), order.deadman, order.request_id);
        let seen = OrderSeen { order: name, sender, deadman, answers, request_id, age_s: 0.0 };
        self.order = Some((seen, arrival_ns));
    }

    fn answer(&mut self, ack: &OperatorAck) {
        let Some((order, _)) = self.order.as_mut().filter(|(o, _)| o.request_id == ack.request_id)
        else {
            return;
        };
        let who = ack.h.sender.split('@').next().unwrap_or_default();
        order.answers.retain(|answer| answer.who != who);
        let (who, detail) = (who.to_owned(), ack.detail.clone());
        order.answers.push(OrderAnswer { who, accepted: ack.accepted, detail });
    }

    /// What is known at `now_ns`.
    #[must_use]
    pub fn snapshot(&self, now_ns: i64) -> Snapshot {
        let age = |at: i64| now_ns.saturating_sub(at).max(0) as f64 * 1e-9;
        let ms = |us: i32| f64::from(us) * 1e-3;
        Snapshot {
            track: self.track.as_ref().map(|track| TrackSeen {
                name: track.name.clone(),
                length_m: track.length,
                kappa: track.kappa.clone(),
            }),
            car: self.state.as_ref().map(|(state, at)| self.car(state, age(*at))),
            programs: self.programs.iter().map(|(n, (b, at))| program(n, b, age(*at))).collect(),
            order: self.order.as_ref().map(|(o, at)| OrderSeen { age_s: age(*at), ..o.clone() }),
            step: self.step.as_ref().map(|step| StepSeen {
                status: step_status(step.status).to_owned(),
                total_ms: ms(step.total_us),
                worst_ms: ms(self.worst_us),
                build_ms: ms(step.build_us),
                solve_ms: ms(step.solve_us),
                deadline_ms: ms(step.deadline_us),
                overruns: step.overruns,
                lap: step.lap,
            }),
            last_stop: self.stop.clone(),
            channels: self.streams.iter().map(|(name, s)| s.seen(name, now_ns)).collect(),
        }
    }

    fn car(&self, state: &VehicleState, age_s: f64) -> CarSeen {
        let place = self.place(state);
        let index = place.map(|(_, _, index)| index);
        let width = self.track.as_ref().zip(index).and_then(|(track, i)| {
            Some((f64::from(*track.w_left.get(i)?), f64::from(*track.w_right.get(i)?)))
        });
        let report = self.report.as_ref();
        let driven_by = match report.map(|report| report.source) {
            Some(1) => "command",
            Some(2) => "plan",
            Some(3) => "stop",
            _ => "nobody",
        };
        CarSeen {
            sender: state.h.sender.clone(),
            age_s,
            quality: state.quality,
            s_m: place.map(|(s, ..)| s),
            e_y_m: place.map(|(_, e_y, _)| e_y),
            width_m: width,
            lap: state.frenet.lap,
            v_x_mps: state.vx,
            accel_mps2: report.map_or(0.0, |report| report.accel),
            steer_rad: report.map_or(0.0, |report| report.steer),
            driven_by: driven_by.to_owned(),
            limited: report.map_or(0, |report| report.limited),
        }
    }

    /// Where on the track: s, e_y and the nearest of the track's points. By the car's own word, else
    /// by its position.
    fn place(&self, state: &VehicleState) -> Option<(f64, f64, usize)> {
        let track = self.track.as_ref()?;
        if state.valid & VehicleState::FRENET != 0 && state.frenet.track_id == track.track_id {
            let s = state.frenet.s;
            let index = track.s.iter().rposition(|at| f64::from(*at) <= s).unwrap_or(0);
            return Some((s, state.frenet.e_y, index));
        }
        if state.valid & VehicleState::POSE == 0 {
            return None;
        }
        let points = track.x.iter().zip(&track.y);
        let offset = |(x, y): (&f32, &f32)| (state.x - f64::from(*x), state.y - f64::from(*y));
        let apart = |d: (f64, f64)| d.0.hypot(d.1);
        let (index, (dx, dy)) =
            points.map(offset).enumerate().min_by(|a, b| apart(a.1).total_cmp(&apart(b.1)))?;
        let yaw = f64::from(*track.yaw.get(index)?);
        let along = dx * yaw.cos() + dy * yaw.sin();
        Some((f64::from(*track.s.get(index)?) + along, dy * yaw.cos() - dx * yaw.sin(), index))
    }
}

fn program(name: &str, beat: &Heartbeat, age_s: f64) -> ProgramSeen {
    ProgramSeen {
        name: name.to_owned(),
        sender: beat.h.sender.clone(),
        state: BridgeState::name_of(beat.state).to_owned(),
        age_s,
        alive: age_s <= SILENCE_S,
        uptime_s: beat.uptime_s,
        rss_mb: beat.rss_mb,
        granted: beat.arm_token != 0,
        ok: beat.rx_ok,
        bad: beat.rx_bad,
        old: beat.rx_old,
        stale: beat.rx_stale,
        lost: beat.rx_lost,
        version: beat.version.clone(),
        detail: beat.detail.clone(),
    }
}

fn step_status(status: i8) -> &'static str {
    match status {
        MpcTelemetry::SOLVED => "solved",
        MpcTelemetry::MAX_ITER => "too many iterations",
        MpcTelemetry::INFEASIBLE => "infeasible",
        MpcTelemetry::NUMERIC => "numerical trouble",
        MpcTelemetry::TIMEOUT => "too late",
        MpcTelemetry::FALLBACK => "fallback",
        _ => "unknown",
    }
}
