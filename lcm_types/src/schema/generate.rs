//! Types to Rust code: a struct with docs, its constants, and how it goes over the wire.

use std::fmt::Write;

use super::{Constant, Dim, Member, Primitive, Schema, SchemaError, Struct, Type};

/// Rust code for every type of the set, to be included where the crate's `wire` module is.
///
/// # Errors
/// A type without a fingerprint, which a parsed schema does not have.
pub fn rust(schema: &Schema) -> Result<String, SchemaError> {
    let mut out = String::new();
    for structure in &schema.structs {
        let unknown = || SchemaError::new(&structure.place, "no fingerprint");
        let fingerprint = schema.fingerprint(&structure.full_name()).ok_or_else(unknown)?;
        // A String takes any formatted text: the results of `write!` cannot be errors.
        let _ = declaration(&mut out, structure);
        let _ = wire(&mut out, schema, structure);
        let _ = message(&mut out, structure, fingerprint);
    }
    Ok(out)
}

/// `vehicle_state_t` is `VehicleState` in Rust.
#[must_use]
pub fn rust_name(lcm_name: &str) -> String {
    let stem = lcm_name.strip_suffix("_t").unwrap_or(lcm_name);
    let upper = |part: &str| {
        let mut chars = part.chars();
        chars.next().map(|c| c.to_ascii_uppercase().to_string() + chars.as_str())
    };
    stem.split('_').filter_map(upper).collect()
}

fn doc(out: &mut String, indent: &str, lines: &[String]) -> std::fmt::Result {
    for line in lines {
        // Units stand in brackets, which rustdoc would read as links.
        let text = line.replace('[', "\\[").replace(']', "\\]");
        writeln!(out, "{indent}/// {text}")?;
    }
    Ok(())
}

fn declaration(out: &mut String, structure: &Struct) -> std::fmt::Result {
    doc(out, "", &structure.doc)?;
    writeln!(out, "///\n/// LCM type `{}`.", structure.full_name())?;
    writeln!(out, "#[derive(Debug, Clone, PartialEq, Default)]")?;
    writeln!(out, "pub struct {} {{", rust_name(&structure.name))?;
    for member in &structure.members {
        doc(out, "    ", &member.doc)?;
        writeln!(out, "    pub {}: {},", member.name, rust_type(member, &member.dims))?;
    }
    writeln!(out, "}}\n")?;
    if structure.constants.is_empty() {
        return Ok(());
    }
    writeln!(out, "impl {} {{", rust_name(&structure.name))?;
    for Constant { name, doc: lines, kind, text } in &structure.constants {
        doc(out, "    ", lines)?;
        let text = text.trim_start_matches('+');
        let real = matches!(kind, Primitive::Float | Primitive::Double);
        let point = if real && !text.contains(['.', 'e', 'E']) { ".0" } else { "" };
        writeln!(out, "    pub const {name}: {} = {text}{point};", primitive(*kind))?;
    }
    writeln!(out, "}}\n")
}

fn primitive(kind: Primitive) -> &'static str {
    match kind {
        Primitive::Int8 => "i8",
        Primitive::Int16 => "i16",
        Primitive::Int32 => "i32",
        Primitive::Int64 => "i64",
        Primitive::Byte => "u8",
        Primitive::Float => "f32",
        Primitive::Double => "f64",
        Primitive::String => "String",
        Primitive::Boolean => "bool",
    }
}

fn element(member: &Member) -> String {
    match &member.kind {
        Type::Primitive(kind) => primitive(*kind).to_owned(),
        Type::Struct(name) => rust_name(name.rsplit('.').next().unwrap_or(name)),
    }
}

fn rust_type(member: &Member, dims: &[Dim]) -> String {
    match dims {
        [] => element(member),
        [Dim::Fixed { count, .. }, rest @ ..] => format!("[{}; {count}]", rust_type(member, rest)),
        [Dim::Variable(_), rest @ ..] => format!("Vec<{}>", rust_type(member, rest)),
    }
}

/// True if the value has one shape whatever the message says, so that its type can read itself.
fn is_static(dims: &[Dim]) -> bool {
    dims.iter().all(|d| matches!(d, Dim::Fixed { .. }))
}

fn wire(out: &mut String, schema: &Schema, structure: &Struct) -> std::fmt::Result {
    let min_size = schema.min_size(structure);
    writeln!(out, "impl crate::wire::Wire for {} {{", rust_name(&structure.name))?;
    writeln!(out, "    const MIN_SIZE: usize = {min_size};\n")?;
    writeln!(
        out,
        "    fn write(&self, w: &mut crate::wire::Writer<'_>) -> Result<(), crate::Error> {{"
    )?;
    for member in &structure.members {
        let field = format!("&self.{}", member.name);
        writeln!(out, "        w.field = \"{}.{}\";", structure.full_name(), member.name)?;
        writeln!(out, "        {}", write_value(&field, &member.dims))?;
    }
    if structure.members.is_empty() {
        writeln!(out, "        let _ = w;")?;
    }
    writeln!(out, "        Ok(())\n    }}\n")?;
    writeln!(out, "    fn read(r: &mut crate::wire::Reader<'_>) -> Result<Self, crate::Error> {{")?;
    for member in &structure.members {
        writeln!(out, "        r.field = \"{}.{}\";", structure.full_name(), member.name)?;
        let value = read_value(member, &member.dims);
        let ty = rust_type(member, &member.dims);
        writeln!(out, "        let {}: {ty} = {value}?;", member.name)?;
    }
    if structure.members.is_empty() {
        writeln!(out, "        let _ = r;")?;
    }
    let names: Vec<_> = structure.members.iter().map(|m| m.name.as_str()).collect();
    writeln!(out, "        Ok(Self {{ {} }})\n    }}\n}}\n", names.join(", "))
}

fn write_value(value: &str, dims: &[Dim]) -> String {
    match dims {
        // A loop over the outer dimension, so that every inner length is checked.
        [Dim::Variable(length), rest @ ..] => format!(
            "let rows = {value}; w.count(i64::from(self.{length}), rows.len())?; \
             for row in rows {{ {} }}",
            write_value("row", rest)
        ),
        [Dim::Fixed { .. }, rest @ ..] if !is_static(rest) => {
            format!("for row in {value} {{ {} }}", write_value("row", rest))
        }
        _ => format!("crate::wire::Wire::write({value}, w)?;"),
    }
}

fn read_value(member: &Member, dims: &[Dim]) -> String {
    match dims {
        [Dim::Variable(length), rest @ ..] => format!(
            "r.rows(i64::from({length}), {}, |r| {})",
            row_size(member, rest),
            read_value(member, rest)
        ),
        [Dim::Fixed { .. }, rest @ ..] if !is_static(rest) => {
            format!("r.fixed_rows(|r| {})", read_value(member, rest))
        }
        _ => "crate::wire::Wire::read(r)".to_owned(),
    }
}

/// An expression for the fewest bytes one row takes on the wire.
fn row_size(member: &Member, dims: &[Dim]) -> String {
    let mut size = format!("<{} as crate::wire::Wire>::MIN_SIZE", element(member));
    for dim in dims {
        match dim {
            Dim::Fixed { count, .. } => size = format!("{size}.saturating_mul({count})"),
            Dim::Variable(length) => {
                size = format!("{size}.saturating_mul(usize::try_from({length}).unwrap_or(0))");
            }
        }
    }
    size
}

fn message(out: &mut String, structure: &Struct, fingerprint: u64) -> std::fmt::Result {
    let name = rust_name(&structure.name);
    writeln!(out, "impl crate::Message for {name} {{")?;
    writeln!(out, "    const NAME: &'static str = \"{}\";", structure.full_name())?;
    writeln!(out, "    const FINGERPRINT: u64 = {fingerprint:#018x};\n}}\n")?;
    let crc = |m: &Member| {
        m.name == "crc" && m.dims.is_empty() && m.kind == Type::Primitive(Primitive::Int32)
    };
    if structure.members.last().is_some_and(crc) {
        writeln!(out, "impl crate::Checked for {name} {{}}\n")?;
    }
    Ok(())
}

impl Schema {
    /// Fewest bytes a value of the type takes on the wire: variable arrays are empty. \[B\]
    #[must_use]
    pub fn min_size(&self, structure: &Struct) -> usize {
        self.min_size_below(structure, 0)
    }

    fn min_size_below(&self, structure: &Struct, depth: usize) -> usize {
        if depth > self.structs.len() {
            return 0; // a struct inside itself: nothing finite can be said
        }
        let member = |m: &Member| {
            let one = match &m.kind {
                Type::Primitive(kind) => kind.min_size(),
                Type::Struct(name) => {
                    self.get(name).map_or(0, |s| self.min_size_below(s, depth + 1))
                }
            };
            m.dims.iter().fold(one, |size, dim| match dim {
                Dim::Fixed { count, .. } => size.saturating_mul(*count),
                Dim::Variable(_) => 0,
            })
        };
        structure.members.iter().map(member).fold(0, usize::saturating_add)
    }
}
