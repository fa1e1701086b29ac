//! The reference driver and the operator: commands and orders by the real protocol.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use anyhow::Result;
use lcm_types::{
    ActuationCommand, Checked as _, Heartbeat, Message as _, OperatorAck, VehicleState, channels,
};
use vehicle_model::{CarParams, Track};

use super::fault::{Fault, FaultKind};
use super::operator::{BenchOperator, Duty, Switch};
use super::proxy::Start;
use hosting::realtime;
use hosting::worker::Worker;
use protocol::convert;
use protocol::publisher::{Identity, Publisher};
use transport::{Filter, Inbox, Received, Transport, now};

const PULSE: Duration = Duration::from_millis(100);
/// A round of the operator.
const ROUND: Duration = Duration::from_millis(10);
/// A command is dead after the bridge's timeout. \[us\]
const VALID_US: i32 = 100_000;
/// Rise time of the speed loop. \[s\]
const SPEED_TIME: f64 = 0.4;
/// Distance over which a deviation decays. \[m\]
const REACH: f64 = 0.9;

/// How far the drive is.
#[derive(Debug, Clone, Default)]
pub(super) struct Progress {
    /// First command sent, monotonic. \[ns\]
    pub(super) driving_ns: Option<i64>,
    /// Speed. \[m/s\]
    pub(super) speed: f64,
    /// Position. \[m\]
    pub(super) s: f64,
    /// Laps begun. \[-\]
    pub(super) lap: i32,
    /// Why the car side last refused an order.
    pub(super) refusal: String,
}

/// What the driver is to do.
#[derive(Debug, Clone)]
pub(super) struct Task {
    pub(super) car: CarParams,
    pub(super) track: Arc<Track>,
    pub(super) speed: f64,
    /// Whether it sends commands, or leaves them to a process.
    pub(super) commands: bool,
    /// Whether the car side is to be armed first.
    pub(super) arming: bool,
    /// Whether the operator holds a dead man's switch.
    pub(super) deadman: bool,
    pub(super) faults: Vec<Fault>,
}

/// The running thread; ends when dropped.
pub(super) struct Driver {
    progress: Arc<Mutex<Progress>>,
    orders: Arc<Mutex<BTreeSet<usize>>>,
    _worker: Worker,
}

impl Driver {
    /// Begins to answer states.
    pub(super) fn start(network: &Arc<dyn Transport>, task: Task, start: &Start) -> Result<Self> {
        let progress: Arc<Mutex<Progress>> = Arc::default();
        let inbox = Inbox::queue(64);
        let names = [channels::STATE, channels::OPERATOR_ACK, "HB/bridge"];
        let names = names.map(str::to_owned).to_vec();
        network.subscribe(Filter::Only(names), inbox.sink())?;
        let operator = BenchOperator::new(network);
        let orders = operator.sent();
        let mut source = Source {
            inbox,
            network: Arc::clone(network),
            out: Outlets::new(network),
            operator,
            task,
            start: Arc::clone(start),
            progress: Arc::clone(&progress),
            restarted: false,
        };
        let worker = Worker::start("hil-driver", move |stop| {
            let _ = realtime::prioritise(realtime::RECEIVE_PRIORITY);
            source.run(stop);
        })?;
        Ok(Self { progress, orders, _worker: worker })
    }

    /// Faults whose order the operator gave, by their place in the scenario.
    pub(super) fn orders(&self) -> BTreeSet<usize> {
        self.orders.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// How far it is.
    pub(super) fn progress(&self) -> Progress {
        self.progress.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// What one start of the controller sends on.
struct Outlets {
    commands: Publisher,
    pulse: Publisher,
    map: Publisher,
    setup: Publisher,
}

impl Outlets {
    fn new(network: &Arc<dyn Transport>) -> Self {
        let identity = Identity::new("lmpc");
        Self {
            commands: Publisher::new(network, &identity, channels::COMMAND),
            pulse: Publisher::new(network, &identity, "HB/lmpc"),
            map: Publisher::new(network, &identity, channels::TRACK),
            setup: Publisher::new(network, &identity, channels::SETUP),
        }
    }
}

struct Source {
    inbox: Inbox,
    network: Arc<dyn Transport>,
    out: Outlets,
    operator: BenchOperator,
    task: Task,
    start: Start,
    progress: Arc<Mutex<Progress>>,
    restarted: bool,
}

impl Source {
    fn run(&mut self, stop: &AtomicBool) {
        let (mut pulse, mut round) = (Instant::now(), Instant::now());
        while !stop.load(Ordering::Relaxed) {
            round = (round + ROUND).max(Instant::now());
            while let Some(received) = self.inbox.wait_until(round) {
                self.hear(&received);
            }
            if Instant::now() >= pulse {
                pulse = Instant::now() + PULSE;
                self.beat();
            }
            self.operator.round(self.duty(), self.switch());
        }
    }

    fn hear(&mut self, received: &Received) {
        match received.channel.as_str() {
            channels::STATE => {
                if let Ok(state) = VehicleState::open(&received.payload) {
                    self.state(&state);
                }
            }
            channels::OPERATOR_ACK => {
                if let Ok(ack) = OperatorAck::decode(&received.payload) {
                    self.operator.answer(&ack);
                    if !ack.accepted {
                        let mut progress =
                            self.progress.lock().unwrap_or_else(PoisonError::into_inner);
                        progress.refusal.clone_from(&ack.detail);
                    }
                    self.grant(ack.arm_token, ack.state);
                }
            }
            _ => {
                if let Ok(beat) = Heartbeat::decode(&received.payload) {
                    self.grant(beat.arm_token, beat.state);
                }
            }
        }
    }

    fn grant(&mut self, token: i64, state: i8) {
        // After the faults begin nobody arms again by itself, and the grant of before is echoed.
        if !self.stopping() || self.rearms() {
            self.operator.grant(token, state);
        }
    }

    /// What the operator does now.
    fn duty(&self) -> Duty {
        // Of several orders the one that began last: an earlier one was given by then.
        let since = now().mono.as_ns().saturating_sub(self.start.load(Ordering::Acquire));
        let faults = self.task.faults.iter().enumerate();
        let begun = faults.filter_map(|(index, fault)| match fault.action {
            FaultKind::Order { order, value } => {
                let (from, until) = fault.window_ns();
                let acts = self.stopping() && (from..until).contains(&since);
                acts.then_some((from, index, order, value.unwrap_or_default()))
            }
            _ => None,
        });
        match begun.max_by_key(|(from, index, ..)| (*from, *index)) {
            Some((_, index, order, value)) => Duty::Give(index, order, value),
            None if self.task.arming && (!self.stopping() || self.rearms()) => Duty::Drive,
            None => Duty::Watch,
        }
    }

    fn switch(&self) -> Switch {
        if !self.task.deadman || self.acts(|a| matches!(a, FaultKind::DeadmanSilent {})) {
            Switch::Silent
        } else if self.acts(|a| matches!(a, FaultKind::DeadmanReleased {})) {
            Switch::Released
        } else {
            Switch::Held
        }
    }

    fn stopping(&self) -> bool {
        self.start.load(Ordering::Acquire) != i64::MAX
    }

    fn rearms(&self) -> bool {
        self.acts(|action| matches!(action, FaultKind::Rearm {}))
    }

    /// Whether a fault of this kind acts now.
    fn acts(&self, is: impl Fn(&FaultKind) -> bool) -> bool {
        let start = self.start.load(Ordering::Acquire);
        let since = now().mono.as_ns().saturating_sub(start);
        start != i64::MAX
            && self.task.faults.iter().any(|fault| {
                let (from, until) = fault.window_ns();
                is(&fault.action) && (from..until).contains(&since)
            })
    }

    fn beat(&mut self) {
        if !self.task.commands || self.acts(|a| matches!(a, FaultKind::SourceSilent {})) {
            return;
        }
        let message = Heartbeat {
            h: self.out.pulse.header(),
            state: Heartbeat::RUNNING,
            arm_token: self.operator.token,
            ..Heartbeat::default()
        };
        let _ = self.out.pulse.send(&message);
        let map = lcm_types::Track {
            h: self.out.map.header(),
            ..protocol::telemetry::track_message(&self.task.track)
        };
        let _ = self.out.map.send_sealed(&map);
        let setup = lcm_types::Setup {
            h: self.out.setup.header(),
            track_id: convert::track_id(&self.task.track),
            car_id: convert::car_id(&self.task.car),
            track: self.task.track.name().to_owned(),
            car: self.task.car.name.clone(),
            ..lcm_types::Setup::default()
        };
        let _ = self.out.setup.send_sealed(&setup);
    }

    fn state(&mut self, state: &VehicleState) {
        {
            let mut progress = self.progress.lock().unwrap_or_else(PoisonError::into_inner);
            (progress.speed, progress.s, progress.lap) =
                (state.vx, state.frenet.s, state.frenet.lap);
            if progress.driving_ns.is_none() && (!self.task.arming || self.operator.running) {
                progress.driving_ns = Some(now().mono.as_ns());
            }
        }
        if !self.task.commands || self.acts(|a| matches!(a, FaultKind::SourceSilent {})) {
            return;
        }
        if !self.restarted && self.acts(|a| matches!(a, FaultKind::SourceRestart {})) {
            self.restarted = true;
            self.out = Outlets::new(&self.network);
        }
        let (accel, steer) = self.track(state);
        let plan: Vec<f32> = vec![0.0; 10];
        #[expect(clippy::cast_possible_truncation, reason = "the plan is in single precision")]
        let message = ActuationCommand {
            h: self.out.commands.header(),
            state_boot_id: state.h.boot_id,
            state_seq: state.h.seq,
            state_mono_ns: state.meas_mono_ns,
            valid_for_us: VALID_US,
            arm_token: self.operator.token,
            enable: true,
            mode: ActuationCommand::MODE_DRIVE,
            accel,
            steer,
            n_plan: 10,
            plan_dt: 0.01,
            plan_steer: vec![steer as f32; 10],
            plan_accel: plan,
            ..ActuationCommand::default()
        };
        let _ = self.out.commands.send_sealed(&message);
    }

    /// Along the centre line at the speed asked for: acceleration and steering angle.
    fn track(&self, state: &VehicleState) -> (f64, f64) {
        let (car, f) = (&self.task.car, &state.frenet);
        let kappa = self.task.track.kappa(f.s);
        let wanted = kappa - f.e_y / (REACH * REACH) - 2.0 * f.e_psi.sin() / REACH;
        let steer = ((car.l_f + car.l_r) * wanted).atan().clamp(-car.delta_max, car.delta_max);
        let accel = ((self.task.speed - state.vx) / SPEED_TIME).clamp(car.a_min, car.a_max);
        (accel, steer)
    }
}
