//! A simulated car on the network: in real time, or in lock-step with its controller.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::Result;
use lcm_types::{
    ActuationCommand, ActuationReport, BootId, LapIndex, MonoTime, SeqNumber, VehicleState,
    channels,
};
use vehicle_model::{Input, State};

use hosting::rule::FailureReason;
use hosting::rule::FailureRule;
use protocol::convert;
use protocol::publisher::{Identity, Publisher};
use protocol::stream_filter::{Accepted, StreamFilter};
use transport::{Filter, Inbox, Received, Transport};
use vehicle_host::Vehicle;

/// How often the state is sent again while it is not answered.
const REPEAT: Duration = Duration::from_millis(200);
/// Messages on the commands' channel that may wait for the car. \[-\]
const WAITING: usize = 1024;
const SILENCE_NS: i64 = 1_000_000_000;
/// An older command is refused on arrival: two and a half periods of 0.1 s.
const MAX_AGE_NS: i64 = 250_000_000;

/// How the car runs.
#[derive(Debug, Clone)]
pub struct CarOptions {
    /// Control period. \[s\]
    pub period: f64,
    /// Time stands still until each state is answered.
    pub lock_step: bool,
    /// Periods after which it ends. \[-\]
    pub steps: Option<u64>,
    /// Laps after which it ends. \[-\]
    pub laps: Option<u32>,
    /// In lock-step, it ends when a state is not answered for this long.
    pub patience: Duration,
}

/// How the drive went.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DriveSummary {
    /// Periods driven. \[-\]
    pub steps: u64,
    /// Lap times by interpolation between the periods, and whether the lap was on the track.
    pub laps: Vec<(f64, bool)>,
    /// Periods begun beyond the edge of the track. \[-\]
    pub off_track: u64,
    /// Periods driven by a fallback plan. \[-\]
    pub by_plan: u64,
    /// Periods driven by the safe stop. \[-\]
    pub stopped: u64,
    /// Periods that began more than a period late. \[-\]
    pub late: u64,
    /// Latest begin of a period. \[s\]
    pub latest: f64,
    /// In lock-step, no answer arrived.
    pub deserted: bool,
    /// A command came that was believed.
    pub commanded: bool,
}

/// The car.
pub struct SimulatedCar {
    options: CarOptions,
    vehicle: Box<dyn Vehicle>,
    commands: Inbox,
    filter: StreamFilter,
    states: Publisher,
    reports: Publisher,
    rule: FailureRule,
    boot_id: BootId,
    /// The command in force and when it came.
    command: Option<(ActuationCommand, Instant)>,
    steer: f64,
    source: i8,
    lap_start: f64,
    lap_clean: bool,
    drive: DriveSummary,
}

impl SimulatedCar {
    /// A vehicle as it stands, on a network.
    ///
    /// # Errors
    /// If the network refuses the subscription.
    pub fn new(
        options: CarOptions,
        vehicle: Box<dyn Vehicle>,
        rule: FailureRule,
        network: &Arc<dyn Transport>,
    ) -> Result<Self> {
        let identity = Identity::new("car");
        let commands = Inbox::queue(WAITING);
        network.subscribe(Filter::channel(channels::COMMAND), commands.sink())?;
        let host = identity.sender.rsplit('@').next().unwrap_or_default();
        Ok(Self {
            filter: StreamFilter::new(MAX_AGE_NS, SILENCE_NS / 4, host),
            states: Publisher::new(network, &identity, channels::STATE),
            reports: Publisher::new(network, &identity, channels::ACTUATION),
            boot_id: identity.boot_id,
            command: None,
            steer: 0.0,
            source: ActuationReport::NOBODY,
            lap_start: 0.0,
            lap_clean: true,
            drive: DriveSummary::default(),
            options,
            vehicle,
            commands,
            rule,
        })
    }

    /// Drives until the steps or laps are done or `stop` is set; `on_lap` sees each lap.
    ///
    /// # Errors
    /// If the network refuses a message, or the vehicle fails.
    pub fn run(
        &mut self,
        stop: &AtomicBool,
        on_lap: &mut dyn FnMut(usize, f64, bool),
    ) -> Result<DriveSummary> {
        let begin = Instant::now();
        let start = transport::now().mono;
        let base = if self.options.lock_step { MonoTime::default() } else { start };
        while !stop.load(Ordering::Relaxed) && !self.done() {
            // Counted, not summed: a thousand additions of 0.1 miss.
            let time = self.drive.steps as f64 * self.options.period;
            let measured_at = base.plus_ns(convert::nanoseconds(time));
            let measured = self.vehicle.measure();
            let before = (self.vehicle.progress(), self.vehicle.lap());
            if self.options.lock_step {
                if !self.step_answered(&measured, measured_at, stop)? {
                    break;
                }
            } else {
                self.step_real_time(&measured, measured_at, begin)?;
            }
            self.drive.steps += 1;
            self.judge(time, before, on_lap);
            self.publish_report()?;
        }
        self.drive.commanded = self.command.is_some();
        Ok(self.drive.clone())
    }

    fn done(&self) -> bool {
        let laps = self.drive.laps.len();
        self.drive.deserted
            || self.options.steps.is_some_and(|steps| self.drive.steps >= steps)
            || self.options.laps.is_some_and(|most| laps >= most as usize)
    }

    fn publish_state(&mut self, x: &State, measured_at: MonoTime) -> Result<SeqNumber> {
        let h = self.states.header();
        let seq = h.number();
        let lap = LapIndex::after(self.vehicle.lap());
        let track = Arc::clone(self.vehicle.track());
        let state: VehicleState =
            convert::state_message(h, measured_at, x, self.vehicle.applied(), &track, lap);
        self.states.send_sealed(&state)?;
        Ok(seq)
    }

    /// One period in lock-step; false if there was no answer.
    fn step_answered(
        &mut self,
        x: &State,
        measured_at: MonoTime,
        stop: &AtomicBool,
    ) -> Result<bool> {
        let patience = Instant::now() + self.options.patience;
        let first = self.publish_state(x, measured_at)?;
        let mut repeat = Instant::now() + REPEAT;
        loop {
            if let Some(received) = self.commands.wait_until(repeat) {
                let answer = self.check(&received).filter(|command| {
                    BootId::new(command.state_boot_id) == self.boot_id
                        && SeqNumber::new(command.state_seq) >= first
                });
                self.commands.recycle(received);
                if let Some(command) = answer {
                    let asked = convert::input_at(&command, 0.0);
                    self.source = asked.map_or(ActuationReport::SAFE_STOP, |(_, source)| source);
                    self.command = Some((command, Instant::now()));
                    let input = asked.map_or_else(|| self.safe_stop(), |(input, _)| input);
                    self.steer = input.delta;
                    self.vehicle.apply(input, self.options.period)?;
                    return Ok(true);
                }
            } else {
                self.publish_state(x, measured_at)?;
                repeat += REPEAT;
            }
            if stop.load(Ordering::Relaxed) {
                return Ok(false);
            }
            if Instant::now() > patience {
                self.drive.deserted = true;
                return Ok(false);
            }
        }
    }

    /// One period of the clock: each command acts from when it comes.
    fn step_real_time(&mut self, x: &State, measured_at: MonoTime, begin: Instant) -> Result<()> {
        let at = |steps: u64| begin + Duration::from_secs_f64(steps as f64 * self.options.period);
        let (start, end) = (at(self.drive.steps), at(self.drive.steps + 1));
        let late = Instant::now().saturating_duration_since(start).as_secs_f64();
        self.drive.latest = self.drive.latest.max(late);
        self.drive.late += u64::from(late > self.options.period);
        self.publish_state(x, measured_at)?;
        let mut done = start;
        let mut left = self.options.period;
        let mut worst = ActuationReport::NOBODY;
        while left > 0.0 {
            let received = self.commands.wait_until(self.change(done).min(end));
            let now = Instant::now().clamp(done, end);
            // To the end of the period by subtraction, so that the plant's clock is exact.
            let length = if now >= end { left } else { (now - done).as_secs_f64().min(left) };
            let input = self.input(done);
            self.steer = input.delta;
            worst = worst.max(self.source);
            self.vehicle.apply(input, length)?;
            (done, left) = (now, if now >= end { 0.0 } else { left - length });
            if let Some(received) = received {
                if let Some(command) = self.check(&received) {
                    self.command = Some((command, Instant::now()));
                }
                self.commands.recycle(received);
            }
        }
        self.drive.by_plan += u64::from(worst == ActuationReport::PLAN);
        self.drive.stopped += u64::from(worst == ActuationReport::SAFE_STOP);
        Ok(())
    }

    /// When what is applied changes without a new command.
    fn change(&self, after: Instant) -> Instant {
        let period = Duration::from_secs_f64(self.options.period);
        let Some((command, came)) = &self.command else { return after + period };
        let dead = *came + Duration::from_micros(command.valid_for_us.max(0) as u64 + 1);
        if dead > after { dead.min(after + period) } else { after + period }
    }

    /// What is applied from `now` on.
    fn input(&mut self, now: Instant) -> Input {
        let Some((command, came)) = &self.command else {
            self.source = ActuationReport::NOBODY;
            return self.safe_stop();
        };
        let age = now.saturating_duration_since(*came).as_secs_f64();
        let Some((input, source)) = convert::input_at(command, age) else {
            self.source = ActuationReport::SAFE_STOP;
            return self.safe_stop();
        };
        self.source = source;
        input
    }

    /// Full braking with the wheels as they are.
    fn safe_stop(&self) -> Input {
        Input { a: self.vehicle.car().a_min, delta: self.steer }
    }

    fn check(&mut self, received: &Received) -> Option<ActuationCommand> {
        let times = (received.arrival.mono, transport::now().mono);
        let car = self.vehicle.car();
        let sane = |c: &ActuationCommand| {
            (car.a_min - 1e-6..=car.a_max + 1e-6).contains(&c.accel)
                && c.steer.abs() <= car.delta_max + 1e-6
        };
        let checked =
            self.filter.check(&received.payload, times, |c: &ActuationCommand| &c.h, sane);
        checked.ok().map(|Accepted { message, .. }| message)
    }

    fn judge(&mut self, time: f64, before: (f64, i64), on_lap: &mut dyn FnMut(usize, f64, bool)) {
        let truth = self.vehicle.truth();
        let broken = self.rule.broken(self.vehicle.track(), &truth, 0.0);
        if matches!(
            broken,
            Some(FailureReason::OffTrack | FailureReason::Spin | FailureReason::WrongWay)
        ) {
            self.drive.off_track += 1;
            self.lap_clean = false;
        }
        let (progress, lap) = before;
        if self.vehicle.lap() > lap {
            let line = (lap + 1) as f64 * self.vehicle.track().length();
            let share = (line - progress) / (self.vehicle.progress() - progress);
            let crossed = time + share * self.options.period;
            let lap_time = crossed - self.lap_start;
            self.drive.laps.push((lap_time, self.lap_clean));
            on_lap(self.drive.laps.len(), lap_time, self.lap_clean);
            (self.lap_start, self.lap_clean) = (crossed, true);
        }
    }

    fn publish_report(&mut self) -> Result<()> {
        let h = self.reports.header();
        let applied = self.vehicle.applied();
        let (cmd_boot_id, cmd_seq) =
            self.command.as_ref().map(|(c, _)| (c.h.boot_id, c.h.seq)).unwrap_or_default();
        let enabled = matches!(self.source, ActuationReport::COMMAND | ActuationReport::PLAN);
        let (source, accel, steer) = (self.source, applied.a, applied.delta);
        let report = ActuationReport {
            h,
            cmd_boot_id,
            cmd_seq,
            enabled,
            source,
            limited: 0,
            accel,
            steer,
            crc: 0,
        };
        self.reports.send_sealed(&report)
    }
}
