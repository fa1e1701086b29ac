//! `docs/reference/configuration.md` is what `controller/src/config.rs` says. `LMPC_WRITE_DOCS=1 cargo
//! test -p controller --test configuration_page` writes it anew.
#![allow(clippy::unwrap_used, clippy::panic, reason = "code of tests")]

use std::fmt::Write as _;
use std::path::Path;

use controller::{Config, Preset};
use vehicle_model::{CarParams, Track};

const TOP: &str = "# Configuration

Generated from `controller/src/config.rs`. A file given with `--config` holds these keys in sections,
`--set section.key=value` sets one of them. Unknown keys and values out of range are refused; `lmpc
check FILE` names all of them. Without a value a key has that of the preset; with the preset `race`,
keys that have a unit follow from the car and the track ([Settings](../driving.md)), here for `barc` on
the track `l`.

`preset`: `race` (default) or `paper`.
";

/// Fields of a struct in the source: doc, name in TOML.
fn fields(source: &str, name: &str) -> Vec<(String, String)> {
    let start = source.find(&format!("pub struct {name} {{")).unwrap_or_else(|| panic!("{name}"));
    let body = source[start..].split_once("{\n").unwrap().1.split_once("\n}").unwrap().0;
    let (mut found, mut doc, mut renamed) = (Vec::new(), Vec::new(), None);
    for line in body.lines().map(str::trim) {
        if let Some(text) = line.strip_prefix("///") {
            doc.push(text.trim().to_owned());
        } else if let Some(rename) = line.strip_prefix("#[serde(rename = \"") {
            renamed = rename.split('"').next().map(str::to_owned);
        } else if let Some(field) = line.strip_prefix("pub ") {
            let name = field.split(':').next().unwrap().to_owned();
            found.push((doc.join(" "), renamed.take().unwrap_or(name)));
            doc.clear();
        }
    }
    found
}

/// The type of each section of `Config`.
fn sections(source: &str) -> Vec<(String, String)> {
    let body = source.split("pub struct Config {\n").nth(1).unwrap().split_once("\n}").unwrap().0;
    let fields = body.lines().filter_map(|line| line.trim().strip_prefix("pub "));
    let pairs = fields.filter_map(|field| field.trim_end_matches(',').split_once(": "));
    pairs.map(|(name, kind)| (name.to_owned(), kind.to_owned())).collect()
}

fn value(table: &toml::Table, section: &str, key: &str) -> String {
    let round = |value: &toml::Value| match value {
        toml::Value::Float(number) => {
            format!("{:.4}", number).trim_end_matches('0').trim_end_matches('.').to_owned()
        }
        other => other.to_string(),
    };
    match &table[section][key] {
        toml::Value::Array(values) => {
            format!("[{}]", values.iter().map(round).collect::<Vec<_>>().join(", "))
        }
        value => round(value),
    }
}

#[test]
fn the_page_is_up_to_date() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let source = std::fs::read_to_string(folder.join("src/config.rs")).unwrap()
        + &std::fs::read_to_string(folder.join("src/config/unforeseen.rs")).unwrap();
    let (car, track) = (CarParams::builtin("barc").unwrap(), Track::builtin("l").unwrap());
    let race = toml::Table::try_from(Config::derived(Preset::Race, &car, &track)).unwrap();
    let paper = toml::Table::try_from(Config::preset(Preset::Paper)).unwrap();
    let mut text = TOP.to_owned();
    let mut count = 0;
    for (section, kind) in sections(&source) {
        if !race[&section].is_table() {
            continue;
        }
        write!(text, "\n## `[{section}]`\n\n| key | race | paper | meaning |\n|---|---|---|---|\n")
            .unwrap();
        let fields = fields(&source, &kind);
        assert_eq!(fields.len(), race[&section].as_table().unwrap().len(), "{section}");
        for (doc, key) in fields {
            count += 1;
            let doc = doc.replace('|', "\\|");
            let (race, paper) = (value(&race, &section, &key), value(&paper, &section, &key));
            writeln!(text, "| `{key}` | {race} | {paper} | {doc} |").unwrap();
        }
    }
    assert!(count > 40, "{count} keys");
    let path = folder.join("../docs/reference/configuration.md");
    if std::env::var_os("LMPC_WRITE_DOCS").is_some() {
        std::fs::write(&path, &text).unwrap();
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(found == text, "the page is old: LMPC_WRITE_DOCS=1 writes it anew");
}
