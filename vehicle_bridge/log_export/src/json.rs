//! Messages as JSON, members by name. What is no number (NaN, infinity) is null.

use lcm_types::schema::{Member, Struct, Type};
use lcm_types::value::Value;
use serde::ser::{Serialize, SerializeMap as _, Serializer};

use super::Types;

/// A message, or a member of one with its first `level` dimensions taken.
#[derive(Clone, Copy)]
pub enum Json<'a> {
    /// A whole struct.
    Message(&'a Types, &'a Struct, &'a Value),
    /// One element of a member, or a part of its array.
    Part(&'a Types, &'a Member, &'a Value),
}

impl Serialize for Json<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        match *self {
            Json::Message(types, of, value) => {
                let Value::Struct(values) = value else { return to.serialize_none() };
                let mut map = to.serialize_map(Some(values.len()))?;
                for (member, value) in of.members.iter().zip(values) {
                    map.serialize_entry(&member.name, &Json::Part(types, member, value))?;
                }
                map.end()
            }
            Json::Part(types, member, value) => match value {
                Value::Integer(v) => to.serialize_i64(*v),
                Value::Float(v) => to.serialize_f32(*v),
                Value::Double(v) => to.serialize_f64(*v),
                Value::Boolean(v) => to.serialize_bool(*v),
                Value::Text(v) => to.serialize_str(v),
                Value::Bytes(v) => to.collect_seq(v),
                Value::Array(rows) => {
                    to.collect_seq(rows.iter().map(|row| Json::Part(types, member, row)))
                }
                Value::Struct(_) => match inner(types, member) {
                    Some(of) => Json::Message(types, of, value).serialize(to),
                    None => to.serialize_none(),
                },
            },
        }
    }
}

/// The struct a member is made of.
pub(super) fn inner<'a>(types: &'a Types, member: &Member) -> Option<&'a Struct> {
    match &member.kind {
        Type::Struct(name) => types.get(name),
        Type::Primitive(_) => None,
    }
}
