//! The service's work: how many steps, how long, and what too long ones lead to.

use std::time::Duration;

/// Steps longer than a period, one after the other, that stop the car: nobody can say then how old
/// the next command will be. \[-\]
const IN_ROW: u32 = 3;

/// The work so far.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DeadlineMonitor {
    /// States answered by a step of the controller. \[-\]
    pub steps: u64,
    /// Longest time from a state's arrival to its command. \[s\]
    pub longest: f64,
    /// Steps that took longer than a period. \[-\]
    pub overruns: i32,
    in_row: u32,
    stops: u32,
}

impl DeadlineMonitor {
    /// Counts a step, which took longer than a period if `over`; true if the car is to be stopped
    /// for it.
    pub(super) fn step(&mut self, over: bool) -> bool {
        self.steps += 1;
        self.overruns += i32::from(over);
        self.in_row = if over { self.in_row + 1 } else { 0 };
        let stop = self.in_row == IN_ROW;
        self.stops += u32::from(stop);
        stop
    }

    /// Text for the heartbeat; `None` while all steps were in time.
    pub(super) fn complaint(&self) -> Option<String> {
        let late = format!("{} steps took longer than a period", self.overruns);
        match (self.overruns, self.stops) {
            (0, _) => None,
            (_, 0) => Some(late),
            (_, stops) => Some(format!("{late}, {stops} stops for {IN_ROW} in a row")),
        }
    }
}

/// Steps made longer, as by a solver that does not find its end in time: for the bench.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Overrun {
    /// The first of them, counted from 0. \[-\]
    pub first: u64,
    /// How many, one after the other. \[-\]
    pub count: u64,
    /// How much longer.
    pub by: Duration,
}

impl Overrun {
    /// Waits, if the step with this number is one of them.
    pub(super) fn wait(&self, step: u64) {
        if (self.first..self.first + self.count).contains(&step) {
            std::thread::sleep(self.by);
        }
    }
}

impl std::str::FromStr for Overrun {
    type Err = String;

    /// From `FIRST,COUNT,MS`.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let numbers: Vec<u64> = text.split(',').filter_map(|part| part.parse().ok()).collect();
        match numbers[..] {
            [first, count, ms] => Ok(Self { first, count, by: Duration::from_millis(ms) }),
            _ => Err(format!("found {text:?}, expected FIRST,COUNT,MS")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_steps_in_a_row_that_are_too_long_stop_the_car_once() {
        let mut monitor = DeadlineMonitor::default();
        let stops: Vec<bool> = [true, true, false, true, true, true, true, false]
            .map(|over| monitor.step(over))
            .into();
        assert_eq!(stops, [false, false, false, false, false, true, false, false]);
        assert_eq!((monitor.steps, monitor.overruns), (8, 6));
        assert_eq!(
            monitor.complaint().unwrap_or_default(),
            "6 steps took longer than a period, 1 stops for 3 in a row"
        );
        assert_eq!(DeadlineMonitor::default().complaint(), None);
    }
}
