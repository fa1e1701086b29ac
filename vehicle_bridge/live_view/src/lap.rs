//! One lap as a trace along the track.

use serde::Serialize;
use serde::ser::{SerializeTuple as _, Serializer};

/// Samples of a lap are at least this share of the track apart, so a trace is bounded. \[-\]
const SPACING: f64 = 1.0 / 1500.0;
/// Largest number of samples of a trace. \[-\]
const MOST: usize = 3000;

/// The car at one place of a lap.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Sample {
    /// Time since the lap began. \[s\]
    pub(crate) t: f64,
    /// Along the track. \[m\]
    pub(crate) s: f64,
    /// East. \[m\]
    pub(crate) x: f64,
    /// North. \[m\]
    pub(crate) y: f64,
    /// Longitudinal velocity. \[m/s\]
    pub(crate) v_x: f64,
    /// Acceleration applied. \[m/s^2\]
    pub(crate) a: f64,
    /// Steering angle applied. \[rad\]
    pub(crate) delta: f64,
    /// Share of the front axle's largest lateral force in use; not a number without the car. \[-\]
    pub(crate) use_f: f64,
    /// The same of the rear axle. \[-\]
    pub(crate) use_r: f64,
    /// Least support of the regression along the plan; not a number before the first step. \[-\]
    pub(crate) support: f64,
    /// Limits that moved the input, as in `CAR/ACT`. \[bits\]
    pub(crate) limited: i32,
}

impl Sample {
    /// The car between here and another place: there by `share`. What is no motion stays.
    pub(crate) fn towards(&self, other: &Self, share: f64) -> Self {
        let mix = |a: f64, b: f64| a + share * (b - a);
        Self {
            x: mix(self.x, other.x),
            y: mix(self.y, other.y),
            v_x: mix(self.v_x, other.v_x),
            ..*self
        }
    }
}

impl Serialize for Sample {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let numbers = [
            self.t,
            self.s,
            self.x,
            self.y,
            self.v_x,
            self.a,
            self.delta,
            self.use_f,
            self.use_r,
            self.support,
        ];
        let mut row = to.serialize_tuple(numbers.len() + 1)?;
        for number in numbers {
            row.serialize_element(&short(number))?;
        }
        row.serialize_element(&self.limited)?;
        row.end()
    }
}

/// To a tenth of a millimetre, as few digits as that takes.
pub(crate) fn short(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

/// A lap, or what was driven of it.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub(crate) struct Trace {
    /// Its number, by who counts laps. \[-\]
    pub(crate) lap: i32,
    /// Lap time; not a number before its end. \[s\]
    pub(crate) time: f64,
    /// It was seen from line to line.
    pub(crate) whole: bool,
    /// The centre of mass stayed between the edges.
    pub(crate) inside: bool,
    /// In the order they were driven, `s` growing.
    pub(crate) samples: Vec<Sample>,
}

impl Trace {
    pub(crate) fn new(lap: i32, whole: bool) -> Self {
        Self { lap, time: f64::NAN, whole, inside: true, samples: Vec::new() }
    }

    /// Takes the end of the lap in.
    pub(crate) fn end(&mut self, sample: Sample) {
        if self.samples.len() >= MOST {
            self.samples.pop();
        }
        self.samples.push(sample);
    }

    /// Takes a place in, if the car went on far enough on a track of this length.
    pub(crate) fn push(&mut self, sample: Sample, length: f64) {
        let far = self.samples.last().is_none_or(|last| sample.s - last.s >= length * SPACING);
        if far && self.samples.len() < MOST {
            self.samples.push(sample);
        }
    }
}
