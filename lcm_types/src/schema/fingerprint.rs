//! Fingerprints of types, the eight bytes every LCM message begins with.
//!
//! The rule is lcm-gen's: names of members, names of primitive types, and dimensions are hashed;
//! names of structs are not, their own hashes are added instead.

use super::{Dim, Schema, Struct, Type};

/// One round: the shift to the right is arithmetic, and bytes are signed, as in C.
fn byte(v: i64, c: i8) -> i64 {
    ((v << 8) ^ (v >> 55)).wrapping_add(i64::from(c))
}

/// A string enters as its length and its characters.
#[expect(clippy::cast_possible_wrap, reason = "the rule is defined on C's signed char")]
fn string(v: i64, s: &str) -> i64 {
    let v = byte(v, s.len() as u8 as i8);
    s.bytes().fold(v, |v, c| byte(v, c as i8))
}

/// The struct's own members, without the types they refer to.
fn base(structure: &Struct) -> i64 {
    structure.members.iter().fold(0x1234_5678, |v, member| {
        let mut v = string(v, &member.name);
        if let Type::Primitive(primitive) = member.kind {
            v = string(v, primitive.name());
        }
        v = byte(v, member.dims.len() as u8 as i8);
        member.dims.iter().fold(v, |v, dim| match dim {
            Dim::Fixed { text, .. } => string(byte(v, 0), text),
            Dim::Variable(name) => string(byte(v, 1), name),
        })
    })
}

impl Schema {
    /// The fingerprint of the type called `full_name`; `None` for an unknown name.
    #[must_use]
    pub fn fingerprint(&self, full_name: &str) -> Option<u64> {
        self.hash(full_name, &mut Vec::new()).map(i64::cast_unsigned)
    }

    fn hash(&self, full_name: &str, parents: &mut Vec<String>) -> Option<i64> {
        if parents.iter().any(|p| p == full_name) {
            return Some(0); // a type inside itself adds nothing
        }
        let structure = self.get(full_name)?;
        parents.push(full_name.to_owned());
        let mut v = base(structure);
        for member in &structure.members {
            if let Type::Struct(other) = &member.kind {
                v = v.wrapping_add(self.hash(other, parents)?);
            }
        }
        parents.pop();
        Some(v.rotate_left(1))
    }
}
