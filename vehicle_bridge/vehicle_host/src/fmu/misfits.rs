//! What is wrong with an FMU and its map before the FMU is loaded: the same for `lmpc check` and for who
//! drives it.

use std::env::consts::{ARCH, DLL_SUFFIX, OS};
use std::path::Path;

use fmu_core::{Inspection, VariableRow};
use roxmltree::Document;

use super::element::{Element, find};
use super::error::FmuError;
use super::map::Map;
use super::slave::attribute;

/// What is done with a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Use {
    /// A number is read.
    Read,
    /// A number is set.
    Set,
    /// A truth value is set.
    Switch,
    /// A text is set.
    Write,
}

/// Every problem of a map with its FMU, by the map's key: no library for this platform, unknown variables,
/// wrong causalities, types and units.
///
/// # Errors
/// [`FmuError`] if the FMU cannot be looked into.
pub fn misfits(map: &Map, file: &Path) -> Result<Vec<(String, String)>, FmuError> {
    Ok(all(map, &fmu_core::inspect(file)?, file))
}

/// [`misfits`] of an FMU that was looked into.
pub(super) fn all(map: &Map, inspection: &Inspection, file: &Path) -> Vec<(String, String)> {
    let mut found = Vec::new();
    if let Err(what) = library(inspection) {
        found.push(("fmu".to_owned(), format!("{}: {what}", file.display())));
    }
    for (key, entry, dimension) in map.entries() {
        let name = entry.variable();
        let (row, element) = match find(inspection, name) {
            Ok(known) => known,
            Err(what) => {
                found.push((key, format!("variable `{name}` of {}: {what}", file.display())));
                continue;
            }
        };
        let (expected, used) = match key.split('.').next() {
            Some("input") => ("input", Use::Set),
            Some("initial") => ("parameter", Use::Set),
            _ => ("output", Use::Read),
        };
        if row.causality != expected && (expected != "output" || row.causality == "input") {
            found.push((
                key.clone(),
                format!("`{name}` is of causality {}, expected {expected}", row.causality),
            ));
        }
        found.extend(mistyped(inspection, row, element, used).map(|what| (key.clone(), what)));
        if let Err(what) = entry.factor(&row.unit, dimension) {
            found.push((key, format!("`{name}`: {what}")));
        }
    }
    for (name, value) in &map.parameters {
        let what = match find(inspection, name) {
            Err(what) => Some(format!("variable `{name}` of {}: {what}", file.display())),
            Ok((row, element)) => match used(value) {
                Some(used) => mistyped(inspection, row, element, used),
                None => Some(format!(
                    "found {}, expected a number, truth value or text",
                    value.type_str()
                )),
            },
        };
        found.extend(what.map(|what| (format!("parameters.{name}"), what)));
    }
    found
}

/// What a value of the map's parameters sets; none if nothing can be set to it.
fn used(value: &toml::Value) -> Option<Use> {
    match value {
        toml::Value::Float(_) | toml::Value::Integer(_) => Some(Use::Set),
        toml::Value::Boolean(_) => Some(Use::Switch),
        toml::Value::String(text) if text == "{seed}" => Some(Use::Set),
        toml::Value::String(_) => Some(Use::Write),
        _ => None,
    }
}

/// What is wrong with a variable's type, if anything.
fn mistyped(
    inspection: &Inspection,
    row: &VariableRow,
    element: Option<Element>,
    used: Use,
) -> Option<String> {
    if row.value_reference.parse::<u32>().is_err() {
        return Some(format!(
            "`{}` has the value reference `{}`, expected a number",
            row.name, row.value_reference
        ));
    }
    let three = attribute(inspection, "fmiVersion").starts_with('3');
    let allowed: &[&str] = match (used, three) {
        (Use::Read | Use::Set, true) if element.is_some() => &["Float64", "Float32"],
        (Use::Set, true) => &["Float64", "Float32", "Int32", "Int64", "Enumeration"],
        (Use::Read, true) => &["Float64", "Float32", "Int32", "Int64"],
        (Use::Read | Use::Set, false) => &["Real", "Integer", "Enumeration"],
        (Use::Switch, _) => &["Boolean"],
        (Use::Write, _) => &["String"],
    };
    let fits = allowed.contains(&row.kind.as_str());
    (!fits).then(|| {
        format!("`{}` is of type {}, expected {}", row.name, row.kind, allowed.join(" or "))
    })
}

/// Whether an FMU is of a known version and has a library for co-simulation on this platform.
///
/// # Errors
/// In words, if not.
pub(super) fn library(inspection: &Inspection) -> Result<(), String> {
    let version = attribute(inspection, "fmiVersion");
    let folder = match (version.chars().next(), OS, ARCH) {
        (Some('2'), "linux", "x86_64" | "aarch64") => Some("linux64"),
        (Some('2'), "windows", "x86_64") => Some("win64"),
        (Some('2'), "macos", "x86_64") => Some("darwin64"),
        (Some('3'), ..) => fmi::fmi3::platform_folder(OS, ARCH).ok(),
        (Some('2'), ..) => None,
        _ => return Err(format!("FMI version `{version}`, expected 2.0 or 3.0")),
    };
    let folder = folder
        .ok_or_else(|| format!("FMI {version} has no folder for libraries of {OS} on {ARCH}"))?;
    let document = Document::parse(&inspection.model_description).map_err(|e| e.to_string())?;
    let mut parts = document.root_element().children();
    let simulation = parts
        .find(|node| node.has_tag_name("CoSimulation"))
        .ok_or("it offers no co-simulation (model exchange alone cannot be driven)")?;
    let identifier = simulation.attribute("modelIdentifier").unwrap_or_default();
    let wanted = format!("binaries/{folder}/{identifier}{DLL_SUFFIX}");
    if inspection.files.iter().any(|(name, _)| *name == wanted) {
        return Ok(());
    }
    let is_library = |name: &&str| name.starts_with("binaries/") && !name.ends_with('/');
    let names = inspection.files.iter().map(|(name, _)| name.as_str());
    let found: Vec<&str> = names.filter(is_library).collect();
    let found = if found.is_empty() { "none".to_owned() } else { found.join(", ") };
    Err(format!(
        "no library for this platform: expected {wanted}, found {found}; export the FMU for {OS} on \
         {ARCH}"
    ))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]

    use std::fs::File;
    use std::io::Write as _;
    use std::path::PathBuf;
    use std::sync::Arc;

    use vehicle_model::{CarParams, State, Track};
    use zip::ZipWriter;
    use zip::write::SimpleFileOptions;

    use super::*;
    use crate::fmu::{FmuOptions, FmuVehicle};

    const MAP: &str = "frame = \"track\"
[input]
a = \"a\"
delta = \"delta\"
[state]
v_x = \"v_x\"
v_y = \"v_y\"
omega_z = \"omega_z\"
e_psi = \"e_psi\"
s = \"s\"
e_y = \"e_y\"
[parameters]
mode = 2
name = \"{car}\"
seed = \"{seed}\"
";

    /// An FMU whose variables have these types, with a library at a place.
    fn fmu(folder: &Path, version: u32, kinds: &[(&str, &str)], library: &str) -> PathBuf {
        let path = folder.join("car.fmu");
        let mut zip = ZipWriter::new(File::create(&path).unwrap());
        let real = if version == 2 { "Real" } else { "Float64" };
        let names = ["a", "delta", "v_x", "v_y", "omega_z", "e_psi", "s", "e_y"];
        let names = names.iter().chain(&["mode", "name", "seed"]).enumerate();
        let variables: String = names
            .map(|(i, name)| {
                let causality = match i {
                    0 | 1 => "input",
                    2..8 => "output",
                    _ => "parameter",
                };
                let kind = kinds.iter().find(|(n, _)| n == name).map_or(real, |(_, kind)| kind);
                let head =
                    format!("name=\"{name}\" valueReference=\"{i}\" causality=\"{causality}\"");
                match version {
                    2 => format!("<ScalarVariable {head}><{kind}/></ScalarVariable>"),
                    _ => format!("<{kind} {head}/>"),
                }
            })
            .collect();
        let text = format!(
            "<fmiModelDescription fmiVersion=\"{version}.0\"><CoSimulation modelIdentifier=\"car\"/>\
             <ModelVariables>{variables}</ModelVariables></fmiModelDescription>"
        );
        for (name, bytes) in [("modelDescription.xml", text.as_str()), (library, "none")] {
            zip.start_file(name, SimpleFileOptions::default()).unwrap();
            zip.write_all(bytes.as_bytes()).unwrap();
        }
        zip.finish().unwrap();
        path
    }

    fn refused(file: &Path) -> String {
        let options = FmuOptions {
            file: file.to_owned(),
            map: Some(Map::from_toml(MAP).unwrap()),
            preload: None,
            car: CarParams::builtin("barc").unwrap(),
            car_name: "barc".to_owned(),
            track: Arc::new(Track::builtin("l").unwrap()),
            track_name: "l".to_owned(),
            seed: 0,
            start: State::default(),
        };
        FmuVehicle::new(options).map(drop).unwrap_err().to_string()
    }

    fn here(version: u32) -> String {
        let three = fmi::fmi3::platform_folder(OS, ARCH).unwrap();
        let folder = if version == 2 { "linux64" } else { three };
        format!("binaries/{folder}/car{DLL_SUFFIX}")
    }

    #[test]
    fn check_and_race_refuse_the_same_for_the_same_reasons() {
        let folder = tempfile::tempdir().unwrap();
        let map = Map::from_toml(MAP).unwrap();
        for version in [2, 3] {
            let wrong = [("delta", "Boolean"), ("e_y", "String"), ("name", "String")];
            let file = fmu(folder.path(), version, &wrong, "binaries/win64/car.dll");
            let found = misfits(&map, &file).unwrap();
            let keys: Vec<&str> = found.iter().map(|(key, _)| key.as_str()).collect();
            assert_eq!(keys, ["fmu", "input.delta", "state.e_y"], "{found:?}");
            let said = refused(&file);
            for (_, what) in &found {
                assert!(said.contains(what), "check: {what}; race: {said}");
            }
            assert!(said.contains("found binaries/win64/car.dll"), "{said}");
            assert!(said.contains("`delta` is of type Boolean, expected "), "{said}");

            let wrong = [("mode", "Boolean"), ("name", "Boolean"), ("seed", "String")];
            let file = fmu(folder.path(), version, &wrong, &here(version));
            let keys: Vec<String> =
                misfits(&map, &file).unwrap().into_iter().map(|(key, _)| key).collect();
            assert_eq!(keys, ["parameters.mode", "parameters.name", "parameters.seed"]);
            assert!(refused(&file).contains("`seed` is of type String"));
        }
    }

    #[test]
    fn what_fits_gets_as_far_as_the_library() {
        let folder = tempfile::tempdir().unwrap();
        let map = Map::from_toml(MAP).unwrap();
        for version in [2, 3] {
            let file = fmu(folder.path(), version, &[("name", "String")], &here(version));
            assert_eq!(misfits(&map, &file).unwrap(), vec![]);
            let said = refused(&file);
            assert!(!said.starts_with("map:"), "{said}");
        }
    }
}
