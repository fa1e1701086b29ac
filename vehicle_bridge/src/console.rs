//! The terminal: results on standard output, talk on standard error, colour where it is wanted.

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
    writeln!(anstream::stdout(), "{line}")
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
            let _ = writeln!(anstream::stderr(), "{line}");
        }
    }
}

/// An error, which is never kept quiet.
pub fn complain(error: &str) {
    let _ = writeln!(anstream::stderr(), "{}: {error}", paint(BAD, "error"));
}
