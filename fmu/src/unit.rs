//! Physical units and how each is built from the SI base units.

/// A unit of the model description with its base-unit exponents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// Name as it appears in the model description, for example `m/s`.
    pub name: &'static str,
    /// Exponent of kilogram.
    pub kg: i32,
    /// Exponent of metre.
    pub m: i32,
    /// Exponent of second.
    pub s: i32,
    /// Exponent of radian.
    pub rad: i32,
    /// Factor that turns a value in this unit into base units.
    pub factor: f64,
    /// No quantity of a car and its track is larger than this.
    pub extent: f64,
}

const fn unit(name: &'static str, [kg, m, s, rad]: [i32; 4], extent: f64) -> Unit {
    Unit { name, kg, m, s, rad, factor: 1.0, extent }
}

/// Dimensionless.
pub const ONE: Unit = unit("1", [0, 0, 0, 0], 1e9);
/// Metre.
pub const M: Unit = unit("m", [0, 1, 0, 0], 1e8);
/// Metre per second.
pub const M_PER_S: Unit = unit("m/s", [0, 1, -1, 0], 1e3);
/// Metre per second squared.
pub const M_PER_S2: Unit = unit("m/s2", [0, 1, -2, 0], 1e3);
/// Metre per second cubed, a jerk.
pub const M_PER_S3: Unit = unit("m/s3", [0, 1, -3, 0], 1e6);
/// Second.
pub const S: Unit = unit("s", [0, 0, 1, 0], 1e9);
/// Per second.
pub const PER_S: Unit = unit("1/s", [0, 0, -1, 0], 1e6);
/// Millisecond.
pub const MS: Unit = Unit { name: "ms", kg: 0, m: 0, s: 1, rad: 0, factor: 1e-3, extent: 1e12 };
/// Radian.
pub const RAD: Unit = unit("rad", [0, 0, 0, 1], 1e6);
/// Radian per second.
pub const RAD_PER_S: Unit = unit("rad/s", [0, 0, -1, 1], 1e3);
/// Radian per metre, a curvature.
pub const RAD_PER_M: Unit = unit("rad/m", [0, -1, 0, 1], 1e3);
/// Kilogram.
pub const KG: Unit = unit("kg", [1, 0, 0, 0], 1e6);
/// Kilogram square metre.
pub const KG_M2: Unit = unit("kg.m2", [1, 2, 0, 0], 1e9);
/// Newton.
pub const N: Unit = unit("N", [1, 1, -2, 0], 1e9);
/// Square metre.
pub const M2: Unit = unit("m2", [0, 2, 0, 0], 1e3);
/// Kilogram per cubic metre.
pub const KG_PER_M3: Unit = unit("kg/m3", [1, -3, 0, 0], 1e3);
/// Watt.
pub const W: Unit = unit("W", [1, 2, -3, 0], 1e9);

/// The unit that papers and tables write as `kg m^2` or `m/s^2`; dimensionless for `-` and what is
/// not known.
#[must_use]
pub fn of_symbol(symbol: &str) -> Unit {
    const ALL: [Unit; 16] = [
        M, M_PER_S, M_PER_S2, M_PER_S3, S, PER_S, RAD, RAD_PER_S, RAD_PER_M, KG, KG_M2, N, M2,
        KG_PER_M3, W, MS,
    ];
    let name = symbol.replace('^', "").replace(' ', ".");
    ALL.into_iter().find(|unit| unit.name == name).unwrap_or(ONE)
}
