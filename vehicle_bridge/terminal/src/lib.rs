//! The terminal: results on standard output, talk on standard error, colour where it is wanted.

pub mod lap_table;
pub mod progress;
pub mod top;

use std::borrow::Cow;
use std::io::{self, Write as _};

use anstyle::{AnsiColor, Style};

/// What went wrong.
pub const BAD: Style = AnsiColor::Red.on_default().bold();
/// What deserves attention.
pub const WARN: Style = AnsiColor::Yellow.on_default();
/// What went well.
pub const GOOD: Style = AnsiColor::Green.on_default();
/// The best of all.
pub const BEST: Style = AnsiColor::Magenta.on_default().bold();
/// What stands back.
pub const SOFT: Style = Style::new().dimmed();

/// `text` in a style.
#[must_use]
pub fn paint(style: Style, text: &str) -> String {
    format!("{style}{text}{style:#}")
}

/// A line of results.
///
/// # Errors
/// If standard output is closed.
pub fn result(line: &str) -> io::Result<()> {
    writeln!(anstream::stdout(), "{}", harmless(line))
}

/// A value as JSON on standard output. What JSON leaves as it is but a terminal obeys is escaped as in JSON.
///
/// # Errors
/// If the value has no JSON, or standard output is closed.
pub fn json(value: &impl serde::Serialize) -> io::Result<()> {
    writeln!(anstream::stdout(), "{}", harmless_json(&serde_json::to_string_pretty(value)?))
}

fn harmless_json(text: &str) -> String {
    let escaped = |c: char| if is_bad(c) { format!("\\u{:04x}", u32::from(c)) } else { c.into() };
    text.chars().map(escaped).collect()
}

/// Talk on standard error.
#[derive(Debug, Clone, Copy)]
pub struct Talk {
    /// Say nothing.
    pub quiet: bool,
}

impl Talk {
    /// Prints a line unless `quiet`; a closed standard error is ignored.
    pub fn say(self, line: &str) {
        if !self.quiet {
            let _ = writeln!(anstream::stderr(), "{}", harmless(line));
        }
    }
}

/// An error, which is never kept quiet.
pub fn complain(error: &str) {
    let _ = writeln!(anstream::stderr(), "{}: {}", paint(BAD, "error"), harmless(error));
}

/// Escape sequences that this program's styles are made of.
const OURS: [&str; 7] =
    ["\x1b[0m", "\x1b[1m", "\x1b[2m", "\x1b[31m", "\x1b[32m", "\x1b[33m", "\x1b[35m"];

/// `text` with every control character but line ends, tabs and the styles above written as an
/// escape, `\u{1b}`: texts from a network or a file cannot move the cursor, clear the screen or
/// turn the writing round.
#[must_use]
pub fn harmless(text: &str) -> Cow<'_, str> {
    if !text.contains(is_bad) {
        return Cow::Borrowed(text);
    }
    let (mut clean, mut rest) = (String::with_capacity(text.len() + 16), text);
    while let Some(at) = rest.find(is_bad) {
        let (before, from) = rest.split_at(at);
        clean.push_str(before);
        rest = match OURS.iter().find(|style| from.starts_with(**style)) {
            Some(style) => {
                clean.push_str(style);
                &from[style.len()..]
            }
            None => {
                let mut characters = from.chars();
                clean.extend(characters.next().into_iter().flat_map(char::escape_unicode));
                characters.as_str()
            }
        };
    }
    clean.push_str(rest);
    Cow::Owned(clean)
}

/// Whether a terminal does something else with it than to show it.
fn is_bad(c: char) -> bool {
    match c {
        '\n' | '\t' => false,
        // Those that change the direction of writing, and those that end a line in some terminals.
        '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{2028}' | '\u{2029}' => true,
        c => c.is_control(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_stays_json_and_controls_no_terminal() {
        let text = "a\x1b[2J\u{9b}2J\u{202e}b\u{2028}\x7f\n\u{e9}";
        let value = serde_json::json!({ "text": text, "list": [1, 2] });
        let shown = harmless_json(&serde_json::to_string_pretty(&value).unwrap());
        assert!(!shown.contains(is_bad), "{shown:?}");
        assert_eq!(serde_json::from_str::<serde_json::Value>(&shown).unwrap(), value);
    }

    #[test]
    fn our_styles_pass_and_nothing_else_that_controls_a_terminal() {
        for style in [BAD, WARN, GOOD, BEST, SOFT] {
            let painted = paint(style, "text\tand\nmore: \u{e9}");
            assert_eq!(harmless(&painted), painted);
        }
        let hostile = "a\x1b[2J\x1b[Hb\rc\u{9b}2Jd\x07\u{202e}e\x1b[8mf\x1b]0;title\x07";
        let clean = harmless(hostile);
        assert_eq!(
            clean,
            "a\\u{1b}[2J\\u{1b}[Hb\\u{d}c\\u{9b}2Jd\\u{7}\\u{202e}e\\u{1b}[8mf\\u{1b}]0;title\\u{7}"
        );
        assert!(!clean.contains(char::is_control));
    }
}
