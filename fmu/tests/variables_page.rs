//! `docs/reference/fmu_variables.md` is what the model descriptions hold. `LMPC_WRITE_DOCS=1 cargo test
//! -p fmu_core --test variables_page` writes it anew.
#![allow(clippy::unwrap_used, reason = "code of tests")]

use std::fmt::Write as _;
use std::path::Path;

use fmu_core::{ControllerFmu, FmuModel, Role, VariableType, VehicleFmu};

const TOP: &str = "# FMU variables

Generated from the model descriptions. `parameter` is set before initialisation, `tunable` before any
step, `input` before each step; the FMU computes `output`. Units are those of the description; `1` is
a number without unit.
";

fn role(role: Role) -> &'static str {
    match role {
        Role::Time => "time",
        Role::Fixed => "parameter",
        Role::Tunable => "tunable",
        Role::Input => "input",
        Role::Discrete | Role::Output => "output",
    }
}

fn kind(kind: VariableType) -> &'static str {
    match kind {
        VariableType::Real => "real",
        VariableType::Integer => "integer",
        VariableType::Boolean => "boolean",
        VariableType::Text => "text",
    }
}

fn section<M: FmuModel>() -> String {
    let description = M::description();
    let mut text = format!("\n## {}\n\n{}\n", description.model_name, description.description);
    text.push_str(
        "\n| variable | role | type | unit | range | meaning |\n|---|---|---|---|---|---|\n",
    );
    for v in description.table.variables() {
        let unit = v.unit.map_or("", |unit| unit.name);
        let range = match (v.min, v.max) {
            (Some(min), Some(max)) => format!("{min} to {max}"),
            _ => String::new(),
        };
        let meaning = v.description.replace('|', "\\|");
        let (role, kind) = (role(v.role), kind(v.kind));
        writeln!(text, "| `{}` | {role} | {kind} | {unit} | {range} | {meaning} |", v.name)
            .unwrap();
    }
    text
}

#[test]
fn the_page_is_up_to_date() {
    let expected = format!("{TOP}{}{}", section::<ControllerFmu>(), section::<VehicleFmu>());
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/reference/fmu_variables.md");
    if std::env::var_os("LMPC_WRITE_DOCS").is_some() {
        std::fs::write(&path, &expected).unwrap();
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(found == expected, "the page is old: LMPC_WRITE_DOCS=1 writes it anew");
}
