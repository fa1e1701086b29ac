//! TOML text that is read again and again, each time without the entry last found wrong, so that
//! every mistake is seen and not only the first.

use std::borrow::Cow;
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};
use vehicle_model::explain_unknown_key;

use super::FileProblem;

/// Most findings in one file; what follows so many is noise.
const MOST_FINDINGS: usize = 100;

/// Most times a text is read again.
const MOST_ROUNDS: usize = 300;

/// Placeholder values inserted for missing keys so that parsing can continue; tried in order.
const STAND_INS: [&str; 4] = ["1.0", "\"x\"", "true", "{}"];

/// Text with the places found wrong blanked out; lines and columns stay where they are.
#[derive(Debug, Clone)]
pub(super) struct Source {
    original: String,
    text: String,
    /// Lines of `text`, from 0, that stand in for missing keys, each with its key and stand-in.
    supplied: Vec<(usize, String, usize)>,
}

impl Source {
    /// The whole text.
    pub(super) fn new(text: &str) -> Self {
        Self { text: text.to_owned(), original: text.to_owned(), supplied: Vec::new() }
    }

    /// What is left to read.
    pub(super) fn text(&self) -> &str {
        &self.text
    }

    /// Reads with `parse`, finding everything on the way that is no TOML, no key, or has the
    /// wrong type. Whether what is left can be read.
    pub(super) fn read(
        &mut self,
        findings: &mut Vec<FileProblem>,
        parse: impl Fn(&str) -> Result<(), toml::de::Error>,
    ) -> bool {
        self.syntax(findings);
        for _ in 0..MOST_ROUNDS {
            let Err(error) = parse(&self.text) else { return true };
            let message = error.message();
            let Some(span) = error.span() else {
                findings.push(FileProblem::of(message.to_owned()));
                return false;
            };
            let line = position(&self.text, span.start).0 - 1;
            let line_start = self.start_of(line);
            let stand_in = self.supplied.iter().position(|s| s.0 == line);
            let goes_on = if let Some(key) = missing_key(message)
                && stand_in.is_some()
                && span.start > line_start
            {
                // A whole table is missing: its stand-in is filled key by key, without a word.
                self.text.insert_str(span.start + 1, &format!("{key} = 1.0, "));
                true
            } else if let Some(key) = missing_key(message) {
                self.missing(line, key, message, findings);
                true
            } else if let Some(i) = stand_in {
                self.next_stand_in(i)
            } else {
                findings.push(self.finding(&span, message));
                let entry = self.entry_around(&span).unwrap_or_else(|| vec![span]);
                self.blank(&entry)
            };
            if !goes_on {
                return false;
            }
        }
        false
    }

    /// Reports a key missing from the table that begins at `line` and puts a stand-in there.
    fn missing(&mut self, line: usize, key: &str, message: &str, findings: &mut Vec<FileProblem>) {
        let header = self.line_text(line).trim().to_owned();
        if header.starts_with('[') {
            let message = format!("{header}: {message}");
            findings.push(FileProblem {
                line: self.original_line(line + 1),
                column: None,
                message,
            });
            self.supply(line + 1, key);
            return;
        }
        // A key that was blanked out has been reported already.
        let blanked = self.original.lines().any(|text| {
            let rest = text.trim_start().strip_prefix(key);
            rest.is_some_and(|rest| rest.trim_start().starts_with('='))
        });
        if !blanked {
            findings.push(FileProblem::of(message.to_owned()));
        }
        self.supply(0, key);
    }

    /// The line of the original that a line of the rest is, both from 1; none for a stand-in.
    pub(super) fn original_line(&self, line: usize) -> Option<usize> {
        if self.supplied.iter().any(|s| s.0 + 1 == line) {
            return None;
        }
        Some(line - self.supplied.iter().filter(|s| s.0 + 1 < line).count())
    }

    /// Whether a stand-in was put for this key.
    pub(super) fn stands_in_for(&self, key: &str) -> bool {
        self.supplied.iter().any(|s| s.1 == key)
    }

    /// Byte at which a line begins, lines from 0.
    fn start_of(&self, line: usize) -> usize {
        self.text.split_inclusive('\n').take(line).map(str::len).sum()
    }

    fn line_text(&self, line: usize) -> &str {
        self.text.lines().nth(line).unwrap_or("")
    }

    /// Puts a stand-in for `key` before a line.
    fn supply(&mut self, line: usize, key: &str) {
        for other in &mut self.supplied {
            other.0 += usize::from(other.0 >= line);
        }
        self.supplied.push((line, key.to_owned(), 0));
        let at = self.start_of(line);
        let newline = if at > 0 && !self.text[..at].ends_with('\n') { "\n" } else { "" };
        self.text.insert_str(at, &format!("{newline}{key} = {}\n", STAND_INS[0]));
    }

    /// Tries the next stand-in; whether there is one.
    fn next_stand_in(&mut self, i: usize) -> bool {
        let (line, key, used) = &mut self.supplied[i];
        *used += 1;
        let Some(next) = STAND_INS.get(*used) else { return false };
        let replacement = format!("{key} = {next}");
        let line = *line;
        let lines: Vec<&str> = self.text.lines().collect();
        let with = |(n, text): (usize, &&str)| {
            if n == line { replacement.clone() } else { (*text).to_owned() }
        };
        self.text = lines.iter().enumerate().map(with).map(|l| l + "\n").collect();
        true
    }

    /// The line of a dotted key, if the file has it.
    pub(super) fn line_of(&self, dotted: &str) -> Option<usize> {
        let root = DeTable::parse_recoverable(&self.text).0;
        let mut table = root.get_ref();
        let mut line = None;
        for part in dotted.split('.') {
            let (key, value) = table.iter().find(|(key, _)| key.get_ref() == part)?;
            line = self.original_line(position(&self.text, key.span().start).0);
            match value.get_ref() {
                DeValue::Table(inner) => table = inner,
                _ => break,
            }
        }
        line
    }

    /// Finds what is no TOML and blanks out its lines.
    fn syntax(&mut self, findings: &mut Vec<FileProblem>) {
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

    fn finding(&self, span: &Range<usize>, message: &str) -> FileProblem {
        let (line, column) = position(&self.text, span.start);
        let found = self.text.get(span.clone()).unwrap_or_default().lines().next().unwrap_or("");
        let message = explain_unknown_key(message).lines().collect::<Vec<_>>().join("; ");
        let message = if found.is_empty() || message.contains(found) {
            message
        } else {
            format!("found `{}`: {message}", found.trim())
        };
        FileProblem { line: self.original_line(line), column: Some(column), message }
    }

    /// Everything that belongs to the innermost entry around `span`: its key, value and, if it is
    /// a table, all that is in it.
    fn entry_around(&self, span: &Range<usize>) -> Option<Vec<Range<usize>>> {
        let root = DeTable::parse(&self.text).ok()?;
        let mut best: Option<Vec<Range<usize>>> = None;
        visit(root.get_ref(), &mut |key, value| {
            let own = [key.span(), value.span()];
            if own.iter().any(|r| r.start <= span.start && span.end <= r.end) {
                let (start, end) = (key.span().start, key.span().end);
                let whole = start.min(value.span().start)..end.max(value.span().end);
                let mut ranges: Vec<Range<usize>> = std::iter::once(whole).collect();
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

type Visitor<'v, 'b> = dyn FnMut(&Spanned<Cow<'b, str>>, &Spanned<DeValue<'b>>) + 'v;

/// Calls `act` for every entry, outer before inner.
fn visit<'b>(table: &DeTable<'b>, act: &mut Visitor<'_, 'b>) {
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
