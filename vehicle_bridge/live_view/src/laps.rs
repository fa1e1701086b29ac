//! Laps: the one that is driven, the last, the best, and all of them as a table.

use std::collections::VecDeque;
use std::sync::Arc;

use lcm_types::LapResult;
use serde::Serialize;

use crate::lap::{Sample, Trace};

/// Laps in the table; older ones go. \[-\]
const ROWS: usize = 500;
/// A lap the controller has not judged by then is judged here. \[s\]
const PATIENCE_S: f64 = 0.5;
/// Lap times of the controller and of this place that differ by less are of the same lap. \[-\]
const SAME: f64 = 0.1;
/// A first lap that begins before this share of the track is a whole one. \[-\]
const NEAR_LINE: f64 = 0.02;

/// A lap in the table.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub(crate) struct Row {
    /// Its number. \[-\]
    lap: i32,
    /// \[s\]
    time: f64,
    /// By the controller if it judged, else by the centre of mass between the edges.
    valid: bool,
    /// The controller judged it: the columns that follow are known.
    judged: bool,
    in_safe_set: bool,
    /// \[m\]
    min_margin: f64,
    violations: i32,
    fallbacks: i32,
    late: i32,
    /// Fastest of the lap. \[m/s\]
    v_max: f64,
}

/// Where and when the car was last.
#[derive(Debug, Clone, Copy)]
struct Before {
    boot_id: i64,
    time_s: f64,
    sample: Sample,
}

/// All laps of a drive on one track.
#[derive(Debug)]
pub(crate) struct Laps {
    length: f64,
    before: Option<Before>,
    /// When the lap began. \[s\]
    begun: f64,
    pub(crate) current: Trace,
    /// Of `current`: grows with each new one. \[-\]
    pub(crate) epoch: u64,
    pub(crate) last: Option<Arc<Trace>>,
    pub(crate) best: Option<Arc<Trace>>,
    pub(crate) rows: VecDeque<Row>,
    /// `last` is not judged yet.
    waiting: bool,
    /// Of table, last and best: grows with each change. \[-\]
    pub(crate) version: u64,
}

impl Laps {
    pub(crate) fn new(length: f64) -> Self {
        Self {
            length,
            before: None,
            begun: 0.0,
            current: Trace::new(0, false),
            epoch: 0,
            last: None,
            best: None,
            rows: VecDeque::new(),
            waiting: false,
            version: 0,
        }
    }

    /// The car at a place: measured by the start `boot_id` of a program at `time_s` on its clock.
    /// `inside` if it is between the edges there.
    pub(crate) fn push(
        &mut self,
        boot_id: i64,
        time_s: f64,
        lap: i32,
        sample: Sample,
        inside: bool,
    ) {
        match self.before {
            Some(last) if last.boot_id == boot_id && last.time_s <= time_s => {
                let step = sample.s - last.sample.s;
                if step < -0.5 * self.length {
                    let share = (self.length - last.sample.s) / (self.length + step).max(1e-9);
                    let share = share.clamp(0.0, 1.0);
                    let crossed = last.time_s + share * (time_s - last.time_s);
                    let line = last.sample.towards(&sample, share);
                    self.close(crossed, line);
                    self.begin(crossed, lap, true);
                    self.current.push(Sample { t: 0.0, s: 0.0, ..line }, self.length);
                } else if step > 0.5 * self.length {
                    self.begin(time_s, lap, false);
                }
            }
            // Another start of the program, or another place of a log: an unfinished lap.
            _ => self.begin(time_s, lap, sample.s < NEAR_LINE * self.length),
        }
        self.before = Some(Before { boot_id, time_s, sample });
        self.current.inside &= inside;
        let t = time_s - self.begun;
        self.current.push(Sample { t, ..sample }, self.length);
        if self.waiting && t > PATIENCE_S {
            self.settle(None);
        }
    }

    fn begin(&mut self, time_s: f64, lap: i32, whole: bool) {
        self.begun = time_s;
        self.epoch += 1;
        self.current = Trace::new(lap, whole);
    }

    /// The lap ends at `time_s`, with the car as `line` says.
    fn close(&mut self, time_s: f64, line: Sample) {
        if self.waiting {
            self.settle(None);
        }
        let mut trace = std::mem::take(&mut self.current);
        if !trace.whole {
            return;
        }
        trace.time = time_s - self.begun;
        trace.end(Sample { t: trace.time, s: self.length, ..line });
        self.last = Some(Arc::new(trace));
        self.waiting = true;
        self.version += 1;
    }

    /// The controller's word on a lap.
    pub(crate) fn judge(&mut self, result: &LapResult) {
        let same = |trace: &Arc<Trace>| {
            (trace.time - result.lap_time).abs() <= SAME * result.lap_time.abs()
        };
        if self.waiting && self.last.as_ref().is_some_and(same) {
            self.settle(Some(result));
        } else {
            // Of a lap that was not seen from line to line.
            self.add(row(result, f64::NAN));
        }
    }

    /// Ends the wait for the controller's word.
    fn settle(&mut self, result: Option<&LapResult>) {
        self.waiting = false;
        let Some(last) = self.last.clone() else { return };
        let v_max = last.samples.iter().map(|sample| sample.v_x).fold(f64::NAN, f64::max);
        let row = match result {
            Some(result) => row(result, v_max),
            None => {
                Row { lap: last.lap, time: last.time, valid: last.inside, v_max, ..Row::default() }
            }
        };
        let timed = Arc::new(Trace { time: row.time, lap: row.lap, ..(*last).clone() });
        if row.valid && self.best.as_ref().is_none_or(|best| timed.time < best.time) {
            self.best = Some(Arc::clone(&timed));
        }
        self.last = Some(timed);
        self.add(row);
    }

    fn add(&mut self, row: Row) {
        if self.rows.len() >= ROWS {
            self.rows.pop_front();
        }
        self.rows.push_back(row);
        self.version += 1;
    }
}

fn row(result: &LapResult, v_max: f64) -> Row {
    Row {
        lap: result.lap,
        time: result.lap_time,
        valid: result.valid,
        judged: true,
        in_safe_set: result.in_safe_set,
        min_margin: result.min_margin,
        violations: result.n_violations,
        fallbacks: result.n_fallback,
        late: result.n_late,
        v_max,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LENGTH: f64 = 10.0;

    /// Drives at a constant speed from `s` on for a time, measured every `period`.
    fn drive(laps: &mut Laps, boot_id: i64, (speed, period, time): (f64, f64, f64), s: f64) {
        for step in 0..(time / period) as u32 {
            let t = f64::from(step) * period;
            let s = (s + speed * t) % LENGTH;
            let sample = Sample { s, v_x: speed, ..Sample::default() };
            laps.push(boot_id, t, 0, sample, true);
        }
    }

    fn result(lap: i32, lap_time: f64, valid: bool) -> LapResult {
        LapResult { lap, lap_time, valid, ..LapResult::default() }
    }

    #[test]
    fn a_lap_takes_length_by_speed_however_often_it_is_measured() {
        for period in [0.01, 0.07, 0.31] {
            let mut laps = Laps::new(LENGTH);
            drive(&mut laps, 1, (3.0, period, 12.0), 0.0);
            let times: Vec<f64> = laps.rows.iter().map(|row| row.time).collect();
            assert_eq!(times.len(), 3, "{times:?}");
            assert!(times.iter().all(|time| (time - LENGTH / 3.0).abs() < 1e-9), "{times:?}");
            let best = laps.best.map(|best| best.time).unwrap_or_default();
            assert!((best - LENGTH / 3.0).abs() < 1e-9);
        }
    }

    #[test]
    fn a_lap_from_the_middle_or_with_a_restart_in_it_is_none() {
        let mut laps = Laps::new(LENGTH);
        drive(&mut laps, 1, (2.0, 0.1, 6.0), 5.0);
        assert!(laps.rows.is_empty() && laps.current.whole);
        drive(&mut laps, 2, (2.0, 0.1, 1.0), 7.0);
        assert!(!laps.current.whole && laps.last.is_none());
    }

    #[test]
    fn the_controller_has_the_last_word_on_a_lap() {
        let mut laps = Laps::new(LENGTH);
        // One period over the line the controller says that the lap does not count.
        drive(&mut laps, 1, (2.0, 0.1, 5.25), 0.0);
        assert!(laps.rows.is_empty());
        laps.judge(&result(7, 5.001, false));
        let row = laps.rows.back().cloned().unwrap_or_default();
        assert!(row.judged && !row.valid && row.lap == 7 && laps.best.is_none());
        assert!((row.v_max - 2.0).abs() < 1e-12);
        // A lap that this place did not see from line to line.
        laps.judge(&result(8, 4.0, true));
        assert!(laps.best.is_none() && laps.rows.len() == 2);
    }

    #[test]
    fn memory_is_bounded_however_slowly_the_car_goes_and_however_long() {
        let mut laps = Laps::new(LENGTH);
        drive(&mut laps, 1, (0.01, 0.01, 999.0), 0.0);
        assert!(laps.current.samples.len() <= 1500, "{}", laps.current.samples.len());
        for lap in 0..2000 {
            laps.judge(&result(lap, 4.0, true));
        }
        assert_eq!(laps.rows.len(), ROWS);
    }
}
