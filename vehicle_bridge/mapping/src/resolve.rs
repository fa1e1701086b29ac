//! Names of a map file to places in messages, and what is wrong with them.

use std::collections::BTreeMap;
use std::fmt;

use lcm_types::channels;
use lcm_types::schema::{Dim, Primitive, Schema, Type};
use lcm_types::value::Path;
use toml::Spanned;

use super::file::SourceEntry;
use super::unit::{Quantity, factor};

/// Something wrong in a map file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MapProblem {
    /// Line, from 1, where it is known.
    pub line: Option<usize>,
    /// What was found and what was expected.
    pub message: String,
}

impl fmt::Display for MapProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "line {line}: {}", self.message),
            None => f.write_str(&self.message),
        }
    }
}

/// A number in a message: where, and of what type.
#[derive(Debug, Clone)]
pub(super) struct Place {
    pub(super) path: Path,
    pub(super) kind: Primitive,
}

pub(super) struct Resolver<'a> {
    text: &'a str,
    pub(super) schema: &'a Schema,
    pub(super) problems: Vec<MapProblem>,
}

impl<'a> Resolver<'a> {
    pub(super) fn new(text: &'a str, schema: &'a Schema) -> Self {
        Self { text, schema, problems: Vec::new() }
    }

    /// Notes a problem at a value of the file.
    pub(super) fn wrong<T>(&mut self, at: &Spanned<T>, message: String) {
        let before = self.text.get(..at.span().start);
        let line = (at.span().end > 0).then(|| before.map(|b| b.matches('\n').count() + 1));
        self.problems.push(MapProblem { line: line.flatten(), message });
    }

    pub(super) fn note<T, U>(&mut self, at: &Spanned<U>, made: Result<T, String>) -> Option<T> {
        made.map_err(|message| self.wrong(at, message)).ok()
    }

    pub(super) fn channel(&mut self, channel: &Spanned<String>) {
        if !channels::is_valid(channel.get_ref()) {
            let found = channel.get_ref();
            self.wrong(channel, format!("channel `{found}`, expected 1 to 63 bytes, no blanks"));
        }
    }

    pub(super) fn kind(&mut self, kind: &Spanned<String>) -> bool {
        let known = self.schema.get(kind.get_ref()).is_some();
        if !known {
            let names: Vec<String> = self.schema.structs.iter().map(|s| s.full_name()).collect();
            let found = kind.get_ref();
            self.wrong(kind, format!("type `{found}`, expected one of {}", names.join(", ")));
        }
        known
    }

    /// The number at a path of a type.
    pub(super) fn number(&mut self, of: &str, field: &Spanned<String>) -> Option<Place> {
        let parsed = Path::parse(self.schema, of, field.get_ref()).map_err(|e| e.to_string());
        let path = self.note(field, parsed)?;
        match self.member(of, field.get_ref()) {
            Some((Type::Primitive(kind), dims)) if kind != Primitive::String => {
                let outside = indices(field.get_ref()).zip(&dims).find_map(|(i, dim)| match dim {
                    Dim::Fixed { count, .. } if i >= *count => Some((i, *count)),
                    _ => None,
                });
                if let Some((index, count)) = outside {
                    let name = field.get_ref();
                    self.wrong(field, format!("`{name}`: index {index}, the array has {count}"));
                    return None;
                }
                Some(Place { path, kind })
            }
            _ => {
                let name = field.get_ref();
                self.wrong(field, format!("`{name}` of {of} is no number"));
                None
            }
        }
    }

    /// The four numbers of a quaternion.
    pub(super) fn four(&mut self, of: &str, field: &Spanned<String>) -> Option<[Path; 4]> {
        let at = |i: usize| {
            let element = Spanned::new(field.span(), format!("{}[{i}]", field.get_ref()));
            self.number(of, &element).map(|place| place.path)
        };
        let found: Vec<Path> = (0..4).map_while(at).collect();
        found.try_into().ok()
    }

    /// Type and dimensions of the last member of a path that is known to parse.
    fn member(&self, of: &str, path: &str) -> Option<(Type, Vec<Dim>)> {
        let mut structure = self.schema.get(of)?;
        let mut last = None;
        for part in path.split('.') {
            let name = part.split('[').next()?;
            let member = structure.members.iter().find(|m| m.name == name)?;
            if let Type::Struct(inner) = &member.kind {
                structure = self.schema.get(inner)?;
            }
            last = Some((member.kind.clone(), member.dims.clone()));
        }
        last
    }

    pub(super) fn unit(&mut self, quantity: Quantity, unit: &Spanned<String>) -> Option<f64> {
        let made = factor(quantity, unit.get_ref());
        self.note(unit, made)
    }

    pub(super) fn finite(&mut self, name: &str, number: &Spanned<f64>, positive: bool) -> f64 {
        let value = *number.get_ref();
        if !value.is_finite() || (positive && value <= 0.0) {
            let range = if positive { "a number above 0" } else { "a number" };
            self.wrong(number, format!("{name} = {value}, expected {range}"));
        }
        value
    }

    /// The source a value names, or the only one there is.
    pub(super) fn source<'s, U>(
        &mut self,
        sources: &'s BTreeMap<String, SourceEntry>,
        named: Option<&Spanned<String>>,
        at: &Spanned<U>,
    ) -> Option<(usize, &'s SourceEntry)> {
        let known = || sources.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
        let found = match named {
            None if sources.len() == 1 => sources.values().next().map(|entry| (0, entry)),
            None => {
                self.wrong(at, format!("`source` is missing, expected one of {}", known()));
                None
            }
            Some(name) => {
                let mut all = sources.iter().enumerate();
                let found = all.find(|(_, (key, _))| *key == name.get_ref());
                if found.is_none() {
                    let text = name.get_ref();
                    self.wrong(name, format!("source `{text}`, expected one of {}", known()));
                }
                found.map(|(index, (_, entry))| (index, entry))
            }
        };
        // An unknown type has been named already.
        found.filter(|(_, entry)| self.schema.get(entry.kind.get_ref()).is_some())
    }
}

/// Indices of the last part of a path.
fn indices(path: &str) -> impl Iterator<Item = usize> + '_ {
    let last = path.rsplit('.').next().unwrap_or_default();
    last.split('[').skip(1).filter_map(|i| i.strip_suffix(']').and_then(|i| i.parse().ok()))
}
