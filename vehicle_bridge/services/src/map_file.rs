//! A map file from the disk, with the `.lcm` files beside it.

use std::fs;
use std::path::Path;

use anyhow::{Context as _, Result, bail};
use bounded_file::Limit;
use lcm_types::schema::Schema;

use mapping::{MapFile, MapProblem, Mapping};

/// Reads a map file and resolves it.
///
/// # Errors
/// Everything that is wrong, in words.
pub fn load(path: &Path) -> Result<Mapping> {
    let shown = path.display();
    let text = bounded_file::text(path, Limit::SETTINGS)?;
    let file: MapFile = toml::from_str(&text).with_context(|| shown.to_string())?;
    match resolve(path, &file, &text) {
        Ok(mapping) => Ok(mapping),
        Err(problems) => {
            let lines: Vec<String> = problems.iter().map(|p| format!("{shown}: {p}")).collect();
            bail!("{}", lines.join("\n"))
        }
    }
}

/// Resolves a map file that was parsed, with the `.lcm` files it names.
///
/// # Errors
/// Everything that is wrong.
pub fn resolve(path: &Path, file: &MapFile, text: &str) -> Result<Mapping, Vec<MapProblem>> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let mut sources = Vec::new();
    let mut problems = Vec::new();
    for name in &file.types {
        match fs::File::open(folder.join(name.get_ref())).and_then(Schema::read_text) {
            Ok(source) => sources.push((name.get_ref().as_str(), source)),
            Err(error) => {
                let line = text.get(..name.span().start).map(|t| t.matches('\n').count() + 1);
                let message = format!("types: cannot read `{}`: {error}", name.get_ref());
                problems.push(MapProblem { line, message });
            }
        }
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    let borrowed: Vec<(&str, &str)> = sources.iter().map(|(n, t)| (*n, t.as_str())).collect();
    let schema = Schema::parse(&borrowed)
        .map_err(|error| vec![MapProblem { line: None, message: error.to_string() }])?;
    Mapping::new(file, text, schema)
}
