//! Units as FMUs and maps spell them.

use std::f64::consts::PI;

/// What a unit measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dimension {
    /// Length.
    Length,
    /// Speed.
    Speed,
    /// Acceleration.
    Acceleration,
    /// Angle.
    Angle,
    /// Angular speed.
    AngularSpeed,
}

const DEG: f64 = PI / 180.0;

/// Spellings, what they measure, and their size in SI units.
const UNITS: [(&[&str], Dimension, f64); 16] = [
    (&["m", "metre", "meter"], Dimension::Length, 1.0),
    (&["km"], Dimension::Length, 1e3),
    (&["cm"], Dimension::Length, 1e-2),
    (&["mm"], Dimension::Length, 1e-3),
    (&["ft"], Dimension::Length, 0.3048),
    (&["m/s", "mps", "m.s-1"], Dimension::Speed, 1.0),
    (&["km/h", "kmh", "kph", "kmph"], Dimension::Speed, 1.0 / 3.6),
    (&["mph", "mi/h"], Dimension::Speed, 0.44704),
    (&["m/s2", "m/s^2", "m/s/s", "mps2", "m.s-2"], Dimension::Acceleration, 1.0),
    (&["g", "g0"], Dimension::Acceleration, 9.80665),
    (&["rad", "radian"], Dimension::Angle, 1.0),
    (&["deg", "degree", "degrees"], Dimension::Angle, DEG),
    (&["mrad"], Dimension::Angle, 1e-3),
    (&["rad/s", "radps", "rad.s-1"], Dimension::AngularSpeed, 1.0),
    (&["deg/s", "degps", "dps", "degree/s"], Dimension::AngularSpeed, DEG),
    (&["rpm", "r/min", "rev/min"], Dimension::AngularSpeed, PI / 30.0),
];

/// What a unit of this spelling measures, and how many SI units it is.
#[must_use]
pub fn unit(spelling: &str) -> Option<(Dimension, f64)> {
    let plain = spelling.trim().to_lowercase().replace('²', "2").replace('°', "deg");
    let known = UNITS.iter().find(|(names, ..)| names.contains(&plain.as_str()))?;
    Some((known.1, known.2))
}

/// All spellings, for messages.
#[must_use]
pub fn spellings() -> String {
    UNITS.iter().map(|(names, ..)| names[0]).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spellings_of_one_unit_agree() {
        assert_eq!(unit("km/h"), unit("kph"));
        assert_eq!(unit("m/s²"), unit("m/s^2"));
        assert_eq!(unit(" ° "), Some((Dimension::Angle, PI / 180.0)));
        assert_eq!(unit("furlong"), None);
    }

    #[test]
    fn known_amounts_come_out_in_si() {
        for (spelling, amount, si) in
            [("km/h", 36.0, 10.0), ("deg", 180.0, PI), ("rpm", 60.0, 2.0 * PI), ("mm", 5.0, 0.005)]
        {
            assert!((unit(spelling).unwrap().1 * amount - si).abs() < 1e-12, "{spelling}");
        }
    }
}
