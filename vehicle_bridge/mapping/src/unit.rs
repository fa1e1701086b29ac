//! Units a map file may name.

/// What a number measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Length.
    Length,
    /// Angle.
    Angle,
    /// Velocity.
    Velocity,
    /// Angular velocity.
    AngularVelocity,
    /// Acceleration.
    Acceleration,
    /// Time.
    Time,
    /// A share, a voltage, a pulse width: whatever the car's own scale is.
    Own,
}

const GRAVITY: f64 = 9.806_65;
const DEGREE: f64 = std::f64::consts::PI / 180.0;

const UNITS: [(Quantity, &[(&str, f64)]); 7] = [
    (Quantity::Length, &[("m", 1.0), ("cm", 0.01), ("mm", 0.001)]),
    (Quantity::Angle, &[("rad", 1.0), ("deg", DEGREE)]),
    (Quantity::Velocity, &[("m/s", 1.0), ("km/h", 1.0 / 3.6), ("mph", 0.447_04)]),
    (Quantity::AngularVelocity, &[("rad/s", 1.0), ("deg/s", DEGREE)]),
    (Quantity::Acceleration, &[("m/s^2", 1.0), ("g", GRAVITY)]),
    (Quantity::Time, &[("us", 1e3), ("ns", 1.0), ("ms", 1e6), ("s", 1e9)]),
    (Quantity::Own, &[("-", 1.0)]),
];

/// How many of our unit (SI; nanoseconds for times) one of `unit` is.
///
/// # Errors
/// The units there are.
pub fn factor(quantity: Quantity, unit: &str) -> Result<f64, String> {
    let units = UNITS.iter().find(|(q, _)| *q == quantity).map_or(&[][..], |(_, units)| units);
    units.iter().find(|(name, _)| *name == unit).map(|(_, factor)| *factor).ok_or_else(|| {
        let known: Vec<&str> = units.iter().map(|(name, _)| *name).collect();
        format!("unit `{unit}`, expected one of {}", known.join(", "))
    })
}
