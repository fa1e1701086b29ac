//! The bridge to a real car that speaks its own messages.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use lcm_types::{ActuationCommand, ActuationReport, BootId, channels};
use vehicle_model::{CarParams, Input};

use super::heartbeat::HeartbeatSender;
use mapping::{CarRequest, Mapping};
use protocol::convert;
use protocol::publisher::{Identity, Publisher};
use protocol::stream_filter::{Accepted, StreamCounts, StreamFilter};
use transport::{Filter, Inbox, Received, Transport};

const SILENCE_NS: i64 = 1_000_000_000;
/// Slower than this, the car stands. \[m/s\]
const STILL: f64 = 0.1;
/// Longest sleep, so that signals are seen.
const NAP: Duration = Duration::from_millis(20);
/// At the end the stop is sent this often: one may be lost. \[-\]
const LAST_WORDS: u32 = 3;

/// What the bridge did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MappedCarSummary {
    /// States published. \[-\]
    pub states: u64,
    /// Commands sent to the car. \[-\]
    pub sent: u64,
    /// Times the commands ended and the stop was sent. \[-\]
    pub stops: u64,
    /// What became of the controller's commands.
    pub commands: StreamCounts,
    /// What became of the car's messages.
    pub source: mapping::CarMessageCounts,
}

/// Between the car's messages and ours.
pub struct MappedCar {
    mapping: Mapping,
    network: Arc<dyn Transport>,
    inbox: Inbox,
    filter: StreamFilter,
    car: CarParams,
    states: Publisher,
    reports: Publisher,
    heartbeat: HeartbeatSender<mapping::CarMessageCounts>,
    boot_id: BootId,
    /// Whether the car moves, by its last state.
    moves: bool,
    /// Start of the controller obeyed so far.
    obeyed: Option<BootId>,
    /// The command in force and when it came.
    command: Option<(ActuationCommand, Instant)>,
    source: i8,
    applied: Input,
    bytes: Vec<u8>,
    summary: MappedCarSummary,
}

impl MappedCar {
    /// On a network; `car` gives the limits a sane command keeps.
    ///
    /// # Errors
    /// If the network refuses the subscription, or a thread cannot be started.
    pub fn new(mapping: Mapping, car: CarParams, network: &Arc<dyn Transport>) -> Result<Self> {
        let identity = Identity::new("car");
        let inbox = Inbox::queue(256);
        let mut wanted = mapping.state_channels();
        wanted.push(channels::COMMAND.to_owned());
        network.subscribe(Filter::Only(wanted), inbox.sink())?;
        let host = identity.sender.rsplit('@').next().unwrap_or_default();
        Ok(Self {
            filter: StreamFilter::new(SILENCE_NS, SILENCE_NS / 4, host),
            states: Publisher::new(network, &identity, channels::STATE),
            reports: Publisher::new(network, &identity, channels::ACTUATION),
            heartbeat: HeartbeatSender::start(network, &identity, "car", None)?,
            boot_id: identity.boot_id,
            moves: false,
            obeyed: None,
            network: Arc::clone(network),
            command: None,
            source: ActuationReport::default().source,
            applied: Input::default(),
            bytes: Vec::new(),
            summary: MappedCarSummary::default(),
            mapping,
            inbox,
            car,
        })
    }

    /// Bridges until `stop` is set, then commands the car to stop.
    ///
    /// # Errors
    /// If the network refuses a message.
    pub fn run(&mut self, stop: &AtomicBool) -> Result<MappedCarSummary> {
        let run = catch_unwind(AssertUnwindSafe(|| self.obey_until(stop)));
        self.command = None;
        let ends = (0..LAST_WORDS).map(|_| self.actuate(Instant::now()));
        let mut stopped = Ok(());
        for end in ends {
            stopped = stopped.or(end);
        }
        match run {
            Ok(run) => run.and(stopped)?,
            Err(_) => bail!("the program panicked (see above); the car was sent its stop values"),
        }
        self.summary.commands = self.filter.counts;
        self.summary.source = self.mapping.counts();
        Ok(self.summary)
    }

    fn obey_until(&mut self, stop: &AtomicBool) -> Result<()> {
        let period = Duration::from_secs_f64(self.mapping.command_period());
        let mut due = Instant::now();
        while !stop.load(Ordering::Relaxed) {
            let now = Instant::now();
            // A flood of states is no reason to keep the car waiting.
            if now >= due {
                self.actuate(now)?;
                due = (now + period).min(self.death().filter(|d| *d > now).unwrap_or(now + period));
            }
            let Some(received) = self.inbox.wait_until(due.min(now + NAP)) else { continue };
            if received.channel == channels::COMMAND {
                if self.on_command(&received) {
                    due = Instant::now();
                }
            } else {
                self.on_car_message(&received)?;
            }
            self.inbox.recycle(received);
        }
        Ok(())
    }

    /// When the command in force may no longer be used.
    fn death(&self) -> Option<Instant> {
        let (command, came) = self.command.as_ref()?;
        Some(
            *came
                + Duration::from_micros(u64::from(command.valid_for_us.max(0).unsigned_abs()) + 1),
        )
    }

    /// Takes a message of the car.
    fn on_car_message(&mut self, received: &Received) -> Result<()> {
        let taken = self.mapping.take(&received.channel, &received.payload, received.arrival);
        if let Some(mut state) = taken {
            self.moves = state.vx.hypot(state.vy) >= STILL;
            state.h = self.states.header();
            self.states.send_sealed(&state)?;
            self.summary.states += 1;
        }
        Ok(())
    }

    /// Takes a command; true if it was believed and answers one of this start's states.
    fn on_command(&mut self, received: &Received) -> bool {
        let times = (received.arrival.mono, transport::now().mono);
        let (car, boot_id) = (&self.car, self.boot_id);
        // There is nobody to arm it: a controller that started anew gets the car at standstill.
        let (moves, obeyed) = (self.moves, self.obeyed);
        let welcome = |boot_id| !moves || obeyed.is_none_or(|obeyed| obeyed == boot_id);
        let sane = |c: &ActuationCommand| {
            let drives = c.enable && c.mode == ActuationCommand::MODE_DRIVE;
            (!drives || BootId::new(c.state_boot_id) == boot_id && welcome(c.h.sender_start()))
                && (car.a_min - 1e-6..=car.a_max + 1e-6).contains(&c.accel)
                && c.steer.abs() <= car.delta_max + 1e-6
                && c.plan_accel.iter().chain(&c.plan_steer).all(|u| u.is_finite())
        };
        let checked =
            self.filter.check(&received.payload, times, |c: &ActuationCommand| &c.h, sane);
        let Ok(Accepted { message, .. }) = checked else { return false };
        if message.enable && message.mode == ActuationCommand::MODE_DRIVE {
            self.obeyed = Some(message.h.sender_start());
        }
        self.command = Some((message, Instant::now()));
        true
    }

    /// Sends the car what is to be applied from `now` on, and reports it.
    fn actuate(&mut self, now: Instant) -> Result<()> {
        let running = self.driven();
        let mut input = None;
        self.source = ActuationReport::NOBODY;
        if let Some((command, came)) = &self.command {
            let age = now.saturating_duration_since(*came).as_secs_f64();
            let asked = convert::input_at(command, age);
            input = asked.map(|(input, _)| input);
            self.source = asked.map_or(ActuationReport::SAFE_STOP, |(_, source)| source);
        }
        self.summary.stops += u64::from(running && input.is_none());
        let input = input.map(|u| Input {
            a: u.a.clamp(self.car.a_min, self.car.a_max),
            delta: u.delta.clamp(-self.car.delta_max, self.car.delta_max),
        });
        let answers_ns = self.command.as_ref().map(|(command, _)| command.state_mono_ns);
        let request = CarRequest { input, answers_ns, utime: transport::now().utime };
        self.mapping.command(&request, &mut self.bytes)?;
        self.network.publish(self.mapping.command_channel(), &self.bytes)?;
        self.summary.sent += 1;
        self.applied = input.unwrap_or(Input { a: self.car.a_min, ..self.applied });
        self.publish_report()
    }

    /// Whether the controller's inputs reach the car.
    fn driven(&self) -> bool {
        matches!(self.source, ActuationReport::COMMAND | ActuationReport::PLAN)
    }

    fn publish_report(&mut self) -> Result<()> {
        let (cmd_boot_id, cmd_seq) =
            self.command.as_ref().map(|(c, _)| (c.h.boot_id, c.h.seq)).unwrap_or_default();
        let report = ActuationReport {
            h: self.reports.header(),
            cmd_boot_id,
            cmd_seq,
            enabled: self.driven(),
            source: self.source,
            accel: self.applied.a,
            steer: self.applied.delta,
            ..ActuationReport::default()
        };
        let (counts, source) = (self.filter.counts, self.mapping.counts());
        let state =
            if report.enabled { lcm_types::Heartbeat::RUNNING } else { lcm_types::Heartbeat::IDLE };
        self.heartbeat.update(|health| {
            health.state = state;
            health.counts = counts;
            health.detail = source;
        });
        self.reports.send_sealed(&report)
    }
}
