//! JSON schemas of message types, with the comments of their `.lcm` files.

use lcm_types::schema::{Dim, Member, Primitive, Struct, Type};
use serde_json::{Map, Value, json};

use super::Types;

/// The schema of a message written by [`Json`](super::json::Json).
#[must_use]
pub fn of(types: &Types, of: &Struct) -> Value {
    message(types, of, &mut Vec::new())
}

fn message(types: &Types, of: &Struct, parents: &mut Vec<String>) -> Value {
    parents.push(of.full_name());
    let properties: Map<String, Value> = of
        .members
        .iter()
        .map(|m| (m.name.clone(), described(array(types, m, &m.dims, parents), &m.doc)))
        .collect();
    parents.pop();
    let schema = json!({ "type": "object", "title": of.full_name(), "properties": properties });
    described(schema, &of.doc)
}

fn described(mut schema: Value, doc: &[String]) -> Value {
    if !doc.is_empty() {
        schema["description"] = doc.join(" ").into();
    }
    schema
}

fn array(types: &Types, member: &Member, dims: &[Dim], parents: &mut Vec<String>) -> Value {
    let Some((dim, rest)) = dims.split_first() else { return element(types, member, parents) };
    let mut schema = json!({ "type": "array", "items": array(types, member, rest, parents) });
    if let Dim::Fixed { count, .. } = dim {
        schema["minItems"] = (*count).into();
        schema["maxItems"] = (*count).into();
    }
    schema
}

fn element(types: &Types, member: &Member, parents: &mut Vec<String>) -> Value {
    match &member.kind {
        // A type inside itself is not followed: its schema would have no end.
        Type::Struct(name) if parents.contains(name) => json!({ "type": "object" }),
        Type::Struct(name) => match types.get(name) {
            Some(of) => message(types, of, parents),
            None => json!({ "type": "object" }),
        },
        Type::Primitive(kind) => json!({ "type": match kind {
            Primitive::Float | Primitive::Double => "number",
            Primitive::String => "string",
            Primitive::Boolean => "boolean",
            _ => "integer",
        }}),
    }
}
