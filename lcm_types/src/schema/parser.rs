//! Tokens to types.

use super::lexer::{Token, tokens};
use super::{Constant, Dim, FilePosition, Member, Primitive, Schema, SchemaError, Struct, Type};

struct Parser {
    tokens: Vec<Token>,
    next: usize,
    package: String,
    end: FilePosition,
}

/// Parses one file into its types; references to other types are checked by the caller.
pub(super) fn parse_file(file: &str, text: &str) -> Result<Vec<Struct>, SchemaError> {
    let tokens = tokens(file, text)?;
    let end = tokens.last().map_or_else(
        || FilePosition { file: file.to_owned(), line: 1, column: 1 },
        |token| token.place.clone(),
    );
    let mut parser = Parser { tokens, next: 0, package: String::new(), end };
    let mut structs = Vec::new();
    while parser.next < parser.tokens.len() {
        let word = parser.word()?;
        match word.text.as_str() {
            "package" => {
                parser.package = parser.word()?.text;
                parser.expect(";")?;
            }
            "struct" => structs.push(parser.structure(word.leading)?),
            "enum" => {
                return Err(SchemaError::new(
                    &word.place,
                    "found `enum`, expected `const` in a struct",
                ));
            }
            other => {
                let message = format!("found `{other}`, expected `package` or `struct`");
                return Err(SchemaError::new(&word.place, message));
            }
        }
    }
    Ok(structs)
}

impl Parser {
    fn take(&mut self) -> Result<Token, SchemaError> {
        let token = self.tokens.get(self.next).cloned();
        self.next += 1;
        token.ok_or_else(|| SchemaError::new(&self.end, "the file ends inside a declaration"))
    }

    fn word(&mut self) -> Result<Token, SchemaError> {
        let token = self.take()?;
        if token.text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') {
            return Ok(token);
        }
        Err(SchemaError::new(&token.place, format!("found `{}`, expected a name", token.text)))
    }

    fn expect(&mut self, mark: &str) -> Result<Token, SchemaError> {
        let token = self.take()?;
        if token.text == mark {
            return Ok(token);
        }
        let message = format!("found `{}`, expected `{mark}`", token.text);
        Err(SchemaError::new(&token.place, message))
    }

    fn peek(&self, text: &str) -> bool {
        self.tokens.get(self.next).is_some_and(|token| token.text == text)
    }

    /// Consumes `,` (true) or `;` (false).
    fn another(&mut self) -> Result<bool, SchemaError> {
        if self.peek(",") {
            self.next += 1;
            return Ok(true);
        }
        self.expect(";").map(|_| false)
    }

    fn structure(&mut self, doc: Vec<String>) -> Result<Struct, SchemaError> {
        let name = self.word()?;
        let mut structure = Struct {
            package: self.package.clone(),
            name: name.text,
            doc,
            members: Vec::new(),
            constants: Vec::new(),
            place: name.place,
        };
        self.expect("{")?;
        while !self.peek("}") {
            let word = self.word()?;
            if word.text == "const" {
                self.constants(word.leading, &mut structure)?;
            } else {
                self.members(word, &mut structure)?;
            }
        }
        self.next += 1;
        Ok(structure)
    }

    fn constants(&mut self, doc: Vec<String>, into: &mut Struct) -> Result<(), SchemaError> {
        let word = self.word()?;
        let kind = Primitive::from_name(&word.text)
            .filter(|p| !matches!(p, Primitive::String | Primitive::Boolean | Primitive::Byte));
        let Some(kind) = kind else {
            let message = format!("constant of type `{}`, expected a number type", word.text);
            return Err(SchemaError::new(&word.place, message));
        };
        loop {
            let name = self.word()?;
            into.check_new_name(&name.text, &name.place)?;
            self.expect("=")?;
            let value = self.take()?;
            if !is_number(&value.text, kind) {
                let message = format!("found `{}`, expected a {}", value.text, kind.name());
                return Err(SchemaError::new(&value.place, message));
            }
            into.constants.push(Constant {
                name: name.text,
                doc: doc.clone(),
                kind,
                text: value.text,
            });
            if !self.another()? {
                return Ok(());
            }
        }
    }

    fn members(&mut self, word: Token, into: &mut Struct) -> Result<(), SchemaError> {
        let kind = match Primitive::from_name(&word.text) {
            Some(primitive) => Type::Primitive(primitive),
            None if word.text.contains('.') || self.package.is_empty() => Type::Struct(word.text),
            None => Type::Struct(format!("{}.{}", self.package, word.text)),
        };
        let first = into.members.len();
        loop {
            let name = self.word()?;
            into.check_new_name(&name.text, &name.place)?;
            let mut dims = Vec::new();
            while self.peek("[") {
                self.next += 1;
                dims.push(self.dimension(into)?);
                self.expect("]")?;
            }
            into.members.push(Member {
                name: name.text,
                doc: word.leading.clone(),
                kind: kind.clone(),
                dims,
                place: name.place,
            });
            if !self.another()? {
                break;
            }
        }
        // The comment behind the `;` describes what was just declared.
        let trailing = self.tokens[self.next - 1].trailing.clone();
        for member in &mut into.members[first..] {
            member.doc.extend(trailing.iter().cloned());
        }
        Ok(())
    }

    fn dimension(&mut self, structure: &Struct) -> Result<Dim, SchemaError> {
        let token = self.take()?;
        // Zero and negative sizes are left out with the rest: lcm-gen has neither.
        let number = integer(&token.text).and_then(|n| usize::try_from(n).ok());
        if let Some(count) = number.filter(|n| (1..=i32::MAX as usize).contains(n)) {
            return Ok(Dim::Fixed { count, text: token.text });
        }
        let length = structure.members.iter().find(|m| m.name == token.text);
        let usable = |m: &Member| matches!(m.kind, Type::Primitive(p) if p.is_integer());
        match length {
            Some(m) if m.dims.is_empty() && usable(m) => Ok(Dim::Variable(token.text)),
            _ => {
                let message = format!(
                    "length `{}`, expected a number or an earlier integer member",
                    token.text
                );
                Err(SchemaError::new(&token.place, message))
            }
        }
    }
}

impl Struct {
    fn check_new_name(&self, name: &str, place: &FilePosition) -> Result<(), SchemaError> {
        let known = self.members.iter().any(|m| m.name == name)
            || self.constants.iter().any(|c| c.name == name);
        if known || name.contains('.') {
            let message = format!("`{name}` in `{}`, expected a new, plain name", self.name);
            return Err(SchemaError::new(place, message));
        }
        Ok(())
    }
}

impl Schema {
    pub(super) fn check_references(&self) -> Result<(), SchemaError> {
        for (index, structure) in self.structs.iter().enumerate() {
            let name = structure.full_name();
            if self.structs[..index].iter().any(|s| s.full_name() == name) {
                let message = format!("`{name}` is declared twice");
                return Err(SchemaError::new(&structure.place, message));
            }
            for member in &structure.members {
                if let Type::Struct(other) = &member.kind
                    && self.get(other).is_none()
                {
                    let message = format!("unknown type `{other}` of `{name}.{}`", member.name);
                    return Err(SchemaError::new(&member.place, message));
                }
            }
        }
        Ok(())
    }
}

/// The value of a decimal or hexadecimal integer.
pub(super) fn integer(text: &str) -> Option<i64> {
    let (sign, digits) = text.strip_prefix('-').map_or((1, text), |rest| (-1, rest));
    let hex = digits.strip_prefix("0x").or_else(|| digits.strip_prefix("0X"));
    let magnitude = match hex {
        Some(hex) => i64::from_str_radix(hex, 16),
        None if digits.starts_with(|c: char| c.is_ascii_digit()) => digits.parse(),
        None => return None,
    };
    magnitude.ok().map(|m| sign * m)
}

fn is_number(text: &str, kind: Primitive) -> bool {
    let fits =
        |bits: u32| integer(text).is_some_and(|v| v >= -(1 << (bits - 1)) && v < (1 << (bits - 1)));
    match kind {
        Primitive::Int8 => fits(8),
        Primitive::Int16 => fits(16),
        Primitive::Int32 => fits(32),
        Primitive::Int64 => integer(text).is_some(),
        Primitive::Float | Primitive::Double => {
            text.parse::<f64>().is_ok_and(f64::is_finite)
                && text.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '-' | '+' | '.'))
        }
        Primitive::Byte | Primitive::String | Primitive::Boolean => false,
    }
}
