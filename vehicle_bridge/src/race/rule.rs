//! When a run counts as failed.

use controller::Config;
use vehicle_model::{State, Track};

use super::record::FailureReason;

/// Slowest speed that still counts as driving [m/s].
const STANDSTILL_SPEED: f64 = 0.1;
/// Longest time a lap may take on a short track [s].
const LAP_TIME_LIMIT: f64 = 40.0;
/// On a long track a lap may take this many times the time at warm-up speed.
const WARM_UP_TIMES: f64 = 6.0;

/// The failure rule of the studies: centre of gravity beyond a track edge, |e_psi| above pi/2,
/// v_x below 0.1 m/s after the start, no lap within 40 s (longer on long tracks).
#[derive(Debug, Clone)]
pub struct FailureRule {
    /// Longest time a lap may take [s].
    pub lap_time_limit: f64,
}

impl FailureRule {
    /// The rule for this track.
    #[must_use]
    pub fn new(config: &Config, track: &Track) -> Self {
        let slow_lap = WARM_UP_TIMES * track.length() / config.warm_up.speed;
        Self { lap_time_limit: slow_lap.max(LAP_TIME_LIMIT) }
    }

    /// Whether a true state, `lap_time` after the line, ends the run.
    #[must_use]
    pub fn broken(&self, track: &Track, x: &State, lap_time: f64) -> Option<FailureReason> {
        if !x.is_finite() {
            return Some(FailureReason::NotFinite);
        }
        if x.e_y > track.width_left(x.s) || x.e_y < -track.width_right(x.s) {
            return Some(FailureReason::OffTrack);
        }
        if x.e_psi.abs() > std::f64::consts::FRAC_PI_2 {
            return Some(FailureReason::WrongWay);
        }
        if x.v_x < STANDSTILL_SPEED {
            return Some(FailureReason::Standstill);
        }
        (lap_time > self.lap_time_limit).then_some(FailureReason::NoLap)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_way_to_fail_has_its_name() {
        let track = Track::builtin("l").unwrap();
        let rule = FailureRule::new(&Config::default(), &track);
        let good = State { v_x: 1.0, s: 3.0, ..State::default() };
        let edge = track.width_left(3.0);
        assert_eq!(rule.broken(&track, &good, 10.0), None);
        assert_eq!(rule.broken(&track, &State { e_y: edge - 1e-9, ..good }, 10.0), None);
        let cases = [
            (State { e_y: edge + 1e-9, ..good }, 0.0, FailureReason::OffTrack),
            (State { e_y: -edge - 1e-9, ..good }, 0.0, FailureReason::OffTrack),
            (State { e_psi: -1.6, ..good }, 0.0, FailureReason::WrongWay),
            (State { v_x: 0.05, ..good }, 0.0, FailureReason::Standstill),
            (State { v_x: f64::NAN, ..good }, 0.0, FailureReason::NotFinite),
            (good, 1e4, FailureReason::NoLap),
        ];
        for (x, time, reason) in cases {
            assert_eq!(rule.broken(&track, &x, time), Some(reason));
        }
    }
}
