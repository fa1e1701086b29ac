//! What of a recording could not be used: where, and why.

use std::fmt;

/// Stretches that are named of one reason.
const NAMED: usize = 5;

/// Rows of a table, by line, or messages of a log, by number from 1, that were left out.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct LeftOut {
    reasons: Vec<(String, Vec<(u64, u64)>)>,
}

impl LeftOut {
    /// Leaves a row out.
    pub(super) fn add(&mut self, row: u64, reason: &str) {
        let place = self.reasons.iter().position(|(known, _)| known == reason);
        let place = place.unwrap_or_else(|| {
            self.reasons.push((reason.to_owned(), Vec::new()));
            self.reasons.len() - 1
        });
        let stretches = &mut self.reasons[place].1;
        match stretches.last_mut() {
            Some((_, last)) if *last + 1 == row => *last = row,
            _ => stretches.push((row, row)),
        }
    }

    /// How many were left out.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.reasons.iter().map(|(_, stretches)| length(stretches)).sum()
    }

    /// Each reason with the first and the last row of every stretch of them.
    pub fn reasons(&self) -> impl Iterator<Item = (&str, &[(u64, u64)])> {
        self.reasons.iter().map(|(reason, stretches)| (reason.as_str(), stretches.as_slice()))
    }
}

fn length(stretches: &[(u64, u64)]) -> u64 {
    stretches.iter().map(|(first, last)| last - first + 1).sum()
}

impl fmt::Display for LeftOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, (reason, stretches)) in self.reasons.iter().enumerate() {
            let named = stretches.iter().take(NAMED).map(|(first, last)| match last - first {
                0 => first.to_string(),
                _ => format!("{first} to {last}"),
            });
            let mut rows = named.collect::<Vec<_>>().join(", ");
            if stretches.len() > NAMED {
                rows += &format!(" and {} more", length(&stretches[NAMED..]));
            }
            let between = if i == 0 { "" } else { "; " };
            write!(f, "{between}{} for {reason}: {rows}", length(stretches))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_that_follow_each_other_are_a_stretch() {
        let mut left = LeftOut::default();
        for row in [17, 20, 21, 22] {
            left.add(row, "no number in v_x");
        }
        left.add(18, "no time");
        assert_eq!(left.count(), 5);
        assert_eq!(left.to_string(), "4 for no number in v_x: 17, 20 to 22; 1 for no time: 18");
        for row in (100..200).step_by(2) {
            left.add(row, "no time");
        }
        assert!(left.to_string().ends_with("51 for no time: 18, 100, 102, 104, 106 and 46 more"));
    }
}
