//! Random messages of any type, and damage done to encoded ones. Used by the tests and by the
//! example that talks to Python, which includes this file by path.

#![allow(clippy::expect_used, clippy::unwrap_used, reason = "code of tests")]

use lcm_types::schema::{Dim, Member, Primitive, Schema, Type};
use lcm_types::value::Value;
use rand::{Rng, RngExt};

/// A random message of the type called `name`: edge values as often as others.
pub(crate) fn message(schema: &Schema, name: &str, rng: &mut impl Rng) -> Value {
    let structure = schema.get(name).expect("a type of the schema");
    let mut values: Vec<Value> = Vec::new();
    for member in &structure.members {
        let is_length = structure.members.iter().any(|m| {
            m.dims.iter().any(|d| matches!(d, Dim::Variable(length) if *length == member.name))
        });
        let value = if is_length {
            // Mostly short, at times long enough to leave the small cases behind.
            Value::Integer(if rng.random_bool(0.1) {
                rng.random_range(0..40)
            } else {
                rng.random_range(0..5)
            })
        } else {
            let count = |dim: &Dim| match dim {
                Dim::Fixed { count, .. } => *count,
                Dim::Variable(length) => {
                    let at = structure.members.iter().position(|m| m.name == *length).unwrap();
                    match values[at] {
                        Value::Integer(n) => usize::try_from(n).unwrap(),
                        _ => unreachable!(),
                    }
                }
            };
            let counts: Vec<usize> = member.dims.iter().map(count).collect();
            array(schema, member, &counts, rng)
        };
        values.push(value);
    }
    Value::Struct(values)
}

fn array(schema: &Schema, member: &Member, counts: &[usize], rng: &mut impl Rng) -> Value {
    match (counts, &member.kind) {
        ([count], Type::Primitive(Primitive::Byte)) => {
            Value::Bytes((0..*count).map(|_| rng.random()).collect())
        }
        ([count, rest @ ..], _) => {
            Value::Array((0..*count).map(|_| array(schema, member, rest, rng)).collect())
        }
        ([], Type::Struct(name)) => message(schema, name, rng),
        ([], Type::Primitive(kind)) => single(*kind, rng),
    }
}

fn single(kind: Primitive, rng: &mut impl Rng) -> Value {
    let edge = rng.random_bool(0.5);
    let choice = rng.random_range(0..4);
    match kind {
        Primitive::Int8 if edge => Value::Integer([0, 1, i8::MIN, i8::MAX][choice].into()),
        Primitive::Int8 => Value::Integer(rng.random::<i8>().into()),
        Primitive::Int16 if edge => Value::Integer([0, -1, i16::MIN, i16::MAX][choice].into()),
        Primitive::Int16 => Value::Integer(rng.random::<i16>().into()),
        Primitive::Int32 if edge => Value::Integer([0, -1, i32::MIN, i32::MAX][choice].into()),
        Primitive::Int32 => Value::Integer(rng.random::<i32>().into()),
        Primitive::Int64 if edge => Value::Integer([0, -1, i64::MIN, i64::MAX][choice]),
        Primitive::Int64 => Value::Integer(rng.random()),
        Primitive::Byte => Value::Integer(rng.random::<u8>().into()),
        Primitive::Float if edge => Value::Float([0.0, -0.0, f32::NAN, f32::INFINITY][choice]),
        Primitive::Float => {
            let value = f32::from_bits(rng.random());
            // Python reads floats as doubles, which makes a signalling NaN a quiet one.
            Value::Float(if value.is_nan() { f32::MIN_POSITIVE } else { value })
        }
        Primitive::Double if edge => Value::Double([0.0, -0.0, f64::NAN, f64::MAX][choice]),
        Primitive::Double => {
            let value = f64::from_bits(rng.random());
            Value::Double(if value.is_nan() { f64::EPSILON } else { value })
        }
        Primitive::Boolean => Value::Boolean(rng.random()),
        Primitive::String => {
            let length = rng.random_range(0..12);
            let alphabet = ['a', 'Z', '/', ' ', 'é', 'ω', '🏎', '\n'];
            let letter = |_| alphabet[rng.random_range(0..alphabet.len())];
            Value::Text((0..length).map(letter).collect())
        }
    }
}

/// Damages an encoded message; the fingerprint is left alone mostly, or nothing would be tested.
#[allow(dead_code, reason = "only the tests damage messages")]
pub(crate) fn damage(bytes: &mut Vec<u8>, rng: &mut impl Rng) {
    for _ in 0..rng.random_range(1..4) {
        let first = if rng.random_bool(0.05) { 0 } else { 8.min(bytes.len()) };
        if first == bytes.len() {
            bytes.push(rng.random());
            continue;
        }
        let at = rng.random_range(first..bytes.len());
        match rng.random_range(0..6) {
            0 => bytes[at] ^= 1 << rng.random_range(0..8),
            1 => bytes.truncate(at),
            2 => bytes.extend((0..rng.random_range(1..20)).map(|_| rng.random::<u8>())),
            3 => {
                // What a length field might hold at worst.
                let extremes =
                    [0, -1, 1, i32::MAX, i32::MIN, 0x0000_7fff, 0x7fff_0000, 4096, 65535];
                let word = extremes[rng.random_range(0..extremes.len())].to_be_bytes();
                let end = (at + 4).min(bytes.len());
                bytes[at..end].copy_from_slice(&word[..end - at]);
            }
            4 => {
                let end = rng.random_range(at..=bytes.len());
                bytes.drain(at..end);
            }
            _ => bytes[at] = rng.random(),
        }
    }
}
