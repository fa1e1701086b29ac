//! TOML text that is read again and again, each time without the entry last found wrong, so that
//! every mistake is seen and not only the first.

use std::ops::Range;

use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::Finding;

/// Most findings in one file; what follows so many is noise.
const MOST_FINDINGS: usize = 100;

/// Text with the places found wrong blanked out; lines and columns stay where they are.
#[derive(Debug, Clone)]
pub struct Source {
    original: String,
    text: String,
    /// Lines put in front for keys that are missing.
    supplied: usize,
}

impl Source {
    /// The whole text.
    #[must_use]
    pub fn new(text: &str) -> Self {
        let original = text.to_owned();
        Self { text: original.clone(), original, supplied: 0 }
    }

    /// What is left to read.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Reads a `T`, finding everything on the way that is no TOML, no key of `T`, or has the
    /// wrong type. `None` if what is left still cannot be read.
    pub fn read<T: DeserializeOwned>(&mut self, findings: &mut Vec<Finding>) -> Option<T> {
        self.syntax(findings);
        while findings.len() < MOST_FINDINGS {
            let error = match toml::from_str::<T>(&self.text) {
                Ok(value) => return Some(value),
                Err(error) => error,
            };
            if let Some(key) = missing_key(error.message()) {
                let in_root = error.span().is_none_or(|span| span.start == 0)
                    || self.entry_around(&error.span().unwrap_or_default()).is_none();
                findings.push(Finding { line: None, column: None, message: error.message().into() });
                if !in_root {
                    return None;
                }
                // Any number will do: the key has been reported already.
                self.text.insert_str(0, &format!("{key} = 1.0\n"));
                self.supplied += 1;
                continue;
            }
            let Some(span) = error.span().filter(|s| s.start >= self.supplied_bytes()) else {
                findings.push(Finding { line: None, column: None, message: error.message().into() });
                return None;
            };
            findings.push(self.finding(&span, error.message()));
            let entry = self.entry_around(&span).unwrap_or_else(|| vec![span]);
            if !self.blank(&entry) {
                return None;
            }
        }
        None
    }

    /// The line of a dotted key, if the file has it.
    #[must_use]
    pub fn line_of(&self, dotted: &str) -> Option<usize> {
        let root = DeTable::parse(&self.original).ok()?;
        let mut table = root.get_ref();
        let mut line = None;
        for part in dotted.split('.') {
            let (key, value) = table.iter().find(|(key, _)| key.get_ref() == part)?;
            line = Some(position(&self.original, key.span().start).0);
            match value.get_ref() {
                DeValue::Table(inner) => table = inner,
                _ => break,
            }
        }
        line
    }

    /// Finds what is no TOML and blanks out its lines.
    fn syntax(&mut self, findings: &mut Vec<Finding>) {
        while findings.len() < MOST_FINDINGS {
            let errors = DeTable::parse_recoverable(&self.text).1;
            let Some(error) = errors.first() else { return };
            let span = error.span().unwrap_or(0..self.text.len());
            findings.push(self.finding(&span, error.message()));
            let line = self.whole_lines(&span);
            if !self.blank(&[line]) {
                return;
            }
        }
    }

    fn finding(&self, span: &Range<usize>, message: &str) -> Finding {
        let (line, column) = position(&self.text, span.start);
        let found = self.text.get(span.clone()).unwrap_or_default().lines().next().unwrap_or("");
        let message = message.lines().collect::<Vec<_>>().join("; ");
        let message = if found.is_empty() || message.contains(found) {
            message
        } else {
            format!("found `{}`: {message}", found.trim())
        };
        Finding { line: Some(line - self.supplied), column: Some(column), message }
    }

    /// Everything that belongs to the innermost entry around `span`: its key, value and, if it is
    /// a table, all that is in it.
    fn entry_around(&self, span: &Range<usize>) -> Option<Vec<Range<usize>>> {
        let root = DeTable::parse(&self.text).ok()?;
        let mut best: Option<Vec<Range<usize>>> = None;
        visit(root.get_ref(), &mut |key, value| {
            let own = [key.span(), value.span()];
            if own.iter().any(|r| r.start <= span.start && span.end <= r.end) {
                let mut ranges = vec![key.span().start.min(value.span().start)
                    ..key.span().end.max(value.span().end)];
                if let DeValue::Table(inner) = value.get_ref() {
                    visit(inner, &mut |k, v| {
                        ranges.push(k.span().start..v.span().end.max(k.span().end));
                    });
                }
                best = Some(ranges);
            }
        });
        best.map(|ranges| ranges.iter().map(|r| self.whole_lines(r)).collect())
    }

    fn whole_lines(&self, span: &Range<usize>) -> Range<usize> {
        let start = span.start.min(self.text.len());
        let end = span.end.clamp(start, self.text.len());
        let first = self.text[..start].rfind('\n').map_or(0, |i| i + 1);
        let last = self.text[end..].find('\n').map_or(self.text.len(), |i| end + i);
        first..last
    }

    /// Whether anything was there to blank out.
    fn blank(&mut self, ranges: &[Range<usize>]) -> bool {
        let mut bytes = std::mem::take(&mut self.text).into_bytes();
        let mut changed = false;
        for byte in ranges.iter().flat_map(Clone::clone) {
            if bytes.get(byte).is_some_and(|b| !b.is_ascii_whitespace()) {
                bytes[byte] = b' ';
                changed = true;
            }
        }
        self.text = String::from_utf8_lossy(&bytes).into_owned();
        changed
    }

    fn supplied_bytes(&self) -> usize {
        self.text.split_inclusive('\n').take(self.supplied).map(str::len).sum()
    }
}

/// Line and column, from 1, of a byte.
fn position(text: &str, byte: usize) -> (usize, usize) {
    let before = &text[..byte.min(text.len())];
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
    (line, column)
}

fn missing_key(message: &str) -> Option<&str> {
    message.strip_prefix("missing field `")?.split('`').next()
}

/// Calls `act` for every entry, outer before inner.
fn visit<'b>(
    table: &DeTable<'b>,
    act: &mut dyn FnMut(&Spanned<std::borrow::Cow<'b, str>>, &Spanned<DeValue<'b>>),
) {
    for (key, value) in table.iter() {
        act(key, value);
        match value.get_ref() {
            DeValue::Table(inner) => visit(inner, act),
            DeValue::Array(items) => {
                for item in items.iter() {
                    if let DeValue::Table(inner) = item.get_ref() {
                        visit(inner, act);
                    }
                }
            }
            _ => {}
        }
    }
}
