//! The `.lcm` language: parser, fingerprints, lint and the generator of Rust code.
//!
//! `build.rs` includes this folder by path to generate the crate's own types; the library offers
//! the same parser at run time, so that a program can read types it was not built with.

mod bounds;
mod fingerprint;
pub mod generate;
mod lexer;
mod lint;
mod parser;
#[cfg(test)]
mod tests;

use std::fmt;

/// Where something stands in a `.lcm` file.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FilePosition {
    /// Name of the file as given to [`Schema::parse`].
    pub file: String,
    /// Line, from 1. [-]
    pub line: usize,
    /// Column, from 1. [-]
    pub column: usize,
}

/// What is wrong in a `.lcm` file, and where.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SchemaError {
    /// Where.
    pub place: FilePosition,
    /// What was found and what was expected.
    pub message: String,
}

impl SchemaError {
    pub(crate) fn new(place: &FilePosition, message: impl Into<String>) -> Self {
        Self { place: place.clone(), message: message.into() }
    }
}

impl fmt::Display for SchemaError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let FilePosition { file, line, column } = &self.place;
        write!(f, "{file}:{line}:{column}: {}", self.message)
    }
}

impl std::error::Error for SchemaError {}

/// The primitive types of LCM; there are no unsigned integers but `byte`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Primitive {
    /// `int8_t`.
    Int8,
    /// `int16_t`.
    Int16,
    /// `int32_t`.
    Int32,
    /// `int64_t`.
    Int64,
    /// `byte`, 0 to 255.
    Byte,
    /// `float`, 32 bit.
    Float,
    /// `double`, 64 bit.
    Double,
    /// `string`, UTF-8 without NUL.
    String,
    /// `boolean`, one byte.
    Boolean,
}

impl Primitive {
    /// All of them, with their names in `.lcm` files.
    pub const ALL: [(Self, &'static str); 9] = [
        (Self::Int8, "int8_t"),
        (Self::Int16, "int16_t"),
        (Self::Int32, "int32_t"),
        (Self::Int64, "int64_t"),
        (Self::Byte, "byte"),
        (Self::Float, "float"),
        (Self::Double, "double"),
        (Self::String, "string"),
        (Self::Boolean, "boolean"),
    ];

    /// The primitive a `.lcm` file calls `name`.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|(_, n)| *n == name).map(|(p, _)| *p)
    }

    /// Its name in `.lcm` files, which is what enters the fingerprint.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].1
    }

    /// Fewest bytes one value takes on the wire; a string is its length and a NUL. \[B\]
    #[must_use]
    pub fn min_size(self) -> usize {
        match self {
            Self::Int8 | Self::Byte | Self::Boolean => 1,
            Self::Int16 => 2,
            Self::Int32 | Self::Float => 4,
            Self::Int64 | Self::Double => 8,
            Self::String => 5,
        }
    }

    /// True for the types a length field may have.
    #[must_use]
    pub fn is_integer(self) -> bool {
        matches!(self, Self::Int8 | Self::Int16 | Self::Int32 | Self::Int64)
    }
}

/// The type of one element of a member.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Type {
    /// A primitive.
    Primitive(Primitive),
    /// Another struct, by its full name `package.name`.
    Struct(String),
}

/// One dimension of an array.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Dim {
    /// A number of elements; the text as written enters the fingerprint.
    Fixed {
        /// Number of elements. [-]
        count: usize,
        /// The number as written.
        text: String,
    },
    /// The name of an earlier integer member holding the number of elements.
    Variable(String),
}

/// One member of a struct.
#[derive(Debug, Clone, PartialEq)]
pub struct Member {
    /// Name.
    pub name: String,
    /// The comment before it and behind it, one line each.
    pub doc: Vec<String>,
    /// Type of one element.
    pub kind: Type,
    /// Dimensions, outermost first; empty for a single value.
    pub dims: Vec<Dim>,
    /// Where it is declared.
    pub place: FilePosition,
}

/// One constant of a struct; constants do not enter the fingerprint.
#[derive(Debug, Clone, PartialEq)]
pub struct Constant {
    /// Name.
    pub name: String,
    /// The comment before the declaration.
    pub doc: Vec<String>,
    /// A numeric primitive.
    pub kind: Primitive,
    /// The value as written.
    pub text: String,
}

/// One message type.
#[derive(Debug, Clone, PartialEq)]
pub struct Struct {
    /// Package; empty if the file names none.
    pub package: String,
    /// Name without the package.
    pub name: String,
    /// The comment before it.
    pub doc: Vec<String>,
    /// Members in wire order.
    pub members: Vec<Member>,
    /// Constants.
    pub constants: Vec<Constant>,
    /// Where it is declared.
    pub place: FilePosition,
}

impl Struct {
    /// `package.name`, or the bare name without a package.
    #[must_use]
    pub fn full_name(&self) -> String {
        if self.package.is_empty() {
            self.name.clone()
        } else {
            format!("{}.{}", self.package, self.name)
        }
    }
}

/// A set of message types that refer to nothing outside the set.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Schema {
    /// The types, in the order of the files.
    pub structs: Vec<Struct>,
}

impl Schema {
    /// Parses files given as (name, text).
    ///
    /// # Errors
    /// The first mistake: syntax, unknown or repeated names, a length that is no earlier
    /// integer, or more than anybody means (1 MiB of text, 2^20 values).
    pub fn parse(files: &[(&str, &str)]) -> Result<Self, SchemaError> {
        let mut structs = Vec::new();
        for (name, text) in files {
            if text.len() > bounds::MAX_TEXT {
                let place = FilePosition { file: (*name).to_owned(), line: 1, column: 1 };
                let message = format!("{} bytes, at most {}", text.len(), bounds::MAX_TEXT);
                return Err(SchemaError::new(&place, message));
            }
            structs.extend(parser::parse_file(name, text)?);
        }
        let schema = Self { structs };
        schema.check_references()?;
        schema.check_bounds()?;
        Ok(schema)
    }

    /// The type called `full_name` (`package.name`).
    #[must_use]
    pub fn get(&self, full_name: &str) -> Option<&Struct> {
        self.structs.iter().find(|s| s.full_name() == full_name)
    }
}
