//! The lap table of a race on the terminal.

use crate::{BEST, GOOD, SOFT, WARN, paint};
use racing::record::LapRow;
use racing::words::kind_word;

/// Heading of the table.
#[must_use]
pub fn head() -> String {
    paint(SOFT, " lap  kind      lap time      best     delta   v max  |e_y| max  notes")
}

/// Remembers the best lap while the table grows.
#[derive(Debug, Default)]
pub struct LapTable {
    best: Option<f64>,
}

impl LapTable {
    /// The line of a lap.
    pub fn line(&mut self, lap: &LapRow) -> String {
        let result = &lap.result;
        let before = self.best;
        let counts = lap.is_learning() && result.valid;
        if counts && before.is_none_or(|b| result.lap_time < b) {
            self.best = Some(result.lap_time);
        }
        let time = format!("{:9.3} s", result.lap_time);
        let improved = counts && before.is_none_or(|b| result.lap_time < b);
        let time = if improved { paint(BEST, &time) } else { time };
        let best =
            self.best.map_or("        ".to_owned(), |b| format!("{b:7.3} s").trim_end().to_owned());
        let delta = match before {
            Some(b) if counts => {
                let delta = format!("{:+8.3}", result.lap_time - b);
                paint(if improved { GOOD } else { SOFT }, &delta)
            }
            _ => " ".repeat(8),
        };
        format!(
            "{:4}  {:8} {time} {best:>9}  {delta}  {:6.2}  {:9.3}  {}",
            result.lap,
            kind_word(result.kind),
            lap.v_max,
            lap.e_y_max,
            notes(lap)
        )
    }
}

/// What did not go the normal way.
fn notes(lap: &LapRow) -> String {
    let mut notes = Vec::new();
    if !lap.result.valid {
        notes.push("not valid".to_owned());
    }
    if lap.fallbacks > 0 {
        notes.push(format!("{} steps fell back", lap.fallbacks));
    }
    if lap.clipped > 0 {
        notes.push(format!("{} inputs cut", lap.clipped));
    }
    if notes.is_empty() { String::new() } else { paint(WARN, &notes.join(", ")) }
}
