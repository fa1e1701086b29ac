//! Values to bytes and back, as a schema says.

use super::Value;
use crate::Error;
use crate::schema::{Dim, Member, Primitive, Schema, Struct, Type};
use crate::signature;
use crate::wire::{Reader, Wire, Writer};

/// Structs inside each other that are read; foreign types may contain themselves. [-]
pub const MAX_DEPTH: usize = 32;

impl Schema {
    /// The message of the type `name` in `bytes`.
    ///
    /// # Errors
    /// As [`Message::decode`](crate::Message::decode), and [`Error::UnknownType`],
    /// [`Error::Depth`].
    pub fn decode(&self, name: &str, bytes: &[u8]) -> Result<Value, Error> {
        let structure = self.require(name)?;
        let (bytes, _) = signature::split(bytes);
        let mut reader = Reader::new(bytes, "");
        let found = reader.fingerprint().map_err(|e| e.at(|| name.to_owned()))?;
        let expected = self.expect_fingerprint(name)?;
        if found != expected {
            return Err(Error::Fingerprint { name: name.to_owned().into(), found, expected });
        }
        let value = self.read_struct(&mut reader, structure, 0)?;
        match reader.left() {
            0 => Ok(value),
            bytes => Err(Error::Trailing { name: name.to_owned().into(), bytes }),
        }
    }

    /// Replaces the contents of `out` with the encoded message.
    ///
    /// # Errors
    /// As [`Message::encode_into`](crate::Message::encode_into), and [`Error::Kind`] where `value`
    /// is not of the type `name`, [`Error::UnknownType`], [`Error::Depth`]; `out` is then empty.
    pub fn encode_into(&self, name: &str, value: &Value, out: &mut Vec<u8>) -> Result<(), Error> {
        let structure = self.require(name)?;
        out.clear();
        out.extend_from_slice(&self.expect_fingerprint(name)?.to_be_bytes());
        let written = self.write_struct(&mut Writer::new(out), structure, value, 0);
        if written.is_err() {
            out.clear();
        }
        written
    }

    fn expect_fingerprint(&self, name: &str) -> Result<u64, Error> {
        self.fingerprint(name).ok_or_else(|| Error::UnknownType { name: name.to_owned() })
    }

    fn read_struct(&self, r: &mut Reader<'_>, of: &Struct, depth: usize) -> Result<Value, Error> {
        check_depth(of, depth)?;
        let mut values = Vec::with_capacity(of.members.len());
        for member in &of.members {
            let value = self.read_dims(r, of, member, &values, 0, depth);
            values.push(value.map_err(|e| e.at(|| field_name(of, member)))?);
        }
        Ok(Value::Struct(values))
    }

    fn read_dims(
        &self,
        r: &mut Reader<'_>,
        of: &Struct,
        member: &Member,
        before: &[Value],
        level: usize,
        depth: usize,
    ) -> Result<Value, Error> {
        let Some(dim) = member.dims.get(level) else { return self.read_one(r, member, depth) };
        let count = length(of, dim, before);
        let row_size = member.dims[level + 1..].iter().fold(self.one_size(member), |size, dim| {
            size.saturating_mul(usize::try_from(length(of, dim, before)).unwrap_or(0))
        });
        let innermost = level + 1 == member.dims.len();
        if innermost && member.kind == Type::Primitive(Primitive::Byte) {
            let rows = r.row_count(count, 1)?;
            return r.bytes(rows).map(|bytes| Value::Bytes(bytes.to_vec()));
        }
        let row = |r: &mut Reader<'_>| self.read_dims(r, of, member, before, level + 1, depth);
        match dim {
            // A fixed number of rows was not asked for by the message: they are read one by one.
            Dim::Fixed { .. } if row_size > 0 => (0..count).map(|_| row(r)).collect(),
            _ => r.rows(count, row_size, row),
        }
        .map(Value::Array)
    }

    /// Fewest bytes one element takes.
    fn one_size(&self, member: &Member) -> usize {
        match &member.kind {
            Type::Primitive(kind) => kind.min_size(),
            Type::Struct(name) => self.get(name).map_or(0, |s| self.min_size(s)),
        }
    }

    fn read_one(&self, r: &mut Reader<'_>, member: &Member, depth: usize) -> Result<Value, Error> {
        let kind = match &member.kind {
            Type::Struct(name) => return self.read_struct(r, self.require(name)?, depth + 1),
            Type::Primitive(kind) => *kind,
        };
        Ok(match kind {
            Primitive::Int8 => Value::Integer(i8::read(r)?.into()),
            Primitive::Int16 => Value::Integer(i16::read(r)?.into()),
            Primitive::Int32 => Value::Integer(i32::read(r)?.into()),
            Primitive::Int64 => Value::Integer(i64::read(r)?),
            Primitive::Byte => Value::Integer(u8::read(r)?.into()),
            Primitive::Float => Value::Float(f32::read(r)?),
            Primitive::Double => Value::Double(f64::read(r)?),
            Primitive::String => Value::Text(String::read(r)?),
            Primitive::Boolean => Value::Boolean(bool::read(r)?),
        })
    }

    fn write_struct(
        &self,
        w: &mut Writer<'_>,
        of: &Struct,
        value: &Value,
        depth: usize,
    ) -> Result<(), Error> {
        check_depth(of, depth)?;
        let values = match value {
            Value::Struct(values) if values.len() == of.members.len() => values,
            other => return Err(wrong_kind(of.full_name(), other, of.full_name())),
        };
        for (index, member) in of.members.iter().enumerate() {
            self.write_dims(w, of, member, &values[..index], &values[index], 0, depth)
                .map_err(|e| e.at(|| field_name(of, member)))?;
        }
        Ok(())
    }

    #[expect(clippy::too_many_arguments, reason = "one step of the walk over an array")]
    fn write_dims(
        &self,
        w: &mut Writer<'_>,
        of: &Struct,
        member: &Member,
        before: &[Value],
        value: &Value,
        level: usize,
        depth: usize,
    ) -> Result<(), Error> {
        let Some(dim) = member.dims.get(level) else {
            return self.write_one(w, of, member, value, depth);
        };
        let expected = length(of, dim, before);
        match value {
            Value::Bytes(bytes) if level + 1 == member.dims.len() => {
                w.count(expected, bytes.len())?;
                w.bytes(bytes);
                Ok(())
            }
            Value::Array(rows) => {
                w.count(expected, rows.len())?;
                rows.iter().try_for_each(|row| {
                    self.write_dims(w, of, member, before, row, level + 1, depth)
                })
            }
            other => Err(wrong_kind(field_name(of, member), other, "an array".to_owned())),
        }
    }

    fn write_one(
        &self,
        w: &mut Writer<'_>,
        of: &Struct,
        member: &Member,
        value: &Value,
        depth: usize,
    ) -> Result<(), Error> {
        let kind = match &member.kind {
            Type::Struct(name) => {
                return self.write_struct(w, self.require(name)?, value, depth + 1);
            }
            Type::Primitive(kind) => *kind,
        };
        let wrong = || wrong_kind(field_name(of, member), value, kind.name().to_owned());
        match (kind, value) {
            (Primitive::Int8, Value::Integer(v)) => i8::try_from(*v).map_err(|_| wrong())?.write(w),
            (Primitive::Int16, Value::Integer(v)) => {
                i16::try_from(*v).map_err(|_| wrong())?.write(w)
            }
            (Primitive::Int32, Value::Integer(v)) => {
                i32::try_from(*v).map_err(|_| wrong())?.write(w)
            }
            (Primitive::Byte, Value::Integer(v)) => u8::try_from(*v).map_err(|_| wrong())?.write(w),
            (Primitive::Int64, Value::Integer(v)) => v.write(w),
            (Primitive::Float, Value::Float(v)) => v.write(w),
            (Primitive::Double, Value::Double(v)) => v.write(w),
            (Primitive::String, Value::Text(v)) => w.string(v),
            (Primitive::Boolean, Value::Boolean(v)) => v.write(w),
            _ => Err(wrong()),
        }
    }
}

fn check_depth(of: &Struct, depth: usize) -> Result<(), Error> {
    if depth <= MAX_DEPTH {
        return Ok(());
    }
    Err(Error::Depth { field: of.full_name().into(), limit: MAX_DEPTH })
}

fn field_name(of: &Struct, member: &Member) -> String {
    format!("{}.{}", of.full_name(), member.name)
}

fn wrong_kind(field: String, found: &Value, expected: String) -> Error {
    Error::Kind { field: field.into(), found: found.kind(), expected }
}

/// Elements of a dimension, from the members read before; the parser put the length there.
fn length(of: &Struct, dim: &Dim, before: &[Value]) -> i64 {
    match dim {
        Dim::Fixed { count, .. } => i64::try_from(*count).unwrap_or(-1),
        Dim::Variable(name) => {
            let position = of.members.iter().position(|m| m.name == *name);
            match position.and_then(|p| before.get(p)) {
                Some(Value::Integer(length)) => *length,
                _ => -1,
            }
        }
    }
}
