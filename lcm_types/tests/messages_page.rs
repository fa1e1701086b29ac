//! `docs/messages.md` is what the `.lcm` files say. `LMPC_WRITE_DOCS=1 cargo test -p lcm_types --test
//! messages_page` writes it anew.
#![allow(clippy::unwrap_used, reason = "code of tests")]

use std::fmt::Write as _;
use std::path::Path;

use lcm_types::schema::{Dim, Member, Schema, Struct, Type};

const TOP: &str = "# Messages on the network

Generated from `lcm_types/lcm/*.lcm`. SI units and radians, in brackets; ISO 8855: x forward, y left,
yaw, steering, curvature and `e_y` positive to the left. World frame: x east, y north. `s`, `e_y`,
`e_psi` are in the frame of the track's centre line.
";

/// `double[4]`, `pred_point_t[n_pred]`.
fn kind(member: &Member) -> String {
    let mut text = match &member.kind {
        Type::Primitive(primitive) => primitive.name().to_owned(),
        Type::Struct(name) => name.rsplit('.').next().unwrap().to_owned(),
    };
    for dim in &member.dims {
        match dim {
            Dim::Fixed { text: count, .. } => write!(text, "[{count}]").unwrap(),
            Dim::Variable(length) => write!(text, "[{length}]").unwrap(),
        }
    }
    text
}

fn section(schema: &Schema, message: &Struct) -> String {
    let name = message.full_name();
    let fingerprint = schema.fingerprint(&name).unwrap();
    let doc = message.doc.join(" ");
    let mut text = format!("\n## {name}\n\n{doc}\n\nFingerprint `{fingerprint:016x}`.\n");
    if !message.constants.is_empty() {
        let words = message.constants.iter().map(|c| format!("`{} = {}`", c.name, c.text));
        let words: Vec<String> = words.collect();
        writeln!(text, " Constants: {}.", words.join(", ")).unwrap();
    }
    text.push_str("\n| field | type | meaning |\n|---|---|---|\n");
    for member in &message.members {
        let doc = member.doc.join(" ").replace('|', "\\|");
        writeln!(text, "| `{}` | `{}` | {doc} |", member.name, kind(member)).unwrap();
    }
    text
}

#[test]
fn the_page_is_up_to_date() {
    let schema = Schema::parse(lcm_types::SOURCES).unwrap();
    let sections = schema.structs.iter().map(|message| section(&schema, message));
    let expected: String = std::iter::once(TOP.to_owned()).chain(sections).collect();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/messages.md");
    if std::env::var_os("LMPC_WRITE_DOCS").is_some() {
        std::fs::write(&path, &expected).unwrap();
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(found == expected, "docs/messages.md is old: LMPC_WRITE_DOCS=1 writes it anew");
    // Every number says what it is, and every field has a meaning.
    for message in &schema.structs {
        for member in &message.members {
            assert!(!member.doc.is_empty(), "{}.{}", message.full_name(), member.name);
        }
    }
}
