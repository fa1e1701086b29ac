//! `lmpc fmu`.

use anyhow::{Result, bail};
use comfy_table::{Table, presets};
use fmu_core::{Inspection, Libraries, inspect, ship};
use serde_json::{Map, Value, json};

use super::Outcome;
use command_line::{FmuAction, FmuArgs, InspectArgs, PackArgs};
use terminal::{SOFT, Talk, paint, result};

/// Packs or inspects.
pub(super) fn run(args: &FmuArgs, talk: Talk) -> Result<Outcome> {
    match &args.action {
        FmuAction::Pack(args) => pack(args, talk),
        FmuAction::Inspect(args) => look(args),
    }
}

fn pack(args: &PackArgs, talk: Talk) -> Result<Outcome> {
    let libraries = Libraries::below(&args.libraries);
    if libraries.is_empty() {
        bail!(
            "{} has no folder of libraries; expected for example {}, which `tools/fmu.sh` builds",
            args.libraries.display(),
            args.libraries.join("x86_64-unknown-linux-gnu").display()
        );
    }
    for platform in &libraries {
        talk.say(&format!("{:?} from {}", platform.platform, platform.folder.display()));
    }
    for file in ship(&libraries, &args.out)? {
        result(&file.display().to_string())?;
    }
    Ok(Outcome::Done)
}

fn look(args: &InspectArgs) -> Result<Outcome> {
    let inside = inspect(&args.file)?;
    if args.json {
        terminal::json(&as_json(&inside))?;
        return Ok(Outcome::Done);
    }
    for (name, value) in &inside.attributes {
        result(&format!("{} {value}", paint(SOFT, &format!("{name}:"))))?;
    }
    result("")?;
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header([
        "variable",
        "type",
        "causality",
        "unit",
        "start",
        "min",
        "max",
        "description",
    ]);
    for v in &inside.variables {
        table.add_row([
            &v.name,
            &v.kind,
            &v.causality,
            &v.unit,
            &v.start,
            &v.min,
            &v.max,
            &v.description,
        ]);
    }
    for line in table.to_string().lines() {
        result(line.trim_end())?;
    }
    result("")?;
    for (name, size) in &inside.files {
        result(&format!("{size:>9} {name}"))?;
    }
    Ok(Outcome::Done)
}

fn as_json(inside: &Inspection) -> Value {
    let attributes: Map<String, Value> =
        inside.attributes.iter().map(|(name, value)| (name.clone(), json!(value))).collect();
    let file = |(name, size): &(String, u64)| json!({ "name": name, "bytes": size });
    let files: Vec<Value> = inside.files.iter().map(file).collect();
    json!({ "attributes": attributes, "variables": inside.variables, "files": files })
}
