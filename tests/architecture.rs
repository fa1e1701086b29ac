//! What ARCHITECTURE.md promises of the source tree.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Every file below a folder that ends in `.rs`.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn paths_named_in_the_architecture_exist() {
    let text = read(&root().join("ARCHITECTURE.md"));
    // Between the fences stands a drawing: its paths are bare words.
    let (mut drawing, mut words) = (false, Vec::new());
    for line in text.lines() {
        if line.starts_with("```") {
            drawing = !drawing;
        } else if drawing {
            words.extend(line.split_whitespace().filter(|word| word.ends_with(".rs")));
        } else {
            words.extend(line.split('`').skip(1).step_by(2));
        }
    }
    let paths: Vec<_> = words.into_iter().filter(|word| word.contains('/')).collect();
    assert!(paths.len() >= 10, "{paths:?}");
    for path in paths {
        let (folder, suffix) = path.split_once("/*").unwrap_or((path, ""));
        let place = root().join(folder);
        assert!(place.exists(), "ARCHITECTURE.md names `{path}`, which does not exist");
        if !suffix.is_empty() {
            let mut names = fs::read_dir(place).unwrap().map(|e| e.unwrap().file_name());
            assert!(names.any(|n| n.to_string_lossy().ends_with(suffix)), "`{path}`: none");
        }
    }
}

#[test]
fn every_crate_is_on_the_map() {
    let text = read(&root().join("ARCHITECTURE.md"));
    let workspace: toml::Table = read(&root().join("Cargo.toml")).parse().unwrap();
    let members = workspace["workspace"]["members"].as_array().unwrap();
    for member in members {
        let path = format!("`{}/`", member.as_str().unwrap());
        assert!(text.contains(&path), "ARCHITECTURE.md does not name {path}");
    }
}

/// Names of all packages that `package` depends on, directly or not, as the lock file has them.
fn dependencies(package: &str) -> Vec<String> {
    let lock: toml::Table = read(&root().join("Cargo.lock")).parse().unwrap();
    let packages = lock["package"].as_array().unwrap();
    let mut all = vec![package.to_owned()];
    let mut next = 0;
    while next < all.len() {
        let of = packages.iter().filter(|p| p["name"].as_str() == Some(all[next].as_str()));
        let direct: Vec<String> = of
            .filter_map(|p| p.get("dependencies")?.as_array())
            .flatten()
            .filter_map(|d| d.as_str()?.split(' ').next().map(str::to_owned))
            .collect();
        for name in direct {
            if !all.contains(&name) {
                all.push(name);
            }
        }
        next += 1;
    }
    all
}

/// A library must not take the saved state of another build.
#[test]
fn the_token_of_the_fmus_is_made_of_all_crates_behind_them() {
    let workspace: toml::Table = read(&root().join("Cargo.toml")).parse().unwrap();
    let paths = workspace["workspace"]["dependencies"].as_table().unwrap();
    let build = read(&root().join("fmu/build.rs"));
    let mut behind = 0;
    for name in dependencies("fmu_core").iter().skip(1) {
        let Some(path) = paths.get(name).and_then(|d| d.get("path")?.as_str()) else { continue };
        assert!(build.contains(&format!("\"../{path}/src\"")), "fmu/build.rs lacks {path}");
        behind += 1;
    }
    assert!(behind >= 9, "{behind} crates behind the FMUs");
}

#[test]
fn no_source_file_has_more_than_400_lines() {
    let mut files = Vec::new();
    for folder in
        ["controller", "fmu", "lcm_types", "python", "tests", "vehicle_bridge", "vehicle_model"]
    {
        sources(&root().join(folder), &mut files);
    }
    assert!(files.len() > 400, "{} files", files.len());
    for file in files {
        let lines = read(&file).lines().count();
        assert!(lines <= 400, "{}: {lines} lines", file.display());
    }
}

/// Every crate with all it may depend on directly, sorted. Who adds one here says why in the commit.
const DEPENDENCIES: &[(&str, &str)] = &[
    (
        "controller",
        "actuators crc32fast fhocp libm nalgebra neighbors postcard pulp rand rand_pcg serde thiserror toml vector_sums vehicle_model",
    ),
    ("controller/actuators", "libm nalgebra serde vehicle_model"),
    ("controller/fhocp", "clarabel nalgebra pulp serde vector_sums vehicle_model"),
    ("controller/neighbors", ""),
    ("controller/vector_sums", ""),
    (
        "fmu",
        "atomic_file bounded_file controller postcard roxmltree serde thiserror vehicle_model zip",
    ),
    ("fmu/capi", "controller crc32fast fmu_core postcard vehicle_model"),
    ("fmu/controller", "fmu_core"),
    ("fmu/vehicle", "fmu_core"),
    ("lcm_types", "crc32fast thiserror"),
    (
        "python",
        "anyhow bounded_file controller hosting numpy optimum pyo3 racing studies vehicle_model",
    ),
    (
        "vehicle_bridge",
        "anstream anyhow auth bounded_file clap clap_complete clap_mangen comfy-table command_line controller doctor driven_laps file_check fmu_core foxglove hil_bench hosting lcm_types live_view log_export network_watch nix optimum optimum_store protocol racing report safety serde serde_json services signal-hook step_timing studies terminal terminal_size toml transport vehicle_host vehicle_model",
    ),
    ("vehicle_bridge/atomic_file", ""),
    ("vehicle_bridge/bounded_file", "thiserror"),
    ("vehicle_bridge/auth", "anyhow hmac hosting lcm_types nix sha2 thiserror transport"),
    (
        "vehicle_bridge/command_line",
        "anstream clap clap_complete controller driven_laps hil_bench hosting lcm_types services studies transport vehicle_model",
    ),
    ("vehicle_bridge/doctor", "file_check fmu_core hosting nix serde transport"),
    ("vehicle_bridge/driven_laps", "anyhow bounded_file controller csv lcm_types vehicle_model"),
    (
        "vehicle_bridge/file_check",
        "bounded_file controller hil_bench mapping serde services toml vehicle_host vehicle_model",
    ),
    (
        "vehicle_bridge/hil_bench",
        "anyhow auth controller hosting lcm_types nix protocol rand rand_distr rand_pcg safety serde serde_json sha2 socket2 svg_page time transport vehicle_host vehicle_model",
    ),
    (
        "vehicle_bridge/hosting",
        "anyhow atomic_file bounded_file controller nalgebra nix serde serde_json signal-hook thiserror thread-priority toml vehicle_model",
    ),
    (
        "vehicle_bridge/live_view",
        "anyhow httparse lcm_types log_export network_watch optimum_store racing serde serde_json vehicle_model",
    ),
    ("vehicle_bridge/log_export", "anyhow csv lcm_types mcap serde serde_json"),
    ("vehicle_bridge/mapping", "lcm_types serde toml vehicle_model"),
    ("vehicle_bridge/network_watch", "lcm_types safety serde"),
    ("vehicle_bridge/optimum", "clarabel nalgebra thiserror vehicle_model"),
    ("vehicle_bridge/optimum_store", "anyhow bounded_file optimum serde toml vehicle_model"),
    (
        "vehicle_bridge/protocol",
        "anyhow controller hosting lcm_types nix serde_json transport vehicle_model",
    ),
    ("vehicle_bridge/racing", "controller hosting thiserror vehicle_host vehicle_model"),
    (
        "vehicle_bridge/report",
        "controller hosting optimum optimum_store racing svg_page toml vehicle_model",
    ),
    ("vehicle_bridge/safety", "lcm_types thiserror vehicle_model"),
    (
        "vehicle_bridge/services",
        "anyhow auth bounded_file controller hosting lcm_types mapping nix protocol safety sd-notify toml transport vehicle_host vehicle_model",
    ),
    ("vehicle_bridge/step_timing", "controller hosting nix serde thiserror vehicle_model"),
    (
        "vehicle_bridge/studies",
        "anyhow atomic_file bounded_file comfy-table controller csv hosting libm racing rand rand_pcg serde svg_page toml vehicle_model",
    ),
    ("vehicle_bridge/svg_page", ""),
    (
        "vehicle_bridge/terminal",
        "anstream anstyle indicatif lcm_types network_watch racing serde serde_json",
    ),
    ("vehicle_bridge/transport", "anyhow lcm lcm_types libloading nix socket2 thiserror"),
    (
        "vehicle_bridge/vehicle_host",
        "actuators fmi fmu_core libloading log roxmltree serde tempfile thiserror toml vehicle_model zip",
    ),
    ("vehicle_model", "libm nalgebra pulp rand rand_pcg serde strsim thiserror toml track"),
    ("vehicle_model/track", "libm nalgebra rand rand_pcg serde serde_json thiserror toml"),
];

/// Crates without files, environment, clock, threads, network.
const PURE: [&str; 11] = [
    "controller",
    "controller/actuators",
    "controller/fhocp",
    "controller/neighbors",
    "controller/vector_sums",
    "vehicle_model",
    "vehicle_model/track",
    "vehicle_bridge/mapping",
    "vehicle_bridge/optimum",
    "vehicle_bridge/safety",
    "vehicle_bridge/svg_page",
];

#[test]
fn every_crate_depends_on_what_its_list_allows() {
    let workspace: toml::Table = read(&root().join("Cargo.toml")).parse().unwrap();
    for member in workspace["workspace"]["members"].as_array().unwrap() {
        let member = member.as_str().unwrap();
        if member.starts_with("tests") {
            continue;
        }
        let manifest: toml::Table = read(&root().join(member).join("Cargo.toml")).parse().unwrap();
        let found: Vec<&str> = manifest
            .get("dependencies")
            .and_then(|d| d.as_table())
            .map(|d| d.keys().map(String::as_str).collect())
            .unwrap_or_default();
        let Some((_, allowed)) = DEPENDENCIES.iter().find(|(name, _)| *name == member) else {
            panic!("{member} is not in DEPENDENCIES");
        };
        assert_eq!(found.join(" "), *allowed, "direct dependencies of {member}");
    }
}

#[test]
fn the_core_depends_on_nothing_of_networks_or_fmi() {
    for package in ["controller", "vehicle_model"] {
        let manifest: toml::Table = read(&root().join(package).join("Cargo.toml")).parse().unwrap();
        assert!(manifest.contains_key("dependencies"));
        let all = dependencies(package);
        assert!(all.iter().any(|name| name == "nalgebra"), "{all:?}");
        for name in &all {
            let name = name.to_lowercase();
            for foreign in ["lcm", "fmi", "fmu", "vehicle_bridge", "socket", "tokio"] {
                assert!(!name.contains(foreign), "{package} depends on {name}");
            }
        }
    }
}

#[test]
fn the_safety_core_stands_on_the_vehicle_model_and_the_messages_alone() {
    let all = dependencies("safety");
    assert!(all.iter().any(|name| name == "lcm_types"), "{all:?}");
    for foreign in ["controller", "transport", "protocol", "hosting", "nix", "socket2", "anyhow"] {
        assert!(!all.iter().any(|name| name == foreign), "the safety core depends on {foreign}");
    }
}

#[test]
fn pure_crates_have_no_files_environment_clock_or_threads() {
    for package in PURE {
        let mut files = Vec::new();
        sources(&root().join(package).join("src"), &mut files);
        assert!(!files.is_empty(), "{package}");
        for file in files {
            let text = read(&file);
            for module in ["fs", "env", "time", "thread", "net", "process", "io"] {
                let name = format!("std::{module}");
                let used = text.match_indices(&name).any(|(at, _)| {
                    let next = text[at + name.len()..].chars().next();
                    !next.is_some_and(|c| c.is_alphanumeric() || c == '_')
                });
                assert!(!used, "{} names {name}", file.display());
            }
            assert!(!text.contains("std::{"), "{}: one import a line", file.display());
            assert!(!text.contains("unsafe {"), "{} has an unsafe block", file.display());
        }
    }
}
