//! An internal period counted in integer ticks.

/// Ticks per second; a nanosecond tick covers 292 years.
const TICKS_PER_SECOND: f64 = 1e9;

/// Relative error of a time or a step a host computed in single precision, such as `float32(0.1)`.
const SINGLE: f64 = f32::EPSILON as f64;

/// Fires every period, counted from the start of the simulation in integer ticks: the sum of
/// many inexact communication steps never moves it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TickSchedule {
    period: i64,
    next: i64,
}

impl TickSchedule {
    /// A schedule whose first event is at the start of the simulation; period in seconds.
    ///
    /// Returns `None` unless the period is a finite number of at least one tick.
    #[must_use]
    pub fn new(period: f64) -> Option<Self> {
        let ticks = (period * TICKS_PER_SECOND).round();
        (1.0..1e18).contains(&ticks).then_some(Self { period: ticks as i64, next: 0 })
    }

    /// The period \[s\].
    #[must_use]
    pub fn period(&self) -> f64 {
        self.period as f64 / TICKS_PER_SECOND
    }

    /// Whether a step of this size \[s\] can hold more than one event.
    #[must_use]
    pub fn too_long(&self, size: f64) -> bool {
        ticks(size) as f64 > self.period as f64 * (1.0 + SINGLE) + 1.0
    }

    /// Whether whole steps of this size \[s\] make up the period, to single precision and a tick.
    #[must_use]
    pub fn divides(&self, size: f64) -> bool {
        let steps = self.period as f64 / (size * TICKS_PER_SECOND);
        let error = SINGLE + 1.0 / self.period as f64;
        (steps - steps.round()).abs() <= steps * error
    }

    /// Takes the next event if it lies before `time` [s after the start], the end of a step of this
    /// size \[s\]: an event at the end of a step belongs to the following step, because the inputs of
    /// that instant come with it. What single precision may add to a time does not count.
    pub fn due_before(&mut self, time: f64, size: f64) -> bool {
        let slack = (SINGLE * time).min(0.25 * size);
        let due = self.next < ticks(time - slack);
        if due {
            self.next += self.period;
        }
        due
    }

    /// Number of events taken so far.
    #[must_use]
    pub fn count(&self) -> i64 {
        self.next / self.period
    }

    /// A schedule of the given period after `count` events, to restore a saved one.
    #[must_use]
    pub fn resumed(period: f64, count: i64) -> Option<Self> {
        let fresh = Self::new(period)?;
        Some(Self { next: fresh.period.checked_mul(count)?, ..fresh })
    }
}

/// Nearest tick; saturates far outside any simulation.
fn ticks(time: f64) -> i64 {
    (time * TICKS_PER_SECOND).round() as i64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inexact_steps_do_not_move_the_events() {
        let mut schedule = TickSchedule::new(0.1).unwrap();
        let (mut time, mut events) = (0.0, Vec::new());
        for k in 0..30_000 {
            time += 0.01;
            if schedule.due_before(time, 0.01) {
                events.push(k);
            }
        }
        let expected: Vec<i32> = (0..3_000).map(|k| 10 * k).collect();
        assert_eq!(events, expected);
        assert_eq!(schedule.count(), 3_000);
        assert_eq!(TickSchedule::resumed(0.1, 3_000), Some(schedule));
    }

    #[test]
    fn steps_in_single_precision_hit_the_same_events() {
        for (size, per_period) in [(0.1_f32, 1), (0.05, 2), (0.02, 5), (0.01, 10)] {
            let size = f64::from(size);
            let mut schedule = TickSchedule::new(0.1).unwrap();
            assert!(!schedule.too_long(size) && schedule.divides(size), "{size}");
            for k in 0..20_000 {
                let due = schedule.due_before(f64::from(k + 1) * size, size);
                assert_eq!(due, k % per_period == 0, "step {k} of {size} s");
            }
        }
    }

    #[test]
    fn only_whole_parts_divide_the_period() {
        let schedule = TickSchedule::new(0.1).unwrap();
        let all = [0.1, 0.1 / 3.0, 0.01, 1e-3, 0.03, 0.099, 0.06, 7e-3];
        let divides = all.map(|size| schedule.divides(size));
        assert_eq!(divides, [true, true, true, true, false, false, false, false]);
        let third = 1.0 / 3.0;
        assert!(TickSchedule::new(third).unwrap().divides(third));
    }

    #[test]
    fn only_steps_beyond_the_period_are_too_long() {
        let schedule = TickSchedule::new(0.1).unwrap();
        assert!(!schedule.too_long(0.1) && !schedule.too_long(0.1 + 1e-12));
        assert!(schedule.too_long(0.100_001));
        assert_eq!(TickSchedule::new(0.0), None);
        assert_eq!(TickSchedule::new(f64::NAN), None);
    }
}
