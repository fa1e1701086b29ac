//! Rules for the project's own types, beyond what the language asks.

use super::{Dim, Schema, SchemaError, Struct, Type};

/// Words that a generator for Rust, Python, Java or C would stumble on.
const KEYWORDS: &str = " abstract and as assert async await become boolean box break byte case \
    catch char class const continue crate def default del do double dyn elif else enum except \
    extends extern false final finally float fn for from gen global goto if impl implements import \
    in instanceof int interface is lambda let long loop macro match mod move mut native new \
    nonlocal not null or override package pass priv private protected pub public raise ref return \
    self Self short signed sizeof static strictfp struct super switch synchronized this throw \
    throws trait transient true try type typedef typeof union unsafe unsigned unsized use virtual \
    void volatile where while with yield ";

/// Longest fixed dimension: Rust's `Default` for arrays ends there.
const MAX_FIXED: usize = 32;

impl Schema {
    /// Everything in the set that breaks the project's rules for its own types:
    /// a package and comments everywhere, no keyword as a name, types named `…_t`, a `crc` only as
    /// the last member, no struct inside itself, fixed dimensions of 1 to 32.
    #[must_use]
    pub fn lint(&self) -> Vec<SchemaError> {
        let mut problems = Vec::new();
        for structure in &self.structs {
            let mut report = |place, message: String| {
                problems.push(SchemaError::new(place, format!("`{}`: {message}", structure.name)));
            };
            if structure.package.is_empty() {
                report(&structure.place, "no package, expected `package name;`".into());
            }
            if !structure.name.ends_with("_t") {
                report(&structure.place, "name, expected to end in `_t`".into());
            }
            if structure.doc.is_empty() {
                report(&structure.place, "no comment, expected what the message is".into());
            }
            if self.contains_itself(structure, &structure.full_name(), 0) {
                report(&structure.place, "contains itself, expected a tree of structs".into());
            }
            for (index, member) in structure.members.iter().enumerate() {
                let name = &member.name;
                if KEYWORDS.contains(&format!(" {name} ")) {
                    report(&member.place, format!("`{name}` is a keyword, expected another name"));
                }
                if member.doc.is_empty() {
                    report(
                        &member.place,
                        format!("no comment on `{name}`, expected meaning and unit"),
                    );
                }
                if name == "crc" && index + 1 != structure.members.len() {
                    report(&member.place, "`crc`, expected as the last member".into());
                }
                for dim in &member.dims {
                    if matches!(dim, Dim::Fixed { count, .. } if !(1..=MAX_FIXED).contains(count)) {
                        report(
                            &member.place,
                            format!("`{name}`, expected 1 to {MAX_FIXED} elements"),
                        );
                    }
                }
            }
        }
        problems
    }

    fn contains_itself(&self, structure: &Struct, sought: &str, depth: usize) -> bool {
        // Deeper than there are types means a circle that does not pass through `sought`.
        depth <= self.structs.len()
            && structure.members.iter().any(|member| match &member.kind {
                Type::Struct(name) if name == sought => true,
                Type::Struct(name) => {
                    self.get(name).is_some_and(|s| self.contains_itself(s, sought, depth + 1))
                }
                Type::Primitive(_) => false,
            })
    }
}
