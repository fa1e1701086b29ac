//! The bridge's loop: ticks on absolute deadlines, and an end that stops the car first.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use lcm_types::channels;

use super::bridge::{Bridge, BridgeSummary, WAITING};
use super::watchdog::Watchdog;
use hosting::shutdown::Shutdown;
use safety::{BridgeEvent, BridgeState, InputSource, StopReason};

/// Quality of a simulated car's states. \[-\]
const GOOD: i8 = 2;
/// A car that is being stopped because the bridge ends is not waited for any longer.
const PATIENCE: Duration = Duration::from_secs(30);
/// A car that was stopped is held for this long before the bridge ends.
const SETTLE: Duration = Duration::from_millis(500);
/// After this many panics the loop is given up. \[-\]
const PANICS: u32 = 3;

/// Where the loop is in time.
struct Clock {
    due: Instant,
    acted: Instant,
    state: BridgeState,
    /// When this state began.
    since: Instant,
    /// When the bridge was asked to end, and whether a car drove then.
    ending: Option<(Instant, bool)>,
    /// Since when the car stands after that.
    stood: Option<Instant>,
}

impl Clock {
    fn new(state: BridgeState) -> Self {
        let now = Instant::now();
        Self { due: now, acted: now, state, since: now, ending: None, stood: None }
    }
}

impl Bridge {
    /// Runs until it is asked to end; `on_change` is called at every change of state. A car that
    /// drives is first stopped along the track, unless the request is urgent. A panic of the loop
    /// is a request to end.
    pub fn run(
        &mut self,
        shutdown: &Shutdown,
        on_change: &mut dyn FnMut(BridgeState, StopReason),
    ) -> BridgeSummary {
        let mut clock = Clock::new(self.safety.bridge_state());
        self.watchdog.iter().for_each(Watchdog::ready);
        while !shutdown.is_urgent() && !self.is_over(shutdown, &mut clock) {
            // The core's memory changes only with a whole event: it is sound after a panic.
            let beat = AssertUnwindSafe(|| self.beat(&mut clock, &mut *on_change));
            if catch_unwind(beat).is_err() {
                self.summary.panics += 1;
                shutdown.request();
                if self.summary.panics >= PANICS {
                    break;
                }
            }
        }
        self.unsent += u64::from(self.side.finish().is_err());
        self.summary.commands = self.safety.counts();
        self.summary.moving = !self.safety.stands(&self.rules, transport::now().mono);
        self.summary
    }

    /// Whether the bridge may end: it is asked to, and the car stands or has had time enough.
    fn is_over(&mut self, shutdown: &Shutdown, clock: &mut Clock) -> bool {
        if !shutdown.is_requested() {
            return false;
        }
        let stops = |state| {
            matches!(state, BridgeState::SafeStop | BridgeState::Estop | BridgeState::Fault)
        };
        let state = self.safety.bridge_state();
        let drove = state == BridgeState::Running || stops(state);
        if clock.ending.is_none() {
            self.watchdog.iter().for_each(Watchdog::ending);
        }
        let (begun, drove) = *clock.ending.get_or_insert((Instant::now(), drove));
        self.step(&BridgeEvent::End);
        let now = transport::now().mono;
        if stops(self.safety.bridge_state()) && !self.safety.stands(&self.rules, now) {
            clock.stood = None;
        } else {
            clock.stood.get_or_insert_with(Instant::now);
        }
        // The brake stays pressed for a moment: slow is not yet still.
        let still = clock.stood.is_some_and(|since| !drove || since.elapsed() > SETTLE);
        still || begun.elapsed() > PATIENCE
    }

    /// One tick, and what comes before it.
    fn beat(&mut self, clock: &mut Clock, on_change: &mut dyn FnMut(BridgeState, StopReason)) {
        let tick = Duration::from_nanos(self.rules.tick_ns.unsigned_abs());
        // From the last deadline, not from now: the beat does not drift.
        clock.due += tick;
        while self.listen(clock.due) {
            // Between two beats: what ends the grant does not wait for the next one.
            let now = Instant::now().clamp(clock.acted, clock.due);
            self.act(now - clock.acted);
            clock.acted = now;
        }
        let late = Instant::now().saturating_duration_since(clock.due);
        let missed = u32::try_from(late.as_nanos() / tick.as_nanos()).unwrap_or(u32::MAX - 1);
        clock.due += tick * missed;
        self.summary.ticks += 1;
        self.summary.missed += u64::from(missed);
        self.summary.latest = self.summary.latest.max(late.as_secs_f64());
        self.act(clock.due - clock.acted);
        clock.acted = clock.due;
        let state = self.safety.bridge_state();
        self.watchdog.iter_mut().for_each(Watchdog::beat);
        if state != clock.state {
            self.watchdog.iter().for_each(|watchdog| watchdog.status(state.name()));
            on_change(state, self.safety.stop_reason());
            (clock.state, clock.since) = (state, Instant::now());
        }
        self.panic_if_due(clock);
    }

    #[expect(clippy::panic, reason = "asked for by the bench")]
    fn panic_if_due(&mut self, clock: &Clock) {
        let due = |after: &mut Duration| clock.since.elapsed() > *after;
        if clock.state == BridgeState::Running && self.panic_after.take_if(due).is_some() {
            panic!("asked for by the bench");
        }
    }

    /// Takes in what comes until `due`; true if the car has to be stopped before that.
    fn listen(&mut self, due: Instant) -> bool {
        for _ in 0..WAITING {
            if self.owes_stop() {
                break;
            }
            let Some(received) = self.commands.wait_until(self.wake(due)) else { break };
            match received.channel.as_str() {
                channels::OPERATOR => self.on_operator_command(&received),
                channels::COMMAND => self.on_command(&received),
                _ => self.on_car_message(&received),
            }
            self.commands.recycle(received);
        }
        for _ in 0..WAITING {
            let Some(received) = self.others.take() else { break };
            self.on_message(&received);
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
        self.source != InputSource::Stop
            && matches!(
                self.safety.bridge_state(),
                BridgeState::SafeStop | BridgeState::Estop | BridgeState::Fault
            )
    }

    /// The next tick, or just after the grant ends, whichever comes first.
    fn wake(&self, due: Instant) -> Instant {
        let Some(until) = self.safety.deadline(&self.rules) else { return due };
        let left_ns = until.plus_ns(1).ns_since(transport::now().mono);
        due.min(Instant::now() + Duration::from_nanos(left_ns.max(0).unsigned_abs()))
    }

    /// The car moves on by `dt`, is measured, and gets its next input.
    fn act(&mut self, dt: Duration) {
        let held = self.held;
        if self.safety.bridge_state() != BridgeState::Fault
            && let Err(error) = self.side.drive(held, dt)
        {
            self.fail(&error.to_string());
        }
        let measured = self.side.measure();
        let measured_at = transport::now().mono;
        if let Some(x) = measured {
            self.step(&BridgeEvent::State(x, GOOD));
        }
        let output = self.step(&BridgeEvent::Tick);
        (self.held, self.source) = (output.applied.sent, output.source);
        if let Err(error) = self.side.actuate(&output) {
            self.fail(&format!("the car cannot be commanded: {error}"));
        }
        self.publish_report(&output);
        self.step(&BridgeEvent::Sent);
        if let Some(x) = measured {
            let h = self.states.header();
            if let Some(state) = self.side.message(h, measured_at, &x, output.applied.sent) {
                self.publish_state(&state);
            }
        }
    }
}
