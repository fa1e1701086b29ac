//! What a track has along s besides its line and widths: bank, slope, friction, speed limits.

use super::{Surface, Track, fingerprint};
use std::f64::consts::FRAC_PI_3;

/// Largest bank and slope; a wall of death is no track \[rad\].
pub(super) const STEEPEST: f64 = FRAC_PI_3;
/// Largest factor of the tyres' friction: 80 is one in per cent \[-\].
pub(super) const MOST_FRICTION: f64 = 3.0;

/// What holds at a place of the centre line. What is `None` is not stated there: bank, slope and
/// friction are linear between the places that state them, a speed limit holds from its place on.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Station {
    /// Progress along the centre line, in [0, L) \[m\].
    pub s: f64,
    /// Angle of the surface about the direction of driving, positive where the left edge is the
    /// higher one (ISO 8855: a right-hand rotation about x), at most pi/3 \[rad\].
    pub bank: Option<f64>,
    /// Angle of the centre line above the horizontal, positive uphill, at most pi/3 \[rad\].
    /// Lengths of the track are horizontal ones.
    pub slope: Option<f64>,
    /// Factor of the tyres' peak friction, above 0 and at most 3 \[-\].
    pub friction: Option<f64>,
    /// Highest speed allowed from here on, above 0; infinity for none \[m/s\].
    pub speed_limit: Option<f64>,
}

/// A value that is stated at some places of the lap.
#[derive(Debug, Clone, PartialEq, Default)]
struct Profile {
    /// Places and values, s ascending.
    knots: Vec<(f64, f64)>,
}

impl Profile {
    fn new(stations: &[Station], value: impl Fn(&Station) -> Option<f64>) -> Self {
        let knots = stations.iter().filter_map(|at| Some((at.s, value(at)?))).collect();
        Self { knots }
    }

    /// Places and values before and behind s, around the lap of this length; none if nothing is
    /// stated.
    fn around(&self, s: f64, length: f64) -> Option<((f64, f64), (f64, f64))> {
        let (first, last) = (*self.knots.first()?, *self.knots.last()?);
        let next = self.knots.partition_point(|knot| knot.0 <= s);
        let before = match next {
            0 => (last.0 - length, last.1),
            _ => self.knots[next - 1],
        };
        let after = self.knots.get(next).copied().unwrap_or((first.0 + length, first.1));
        Some((before, after))
    }

    /// Slope of the value at s.
    fn rate(&self, s: f64, length: f64) -> f64 {
        let rate = |(before, after): ((f64, f64), (f64, f64))| {
            if after.0 > before.0 { (after.1 - before.1) / (after.0 - before.0) } else { 0.0 }
        };
        self.around(s, length).map_or(0.0, rate)
    }

    /// The value at s, linear between the places.
    fn linear(&self, s: f64, length: f64) -> Option<f64> {
        let (before, after) = self.around(s, length)?;
        Some(before.1 + (after.1 - before.1) * (s - before.0) / (after.0 - before.0))
    }
}

/// All profiles of a track.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Along {
    /// No bank, no slope, friction 1.
    flat: bool,
    stations: Vec<Station>,
    bank: Profile,
    slope: Profile,
    friction: Profile,
    speed_limit: Profile,
}

impl Default for Along {
    fn default() -> Self {
        let none = Profile::default();
        Self {
            flat: true,
            stations: Vec::new(),
            bank: none.clone(),
            slope: none.clone(),
            friction: none.clone(),
            speed_limit: none,
        }
    }
}

/// What is wrong with a station: the key, its value and what is expected.
type Wrong = (&'static str, f64, &'static str);

impl Station {
    /// The first thing wrong with the station on a track of this length.
    pub(super) fn wrong(&self, length: f64) -> Option<Wrong> {
        let angle = |a: f64| a.abs() <= STEEPEST;
        let angles = "an angle between -pi/3 and pi/3";
        let positive = |v: f64| v > 0.0;
        let checks: [(&str, Option<f64>, bool, &str); 5] = [
            ("s", Some(self.s), (0.0..length).contains(&self.s), "a place from 0 up to the length"),
            ("bank", self.bank, self.bank.is_none_or(angle), angles),
            ("slope", self.slope, self.slope.is_none_or(angle), angles),
            (
                "friction",
                self.friction,
                self.friction.is_none_or(|v| positive(v) && v <= MOST_FRICTION),
                "a factor above 0, at most 3",
            ),
            (
                "speed_limit",
                self.speed_limit,
                self.speed_limit.is_none_or(positive),
                "a speed above 0, or infinity",
            ),
        ];
        let bad = checks.into_iter().find(|check| !check.2)?;
        Some((bad.0, bad.1.unwrap_or(f64::NAN), bad.3))
    }
}

impl Track {
    /// The same track with these stations, in any order; none for a flat track. Two at the same
    /// place are in the order given.
    ///
    /// # Errors
    /// The first station that is not on the track, or has a value out of its range.
    pub fn with_stations(mut self, stations: &[Station]) -> Result<Self, super::TrackError> {
        let mut stations = stations.to_vec();
        for (i, station) in stations.iter().enumerate() {
            if let Some((key, found, expected)) = station.wrong(self.length) {
                let item = format!("station {}", i + 1);
                return Err(super::TrackError::Value { item, key, found, expected });
            }
        }
        stations.sort_by(|a, b| a.s.total_cmp(&b.s));
        if !stations.is_empty() {
            let stated = |value: Option<f64>| value.map_or(u64::MAX, |v| (v + 0.0).to_bits());
            let mut words = vec![self.fingerprint];
            for at in &stations {
                let values = [Some(at.s), at.bank, at.slope, at.friction, at.speed_limit];
                words.extend(values.map(stated));
            }
            self.fingerprint = fingerprint(&words);
        }
        let level = |at: &Station| {
            at.bank.unwrap_or(0.0) == 0.0
                && at.slope.unwrap_or(0.0) == 0.0
                && at.friction.unwrap_or(1.0) == 1.0
        };
        self.along = Along {
            flat: stations.iter().all(level),
            bank: Profile::new(&stations, |at| at.bank),
            slope: Profile::new(&stations, |at| at.slope),
            friction: Profile::new(&stations, |at| at.friction),
            speed_limit: Profile::new(&stations, |at| at.speed_limit),
            stations,
        };
        Ok(self)
    }

    /// The stations of the track, s ascending; none on a flat track of even friction.
    #[must_use]
    pub fn stations(&self) -> &[Station] {
        &self.along.stations
    }

    /// Whether the road is level and of even friction 1: what bank, slope and friction it has, if
    /// any, is nil everywhere.
    #[must_use]
    pub fn is_flat(&self) -> bool {
        self.along.flat
    }

    /// The surface of the road at s.
    #[must_use]
    pub fn surface(&self, s: f64) -> Surface {
        let s = self.wrap(s);
        Surface {
            bank: self.along.bank.linear(s, self.length).unwrap_or(0.0),
            slope: self.along.slope.linear(s, self.length).unwrap_or(0.0),
            bank_rate: self.along.bank.rate(s, self.length),
            slope_rate: self.along.slope.rate(s, self.length),
            friction: self.along.friction.linear(s, self.length).unwrap_or(1.0),
        }
    }

    /// Bank at s, positive where the left edge is the higher one \[rad\].
    #[must_use]
    pub fn bank(&self, s: f64) -> f64 {
        self.along.bank.linear(self.wrap(s), self.length).unwrap_or(0.0)
    }

    /// Slope at s, positive uphill \[rad\].
    #[must_use]
    pub fn slope(&self, s: f64) -> f64 {
        self.along.slope.linear(self.wrap(s), self.length).unwrap_or(0.0)
    }

    /// Factor of the tyres' peak friction at s \[-\].
    #[must_use]
    pub fn friction(&self, s: f64) -> f64 {
        self.along.friction.linear(self.wrap(s), self.length).unwrap_or(1.0)
    }

    /// Speed limit at s, infinity where there is none \[m/s\].
    #[must_use]
    pub fn speed_limit(&self, s: f64) -> f64 {
        let around = self.along.speed_limit.around(self.wrap(s), self.length);
        around.map_or(f64::INFINITY, |(before, _)| before.1)
    }
}
