//! The process between controller and car: the safety core with a clock and a network.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::Result;
use lcm_types::{
    ActuationReport, Checked as _, Heartbeat, Message as _, OperatorAck, OperatorCommand,
    Track as TrackMessage, VehicleState, channels,
};
use vehicle_model::Input;

use super::account::{Account, Refused};
use super::guard::Counts;
use super::orders::{Heard, Orders};
use super::outlet::{Identity, Outlet, random};
use super::pulse::Pulse;
use super::record::Log;
use super::side::CarSide;
use crate::safety::{
    self, Answer, Event, Lapse, Order, OrderKind, Output, Phase, Rules, Safety, Source, decode,
};
use crate::transport::{self, Filter, Inbox, Received, Transport};

/// Messages of each kind that may wait. \[-\]
const WAITING: usize = 1024;

/// Quality of a simulated car's states. \[-\]
const GOOD: i8 = 2;

/// How the bridge ran.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Bridged {
    /// Ticks. \[-\]
    pub ticks: u64,
    /// Ticks that never came, because the bridge was late. \[-\]
    pub missed: u64,
    /// Latest begin of a tick. \[s\]
    pub latest: f64,
    /// Commands.
    pub commands: safety::Counts,
}

/// The bridge.
pub struct Bridge {
    rules: Rules,
    safety: Safety,
    side: CarSide,
    host: String,
    commands: Inbox,
    others: Inbox,
    states: Outlet,
    reports: Outlet,
    acks: Outlet,
    pulse: Pulse<Account>,
    unsent: u64,
    desk: Orders,
    /// What the car was told at the last tick.
    held: Input,
    source: Source,
    bridged: Bridged,
}

impl Bridge {
    /// Between a network and a car.
    ///
    /// # Errors
    /// If the network refuses the subscriptions, or a thread cannot be started.
    pub fn new(
        mut rules: Rules,
        side: CarSide,
        notes: Vec<String>,
        network: &Arc<dyn Transport>,
    ) -> Result<Self> {
        let identity = Identity::new("bridge");
        rules.boot_id = identity.boot_id;
        let (commands, others) = (Inbox::queue(WAITING), Inbox::queue(WAITING));
        let mut heard = side.channels();
        heard.push(channels::COMMAND.to_owned());
        network.subscribe(Filter::Only(heard), commands.sink())?;
        let life = format!("{}lmpc", channels::HEARTBEAT);
        // An order does not wait for the tick.
        network.subscribe(Filter::channel(channels::OPERATOR), commands.urgent_sink())?;
        let names = vec![channels::TRACK.to_owned(), life];
        network.subscribe(Filter::Only(names), others.sink())?;
        let host = identity.sender.rsplit('@').next().unwrap_or_default().to_owned();
        let pulse: Pulse<Account> = Pulse::start(network, &identity, "bridge", None)?;
        pulse.update(|health| health.detail.notes = notes.into());
        Ok(Self {
            states: Outlet::new(network, &identity, channels::STATE),
            reports: Outlet::new(network, &identity, channels::ACTUATION),
            acks: Outlet::new(network, &identity, channels::OPERATOR_ACK),
            pulse,
            safety: Safety::default(),
            desk: Orders::new(&host),
            held: Input::default(),
            source: Source::None,
            bridged: Bridged::default(),
            rules,
            side,
            host,
            commands,
            others,
            unsent: 0,
        })
    }

    /// Tells in every life sign what the log behind the network loses.
    #[must_use]
    pub fn with_log(self, log: Option<Log>) -> Self {
        self.pulse.update(|health| health.detail.log = log);
        self
    }

    /// Runs until `stop` is set; `on_change` hears of every change of state.
    pub fn run(&mut self, stop: &AtomicBool, on_change: &mut dyn FnMut(Phase, Lapse)) -> Bridged {
        let tick = Duration::from_nanos(self.rules.tick_ns.unsigned_abs());
        let mut due = Instant::now();
        let mut acted = due;
        let mut last = self.safety.phase();
        while !stop.load(Ordering::Relaxed) {
            // From the last deadline, not from now: the beat does not drift.
            due += tick;
            while self.listen(due) {
                // Between two beats: what ends the grant does not wait for the next one.
                let now = Instant::now().clamp(acted, due);
                self.act(now - acted);
                acted = now;
            }
            let late = Instant::now().saturating_duration_since(due);
            let missed = u32::try_from(late.as_nanos() / tick.as_nanos()).unwrap_or(u32::MAX - 1);
            due += tick * missed;
            self.bridged.ticks += 1;
            self.bridged.missed += u64::from(missed);
            self.bridged.latest = self.bridged.latest.max(late.as_secs_f64());
            self.act(due - acted);
            acted = due;
            let phase = self.safety.phase();
            if phase != last {
                on_change(phase, self.safety.lapse());
                last = phase;
            }
        }
        self.unsent += u64::from(self.side.finish().is_err());
        self.bridged.commands = self.safety.counts();
        self.bridged
    }

    /// Takes in what comes until `due`; true if the car has to be stopped before that.
    fn listen(&mut self, due: Instant) -> bool {
        for _ in 0..WAITING {
            if self.owes_stop() {
                break;
            }
            let Some(received) = self.commands.wait_until(self.wake(due)) else { break };
            match received.channel.as_str() {
                channels::OPERATOR => self.order(&received),
                channels::COMMAND => self.command(&received),
                _ => self.tell(&received),
            }
            self.commands.recycle(received);
        }
        for _ in 0..WAITING {
            let Some(received) = self.others.take() else { break };
            self.hear(&received);
            self.others.recycle(received);
        }
        if !self.owes_stop() {
            // A storm does not bring the tick forward.
            std::thread::sleep(self.wake(due).saturating_duration_since(Instant::now()));
        }
        Instant::now() < due
    }

    /// Whether the car does not know yet that it is being stopped.
    fn owes_stop(&self) -> bool {
        self.source != Source::Stop
            && matches!(self.safety.phase(), Phase::SafeStop | Phase::Estop | Phase::Fault)
    }

    /// The next tick, or just after the grant ends, whichever comes first.
    fn wake(&self, due: Instant) -> Instant {
        let Some(until_ns) = self.safety.deadline(&self.rules) else { return due };
        let left_ns = until_ns.saturating_add(1).saturating_sub(transport::now().mono_ns);
        due.min(Instant::now() + Duration::from_nanos(left_ns.max(0).unsigned_abs()))
    }

    /// The car moves on by `dt`, is measured, and gets its next input.
    fn act(&mut self, dt: Duration) {
        let held = self.held;
        if self.safety.phase() != Phase::Fault
            && let Err(error) = self.side.drive(held, dt)
        {
            self.fail(&error.to_string());
        }
        let measured = self.side.measure();
        let meas_ns = transport::now().mono_ns;
        if let Some(x) = measured {
            self.step(&Event::State(x, GOOD));
        }
        let output = self.step(&Event::Tick);
        (self.held, self.source) = (output.applied.sent, output.source);
        if let Err(error) = self.side.actuate(&output) {
            self.fail(&format!("the car cannot be told: {error}"));
        }
        self.report(&output);
        self.step(&Event::Sent);
        if let Some(x) = measured {
            let h = self.states.header();
            if let Some(state) = self.side.message(h, meas_ns, &x, output.applied.sent) {
                self.publish(&state);
            }
        }
    }

    fn fail(&mut self, why: &str) {
        self.refuse(Refused::Car(why.into()));
        self.step(&Event::CarFailed);
    }

    fn refuse(&self, what: Refused) {
        self.pulse.update(|health| health.detail.refused = Some(what));
    }

    /// A message of a real car.
    fn tell(&mut self, received: &Received) {
        let Some(told) = self.side.hear(received) else { return };
        if told.is_new {
            self.step(&Event::State(told.x, told.message.quality));
        }
        self.publish(&VehicleState { h: self.states.header(), ..told.message });
    }

    fn publish(&mut self, state: &VehicleState) {
        // The network may be gone: the car is still there.
        let sent = self.states.send_sealed(state);
        self.unsent += u64::from(sent.is_err());
    }

    fn step(&mut self, event: &Event<'_>) -> Output {
        let now_ns = transport::now().mono_ns;
        let (next, output) = safety::step(&self.rules, &self.safety, event, now_ns);
        self.safety = next;
        output
    }

    fn command(&mut self, received: &Received) {
        let arrival_ns = received.arrival.mono_ns;
        let reject = match decode(&received.payload, arrival_ns, &self.rules, &self.host) {
            Ok(offer) => match self.step(&Event::Command(&offer)).answer {
                Answer::Rejected(reject) => reject,
                _ => return,
            },
            Err(reject) => {
                self.safety.count(reject);
                reject
            }
        };
        self.refuse(Refused::Command(reject));
    }

    fn hear(&mut self, received: &Received) {
        match received.channel.as_str() {
            channels::TRACK => {
                if let Ok(track) = TrackMessage::open(&received.payload) {
                    self.step(&Event::Track(track.h.boot_id, track.track_id));
                }
            }
            _ => {
                if let Ok(beat) = Heartbeat::decode(&received.payload)
                    && let Answer::Rejected(reject) =
                        self.step(&Event::Pulse(beat.h.boot_id)).answer
                {
                    self.refuse(Refused::LifeSign(reject));
                }
            }
        }
    }

    fn order(&mut self, received: &Received) {
        let times = (received.arrival.mono_ns, transport::now().mono_ns);
        let Some(heard) = self.desk.hear(&received.payload, times) else { return };
        let (boot_id, ack) = match heard {
            Heard::New(order) => (order.h.boot_id, self.obey(&order)),
            // A dead man's switch is held by saying so.
            Heard::Again(order, ack)
                if ack.accepted && order.deadman && order.command == OperatorCommand::START =>
            {
                (order.h.boot_id, self.obey(&order))
            }
            Heard::Again(order, ack) => {
                (order.h.boot_id, OperatorAck { h: self.acks.header(), ..ack })
            }
        };
        // What the network refuses is asked again.
        let _ = self.acks.send(&ack);
        self.desk.answered(boot_id, &ack);
    }

    fn obey(&mut self, order: &OperatorCommand) -> OperatorAck {
        let kind = match order.command {
            OperatorCommand::ARM => OrderKind::Arm { moving: order.value == 1.0 },
            OperatorCommand::DISARM => OrderKind::Disarm,
            OperatorCommand::START => OrderKind::Start,
            OperatorCommand::STOP => OrderKind::Stop,
            OperatorCommand::ESTOP => OrderKind::Estop,
            OperatorCommand::ESTOP_RESET => OrderKind::Reset,
            OperatorCommand::SET_SPEED_CAP => OrderKind::SpeedCap(order.value),
            other => OrderKind::Unknown(other),
        };
        let (token, deadman) = (order.arm_token, order.deadman);
        let answer =
            self.step(&Event::Order(Order { kind, token, deadman, fresh: random() })).answer;
        let detail = match answer {
            Answer::Denied(denied) => denied.to_string(),
            _ => String::new(),
        };
        OperatorAck {
            h: self.acks.header(),
            request_id: order.request_id,
            accepted: detail.is_empty(),
            state: self.safety.phase() as i8,
            arm_token: self.safety.token(),
            detail,
        }
    }

    fn report(&mut self, output: &Output) {
        let (cmd_boot_id, cmd_seq) = self.safety.command().unwrap_or_default();
        let report = ActuationReport {
            h: self.reports.header(),
            cmd_boot_id,
            cmd_seq,
            enabled: matches!(output.source, Source::Command | Source::Plan),
            source: output.source as i8,
            limited: output.applied.bits,
            accel: output.applied.sent.a,
            steer: output.applied.sent.delta,
            crc: 0,
        };
        let sent = self.reports.send_sealed(&report);
        self.unsent += u64::from(sent.is_err());
        let c = self.safety.counts();
        let counts = Counts { ok: c.ok, bad: c.bad, old: c.old, stale: c.stale, lost: c.lost };
        let (lapse, missed, unsent) = (self.safety.lapse(), self.bridged.missed, self.unsent);
        let car = self.side.counts();
        let (state, arm_token) = (self.safety.phase() as i8, self.safety.token());
        self.pulse.update(|health| {
            health.state = state;
            health.counts = counts;
            health.arm_token = arm_token;
            let said = &mut health.detail;
            (said.lapse, said.missed, said.unsent, said.car) = (lapse, missed, unsent, car);
            (said.limited, said.applied) = (c.limited, Some(output.applied));
        });
    }
}
