//! Generates the message types from the `.lcm` files, in Rust alone: no tool is needed.

#![allow(clippy::print_stdout, reason = "how a build script talks to cargo")]

use std::error::Error;
use std::path::{Path, PathBuf};
use std::{env, fs};

#[path = "src/schema/mod.rs"]
#[allow(dead_code, unreachable_pub, reason = "the library uses what the build does not")]
mod schema;

fn main() -> Result<(), Box<dyn Error>> {
    let root = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?);
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=src/schema");
    // The product's messages, and a type with every feature of the language for the tests.
    for (folder, output, house_rules) in [("lcm", "messages", true), ("tests/lcm", "sample", false)]
    {
        println!("cargo::rerun-if-changed={folder}");
        generate(&root.join(folder), output, house_rules)?;
    }
    Ok(())
}

fn generate(folder: &Path, output: &str, house_rules: bool) -> Result<(), Box<dyn Error>> {
    let mut paths: Vec<PathBuf> =
        fs::read_dir(folder)?.map(|entry| entry.map(|e| e.path())).collect::<Result<_, _>>()?;
    paths.retain(|path| path.extension().is_some_and(|e| e == "lcm"));
    paths.sort();
    let mut files = Vec::new();
    for path in &paths {
        files.push((path.to_string_lossy().into_owned(), fs::read_to_string(path)?));
    }
    let borrowed: Vec<(&str, &str)> = files.iter().map(|(n, t)| (n.as_str(), t.as_str())).collect();
    let schema = schema::Schema::parse(&borrowed)?;
    let problems = if house_rules { schema.lint() } else { Vec::new() };
    if !problems.is_empty() {
        let lines: Vec<String> = problems.iter().map(ToString::to_string).collect();
        return Err(lines.join("\n").into());
    }
    let mut code = schema::generate::rust(&schema)?;
    code.push_str("/// The `.lcm` files the types come from: name and text.\n");
    code.push_str("pub const SOURCES: &[(&str, &str)] = &[\n");
    for path in &paths {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        code.push_str(&format!("    ({name:?}, include_str!({path:?})),\n"));
    }
    code.push_str("];\n");
    fs::write(Path::new(&env::var("OUT_DIR")?).join(format!("{output}.rs")), code)?;
    Ok(())
}
