//! The message types an export knows: the product's own, and those of `.lcm` files given to it.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use anyhow::{Context as _, Result};
use lcm_types::Error;
use lcm_types::schema::{Schema, Struct};
use lcm_types::value::Value;

/// Types found by the fingerprint a message begins with.
#[derive(Debug, Clone)]
pub struct Types {
    schema: Schema,
    by_fingerprint: BTreeMap<[u8; 8], usize>,
}

impl Types {
    /// The product's types and those in `files`.
    ///
    /// # Errors
    /// If a file cannot be read, or holds no right types; a name may not be defined twice.
    pub fn load(files: &[PathBuf]) -> Result<Self> {
        let mut sources: Vec<(String, String)> =
            lcm_types::SOURCES.iter().map(|(n, t)| ((*n).to_owned(), (*t).to_owned())).collect();
        for path in files {
            let shown = path.display().to_string();
            let text = fs::read_to_string(path).with_context(|| format!("cannot read {shown}"))?;
            sources.push((shown, text));
        }
        let borrowed: Vec<(&str, &str)> = sources.iter().map(|(n, t)| (&**n, &**t)).collect();
        let schema = Schema::parse(&borrowed)?;
        let mut by_fingerprint = BTreeMap::new();
        for (index, structure) in schema.structs.iter().enumerate() {
            if let Some(fingerprint) = schema.fingerprint(&structure.full_name()) {
                by_fingerprint.insert(fingerprint.to_be_bytes(), index);
            }
        }
        Ok(Self { schema, by_fingerprint })
    }

    /// The type of a message, by its first eight bytes.
    #[must_use]
    pub fn of(&self, message: &[u8]) -> Option<&Struct> {
        let index = self.by_fingerprint.get(message.first_chunk::<8>()?)?;
        self.schema.structs.get(*index)
    }

    /// The type called `name`.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&Struct> {
        self.schema.get(name)
    }

    /// A message of the type `of`.
    ///
    /// # Errors
    /// As [`Schema::decode`].
    pub fn decode(&self, of: &Struct, message: &[u8]) -> Result<Value, Error> {
        self.schema.decode(&of.full_name(), message)
    }
}
