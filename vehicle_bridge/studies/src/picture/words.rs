//! Columns in words, and the interval of a share.

use super::samples::{DRIVING, FAILED, LAP};

/// Quantile of the normal distribution for an interval of 95 %.
const Z: f64 = 1.96;

/// Interval of 95 % of a share found in `n` runs (Wilson 1927).
pub(super) fn wilson(share: f64, n: usize) -> Option<(f64, f64)> {
    if n == 0 {
        return None;
    }
    let n = n as f64;
    let z2 = Z * Z / n;
    let middle = (share + 0.5 * z2) / (1.0 + z2);
    let half = Z * (share * (1.0 - share) / n + 0.25 * z2 / n).sqrt() / (1.0 + z2);
    Some(((middle - half).max(0.0), (middle + half).min(1.0)))
}

/// Units that end the names of columns.
const UNITS: [(&str, &str); 9] = [
    ("_mps", "m/s"),
    ("_mps2", "m/s\u{b2}"),
    ("_radps", "rad/s"),
    ("_rad", "rad"),
    ("_us", "\u{b5}s"),
    ("_ms", "ms"),
    ("_kg", "kg"),
    ("_s", "s"),
    ("_m", "m"),
];

/// A column in words, with its unit.
pub(super) fn label(name: &str) -> String {
    match name {
        FAILED => return "share of runs that failed".to_owned(),
        DRIVING => return "share of runs that finished".to_owned(),
        _ => {}
    }
    let found = UNITS.iter().find(|(end, _)| name.ends_with(end));
    found.map_or_else(
        || words(name),
        |(end, unit)| format!("{} [{unit}]", words(name.strip_suffix(end).unwrap_or(name))),
    )
}

/// A column in words, without its unit.
pub(super) fn bare(name: &str) -> String {
    if name == LAP || name.contains('.') {
        return name.to_owned();
    }
    label(name).split(" [").next().unwrap_or(name).to_owned()
}

/// A column's name; keys of settings stay as they are set.
fn words(name: &str) -> String {
    match name {
        FAILED => "failed runs".to_owned(),
        DRIVING => "runs that drive on".to_owned(),
        _ if name.contains('.') => name.to_owned(),
        _ => name.replace('_', " "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_of_a_share_is_wilsons() {
        // Newcombe (1998), table I: 81 of 263 and 0 of 20.
        let near =
            |(a, b): (f64, f64), c: f64, d: f64| (a - c).abs() < 5e-5 && (b - d).abs() < 5e-5;
        assert!(near(wilson(81.0 / 263.0, 263).unwrap(), 0.2553, 0.3662));
        assert!(near(wilson(0.0, 20).unwrap(), 0.0, 0.1611));
        assert!(wilson(f64::NAN, 0).is_none());
    }

    #[test]
    fn units_stand_in_brackets_and_keys_stay() {
        for (name, text, short) in [
            ("best_lap_s", "best lap [s]", "best lap"),
            ("v_x_mps", "v x [m/s]", "v x"),
            ("config.cost.control_rate", "config.cost.control_rate", "config.cost.control_rate"),
            ("lap", "lap", "lap"),
        ] {
            assert_eq!((label(name).as_str(), bare(name).as_str()), (text, short));
        }
    }
}
