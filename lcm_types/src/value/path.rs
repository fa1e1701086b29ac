//! Names of single values inside a message: `pose.pos[0]`.

use super::Value;
use crate::Error;
use crate::schema::{FilePosition, Schema, SchemaError, Type};

/// The way from a message to one value in it, resolved once.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Path {
    steps: Vec<usize>,
}

impl Path {
    /// Resolves `path` (`member.member[index]…`) in the type called `name`.
    ///
    /// # Errors
    /// [`Error::UnknownType`]; [`Error::Schema`] naming the part that fits no member.
    pub fn parse(schema: &Schema, name: &str, path: &str) -> Result<Self, Error> {
        let mut structure = schema.require(name)?;
        let mut steps = Vec::new();
        let mut column = 1;
        let mut parts = path.split('.').peekable();
        while let Some(part) = parts.next() {
            let wrong = |message: String| {
                let place =
                    FilePosition { file: format!("path `{path}` in {name}"), line: 1, column };
                Error::Schema(SchemaError::new(&place, message))
            };
            let (member_name, indices) = part.split_at(part.find('[').unwrap_or(part.len()));
            let position = structure.members.iter().position(|m| m.name == member_name);
            let Some(position) = position else {
                let known: Vec<&str> = structure.members.iter().map(|m| m.name.as_str()).collect();
                return Err(wrong(format!(
                    "`{member_name}`, expected one of {}",
                    known.join(", ")
                )));
            };
            steps.push(position);
            let member = &structure.members[position];
            let before = steps.len();
            for index in indices.split('[').skip(1) {
                let number = index.strip_suffix(']').and_then(|i| i.parse().ok());
                steps
                    .push(number.ok_or_else(|| wrong(format!("`[{index}`, expected `[number]`")))?);
            }
            let given = steps.len() - before;
            if given != member.dims.len() {
                let expected = member.dims.len();
                return Err(wrong(format!("{given} indices on `{part}`, expected {expected}")));
            }
            match (&member.kind, parts.peek()) {
                (Type::Struct(inner), Some(_)) => structure = schema.require(inner)?,
                (Type::Struct(inner), None) => {
                    return Err(wrong(format!(
                        "`{part}` is a {inner}, expected one of its members"
                    )));
                }
                (Type::Primitive(kind), Some(_)) => {
                    return Err(wrong(format!("`{part}` is a {}, it has no members", kind.name())));
                }
                (Type::Primitive(_), None) => {}
            }
            column += part.len() + 1;
        }
        Ok(Self { steps })
    }

    /// The value there; `None` where an array is too short, and for single bytes of an array.
    #[must_use]
    pub fn get<'a>(&self, message: &'a Value) -> Option<&'a Value> {
        self.steps.iter().try_fold(message, |value, step| match value {
            Value::Array(values) | Value::Struct(values) => values.get(*step),
            _ => None,
        })
    }

    /// The value there, to be changed.
    #[must_use]
    pub fn get_mut<'a>(&self, message: &'a mut Value) -> Option<&'a mut Value> {
        self.steps.iter().try_fold(message, |value, step| match value {
            Value::Array(values) | Value::Struct(values) => values.get_mut(*step),
            _ => None,
        })
    }
}
