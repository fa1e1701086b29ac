//! Times without the seconds before the drive: what counts from 1970 has no bits left for microseconds.

/// The whole units of a clock that are taken off its times.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ClockStart {
    /// Whole units.
    whole: i64,
    /// Length of a unit \[s\].
    unit: f64,
}

impl ClockStart {
    /// A clock whose first time is this text; none if that is no number.
    pub(super) fn of(text: &str, unit: f64) -> Option<Self> {
        let value: f64 = text.parse().ok().filter(|value: &f64| value.is_finite())?;
        let whole = split(text).map_or(value.floor() as i64, |(whole, _)| whole);
        Some(Self { whole, unit })
    }

    /// Seconds of a time in units of `unit`, from this start; none if it is no finite number.
    ///
    /// Times that differ by whole units from others give the same bits as those.
    pub(super) fn seconds(&self, text: &str, unit: f64) -> Option<f64> {
        let value: f64 = text.parse().ok().filter(|value: &f64| value.is_finite())?;
        let short = split(text).filter(|_| unit == self.unit).and_then(|(whole, fraction)| {
            let whole = whole.checked_sub(self.whole)?;
            // Of a time before the start the fraction counts the other way.
            (whole >= 0).then(|| format!("{whole}{fraction}").parse::<f64>().ok())?
        });
        let start = self.whole as f64 * self.unit;
        Some(short.map_or_else(|| value * unit - start, |short| short * unit))
    }
}

/// Whole part and fraction of a decimal number that is not negative and has no exponent.
fn split(text: &str) -> Option<(i64, &str)> {
    let (whole, fraction) = text.split_at(text.find('.').unwrap_or(text.len()));
    let digits = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
    let plain = digits(whole) && digits(fraction.strip_prefix('.').unwrap_or(""));
    plain.then(|| whole.parse().ok())?.map(|whole| (whole, fraction))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]

    use super::*;

    #[test]
    fn times_since_1970_have_the_bits_of_times_from_zero() {
        let start = ClockStart::of("1700000000.25", 1.0).unwrap();
        for (since, from_zero) in
            [("1700000000.25", 0.25), ("1700000012.3", 12.3), ("1700000003", 3.0)]
        {
            assert_eq!(start.seconds(since, 1.0).unwrap().to_bits(), f64::to_bits(from_zero));
        }
        assert_eq!(start.seconds("1699999999.5", 1.0), Some(-0.5));
        assert_eq!(start.seconds("1.7000000005e9", 1.0), Some(0.5));
        assert_eq!(start.seconds("nan", 1.0), None);
        let nanoseconds = ClockStart::of("1700000000123456789", 1e-9).unwrap();
        assert_eq!(nanoseconds.seconds("1700000000123456790", 1e-9), Some(1e-9));
        let zero = ClockStart::of("0.1", 1.0).unwrap();
        assert_eq!(zero.seconds("12.7", 1.0), Some(12.7));
        assert_eq!(ClockStart::of("-4.5", 1.0).unwrap().seconds("-4.5", 1.0), Some(0.5));
    }
}
