//! The process between controller and car: the safety core with a clock and a network.

use std::sync::Arc;
use std::time::Duration;

use anyhow::Result;
use lcm_types::{
    ActuationReport, ArmToken, BootId, Checked as _, Heartbeat, Message as _, OperatorAck,
    OperatorCommand, VehicleState, channels,
};
use vehicle_model::Input;

use super::account::{Account, Refused};
use super::heartbeat::HeartbeatSender;
use super::neighbours::{Neighbours, Role};
use super::side::CarSide;
use super::watchdog::Watchdog;
use auth::Seal;
use protocol::operator_inbox::{Heard, OperatorInbox};
use protocol::publisher::{Identity, Publisher, random};
use protocol::stream_filter::StreamCounts;
use safety::{
    Answer, BridgeEvent, InputSource, Order, OrderKind, Output, Rules, Safety, Setup, decode,
};
use transport::record::NetworkLog;
use transport::{Filter, Inbox, Received, Transport};

/// Messages of each kind that may wait. \[-\]
pub(super) const WAITING: usize = 1024;

/// How the bridge ran.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BridgeSummary {
    /// Ticks. \[-\]
    pub ticks: u64,
    /// Ticks that never came, because the bridge was late. \[-\]
    pub missed: u64,
    /// Latest begin of a tick. \[s\]
    pub latest: f64,
    /// Commands.
    pub commands: safety::CommandCounts,
    /// Panics of the loop; each stops the car. \[-\]
    pub panics: u32,
    /// The car still moved when the bridge ended.
    pub moving: bool,
}

/// The bridge.
pub struct Bridge {
    pub(super) rules: Rules,
    pub(super) safety: Safety,
    pub(super) side: CarSide,
    pub(super) host: String,
    pub(super) commands: Inbox,
    pub(super) others: Inbox,
    pub(super) states: Publisher,
    pub(super) reports: Publisher,
    pub(super) acks: Publisher,
    pub(super) heartbeat: HeartbeatSender<Account>,
    pub(super) unsent: u64,
    pub(super) operators: OperatorInbox,
    pub(super) neighbours: Neighbours,
    /// Who looks after this loop from outside.
    pub(super) watchdog: Option<Watchdog>,
    /// For the bench: panics after this long in RUNNING.
    pub(super) panic_after: Option<Duration>,
    /// Input of the last tick.
    pub(super) held: Input,
    pub(super) source: InputSource,
    pub(super) summary: BridgeSummary,
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
        let names = vec![channels::SETUP.to_owned(), life];
        network.subscribe(Filter::Only(names), others.sink())?;
        let host = identity.sender.rsplit('@').next().unwrap_or_default().to_owned();
        let heartbeat: HeartbeatSender<Account> =
            HeartbeatSender::start(network, &identity, "bridge", None)?;
        heartbeat.update(|health| health.detail.notes = notes.into());
        Ok(Self {
            states: Publisher::new(network, &identity, channels::STATE),
            reports: Publisher::new(network, &identity, channels::ACTUATION),
            acks: Publisher::new(network, &identity, channels::OPERATOR_ACK),
            heartbeat,
            safety: Safety::default(),
            operators: OperatorInbox::new(&host),
            neighbours: Neighbours::new(identity.boot_id),
            panic_after: None,
            watchdog: None,
            held: Input::default(),
            source: InputSource::None,
            summary: BridgeSummary::default(),
            rules,
            side,
            host,
            commands,
            others,
            unsent: 0,
        })
    }

    /// Names other cars and bridges on `network`, which is to have no log behind it: what this
    /// bridge sends itself comes back there.
    ///
    /// # Errors
    /// If the network refuses the subscription.
    pub fn watching(self, network: &Arc<dyn Transport>) -> Result<Self> {
        let other_bridge = format!("{}bridge", channels::HEARTBEAT);
        let names = vec![channels::STATE.to_owned(), other_bridge];
        network.subscribe(Filter::Only(names), self.others.sink())?;
        Ok(self)
    }

    /// Panics after this long in RUNNING: for the bench.
    #[must_use]
    pub fn with_panic(self, panic_after: Option<Duration>) -> Self {
        Self { panic_after, ..self }
    }

    /// Tells in every heartbeat what the log behind the network loses.
    #[must_use]
    pub fn with_log(self, log: Option<NetworkLog>) -> Self {
        self.heartbeat.update(|health| health.log = log);
        self
    }

    /// Notifies the service manager and a relay that the loop runs.
    #[must_use]
    pub fn with_watchdog(self, watchdog: Watchdog) -> Self {
        Self { watchdog: Some(watchdog), ..self }
    }

    /// Counts for every heartbeat what was refused for want of a signature.
    #[must_use]
    pub fn with_seal(self, seal: Option<Seal>) -> Self {
        self.heartbeat.update(|health| health.detail.seal = seal);
        self
    }

    pub(super) fn fail(&mut self, why: &str) {
        self.refuse(Refused::Car(why.into()));
        self.step(&BridgeEvent::CarFailed);
    }

    fn refuse(&self, what: Refused) {
        self.heartbeat.update(|health| health.detail.refused = Some(what));
    }

    /// A message of a real car.
    pub(super) fn on_car_message(&mut self, received: &Received) {
        let Some(told) = self.side.hear(received) else { return };
        if told.is_new {
            self.step(&BridgeEvent::State(told.x, told.message.quality));
        }
        self.publish_state(&VehicleState { h: self.states.header(), ..told.message });
    }

    pub(super) fn publish_state(&mut self, state: &VehicleState) {
        // The network may be gone: the car is still there.
        let sent = self.states.send_sealed(state);
        self.unsent += u64::from(sent.is_err());
        self.step(&BridgeEvent::Published(state.h.number()));
    }

    pub(super) fn step(&mut self, event: &BridgeEvent<'_>) -> Output {
        let now = transport::now().mono;
        let (next, output) = safety::step(&self.rules, &self.safety, event, now);
        self.safety = next;
        output
    }

    pub(super) fn on_command(&mut self, received: &Received) {
        let arrival = received.arrival.mono;
        let reject = match decode(&received.payload, arrival, &self.rules, &self.host) {
            Ok(command) => match self.step(&BridgeEvent::Command(&command)).answer {
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

    pub(super) fn on_message(&mut self, received: &Received) {
        match received.channel.as_str() {
            channels::SETUP => {
                if let Ok(m) = lcm_types::Setup::open(&received.payload) {
                    let lcm_types::Setup { track_id, car_id, config_id, period_ns, .. } = m;
                    let setup = Setup { track_id, car_id, config_id, period_ns };
                    self.step(&BridgeEvent::Setup(m.h.sender_start(), setup));
                }
            }
            channels::STATE => {
                if let Ok(state) = VehicleState::open(&received.payload) {
                    self.neighbours.note(Role::Car, &state.h);
                }
            }
            channel => {
                let Ok(beat) = Heartbeat::decode(&received.payload) else { return };
                if channel.ends_with("bridge") {
                    return self.neighbours.note(Role::Bridge, &beat.h);
                }
                self.neighbours.note(Role::Controller, &beat.h);
                if let Answer::Rejected(reject) =
                    self.step(&BridgeEvent::Heartbeat(beat.h.sender_start())).answer
                {
                    self.refuse(Refused::Heartbeat(reject));
                }
            }
        }
    }

    pub(super) fn on_operator_command(&mut self, received: &Received) {
        let times = (received.arrival.mono, transport::now().mono);
        let Some(heard) = self.operators.hear(&received.payload, times) else { return };
        let (boot_id, ack) = match heard {
            Heard::New(order) => (order.h.sender_start(), self.obey(&order)),
            // A dead man's switch is held by saying so.
            Heard::Again(order, ack)
                if ack.accepted && order.deadman && order.command == OperatorCommand::START =>
            {
                (order.h.sender_start(), self.obey(&order))
            }
            Heard::Again(order, ack) => {
                (order.h.sender_start(), OperatorAck { h: self.acks.header(), ..ack })
            }
        };
        // What the network refuses is asked again.
        let _ = self.acks.send(&ack);
        self.operators.answered(boot_id, &ack);
    }

    fn obey(&mut self, order: &OperatorCommand) -> OperatorAck {
        let kind = match order.command {
            OperatorCommand::ARM => OrderKind::Arm {
                moving: order.value == 1.0,
                controller: BootId::new(order.arm_token),
            },
            OperatorCommand::DISARM => OrderKind::Disarm,
            OperatorCommand::START => OrderKind::Start,
            OperatorCommand::STOP => OrderKind::Stop,
            OperatorCommand::ESTOP => OrderKind::Estop,
            OperatorCommand::ESTOP_RESET => OrderKind::Reset,
            OperatorCommand::SET_SPEED_CAP => OrderKind::SpeedCap(order.value),
            other => OrderKind::Unknown(other),
        };
        let (token, deadman) = (ArmToken::new(order.arm_token), order.deadman);
        let answer = self
            .step(&BridgeEvent::Order(Order {
                kind,
                token,
                deadman,
                fresh: ArmToken::new(random()),
            }))
            .answer;
        let detail = match answer {
            Answer::Denied(denied) => denied.to_string(),
            _ => String::new(),
        };
        OperatorAck {
            h: self.acks.header(),
            request_id: order.request_id,
            accepted: detail.is_empty(),
            state: self.safety.bridge_state() as i8,
            arm_token: self.safety.token().get(),
            detail,
        }
    }

    pub(super) fn publish_report(&mut self, output: &Output) {
        let (boot_id, seq) = self.safety.command().unwrap_or_default();
        let report = ActuationReport {
            h: self.reports.header(),
            cmd_boot_id: boot_id.get(),
            cmd_seq: seq.get(),
            enabled: matches!(output.source, InputSource::Command | InputSource::Plan),
            source: output.source as i8,
            limited: output.applied.bits,
            accel: output.applied.sent.a,
            steer: output.applied.sent.delta,
            crc: 0,
        };
        let sent = self.reports.send_sealed(&report);
        self.unsent += u64::from(sent.is_err());
        let c = self.safety.counts();
        let safety::CommandCounts { ok, bad, wrong_type, old, stale, lost, .. } = c;
        let counts = StreamCounts { ok, bad, wrong_type, old, stale, lost };
        let stop_reason = self.safety.stop_reason();
        let (missed, unsent) = (self.summary.missed, self.unsent);
        let (car, clock) = (self.side.counts(), self.side.clock());
        let (state, arm_token) = (self.safety.bridge_state() as i8, self.safety.token());
        let (neighbours, finding) = (self.neighbours.news(), self.safety.finding());
        let creeps = self.safety.creeps();
        let relay = self.watchdog.as_ref().and_then(Watchdog::trouble).map(Arc::from);
        self.heartbeat.update(|health| {
            health.state = state;
            health.counts = counts;
            (health.arm_token, health.stop_reason) = (arm_token, stop_reason);
            let said = &mut health.detail;
            (said.missed, said.unsent, said.car) = (missed, unsent, car);
            (said.doubt, said.creeps) = (finding, creeps);
            (said.relay, said.clock) = (relay, clock);
            if let Some(news) = neighbours {
                said.neighbours = news;
            }
            (said.limited, said.applied) = (c.limited, Some(output.applied));
        });
    }
}
