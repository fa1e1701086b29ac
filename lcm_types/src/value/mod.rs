//! Messages of types known only at run time: a [`Schema`] decodes bytes to a [`Value`] and back.
//!
//! ```
//! use lcm_types::schema::Schema;
//! use lcm_types::value::Path;
//! let text = "package bot_core; struct pose_t { int64_t utime; double pos[3]; }";
//! let schema = Schema::parse(&[("pose.lcm", text)])?;
//! let mut pose = schema.zero("bot_core.pose_t")?;
//! let east = Path::parse(&schema, "bot_core.pose_t", "pos[0]")?;
//! *east.get_mut(&mut pose).unwrap() = lcm_types::value::Value::Double(1.5);
//! let mut bytes = Vec::new();
//! schema.encode_into("bot_core.pose_t", &pose, &mut bytes)?;
//! let again = schema.decode("bot_core.pose_t", &bytes)?;
//! assert_eq!(east.get(&again).and_then(|v| v.number()), Some(1.5));
//! # Ok::<(), lcm_types::Error>(())
//! ```

mod codec;
mod path;
#[cfg(test)]
mod tests;

pub use codec::MAX_DEPTH;
pub use path::Path;

use crate::Error;
use crate::schema::{Dim, Member, Primitive, Schema, Struct, Type};

/// A value of any LCM type.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// `int8_t`, `int16_t`, `int32_t`, `int64_t` or a single `byte`.
    Integer(i64),
    /// `float`.
    Float(f32),
    /// `double`.
    Double(f64),
    /// `boolean`.
    Boolean(bool),
    /// `string`.
    Text(String),
    /// The innermost dimension of an array of `byte`.
    Bytes(Vec<u8>),
    /// One dimension of an array.
    Array(Vec<Value>),
    /// The members of a struct, in the order of the schema.
    Struct(Vec<Value>),
}

impl Value {
    /// The value as a number; a boolean is 0 or 1, anything but a single number is `None`.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "counters above 2^53 are no measurements")]
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Integer(value) => Some(*value as f64),
            Self::Float(value) => Some(f64::from(*value)),
            Self::Double(value) => Some(*value),
            Self::Boolean(value) => Some(f64::from(u8::from(*value))),
            _ => None,
        }
    }

    /// Name of the variant, for messages.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Integer(_) => "an integer",
            Self::Float(_) => "a float",
            Self::Double(_) => "a double",
            Self::Boolean(_) => "a boolean",
            Self::Text(_) => "a string",
            Self::Bytes(_) => "bytes",
            Self::Array(_) => "an array",
            Self::Struct(_) => "a struct",
        }
    }
}

impl Schema {
    /// The type called `name`, or the error that there is none.
    pub(crate) fn require(&self, name: &str) -> Result<&Struct, Error> {
        self.get(name).ok_or_else(|| Error::UnknownType { name: name.to_owned() })
    }

    /// A message of the type `name` with every number 0, every string and variable array empty.
    ///
    /// # Errors
    /// [`Error::UnknownType`]; [`Error::Depth`] for a type inside itself.
    pub fn zero(&self, name: &str) -> Result<Value, Error> {
        self.zero_struct(name, 0)
    }

    fn zero_struct(&self, name: &str, depth: usize) -> Result<Value, Error> {
        if depth > MAX_DEPTH {
            return Err(Error::Depth { field: name.to_owned().into(), limit: MAX_DEPTH });
        }
        let members = &self.require(name)?.members;
        let values = members.iter().map(|m| self.zero_member(m, &m.dims, depth));
        Ok(Value::Struct(values.collect::<Result<_, _>>()?))
    }

    fn zero_member(&self, member: &Member, dims: &[Dim], depth: usize) -> Result<Value, Error> {
        let byte = member.kind == Type::Primitive(Primitive::Byte);
        match dims {
            [Dim::Variable(_)] if byte => Ok(Value::Bytes(Vec::new())),
            [Dim::Fixed { count, .. }] if byte => Ok(Value::Bytes(vec![0; *count])),
            [Dim::Variable(_), ..] => Ok(Value::Array(Vec::new())),
            [Dim::Fixed { count, .. }, rest @ ..] => {
                Ok(Value::Array(vec![self.zero_member(member, rest, depth)?; *count]))
            }
            [] => match &member.kind {
                Type::Struct(name) => self.zero_struct(name, depth + 1),
                Type::Primitive(kind) => Ok(match kind {
                    Primitive::Float => Value::Float(0.0),
                    Primitive::Double => Value::Double(0.0),
                    Primitive::String => Value::Text(String::new()),
                    Primitive::Boolean => Value::Boolean(false),
                    _ => Value::Integer(0),
                }),
            },
        }
    }
}
