//! Ranges of the car parameters.

use std::fmt;

use super::CarParams;
use super::keys::CarGroup;

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

impl CarParams {
    /// Every value that is out of range or, where all are in theirs, that no car has beside the others,
    /// with its key in the car file; empty when all is well.
    #[must_use]
    pub fn validate(&self) -> Vec<ParamProblem> {
        let problems = self.out_of_range();
        if problems.is_empty() { super::units::mistakes(self) } else { problems }
    }

    /// Every value outside the range of its own key.
    pub(super) fn out_of_range(&self) -> Vec<ParamProblem> {
        let mut problems = Vec::new();
        for key in CarGroup::ALL.into_iter().flat_map(CarGroup::keys) {
            let Some(value) = (key.get)(self).filter(|value| !key.range.holds(*value)) else {
                continue;
            };
            problems.push(ParamProblem {
                section: key.group.section(),
                key: key.key,
                found: value.to_string(),
                expected: key.range.text(),
                line: None,
            });
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
