//! The clock of a real car beside this host's: what its stamps mean here when the two drift apart.
//!
//! A map takes the car's clock to begin when its first message arrived. Two crystals differ by up to
//! 100 us in a second: after a quarter of an hour every state would seem 0.1 s old, and every command
//! that answers one would be refused. So the stamps are moved, as slowly as a clock may drift: a network
//! that becomes slower makes states old before it is taken for a drift.

use std::fmt;

/// Fastest drift that is followed, as NTP slews a clock at most. \[ns/ns\]
const FOLLOWED: f64 = 500e-6;
/// States are compared over this time: the one that came fastest shows the clock, the others the
/// network. \[ns\]
const WINDOW_NS: i64 = 1_000_000_000;
/// Smaller differences are left: a car on this host's clock keeps its stamps to the nanosecond. \[ns\]
const LEFT_NS: i64 = 1_000_000;
/// A difference that is named, and one at which it no longer is. \[ns\]
const NAMED_NS: i64 = 20_000_000;
const FORGOTTEN_NS: i64 = 10_000_000;

/// What is wrong with the car's clock, or with the network before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClockFinding {
    /// How much later than their stamps say the states arrive; negative: earlier. \[s\]
    pub late: f64,
    /// How much the difference has grown in a second, since the first state. \[s/s\]
    pub drift: f64,
}

impl fmt::Display for ClockFinding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (ms, ppm) = (self.late.abs() * 1e3, self.drift * 1e6);
        let way = if self.late > 0.0 { "later" } else { "earlier" };
        write!(
            f,
            "states of the car arrive {ms:.0} ms {way} than their stamps say, {ppm:+.0} us/s since the \
             first; expected at most 20 ms, and a drift of at most 500 us/s: compare the car's clock \
             with this host's, and look for a network that has become slower"
        )
    }
}

/// The car's clock as seen by the arrival of its states.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct CarClock {
    /// What the stamps are moved by. \[ns\]
    moved_ns: i64,
    /// What is still to be moved. \[ns\]
    owed_ns: i64,
    /// Beginning of the window, and how late the fastest state of this one and the last was. \[ns\]
    window: Option<(i64, i64)>,
    before_ns: Option<i64>,
    /// Arrival and lateness of the first window's fastest state, without what was moved. \[ns\]
    first: Option<(i64, i64)>,
    /// The last state: its stamp, its arrival, its stamp as moved. \[ns\]
    last: Option<(i64, i64, i64)>,
    finding: Option<ClockFinding>,
}

impl CarClock {
    /// The time here of a state that the map stamps `stamp_ns` and that arrived at `arrival_ns`. The
    /// same stamp again has the same time; a later one has a later.
    pub(super) fn time(&mut self, stamp_ns: i64, arrival_ns: i64) -> i64 {
        if stamp_ns == arrival_ns {
            // No clock of its own, or one that the map has just set.
            *self = Self { last: Some((stamp_ns, arrival_ns, stamp_ns)), ..Self::default() };
            return stamp_ns;
        }
        let mut passed_ns = 0;
        if let Some((last_stamp, last_arrival, last_time)) = self.last {
            if last_stamp == stamp_ns {
                return last_time;
            }
            passed_ns = arrival_ns.saturating_sub(last_arrival).clamp(0, WINDOW_NS);
        }
        #[expect(clippy::cast_possible_truncation, reason = "below a millisecond")]
        let most = (FOLLOWED * passed_ns as f64) as i64;
        let step = self.owed_ns.clamp(-most, most);
        (self.moved_ns, self.owed_ns) = (self.moved_ns + step, self.owed_ns - step);
        let time = stamp_ns.saturating_add(self.moved_ns);
        self.note(arrival_ns, arrival_ns.saturating_sub(time));
        let time = self.last.map_or(time, |(_, _, last)| time.max(last.saturating_add(1)));
        self.last = Some((stamp_ns, arrival_ns, time));
        time
    }

    /// What is wrong, if anything is.
    pub(super) fn finding(&self) -> Option<ClockFinding> {
        self.finding
    }

    /// Takes in how late a state came after its moved stamp.
    fn note(&mut self, arrival_ns: i64, late_ns: i64) {
        let (begun, least) = self.window.unwrap_or((arrival_ns, late_ns));
        let least = least.min(late_ns);
        if arrival_ns.saturating_sub(begun) < WINDOW_NS {
            self.window = Some((begun, least));
            return;
        }
        let floor = self.before_ns.map_or(least, |before| before.min(least));
        (self.window, self.before_ns) = (None, Some(least));
        self.owed_ns = if floor.abs() > LEFT_NS { floor } else { 0 };
        let whole = floor.saturating_add(self.moved_ns);
        let (first_at, first) = *self.first.get_or_insert((arrival_ns, whole));
        let since = arrival_ns.saturating_sub(first_at).max(WINDOW_NS) as f64;
        let named = if self.finding.is_some() { FORGOTTEN_NS } else { NAMED_NS };
        self.finding = (floor.abs() > named).then(|| ClockFinding {
            late: floor as f64 * 1e-9,
            drift: whole.saturating_sub(first) as f64 / since,
        });
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]
    use super::*;

    const MS: i64 = 1_000_000;

    /// States a hundred times a second for `seconds`, of a car whose clock gains `ppm` \[us/s\], on a
    /// network that takes up to 4 ms and `more` at each time; the greatest errors of the times, early
    /// and late, after the first `settled` seconds. \[ms\]
    fn errors(
        clock: &mut CarClock,
        seconds: i64,
        ppm: f64,
        settled: i64,
        more: impl Fn(i64) -> i64,
    ) -> (f64, f64) {
        let (mut early, mut late) = (0.0_f64, 0.0_f64);
        for n in 0..seconds * 100 {
            let measured = n * 10 * MS;
            let delay = (n * 7919 % 41) * MS / 10 + more(measured);
            let gained = (measured as f64 * ppm * 1e-6) as i64;
            // As a map stamps them: the first as it arrived.
            let time = clock.time(measured + gained, measured + delay);
            if n >= settled * 100 {
                let error = (time - measured) as f64 / MS as f64;
                (early, late) = (early.max(-error), late.max(error));
            }
        }
        (early, late)
    }

    #[test]
    fn an_hour_of_drift_makes_no_state_old() {
        for ppm in [-400.0, -100.0, 0.0, 100.0, 400.0] {
            let mut clock = CarClock::default();
            let (early, late) = errors(&mut clock, 3600, ppm, 0, |_| 0);
            assert!(early < 3.0 && late < 3.0, "{ppm} us/s: {early} ms early, {late} ms late");
            assert_eq!(clock.finding(), None, "{ppm} us/s");
        }
    }

    #[test]
    fn a_clock_without_drift_keeps_its_stamps() {
        let mut clock = CarClock::default();
        assert_eq!(errors(&mut clock, 600, 0.0, 0, |_| MS / 2), (0.0, 0.0));
    }

    #[test]
    fn a_clock_that_no_crystal_explains_is_named_and_its_states_grow_old() {
        for ppm in [-5000.0, 5000.0] {
            let mut clock = CarClock::default();
            let (early, late) = errors(&mut clock, 30, ppm, 0, |_| 0);
            assert!(early.max(late) > 100.0, "{ppm}: {early} ms early, {late} ms late");
            let found = clock.finding().unwrap();
            assert!((found.drift * 1e6 + ppm).abs() < 250.0, "{ppm}: {found:?}");
            assert_eq!(found.late > 0.0, ppm < 0.0, "{ppm}: {found:?}");
        }
    }

    #[test]
    fn a_network_that_becomes_slower_makes_states_old_and_is_named() {
        let mut clock = CarClock::default();
        // From the tenth second on everything takes 60 ms longer: 20 s later most of it still counts.
        let slower = |at: i64| if at > 10_000 * MS { 60 * MS } else { 0 };
        let (_, late) = errors(&mut clock, 30, 0.0, 0, slower);
        assert!(late < 12.0, "{late} ms of 60 are taken for a drift");
        assert!(clock.finding().unwrap().to_string().contains("ms later than their stamps say"));
    }

    #[test]
    fn the_same_stamp_is_the_same_time_and_a_clock_that_is_set_begins_anew() {
        let mut clock = CarClock::default();
        errors(&mut clock, 60, 400.0, 0, |_| 0);
        let at = 61_000 * MS;
        let time = clock.time(at, at + MS);
        assert_eq!(clock.time(at, at + 500 * MS), time, "a frozen sensor");
        assert!(clock.time(at + 1, at + 2 * MS) > time);
        assert_eq!(clock.time(at + 9000 * MS, at + 9000 * MS), at + 9000 * MS);
        let next = clock.time(at + 9010 * MS, at + 9011 * MS);
        assert_eq!(next, at + 9010 * MS, "nothing of the old clock is left");
    }
}
