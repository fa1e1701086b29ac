//! Which measurements are answered, and what time they bear. Pure.

/// How fast the beat follows that of the measurements. \[-\]
const FOLLOW: f64 = 0.2;

/// One answer each period, from a source that may be faster.
#[derive(Debug, Clone)]
pub struct Schedule {
    period_ns: i64,
    /// Time of the controller when the source's clock is 0. \[ns\]
    offset_ns: Option<i64>,
    /// When the next answer is due, the controller's time. \[ns\]
    due_ns: i64,
    /// Last measurement seen, answered or not, the controller's time. \[ns\]
    seen_ns: i64,
    arrival_ns: i64,
}

impl Schedule {
    /// Nothing measured yet.
    #[must_use]
    pub fn new(period_ns: i64) -> Self {
        Self { period_ns, offset_ns: None, due_ns: 0, seen_ns: i64::MIN, arrival_ns: 0 }
    }

    /// A source started (again), with a clock of its own: the controller's time goes on by what
    /// passed between the arrivals.
    pub fn restart(&mut self, measured_ns: i64, arrival_ns: i64) {
        let now = match self.offset_ns {
            None => 0,
            Some(_) => self.seen_ns + (arrival_ns - self.arrival_ns).max(self.period_ns),
        };
        self.offset_ns = Some(now - measured_ns);
        self.due_ns = now;
        self.seen_ns = now - self.period_ns;
    }

    /// The controller's time of a measurement; `None` before the first.
    #[must_use]
    pub fn time(&self, measured_ns: i64) -> Option<i64> {
        self.offset_ns.map(|offset| measured_ns + offset)
    }

    /// The controller's time of a measurement that is to be answered; `None` if the next one will
    /// be nearer to when an answer is due.
    pub fn due(&mut self, measured_ns: i64, arrival_ns: i64) -> Option<i64> {
        let time = self.time(measured_ns)?;
        let interval = time - self.seen_ns;
        (self.seen_ns, self.arrival_ns) = (time, arrival_ns);
        let early = self.due_ns - time;
        if interval <= 0 || early > interval / 2 {
            return None;
        }
        let off = -early;
        self.due_ns = if off > self.period_ns / 2 {
            time + self.period_ns
        } else {
            #[expect(clippy::cast_possible_truncation, reason = "below a period")]
            let follow = (FOLLOW * off as f64) as i64;
            self.due_ns + self.period_ns + follow
        };
        Some(time)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;

    /// Times answered of a source with this interval, over ten seconds.
    fn answered(interval_us: i64) -> Vec<i64> {
        let mut schedule = Schedule::new(100 * MS);
        schedule.restart(77, 0);
        let count = 10_000_000 / interval_us;
        (0..count).filter_map(|i| schedule.due(77 + i * interval_us * 1000, 0)).collect()
    }

    #[test]
    fn every_state_of_a_source_at_the_period_is_answered_though_its_clock_is_off() {
        for interval_us in [100_000, 99_900, 100_100, 98_000, 103_000] {
            let times = answered(interval_us);
            assert_eq!(times.len() as i64, 10_000_000 / interval_us, "{interval_us} us");
            assert_eq!((times[0], times[1]), (0, interval_us * 1000));
        }
    }

    #[test]
    fn a_faster_source_is_answered_once_a_period() {
        for interval_us in [1_000, 10_000, 20_000, 33_333] {
            let times = answered(interval_us);
            assert!((99..=101).contains(&times.len()), "{interval_us}: {}", times.len());
            for pair in times.windows(2) {
                let error = (pair[1] - pair[0] - 100 * MS).abs();
                assert!(error <= interval_us * 1000, "{interval_us}: {error}");
            }
        }
    }

    #[test]
    fn time_goes_on_when_the_source_starts_again() {
        let mut schedule = Schedule::new(100 * MS);
        schedule.restart(5_000 * MS, 1_000 * MS);
        assert_eq!(schedule.due(5_000 * MS, 1_000 * MS), Some(0));
        schedule.restart(3 * MS, 4_000 * MS);
        assert_eq!(schedule.due(3 * MS, 4_000 * MS), Some(3_000 * MS));
        assert_eq!(schedule.due(103 * MS, 4_100 * MS), Some(3_100 * MS));
    }
}
