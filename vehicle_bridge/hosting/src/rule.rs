//! When a run counts as failed.

use std::f64::consts::FRAC_PI_2;

use controller::{Config, Preset};
use vehicle_model::{CarParams, Outline, State, Track};

/// Slowest speed that still counts as driving [m/s].
const STANDSTILL_SPEED: f64 = 0.1;
/// Longest time a lap may take on a short track [s].
const LAP_TIME_LIMIT: f64 = 40.0;
/// On a long track a lap may take this many times the time at warm-up speed.
const WARM_UP_TIMES: f64 = 6.0;

/// Why a run counts as failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FailureReason {
    /// The body crossed a track edge, or the centre of gravity where only that counts.
    OffTrack,
    /// The car turned more than 90 degrees away from the track while it slid on along it.
    Spin,
    /// The car turned round and drove back.
    WrongWay,
    /// The car stood still after its start.
    Standstill,
    /// No lap was finished in the time allowed.
    NoLap,
    /// The simulated car's state ceased to be a number.
    NotFinite,
}

impl FailureReason {
    /// The word in CSV and JSON.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::OffTrack => "off_track",
            Self::Spin => "spin",
            Self::WrongWay => "wrong_way",
            Self::Standstill => "standstill",
            Self::NoLap => "no_lap",
            Self::NotFinite => "not_finite",
        }
    }
}

/// What has to stay between the edges of the track.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TrackLimit {
    /// The whole body: length, width and heading count.
    Body,
    /// The centre of gravity, as in the paper's studies.
    CentreOfGravity,
}

impl TrackLimit {
    /// What is judged unless somebody asks for something else: the body. The preset `paper` keeps
    /// the centre of gravity inside, as the paper does, and is judged by that.
    #[must_use]
    pub fn of(config: &Config) -> Self {
        match config.preset {
            Preset::Race => Self::Body,
            Preset::Paper => Self::CentreOfGravity,
        }
    }
}

/// Judges whether a car is on the track. Races, studies, simulated cars on a network, the messages
/// of a lap and the verdicts of a bench all judge by this.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edges {
    /// The body that has to stay inside; none where only the centre of gravity counts.
    outline: Option<Outline>,
}

impl Edges {
    /// For a car whose body or centre of gravity has to stay inside.
    #[must_use]
    pub fn new(car: &CarParams, limit: TrackLimit) -> Self {
        Self { outline: (limit == TrackLimit::Body).then(|| Outline::new(car)) }
    }

    /// How far what has to stay inside is beyond an edge; negative inside \[m\].
    #[must_use]
    pub fn beyond(&self, track: &Track, x: &State) -> f64 {
        match &self.outline {
            Some(outline) => outline.overhang(track, x),
            None => (x.e_y - track.width_left(x.s)).max(-x.e_y - track.width_right(x.s)),
        }
    }
}

/// When a run ends: body or centre of gravity beyond a track edge, |e_psi| above pi/2, v_x below
/// 0.1 m/s after the start, no lap within 40 s (longer on long tracks).
#[derive(Debug, Clone)]
pub struct FailureRule {
    /// Longest time a lap may take \[s\].
    pub lap_time_limit: f64,
    /// What is off the track.
    pub edges: Edges,
}

impl FailureRule {
    /// The rule for this car and track.
    #[must_use]
    pub fn new(config: &Config, track: &Track, car: &CarParams, limit: TrackLimit) -> Self {
        let slow_lap = WARM_UP_TIMES * track.length() / config.warm_up.speed;
        Self { lap_time_limit: slow_lap.max(LAP_TIME_LIMIT), edges: Edges::new(car, limit) }
    }

    /// Whether a true state, `lap_time` \[s\] after the line, ends the run.
    #[must_use]
    pub fn broken(&self, track: &Track, x: &State, lap_time: f64) -> Option<FailureReason> {
        if !x.is_finite() {
            return Some(FailureReason::NotFinite);
        }
        if self.edges.beyond(track, x) > 0.0 {
            return Some(FailureReason::OffTrack);
        }
        if x.e_psi.abs() > FRAC_PI_2 {
            // A car that slides on along the track has spun; one that drives back has turned.
            let course = x.e_psi + x.v_y.atan2(x.v_x);
            let spun = course.cos() > 0.0;
            return Some(if spun { FailureReason::Spin } else { FailureReason::WrongWay });
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
        let car = CarParams::builtin("barc").unwrap();
        let rule = FailureRule::new(&Config::default(), &track, &car, TrackLimit::CentreOfGravity);
        let good = State { v_x: 1.0, s: 3.0, ..State::default() };
        let edge = track.width_left(3.0);
        assert_eq!(rule.broken(&track, &good, 10.0), None);
        assert_eq!(rule.broken(&track, &State { e_y: edge - 1e-9, ..good }, 10.0), None);
        let cases = [
            (State { e_y: edge + 1e-9, ..good }, 0.0, FailureReason::OffTrack),
            (State { e_y: -edge - 1e-9, ..good }, 0.0, FailureReason::OffTrack),
            (State { e_psi: -1.6, ..good }, 0.0, FailureReason::WrongWay),
            (State { e_psi: -1.6, v_y: 2.0, ..good }, 0.0, FailureReason::Spin),
            (State { v_x: 0.05, ..good }, 0.0, FailureReason::Standstill),
            (State { v_x: f64::NAN, ..good }, 0.0, FailureReason::NotFinite),
            (good, 1e4, FailureReason::NoLap),
        ];
        for (x, time, reason) in cases {
            assert_eq!(rule.broken(&track, &x, time), Some(reason));
        }
    }

    #[test]
    fn a_body_reaches_the_edge_before_its_centre_does() {
        let track = Track::builtin("l").unwrap();
        let car = CarParams::builtin("barc").unwrap();
        let rule =
            FailureRule::new(&Config::default(), &track, &car, TrackLimit::of(&Config::default()));
        // On a straight, heading along it, the body reaches half its width.
        let e_y = track.width_left(0.5) - 0.5 * car.width;
        let at = |e_y: f64| State { v_x: 1.0, s: 0.5, e_y, ..State::default() };
        assert_eq!(rule.broken(&track, &at(e_y - 1e-9), 0.0), None);
        assert_eq!(rule.broken(&track, &at(e_y + 1e-9), 0.0), Some(FailureReason::OffTrack));
        assert!((rule.edges.beyond(&track, &at(e_y + 0.02)) - 0.02).abs() < 1e-9);
        let paper = Config::preset(Preset::Paper);
        let rule = FailureRule::new(&paper, &track, &car, TrackLimit::of(&paper));
        assert_eq!(rule.broken(&track, &at(e_y + 0.02), 0.0), None);
    }
}
