//! Limits of the rules of doubt, by default from car and track.

use vehicle_model::{CarParams, Track};

/// What may differ before a state or an actuator is doubted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DoubtLimits {
    /// How far a corner of the body may be beyond the edge. \[m\]
    pub edge: f64,
    /// How far a predicted stop may take the centre of mass beyond the edge. \[m\]
    pub stop_edge: f64,
    /// Greatest angle between car and track. \[rad\]
    pub heading: f64,
    /// Constant part of the disagreement between position and velocity. \[m\]
    pub position: f64,
    /// Share by which a speed may be wrong. \[-\]
    pub speed_share: f64,
    /// Angle by which a heading may be wrong. \[rad\]
    pub heading_error: f64,
    /// Time by which a measurement may be early or late. \[s\]
    pub timing: f64,
    /// Constant part of the disagreement between heading and yaw rate. \[rad\]
    pub turn: f64,
    /// Acceleration by which the speed may disagree with throttle and brake. \[m/s^2\]
    pub accel: f64,
    /// Steering angle by which the yaw rate may disagree with the steering. \[rad\]
    pub steer: f64,
    /// Yaw rate that is always allowed. \[rad/s\]
    pub yaw_rate: f64,
    /// A disagreement of twice its limit is doubted after this long. \[s\]
    pub patience: f64,
    /// Up to this speed a doubted car may still be accelerated: one that was armed askew has to turn
    /// round. \[m/s\]
    pub crawl: f64,
}

impl DoubtLimits {
    /// The limits of a car on a track.
    #[must_use]
    pub fn new(car: &CarParams, track: &Track) -> Self {
        let half = (0..256)
            .map(|i| track.length() * f64::from(i) / 256.0)
            .map(|s| track.width_left(s).min(track.width_right(s)))
            .fold(f64::INFINITY, f64::min);
        Self {
            // Laps are judged by the centre of mass: a corner may be out by as much as the body is wide.
            edge: 0.75 * car.width,
            stop_edge: 0.5 * car.width,
            heading: 1.8,
            position: 0.1 * half,
            speed_share: 0.07,
            heading_error: 0.035,
            timing: 0.03,
            turn: 0.1,
            accel: 0.35 * car.a_max.max(-car.a_min),
            steer: 0.05,
            yaw_rate: 0.15,
            patience: 0.1,
            // Full braking stops the car within half the width of its body.
            crawl: (-car.a_min * car.width).sqrt(),
        }
    }
}

/// A limit's name on a command line, with its unit, and its place.
type Named = (&'static str, fn(&mut DoubtLimits) -> &mut f64);

/// All of them.
const NAMED: [Named; 13] = [
    ("edge_m", |l| &mut l.edge),
    ("stop_edge_m", |l| &mut l.stop_edge),
    ("heading_rad", |l| &mut l.heading),
    ("position_m", |l| &mut l.position),
    ("speed_share", |l| &mut l.speed_share),
    ("heading_error_rad", |l| &mut l.heading_error),
    ("timing_s", |l| &mut l.timing),
    ("turn_rad", |l| &mut l.turn),
    ("accel_mps2", |l| &mut l.accel),
    ("steer_rad", |l| &mut l.steer),
    ("yaw_rate_radps", |l| &mut l.yaw_rate),
    ("patience_s", |l| &mut l.patience),
    ("crawl_mps", |l| &mut l.crawl),
];

/// Why a limit was not set.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DoubtLimitError {
    /// There is no such limit.
    #[error("doubt limit `{found}` is not known, expected one of {known}")]
    Name {
        /// What was named.
        found: String,
        /// What there is.
        known: String,
    },
    /// It is not a number above 0: a rule without a limit would stop every car, or none.
    #[error("doubt limit {name} is {found}, expected a number above 0")]
    Value {
        /// Which.
        name: &'static str,
        /// What was given.
        found: f64,
    },
}

impl DoubtLimits {
    /// Sets the limit of this name; what it was.
    ///
    /// # Errors
    /// [`DoubtLimitError`]; nothing is changed then.
    pub fn set(&mut self, name: &str, value: f64) -> Result<f64, DoubtLimitError> {
        let Some((name, place)) = NAMED.iter().find(|(known, _)| *known == name) else {
            let known = NAMED.map(|(known, _)| known).join(", ");
            return Err(DoubtLimitError::Name { found: name.to_owned(), known });
        };
        if !(value > 0.0 && value.is_finite()) {
            return Err(DoubtLimitError::Value { name, found: value });
        }
        Ok(std::mem::replace(place(self), value))
    }

    /// Names of all limits, each with its unit.
    pub fn names() -> impl Iterator<Item = &'static str> {
        NAMED.iter().map(|(name, _)| *name)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]
    use super::*;

    #[test]
    fn each_limit_has_a_name_and_a_place_of_its_own() {
        let car = CarParams::builtin("barc").unwrap();
        let before = DoubtLimits::new(&car, &Track::builtin("l").unwrap());
        let mut limits = before;
        for (value, name) in (101..).map(f64::from).zip(DoubtLimits::names()) {
            // A place that two names had would give back the number of the first.
            assert!(limits.set(name, value).unwrap() < 100.0, "{name}");
        }
        // No field is left as it was.
        let DoubtLimits {
            edge,
            stop_edge,
            heading,
            position,
            speed_share,
            heading_error,
            timing,
            turn,
            accel,
            steer,
            yaw_rate,
            patience,
            crawl,
        } = limits;
        let all = [
            edge,
            stop_edge,
            heading,
            position,
            speed_share,
            heading_error,
            timing,
            turn,
            accel,
            steer,
            yaw_rate,
            patience,
            crawl,
        ];
        assert!(all.iter().zip(101..).all(|(found, set)| *found == f64::from(set)), "{all:?}");
    }

    #[test]
    fn the_page_names_every_limit() {
        let page = include_str!("../../../../docs/safety.md");
        for name in DoubtLimits::names() {
            assert!(page.contains(&format!("`{name}`")), "docs/safety.md lacks `{name}`");
        }
    }

    #[test]
    fn what_is_no_limit_is_refused_and_changes_nothing() {
        let car = CarParams::builtin("barc").unwrap();
        let before = DoubtLimits::new(&car, &Track::builtin("l").unwrap());
        let mut limits = before;
        for value in [0.0, -0.1, f64::NAN, f64::INFINITY] {
            let error = limits.set("edge_m", value).unwrap_err().to_string();
            assert!(error.contains("edge_m") && error.contains("above 0"), "{error}");
        }
        let error = limits.set("egde_m", 1.0).unwrap_err().to_string();
        assert!(error.contains("`egde_m`") && error.contains("crawl_mps"), "{error}");
        assert_eq!(limits, before);
    }
}
