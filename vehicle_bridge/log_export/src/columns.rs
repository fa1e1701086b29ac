//! Messages as rows of a table: one column for each single value.

use lcm_types::schema::{Member, Struct};
use lcm_types::value::Value;

use super::Types;
use super::json::{Json, inner};

/// Longest array that is given columns of its own; a longer one is one cell of JSON. \[-\]
pub const MAX_INDEX: usize = 256;

/// The columns a stream of messages needs, grown by each message of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ColumnTree {
    /// One column.
    Cell,
    /// Elements of an array, as many as the longest has.
    List(Vec<ColumnTree>),
    /// Members of a struct.
    Group(Vec<ColumnTree>),
}

impl ColumnTree {
    /// The columns `value` needs.
    #[must_use]
    pub fn of(value: &Value) -> Self {
        match value {
            Value::Array(rows) if rows.len() > MAX_INDEX => Self::Cell,
            Value::Array(rows) => Self::List(rows.iter().map(Self::of).collect()),
            Value::Struct(members) => Self::Group(members.iter().map(Self::of).collect()),
            _ => Self::Cell,
        }
    }

    /// Grows to hold `value` too.
    pub fn grow(&mut self, value: &Value) {
        match (self, value) {
            (Self::Cell, _) => {}
            (this, Value::Array(rows)) if rows.len() > MAX_INDEX => *this = Self::Cell,
            (Self::List(columns), Value::Array(rows)) => {
                columns.iter_mut().zip(rows).for_each(|(column, row)| column.grow(row));
                columns.extend(rows.iter().skip(columns.len()).map(Self::of));
            }
            (Self::Group(columns), Value::Struct(members)) => {
                columns.iter_mut().zip(members).for_each(|(column, member)| column.grow(member));
            }
            _ => {}
        }
    }

    /// Names of the columns of a message: `h.seq`, `pred[3].x`.
    #[must_use]
    pub fn names(&self, types: &Types, of: &Struct) -> Vec<String> {
        let mut names = Vec::new();
        self.name_members(types, of, "", &mut names);
        names
    }

    fn name_members(&self, types: &Types, of: &Struct, prefix: &str, names: &mut Vec<String>) {
        let Self::Group(columns) = self else { return };
        for (member, column) in of.members.iter().zip(columns) {
            column.name_member(types, member, format!("{prefix}{}", member.name), names);
        }
    }

    fn name_member(&self, types: &Types, member: &Member, name: String, names: &mut Vec<String>) {
        match (self, inner(types, member)) {
            (Self::List(columns), _) => {
                for (index, column) in columns.iter().enumerate() {
                    column.name_member(types, member, format!("{name}[{index}]"), names);
                }
            }
            (Self::Group(_), Some(of)) => {
                self.name_members(types, of, &format!("{name}."), names);
            }
            _ => names.push(name),
        }
    }

    /// The cells of a message, in the order of the names; empty where an array is shorter.
    pub fn cells(&self, types: &Types, of: &Struct, value: &Value, cells: &mut Vec<String>) {
        self.fill_members(types, of, Some(value), cells);
    }

    fn fill_members(
        &self,
        types: &Types,
        of: &Struct,
        value: Option<&Value>,
        cells: &mut Vec<String>,
    ) {
        let Self::Group(columns) = self else { return };
        let values: &[Value] = match value {
            Some(Value::Struct(values)) => values,
            _ => &[],
        };
        for (index, (member, column)) in of.members.iter().zip(columns).enumerate() {
            column.fill_member(types, member, values.get(index), cells);
        }
    }

    fn fill_member(
        &self,
        types: &Types,
        member: &Member,
        value: Option<&Value>,
        cells: &mut Vec<String>,
    ) {
        match (self, inner(types, member)) {
            (Self::List(columns), _) => {
                let rows: &[Value] = match value {
                    Some(Value::Array(rows)) => rows,
                    _ => &[],
                };
                for (index, column) in columns.iter().enumerate() {
                    column.fill_member(types, member, rows.get(index), cells);
                }
            }
            (Self::Group(_), Some(of)) => self.fill_members(types, of, value, cells),
            _ => cells.push(value.map_or_else(String::new, |value| cell(types, member, value))),
        }
    }
}

fn cell(types: &Types, member: &Member, value: &Value) -> String {
    match value {
        Value::Integer(v) => v.to_string(),
        Value::Float(v) => v.to_string(),
        Value::Double(v) => v.to_string(),
        Value::Boolean(v) => u8::from(*v).to_string(),
        Value::Text(v) => v.clone(),
        Value::Bytes(v) => v.iter().map(|byte| format!("{byte:02x}")).collect(),
        Value::Array(_) | Value::Struct(_) => {
            serde_json::to_string(&Json::Part(types, member, value)).unwrap_or_default()
        }
    }
}
