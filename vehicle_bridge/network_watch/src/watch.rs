//! What was heard so far.

use std::collections::BTreeMap;

use lcm_types::{
    ActuationReport, Heartbeat, MpcTelemetry, OperatorAck, OperatorCommand, Track, VehicleState,
};

use super::stream::Stream;
use super::{
    CarSeen, Estimates, OrderAnswer, OrderSeen, ProgramSeen, Seen, Snapshot, StepSeen, TrackSeen,
};
use safety::{BridgeState, StopReason};

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
    /// A message that arrived; what it was, if it is a message of ours and could be decoded.
    pub fn take(&mut self, channel: &str, payload: &[u8], arrival_ns: i64) -> Option<Seen> {
        if self.streams.len() >= CHANNELS && !self.streams.contains_key(channel) {
            return None;
        }
        let read = Seen::read(channel, payload);
        let stream = self.streams.entry(channel.to_owned()).or_default();
        stream.take(payload.len(), arrival_ns);
        match read? {
            Ok(seen) => {
                stream.read(seen.header());
                self.keep(&seen, arrival_ns);
                Some(seen)
            }
            Err(_) => {
                stream.puzzle();
                None
            }
        }
    }

    fn keep(&mut self, seen: &Seen, arrival_ns: i64) {
        match seen {
            Seen::State(state) => self.state = Some((state.clone(), arrival_ns)),
            Seen::Report(report) => self.report = Some(report.clone()),
            Seen::Step(step) => {
                self.worst_us = self.worst_us.max(step.total_us);
                self.step = Some(step.clone());
            }
            Seen::Track(track) => self.track = Some(track.clone()),
            Seen::Order(order) => self.order(order, arrival_ns),
            Seen::Answer(ack) => self.answer(ack),
            Seen::Beat(name, beat) => {
                // Arming forgets the reason, people want to see the last one still.
                if name == "bridge" && beat.stop_reason != Heartbeat::STOP_NONE {
                    let known = StopReason::of_codes(beat.stop_reason, beat.stop_doubt);
                    self.stop = Some(known.map_or_else(
                        || format!("reason {} of another version", beat.stop_reason),
                        |reason| reason.to_string(),
                    ));
                }
                self.programs.insert(name.clone(), (beat.clone(), arrival_ns));
            }
            Seen::Command(_) | Seen::Lap(_) | Seen::Setup(_) => {}
        }
    }

    /// The last track.
    #[must_use]
    pub fn track(&self) -> Option<&Track> {
        self.track.as_ref()
    }

    /// The last state and when it arrived. \[ns\]
    #[must_use]
    pub fn state(&self) -> Option<(&VehicleState, i64)> {
        self.state.as_ref().map(|(state, at)| (state, *at))
    }

    /// What was applied last.
    #[must_use]
    pub fn report(&self) -> Option<&ActuationReport> {
        self.report.as_ref()
    }

    /// The controller's last step.
    #[must_use]
    pub fn step(&self) -> Option<&MpcTelemetry> {
        self.step.as_ref()
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
                estimates: Estimates::of(step),
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
            Some(ActuationReport::COMMAND) => "command",
            Some(ActuationReport::PLAN) => "plan",
            Some(ActuationReport::SAFE_STOP) => "stop",
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
    #[must_use]
    pub fn place(&self, state: &VehicleState) -> Option<(f64, f64, usize)> {
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

/// How a solver ended, in words, by the code of `LMPC/TELEM`.
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
