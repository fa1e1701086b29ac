//! What the wire on the car's side says of a run: measured afterwards, from the stamps in the
//! messages, so that a late observer does not count.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use anyhow::{Context as _, Result};
use hosting::rule::Edges;
use lcm_types::eventlog::EventReader;
use lcm_types::{
    ActuationReport, Checked as _, Frenet, Heartbeat, Message as _, OperatorAck, VehicleState,
    channels,
};
use vehicle_model::{Limiter, State, Track};

use super::controller_side::ControllerMessages;
use super::measure::{Measure, MeasuredValues};
use super::on_car::TRUTH;
use super::output::{STOP, drives, unsafe_reports};
use super::passed::Passed;
use transport::{Inbox, Received};

const PLAN: i8 = ActuationReport::PLAN;
/// A second. \[ns\]
const SECOND_NS: i64 = 1_000_000_000;
/// The car side stood still if two reports are this far apart. \[ms\]
const GAP_MS: f64 = 200.0;

/// Messages received on the car's side.
#[derive(Debug, Default)]
pub(super) struct Heard {
    pub(super) reports: Vec<ActuationReport>,
    states: Vec<VehicleState>,
    /// Of a simulated car that can fail.
    truth: Vec<VehicleState>,
    /// Of the bridge.
    pub(super) beats: Vec<Heartbeat>,
    pub(super) acks: Vec<OperatorAck>,
    pub(super) controller: ControllerMessages,
}

/// What a run is measured by.
pub(super) struct Rule<'a> {
    pub(super) limiter: Limiter,
    pub(super) edges: Edges,
    pub(super) track: &'a Track,
    /// Whether only a grant lets the car drive.
    pub(super) latching: bool,
}

impl Heard {
    /// Everything in the inbox that was sent until then.
    pub(super) fn of(inbox: &Inbox, until_ns: i64) -> Self {
        let mut heard = Self::default();
        while let Some(Received { channel, payload, .. }) = inbox.take() {
            heard.add(&channel, &payload);
        }
        heard.until(until_ns)
    }

    /// The same, from a log of a process that sent or heard it.
    pub(super) fn of_log(log: &Path, until_ns: i64) -> Result<Self> {
        let file = File::open(log).with_context(|| format!("cannot read {}", log.display()))?;
        let mut heard = Self::default();
        for event in EventReader::new(BufReader::new(file)) {
            let event = event?;
            heard.add(&event.channel, &event.data);
        }
        Ok(heard.until(until_ns))
    }

    fn add(&mut self, channel: &str, payload: &[u8]) {
        match channel {
            channels::ACTUATION => self.reports.extend(ActuationReport::open(payload).ok()),
            channels::STATE => self.states.extend(VehicleState::open(payload).ok()),
            TRUTH => self.truth.extend(VehicleState::open(payload).ok()),
            channels::OPERATOR_ACK => self.acks.extend(OperatorAck::decode(payload).ok()),
            "HB/bridge" => self.beats.extend(Heartbeat::decode(payload).ok()),
            _ => self.controller.add(channel, payload),
        }
    }

    /// What follows the observation is the end of the programs.
    fn until(mut self, until_ns: i64) -> Self {
        self.reports.retain(|report| report.h.mono_ns <= until_ns);
        self.states.retain(|state| state.h.mono_ns <= until_ns);
        self.truth.retain(|state| state.h.mono_ns <= until_ns);
        self
    }

    /// Everything that can be measured, with the faults beginning at `start_ns`.
    pub(super) fn values(&self, start_ns: i64, passed: &Passed, rule: &Rule<'_>) -> MeasuredValues {
        let mut values = MeasuredValues::default();
        let after: Vec<_> = self.reports.iter().filter(|r| r.h.mono_ns >= start_ns).collect();
        let ms = |from: i64, to: i64| (to - from) as f64 * 1e-6;
        let first = |source: &dyn Fn(&ActuationReport) -> bool, from: i64| {
            after.iter().find(|r| r.h.mono_ns >= from && source(r)).map(|r| r.h.mono_ns)
        };
        let stops = |r: &ActuationReport| r.source == STOP || !r.enabled;
        let stop = first(&stops, start_ns);
        let genuine = passed.genuine();
        let last_command =
            |before: i64| genuine.iter().rev().find(|c| c.time_ns <= before).map(|c| c.time_ns);
        let mut react = |measure: Measure, from: i64, to: i64| {
            values.insert(measure, ms(from, to));
            values.reacted(measure, (from - start_ns) as f64 * 1e-9);
        };
        if let Some(stop) = stop {
            react(Measure::FaultToStopMs, start_ns, stop);
            if let Some(last) = last_command(stop) {
                react(Measure::LossToStopMs, last, stop);
            }
        }
        let planned = first(&|r| r.source == PLAN, start_ns);
        if let Some((plan, last)) = planned.and_then(|plan| Some((plan, last_command(plan)?))) {
            react(Measure::LossToPlanMs, last, plan);
        }
        if let Some(estop) = passed.estop_ns
            && let Some(obeyed) = first(&stops, estop)
        {
            react(Measure::EstopMs, estop, obeyed);
            values.insert(Measure::EstopsLost, f64::from(passed.estops_lost));
        }
        let resumed =
            |r: &&&ActuationReport| drives(r) && stop.is_some_and(|stop| r.h.mono_ns > stop);
        values.insert(Measure::Resumed, after.iter().filter(resumed).count() as f64);
        self.controller.values(start_ns, &mut values);
        if let Some(rate) = passed.storm_hz() {
            values.insert(Measure::StormHz, rate);
        }
        let refused = |ack: &&OperatorAck| ack.h.mono_ns >= start_ns && !ack.accepted;
        values.insert(Measure::OrdersRefused, self.acks.iter().filter(refused).count() as f64);
        let count =
            |is: &dyn Fn(&ActuationReport) -> bool| after.iter().filter(|r| is(r)).count() as f64;
        values.insert(Measure::PlanTicks, count(&|r| r.source == PLAN));
        let known = |r: &ActuationReport| {
            genuine.iter().any(|c| (c.boot_id, c.seq) == (r.cmd_boot_id, r.cmd_seq))
        };
        values.insert(Measure::BadApplied, count(&|r| drives(r) && !known(r)));
        let beyond = unsafe_reports(&self.reports, &self.acks, &rule.limiter, rule.latching);
        values.insert(Measure::UnsafeOutputs, beyond as f64);
        // The last report before the fault counts: a stop may come in the first one after it.
        let before = self.reports.iter().rfind(|r| r.h.mono_ns < start_ns);
        let all: Vec<_> = before.into_iter().chain(after.iter().copied()).collect();
        let trips = all.windows(2).filter(|p| drives(p[0]) && stops(p[1])).count();
        values.insert(Measure::Trips, trips as f64);
        let gap = |p: &[&ActuationReport]| ms(p[0].h.mono_ns, p[1].h.mono_ns);
        values.insert(Measure::LongestGapMs, after.windows(2).map(gap).fold(0.0, f64::max));
        if let Some(first) = after.windows(2).position(|p| gap(p) > GAP_MS) {
            let driving = after[first + 1..].iter().filter(|r| drives(r)).count();
            values.insert(Measure::DrivesAfterGap, driving as f64);
        }
        values.insert(Measure::Drives, count(&drives));
        self.of_states(start_ns, rule, &mut values);
        self.of_beats(start_ns, &mut values);
        values
    }

    fn of_states(&self, start_ns: i64, rule: &Rule<'_>, values: &mut MeasuredValues) {
        let states = self.judged();
        let track = rule.track;
        let beyond = |state: &VehicleState| {
            let Frenet { s, e_y, e_psi, .. } = state.frenet;
            rule.edges.beyond(track, &State { s, e_y, e_psi, ..State::default() })
        };
        let observed = states.iter().filter(|state| state.h.mono_ns >= start_ns);
        let farthest = observed.map(beyond).fold(f64::NEG_INFINITY, f64::max);
        if farthest.is_finite() {
            values.insert(Measure::BeyondM, farthest);
        }
        let off = states.iter().filter(|state| beyond(state) > 0.0);
        values.insert(Measure::OffTrack, off.count() as f64);
        let after: Vec<_> = states.iter().filter(|s| s.h.mono_ns >= start_ns).collect();
        if let Some(last) = after.last() {
            let least = after.iter().map(|state| state.vx).fold(f64::INFINITY, f64::min);
            values.insert(Measure::LeastSpeedMps, least);
            let at_end = after.iter().filter(|s| last.h.mono_ns - s.h.mono_ns <= SECOND_NS);
            let most = at_end.map(|state| state.vx).fold(f64::NEG_INFINITY, f64::max);
            values.insert(Measure::FinalSpeedMps, most);
        }
        if after.last().is_some_and(|state| state.vx < 0.05) {
            let way =
                after.windows(2).map(|p| (p[1].h.mono_ns - p[0].h.mono_ns) as f64 * 1e-9 * p[0].vx);
            values.insert(Measure::StopDistanceM, way.sum());
        }
    }

    fn of_beats(&self, start_ns: i64, values: &mut MeasuredValues) {
        let before = self.beats.iter().rev().find(|beat| beat.h.mono_ns <= start_ns);
        let dropped = self.beats.iter().map(|beat| beat.log_dropped).max().unwrap_or(0);
        let both = values.get(Measure::LogDropped).unwrap_or(0.0) + dropped as f64;
        values.insert(Measure::LogDropped, both);
        if let (Some(first), Some(last)) = (before, self.beats.last()) {
            let refused = |b: &Heartbeat| b.rx_bad + b.rx_old + b.rx_stale;
            values.insert(Measure::Refused, (refused(last) - refused(first)) as f64);
            let named = last.rx_wrong_type - first.rx_wrong_type;
            values.insert(Measure::FingerprintsNamed, named as f64);
        }
    }

    /// The states a run is judged by: the true ones where the car sends them.
    pub(super) fn judged(&self) -> &[VehicleState] {
        if self.truth.is_empty() { &self.states } else { &self.truth }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]
    use hosting::rule::TrackLimit;

    use super::*;
    use crate::passed::Passing;
    use lcm_types::Header;

    const MS: i64 = 1_000_000;

    fn report(tick: i64, source: i8, steer: f64) -> ActuationReport {
        let h = Header { mono_ns: tick * 10 * MS, seq: tick, ..Header::default() };
        // After the third none came.
        let (enabled, cmd_seq) =
            (matches!(source, ActuationReport::COMMAND | ActuationReport::PLAN), tick.min(2));
        ActuationReport { h, source, enabled, cmd_seq, steer, ..ActuationReport::default() }
    }

    #[test]
    fn reactions_and_unsafe_outputs_come_from_the_stamps() {
        let sources = [1, 1, 1, 2, 2, 3, 3];
        let mut reports: Vec<_> =
            sources.iter().zip(0..).map(|(source, tick)| report(tick, *source, 0.0)).collect();
        reports[6].steer = 0.2;
        let heard = Heard { reports, ..Heard::default() };
        let mut passed = Passed::default();
        for (seq, time_ns) in [(0, -MS), (1, 9 * MS), (2, 19 * MS)] {
            passed.commands.push(Passing { boot_id: 0, token: 5, seq, time_ns });
        }
        // One that starts again and echoes the grant is not the one that was armed.
        passed.commands.push(Passing { boot_id: 1, token: 5, seq: 3, time_ns: 25 * MS });
        let limiter = Limiter {
            a_min: -2.0,
            a_max: 2.0,
            delta_max: 0.4,
            a_rate_max: f64::INFINITY,
            delta_rate_max: 10.0,
            speed_cap: f64::INFINITY,
        };
        let track = Track::builtin("l").unwrap();
        let car = vehicle_model::CarParams::builtin("barc").unwrap();
        let edges = Edges::new(&car, TrackLimit::Body);
        let rule = Rule { limiter, edges, track: &track, latching: true };
        let values = heard.values(10 * MS, &passed, &rule);
        let expected = [
            (Measure::LossToStopMs, 31.0),
            (Measure::LossToPlanMs, 11.0),
            (Measure::FaultToStopMs, 40.0),
            (Measure::UnsafeOutputs, 1.0),
            (Measure::BadApplied, 0.0),
            (Measure::PlanTicks, 2.0),
            (Measure::Trips, 1.0),
        ];
        for (measure, value) in expected {
            let found = values.get(measure).unwrap();
            assert!((found - value).abs() < 1e-9, "{measure:?}: {values:?}");
        }
    }

    #[test]
    fn a_stop_in_the_first_report_after_the_fault_is_a_trip() {
        let track = Track::builtin("l").unwrap();
        let car = vehicle_model::CarParams::builtin("barc").unwrap();
        let (limiter, edges) = (Limiter::new(&car), Edges::new(&car, TrackLimit::Body));
        let rule = Rule { limiter, edges, track: &track, latching: true };
        let trips = |sources: &[i8]| {
            let reports = sources.iter().zip(0..).map(|(source, tick)| report(tick, *source, 0.0));
            let heard = Heard { reports: reports.collect(), ..Heard::default() };
            heard.values(5 * MS, &Passed::default(), &rule).get(Measure::Trips)
        };
        // The fault begins between the first report and the second.
        assert_eq!(trips(&[1, 3, 3]), Some(1.0));
        assert_eq!(trips(&[1, 1, 3]), Some(1.0));
        assert_eq!(trips(&[3, 3, 3]), Some(0.0), "it stood before");
        assert_eq!(trips(&[1, 1, 1]), Some(0.0));
    }

    #[test]
    fn a_body_beyond_the_edge_is_off_the_track() {
        let track = Track::builtin("l").unwrap();
        let car = vehicle_model::CarParams::builtin("barc").unwrap();
        // On a straight, heading along it: centres 1 mm on either side of the body's limit.
        let limit = track.width_left(0.5) - 0.5 * car.width;
        let state = |e_y: f64| VehicleState {
            frenet: Frenet { s: 0.5, e_y, ..Frenet::default() },
            vx: 1.0,
            ..VehicleState::default()
        };
        let heard =
            Heard { states: vec![state(limit - 1e-3), state(limit + 1e-3)], ..Heard::default() };
        let edges = Edges::new(&car, TrackLimit::Body);
        let rule = Rule { limiter: Limiter::new(&car), edges, track: &track, latching: true };
        let values = heard.values(0, &Passed::default(), &rule);
        assert_eq!(values.get(Measure::OffTrack), Some(1.0));
        assert!((values.get(Measure::BeyondM).unwrap() - 1e-3).abs() < 1e-9);
    }
}
