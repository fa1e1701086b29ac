//! Text of a `.lcm` file to tokens, comments attached to what they describe.

use super::{FilePosition, SchemaError};

/// A word, a number or a punctuation mark.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Token {
    pub(super) text: String,
    pub(super) place: FilePosition,
    /// Lines of the comments since the token before.
    pub(super) leading: Vec<String>,
    /// Lines of the comment behind the token, on its line.
    pub(super) trailing: Vec<String>,
}

struct Cursor<'a> {
    rest: &'a str,
    place: FilePosition,
}

impl<'a> Cursor<'a> {
    /// Takes `bytes` bytes off the front; the caller cuts at a character's boundary.
    fn take(&mut self, bytes: usize) -> &'a str {
        let (taken, rest) = self.rest.split_at(bytes);
        for c in taken.chars() {
            if c == '\n' {
                self.place.line += 1;
                self.place.column = 1;
            } else {
                self.place.column += 1;
            }
        }
        self.rest = rest;
        taken
    }

    /// Takes the longest front of which every character satisfies `keep`.
    fn take_while(&mut self, keep: impl Fn(char) -> bool) -> &'a str {
        self.take(self.rest.find(|c| !keep(c)).unwrap_or(self.rest.len()))
    }

    /// Takes a comment, if one begins here, and returns its lines.
    fn comment(&mut self) -> Result<Option<Vec<String>>, SchemaError> {
        if self.rest.starts_with("//") {
            let line = self.take_while(|c| c != '\n');
            return Ok(Some(vec![line.trim_start_matches('/').trim().to_owned()]));
        }
        if !self.rest.starts_with("/*") {
            return Ok(None);
        }
        let Some(end) = self.rest.find("*/") else {
            return Err(SchemaError::new(&self.place, "comment without an end, expected `*/`"));
        };
        let text = self.take(end + 2);
        let lines = text[2..end].lines();
        Ok(Some(
            lines
                .map(|l| l.trim().trim_start_matches('*').trim().to_owned())
                .filter(|l| !l.is_empty())
                .collect(),
        ))
    }
}

/// Splits a file into tokens.
pub(super) fn tokens(file: &str, text: &str) -> Result<Vec<Token>, SchemaError> {
    let mut cursor =
        Cursor { rest: text, place: FilePosition { file: file.to_owned(), line: 1, column: 1 } };
    let mut tokens: Vec<Token> = Vec::new();
    let mut leading = Vec::new();
    loop {
        cursor.take_while(char::is_whitespace);
        let place = cursor.place.clone();
        if let Some(lines) = cursor.comment()? {
            match tokens.last_mut() {
                Some(token) if token.place.line == place.line => token.trailing.extend(lines),
                _ => leading.extend(lines),
            }
            continue;
        }
        let Some(first) = cursor.rest.chars().next() else { return Ok(tokens) };
        let text = if is_word(first) || matches!(first, '-' | '+') {
            cursor.take(1);
            let more = cursor.take_while(is_word).to_owned();
            // The sign of an exponent belongs to the number: 1e-3.
            let exponent = first.is_ascii_digit() && more.ends_with(['e', 'E']);
            let sign =
                exponent && !more.starts_with(['x', 'X']) && cursor.rest.starts_with(['-', '+']);
            let tail = if sign {
                cursor.take(1).to_owned() + cursor.take_while(is_word)
            } else {
                String::new()
            };
            format!("{first}{more}{tail}")
        } else if "{}[];,=".contains(first) {
            cursor.take(1).to_owned()
        } else {
            return Err(SchemaError::new(&place, format!("unexpected character {first:?}")));
        };
        tokens.push(Token {
            text,
            place,
            leading: std::mem::take(&mut leading),
            trailing: Vec::new(),
        });
    }
}

/// True for what words and numbers are made of; a dot separates a package from a type.
fn is_word(c: char) -> bool {
    c.is_ascii_alphanumeric() || matches!(c, '_' | '.')
}
