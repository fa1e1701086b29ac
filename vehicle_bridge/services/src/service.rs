//! The controller as a service: one command for each state that is due.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::Result;
use controller::{Command, Controller, Reason};
use lcm_types::{
    ActuationCommand, Heartbeat, MonoTime, OperatorAck, OperatorCommand, VehicleState, channels,
};
use vehicle_model::Input;

use super::deadline_monitor::DeadlineMonitor;
use super::descriptions::Descriptions;
use super::grant::Grant;
use super::heartbeat::{HeartbeatSender, TrackAndSetup};
use super::operator::{self, Authority};
use super::schedule::Schedule;
pub use super::service_options::ServiceOptions;
use super::store::LearnedDataStore;
use auth::Seal;
use hosting::timing::Stopwatch;
use protocol::convert::{self, AnsweredState, CommandDraft};
use protocol::operator_inbox::{Heard, OperatorInbox};
use protocol::publisher::{Identity, Publisher};
use protocol::stream_filter::{Accepted, StreamFilter};
use protocol::telemetry::{self, HostTelemetry, LapSeen};
use transport::{Filter, Inbox, Received, Transport};

/// A silence this long lets another sender of states in. \[s\]
const SILENCE: f64 = 1.0;
/// Messages on the states' channel that may wait while the controller computes. \[-\]
const WAITING: usize = 1024;
/// Longest sleep, so that signals and orders are seen.
const NAP: Duration = Duration::from_millis(20);

/// What a lap was, for who watches.
pub type OnLap<'a> = &'a mut dyn FnMut(&controller::LapResult, &LapSeen);

/// The service.
pub struct Service {
    options: ServiceOptions,
    controller: Controller,
    store: Option<LearnedDataStore>,
    states: Inbox,
    orders: Inbox,
    filter: StreamFilter,
    operators: OperatorInbox,
    authority: Authority,
    grant: Grant,
    commands: Publisher,
    telemetry: Publisher,
    laps: Publisher,
    acks: Publisher,
    heartbeat: HeartbeatSender,
    schedule: Schedule,
    track_id: i64,
    descriptions: Descriptions,
    seen: LapSeen,
    last: Option<Last>,
    deadlines: DeadlineMonitor,
    send_errors: u64,
    save_error: Option<String>,
}

/// The last step.
#[derive(Debug, Clone, Copy)]
struct Last {
    answered: AnsweredState,
    input: Input,
    speed: f64,
    arrival: MonoTime,
    /// The input was cut after the controller gave it.
    cut: bool,
    /// The controller answered this state.
    stepped: bool,
}

impl Service {
    /// On a network, with a controller that may have loaded data.
    ///
    /// # Errors
    /// If the network refuses the subscriptions, or a thread cannot be started.
    pub fn new(
        options: ServiceOptions,
        controller: Controller,
        store: Option<LearnedDataStore>,
        network: &Arc<dyn Transport>,
    ) -> Result<Self> {
        let identity = Identity::new("lmpc");
        let publisher = |channel: &str| Publisher::new(network, &identity, channel);
        let (states, orders) = (Inbox::queue(WAITING), Inbox::queue(64));
        network.subscribe(Filter::channel(channels::STATE), states.sink())?;
        network.subscribe(Filter::channel(channels::OPERATOR), orders.sink())?;
        let grant = Grant::listen(network)?;
        let host = identity.sender.rsplit('@').next().unwrap_or_default();
        let (age, silence) =
            (convert::nanoseconds(options.valid_for), convert::nanoseconds(SILENCE));
        let name = if options.dry_run { channels::COMMAND_DRY } else { channels::COMMAND };
        let track = telemetry::track_message(controller.track());
        let driven = TrackAndSetup { track, setup: options.setup.clone() };
        let key = store.as_ref().map(|s| s.path().display().to_string()).unwrap_or_default();
        let seen = LapSeen::new(controller.car(), key);
        let heartbeat = HeartbeatSender::start(network, &identity, "lmpc", Some(driven))?;
        heartbeat.update(|health| health.log.clone_from(&options.log));
        Ok(Self {
            filter: StreamFilter::new(age, silence, host),
            operators: OperatorInbox::new(host),
            authority: Authority::new(options.wait_for_start),
            commands: publisher(name),
            telemetry: publisher(channels::TELEMETRY),
            laps: publisher(channels::LAP),
            acks: publisher(channels::OPERATOR_ACK),
            grant,
            heartbeat,
            schedule: Schedule::new(convert::nanoseconds(controller.config().horizon.period)),
            track_id: convert::track_id(controller.track()),
            descriptions: Descriptions::new(controller.car(), controller.track()),
            seen,
            last: None,
            deadlines: DeadlineMonitor::default(),
            send_errors: 0,
            save_error: None,
            options,
            controller,
            store,
            states,
            orders,
        })
    }

    /// Serves until `stop` is set, then commands the car to stop.
    pub fn run(&mut self, stop: &AtomicBool, on_lap: OnLap<'_>) {
        let period = Duration::from_secs_f64(self.controller.config().horizon.period);
        let mut deadline = Instant::now() + period;
        while !stop.load(Ordering::Relaxed) {
            self.grant.update();
            while let Some(order) = self.orders.take() {
                self.on_operator_command(&order);
            }
            let received = self.states.wait_until(deadline.min(Instant::now() + NAP));
            if received.is_some_and(|received| self.on_state(received, &mut *on_lap)) {
                deadline = Instant::now() + period;
            } else if Instant::now() >= deadline {
                self.overdue();
                // From the last deadline, not from now: the beat does not drift.
                deadline += period;
            }
            self.update_heartbeat();
        }
        self.publish_stop(ActuationCommand::MODE_SAFE_STOP);
        if let (Some(store), true) = (&self.store, self.controller.learning_pending()) {
            self.controller.finish_learning();
            store.save(&self.controller);
        }
    }

    /// Answers the newest accepted state; false if there was none. All that wait are checked:
    /// whatever else is sent on the channel displaces no state.
    fn on_state(&mut self, first: Received, on_lap: OnLap<'_>) -> bool {
        let (mut newest, mut next) = (None, Some(first));
        for _ in 0..WAITING {
            let Some(received) = next else { break };
            newest = self.believe(&received).map(|s| (s, received.arrival.mono)).or(newest);
            self.states.recycle(received);
            next = self.states.take();
        }
        let Some((state, arrival)) = newest else { return false };
        match self.mode() {
            ActuationCommand::MODE_DRIVE => self.drive(&state, arrival, on_lap),
            mode => {
                self.remember(&state, arrival);
                self.publish_stop(mode);
            }
        }
        true
    }

    /// What the operator wants, as far as a bridge that is heard lets the car drive.
    fn mode(&self) -> i8 {
        match self.authority.mode() {
            ActuationCommand::MODE_DRIVE if !self.grant.lets_drive() => ActuationCommand::MODE_OFF,
            mode => mode,
        }
    }

    /// A state, if it is believed.
    fn believe(&mut self, received: &Received) -> Option<VehicleState> {
        let (arrival, now) = (received.arrival.mono, transport::now().mono);
        let (track_id, bridge) = (self.track_id, self.grant.bridge());
        let descriptions = &self.descriptions;
        let sane = |state: &VehicleState| {
            // Another car's answers would be another car's commands.
            bridge.is_none_or(|bridge| state.h.sender_start() == bridge)
                && state.quality > VehicleState::BAD
                && convert::pose(state, track_id).is_some_and(|pose| convert::is_finite(&pose))
                && descriptions.agree(state)
        };
        let times = (arrival, now);
        let checked = self.filter.check(&received.payload, times, |state| &state.h, sane);
        let Accepted { message: state, fresh_start } = checked.ok()?;
        if fresh_start {
            self.schedule.restart(state.meas_mono_ns, arrival.as_ns());
        }
        Some(state)
    }

    fn remember(&mut self, state: &VehicleState, arrival: MonoTime) {
        let input = self.last.map(|last| last.input).unwrap_or_default();
        let (answered, speed) = (AnsweredState::of(state), state.vx);
        self.last = Some(Last { answered, input, speed, arrival, cut: true, stepped: false });
    }

    fn drive(&mut self, state: &VehicleState, arrival: MonoTime, on_lap: OnLap<'_>) {
        let answered = AnsweredState::of(state);
        if self.last.is_some_and(|last| {
            last.stepped
                && last.answered.boot_id == answered.boot_id
                && last.answered.measured == answered.measured
        }) {
            // The same measurement again: the car did not receive the answer.
            self.publish_command(answered, ActuationCommand::MODE_DRIVE);
            return;
        }
        let Some(time_ns) = self.schedule.due(state.meas_mono_ns, arrival.as_ns()) else { return };
        let Some(pose) = convert::pose(state, self.track_id) else { return };
        let period = self.controller.config().horizon.period;
        // Normally the controller's own word is what was applied.
        let applied = self.last.filter(|last| last.cut).map(|last| last.input);
        let measurement = convert::measurement(pose, time_ns, period, applied);
        let mut stopwatch = Stopwatch::start();
        let command = self.controller.step_probed(&measurement, &mut stopwatch);
        self.options.overrun.iter().for_each(|overrun| overrun.wait(self.deadlines.steps));
        let time = stopwatch.stop();
        let cap = self.authority.speed_cap;
        let before = self.last.map(|last| last.input).unwrap_or_default();
        let input = operator::capped(command.input, before, state.vx, cap, &self.controller);
        let cut = input != command.input;
        self.last = Some(Last { answered, input, speed: state.vx, arrival, cut, stepped: true });
        let elapsed = || transport::now().mono.ns_since(arrival) as f64 * 1e-9;
        if self.deadlines.step(elapsed() > period) {
            self.authority.state = Heartbeat::SAFE_STOP;
        }
        self.publish_command(answered, self.authority.mode());
        let total = elapsed();
        self.deadlines.longest = self.deadlines.longest.max(total);
        let (state_seq, overruns) = (answered.seq, self.deadlines.overruns);
        self.publish_step(&command, &HostTelemetry { state_seq, time, total, overruns }, on_lap);
    }

    fn publish_command(&mut self, answered: AnsweredState, mode: i8) {
        let input = self.last.map(|last| last.input).unwrap_or_default();
        let drives = mode == ActuationCommand::MODE_DRIVE;
        let cut = self.last.is_some_and(|last| last.cut);
        #[expect(clippy::cast_possible_truncation, reason = "seconds")]
        let valid_for_us = (self.options.valid_for * 1e6) as i32;
        let order = CommandDraft {
            answered,
            mode,
            input: if drives { input } else { Input { a: 0.0, ..input } },
            plan: (drives && !cut).then(|| self.controller.plan()),
            period: self.controller.config().horizon.period,
            valid_for_us,
            arm_token: self.grant.token(),
        };
        let message = order.message(self.commands.header());
        let sent = self.commands.send_sealed(&message);
        self.count(sent);
    }

    fn publish_stop(&mut self, mode: i8) {
        let answered = self.last.map(|last| last.answered).unwrap_or_default();
        self.publish_command(answered, mode);
    }

    /// After the command: telemetry, the end of a lap, and what can be prepared.
    fn publish_step(&mut self, command: &Command, step: &HostTelemetry, on_lap: OnLap<'_>) {
        let h = self.telemetry.header();
        let message = telemetry::step_message(h, &self.controller, command, step);
        let sent = self.telemetry.send(&message);
        self.count(sent);
        if let Some(lap) = &command.status.finished {
            let best = if lap.valid { lap.lap_time } else { f64::INFINITY };
            self.seen.best_time = self.seen.best_time.min(best);
            let h = self.laps.header();
            let message = telemetry::lap_message(h, self.track_id, lap, &self.seen);
            let sent = self.laps.send(&message);
            self.count(sent);
            on_lap(lap, &self.seen);
            self.seen.close(lap);
        }
        let late = step.total > self.controller.config().horizon.period;
        if command.status.reason != Reason::TimeNotAdvancing {
            self.seen.add(self.controller.track(), command, late);
        }
        // The work of a lap's end takes a few steps; only then is there something new to keep.
        let pending = self.controller.learning_pending();
        self.controller.prepare();
        if let (Some(store), true) = (&self.store, pending && !self.controller.learning_pending()) {
            store.save(&self.controller);
        }
    }

    /// No state came in time. The car follows its last command's plan as long as that is valid.
    fn overdue(&mut self) {
        let Some(last) = self.last else { return };
        let silent_ns = transport::now().mono.ns_since(last.arrival);
        if silent_ns > convert::nanoseconds(self.options.valid_for) {
            self.publish_stop(match self.mode() {
                ActuationCommand::MODE_DRIVE => ActuationCommand::MODE_SAFE_STOP,
                mode => mode,
            });
        }
    }

    fn on_operator_command(&mut self, received: &Received) {
        let times = (received.arrival.mono, transport::now().mono);
        let order = match self.operators.hear(&received.payload, times) {
            None => return,
            Some(Heard::New(order)) => order,
            Some(Heard::Again(_, ack)) => {
                let sent = self.acks.send(&OperatorAck { h: self.acks.header(), ..ack });
                return self.count(sent);
            }
        };
        if matches!(order.command, OperatorCommand::ARM | OperatorCommand::DISARM) {
            return; // for the bridge alone
        }
        let answer = self.authority.obey(&order, self.last.map(|last| last.speed));
        let cap = operator::plan_cap(self.authority.speed_cap, &self.controller);
        // Both ends have the same range: what the authority took, the controller takes.
        let answer = answer
            .and_then(|()| self.controller.set_speed_cap(cap).map_err(|error| error.to_string()));
        let ack = OperatorAck {
            h: self.acks.header(),
            request_id: order.request_id,
            accepted: answer.is_ok(),
            state: self.authority.state,
            arm_token: 0,
            detail: answer.err().unwrap_or_default(),
        };
        let sent = self.acks.send(&ack);
        self.operators.answered(order.h.sender_start(), &ack);
        self.count(sent);
    }

    fn count(&mut self, sent: Result<()>) {
        self.send_errors += u64::from(sent.is_err());
    }

    fn update_heartbeat(&mut self) {
        if let Some(outcome) = self.store.as_ref().and_then(LearnedDataStore::outcome) {
            self.save_error = outcome;
        }
        let (state, counts) = (self.authority.state, self.filter.counts);
        let laps = self.controller.laps().len();
        let save_failures = self.store.as_ref().map_or(0, LearnedDataStore::failures);
        let mut detail = vec![format!("{laps} laps learned")];
        detail.extend(self.options.notes.iter().cloned());
        detail.extend(self.deadlines.complaint());
        if self.send_errors > 0 {
            detail.push(format!("{} messages could not be sent", self.send_errors));
        }
        detail.extend(self.save_error.clone());
        detail.extend(self.grant.complaint());
        detail.extend(self.descriptions.complaint());
        detail.extend(self.options.seal.as_ref().and_then(Seal::complaint));
        self.heartbeat.update(|health| {
            health.state = state;
            health.counts = counts;
            health.laps_learned = Some(laps);
            health.save_failures = save_failures;
            health.detail = detail.join("; ");
        });
    }

    /// The work so far.
    #[must_use]
    pub fn deadlines(&self) -> DeadlineMonitor {
        self.deadlines
    }

    /// The controller.
    #[must_use]
    pub fn controller(&self) -> &Controller {
        &self.controller
    }
}
