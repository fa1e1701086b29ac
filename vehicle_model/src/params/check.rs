//! Ranges of the car parameters.

use std::fmt;

use super::CarParams;

/// One value of a car that is out of range.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ParamProblem {
    /// Section of the car file, empty for the top level.
    pub section: &'static str,
    /// Key in the car file.
    pub key: &'static str,
    /// What was found.
    pub found: String,
    /// What is allowed.
    pub expected: &'static str,
    /// Line of the key in the file it came from, from 1.
    pub line: Option<usize>,
}

impl fmt::Display for ParamProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(line) = self.line {
            write!(f, "line {line}: ")?;
        }
        let dot = if self.section.is_empty() { "" } else { "." };
        write!(
            f,
            "{}{dot}{}: found {}, expected {}",
            self.section, self.key, self.found, self.expected
        )
    }
}

/// What a number must satisfy.
#[derive(Clone, Copy)]
enum Range {
    Positive,
    NotNegative,
    Negative,
    Share,
    Steering,
}

impl Range {
    fn holds(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Positive => value > 0.0,
                Self::NotNegative => value >= 0.0,
                Self::Negative => value < 0.0,
                Self::Share => (0.0..=1.0).contains(&value),
                Self::Steering => value > 0.0 && value < std::f64::consts::FRAC_PI_2,
            }
    }

    const fn text(self) -> &'static str {
        match self {
            Self::Positive => "a number above 0",
            Self::NotNegative => "a number of 0 or above",
            Self::Negative => "a number below 0",
            Self::Share => "a share between 0 and 1",
            Self::Steering => "an angle above 0 and below pi/2",
        }
    }
}

impl CarParams {
    /// Every value that is out of range, with its key in the car file; empty when all is well.
    #[must_use]
    pub fn validate(&self) -> Vec<ParamProblem> {
        use Range::{Negative, NotNegative, Positive, Share, Steering};
        let top = [
            ("mass_kg", Some(self.mass), Positive),
            ("inertia_z_kgm2", Some(self.inertia_z), Positive),
            ("l_f_m", Some(self.l_f), Positive),
            ("l_r_m", Some(self.l_r), Positive),
            ("h_cg_m", Some(self.h_cg), NotNegative),
            ("length_m", Some(self.length), Positive),
            ("width_m", Some(self.width), Positive),
            ("cd", Some(self.cd), NotNegative),
            ("cl_front", Some(self.cl_front), NotNegative),
            ("cl_rear", Some(self.cl_rear), NotNegative),
            ("area_m2", Some(self.area), NotNegative),
            ("rho_kgpm3", Some(self.rho), NotNegative),
            ("rolling", Some(self.rolling), Share),
            ("linear_drag_per_s", Some(self.linear_drag), NotNegative),
            ("drive_front", Some(self.drive_front), Share),
            ("brake_front", Some(self.brake_front), Share),
            ("power_max_w", self.power_max, Positive),
            ("drive_force_max_n", self.drive_force_max, Positive),
            ("brake_force_max_n", self.brake_force_max, Positive),
            ("speed_max_mps", self.speed_max, Positive),
            ("a_min_mps2", Some(self.a_min), Negative),
            ("a_max_mps2", Some(self.a_max), Positive),
            ("delta_max_rad", Some(self.delta_max), Steering),
            ("delta_rate_max_radps", self.delta_rate_max, Positive),
            ("a_rate_max_mps3", self.a_rate_max, Positive),
            ("actuator_lag_s", Some(self.actuator_lag), NotNegative),
            ("actuator_delay_s", Some(self.actuator_delay), NotNegative),
            ("blend_speed_low_mps", Some(self.blend_speed_low), NotNegative),
            ("blend_speed_high_mps", Some(self.blend_speed_high), NotNegative),
        ];
        let tyres = [("tyre_front", &self.tyre_front), ("tyre_rear", &self.tyre_rear)];

        let mut problems = Vec::new();
        let mut check = |section, key, value: Option<f64>, range: Range| {
            let Some(value) = value.filter(|value| !range.holds(*value)) else { return };
            let found = value.to_string();
            problems.push(ParamProblem { section, key, found, expected: range.text(), line: None });
        };
        for (key, value, range) in top {
            check("", key, value, range);
        }
        for (section, tyre) in tyres {
            check(section, "b", Some(tyre.b), Positive);
            check(section, "c", Some(tyre.c), Positive);
            check(section, "mu", Some(tyre.mu), Positive);
        }
        let flows = self.cd > 0.0 || self.cl_front > 0.0 || self.cl_rear > 0.0;
        for (key, value) in [("area_m2", self.area), ("rho_kgpm3", self.rho)] {
            if flows && value == 0.0 {
                problems.push(ParamProblem {
                    section: "",
                    key,
                    found: value.to_string(),
                    expected: "a number above 0, because cd or cl_* is not 0",
                    line: None,
                });
            }
        }
        let blend_off = self.blend_speed_low == 0.0 && self.blend_speed_high == 0.0;
        if !blend_off && self.blend_speed_low >= self.blend_speed_high {
            problems.push(ParamProblem {
                section: "",
                key: "blend_speed_low_mps",
                found: self.blend_speed_low.to_string(),
                expected: "a speed below blend_speed_high_mps, or both 0",
                line: None,
            });
        }
        problems
    }
}
