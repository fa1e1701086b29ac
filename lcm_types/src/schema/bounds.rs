//! Limits on what a `.lcm` file may declare: whoever reads one from a stranger spends bounded memory
//! and time.

use std::collections::BTreeMap;

use super::{Dim, Schema, SchemaError, Type};

/// Longest text of one file. \[B\]
pub(super) const MAX_TEXT: usize = 1 << 20;
/// Most dimensions of one member. \[-\]
const MAX_DIMS: usize = 16;
/// Most single values in one message, arrays of variable length not counted. \[-\]
const MAX_VALUES: usize = 1 << 20;

impl Schema {
    /// The text of a file, which is not read beyond 1 MiB.
    ///
    /// # Errors
    /// What the reader refuses; a text that is too long, or no UTF-8.
    pub fn read_text(input: impl std::io::Read) -> std::io::Result<String> {
        use std::io::Read as _;
        let mut text = String::new();
        input.take(MAX_TEXT as u64 + 1).read_to_string(&mut text)?;
        if text.len() > MAX_TEXT {
            let message = format!("longer than {MAX_TEXT} bytes: no `.lcm` file");
            return Err(std::io::Error::other(message));
        }
        Ok(text)
    }

    /// Refuses types whose messages would have more values than anybody means.
    pub(super) fn check_bounds(&self) -> Result<(), SchemaError> {
        let mut known = BTreeMap::new();
        let named: BTreeMap<String, usize> =
            self.structs.iter().enumerate().map(|(i, s)| (s.full_name(), i)).collect();
        (0..self.structs.len()).try_for_each(|i| self.values(i, &named, &mut known).map(|_| ()))
    }

    /// Single values in a message of a type; each type is counted once.
    fn values(
        &self,
        index: usize,
        named: &BTreeMap<String, usize>,
        known: &mut BTreeMap<usize, usize>,
    ) -> Result<usize, SchemaError> {
        if let Some(count) = known.get(&index) {
            return Ok(*count);
        }
        // A type inside itself, as LCM allows behind a variable length: its size is the message's.
        known.insert(index, 1);
        let mut all = 0_usize;
        for member in &self.structs[index].members {
            if member.dims.len() > MAX_DIMS {
                let found = member.dims.len();
                let message =
                    format!("`{}` has {found} dimensions, at most {MAX_DIMS}", member.name);
                return Err(SchemaError::new(&member.place, message));
            }
            let one = match &member.kind {
                Type::Primitive(_) => 1,
                Type::Struct(name) => match named.get(name) {
                    Some(inner) => self.values(*inner, named, known)?,
                    None => 1,
                },
            };
            let size = member.dims.iter().fold(one, |size, dim| match dim {
                Dim::Fixed { count, .. } => size.saturating_mul(*count),
                Dim::Variable(_) => size,
            });
            all = all.saturating_add(size);
            if all > MAX_VALUES {
                let message = format!(
                    "with `{}` a message has more than {MAX_VALUES} values: no type of a vehicle",
                    member.name
                );
                return Err(SchemaError::new(&member.place, message));
            }
        }
        known.insert(index, all.max(1));
        Ok(all.max(1))
    }
}
