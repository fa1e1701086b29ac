//! What of a car matters to a track.

/// The numbers of a car that decide whether it can drive a track, and how large random tracks for it are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CarSize<'a> {
    /// Name of the car.
    pub name: &'a str,
    /// Width of its body \[m\].
    pub width: f64,
    /// Radius at full steering lock \[m\].
    pub lock: f64,
    /// Greatest acceleration that the tyres of its weaker axle give on a level road \[m/s^2\].
    pub grip: f64,
}
