//! The table of keys: `docs/reference/configuration.md` is generated from it, and what it says of the
//! values of a preset holds. `LMPC_WRITE_DOCS=1 cargo test --release -p controller --test
//! configuration_page` writes the page anew.
#![allow(clippy::unwrap_used, clippy::panic, reason = "code of tests")]

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use controller::config::SECTIONS;
use controller::config::keys::{ConfigKey, Derivation, ValueKind};
use controller::{Config, Preset};
use vehicle_model::{CarParams, Track};

const TOP: &str = "# Configuration

Generated from the table of keys in `controller/src/config/`. A file given with `--config` holds these
keys in sections, `--set section.key=value` sets one of them. Unknown keys and values out of range are
refused; `lmpc check FILE` names all of them. Without a value a key has that of the preset; with the
preset `race` many keys follow from the car and the track ([Settings](../driving.md)), here for `barc` on
the track `l`. `lmpc config --car FILE --track FILE` prints the values for your own, each with its
origin; `lmpc config --schema` prints a JSON schema for editors.

";

fn row(key: &ConfigKey, race: &Config, paper: &Config) -> String {
    let range = key.range.map_or(String::new(), |[least, most]| format!("{least} to {most}"));
    let range = match key.kind {
        ValueKind::Choice(words) => {
            words.iter().map(|w| format!("`{}`", w.word)).collect::<Vec<_>>().join(", ")
        }
        _ => range,
    };
    let mut meaning = key.meaning().to_owned();
    match key.derivation {
        Derivation::Preset => {}
        Derivation::Car(rule) => write!(meaning, " From the car: {rule}.").unwrap(),
        Derivation::CarAndTrack(rule) => {
            write!(meaning, " From car and track: {rule}.").unwrap();
        }
    }
    if let ValueKind::Choice(words) = key.kind {
        for word in words {
            write!(meaning, " `{}`: {}", word.word, word.meaning()).unwrap();
        }
    }
    let (race, paper) = (key.value(race), key.value(paper));
    let cells =
        [key.symbol, key.unit, &range, &format!("{race:.5}"), &format!("{paper:.5}"), &meaning];
    format!("| `{}` | {} |", key.name, cells.map(|cell| cell.replace('|', "\\|")).join(" | "))
}

#[test]
fn the_page_is_up_to_date() {
    let (car, track) = (CarParams::builtin("barc").unwrap(), Track::builtin("l").unwrap());
    let race = Config::derived(Preset::Race, &car, &track);
    let paper = Config::preset(Preset::Paper);
    let mut text = TOP.to_owned();
    text += "`preset`, above all sections, names the set of defaults:\n";
    for preset in Preset::CHOICES {
        let default = if preset.word == "race" { " (default)" } else { "" };
        write!(text, "\n- `{}`{default}: {}", preset.word, preset.meaning()).unwrap();
    }
    text += "\n";
    for section in SECTIONS {
        let (name, about) = (section.name, section.about());
        write!(text, "\n## `[{name}]`\n\n{about}\n\n").unwrap();
        text += "| key | symbol | unit | allowed | race | paper | meaning |\n|---|---|---|---|---|---|---|\n";
        for key in section.keys {
            writeln!(text, "{}", row(key, &race, &paper)).unwrap();
        }
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/reference/configuration.md");
    if std::env::var_os("LMPC_WRITE_DOCS").is_some() {
        std::fs::write(&path, &text).unwrap();
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(found == text, "the page is old: LMPC_WRITE_DOCS=1 writes it anew");
}

/// The table and the file have the same keys in the same order, and the table's values are the
/// file's.
#[test]
fn the_table_holds_every_key_of_a_file() {
    let config = Config::preset(Preset::Paper);
    let file = toml::Table::try_from(&config).unwrap();
    let sections: Vec<&str> = SECTIONS.iter().map(|section| section.name).collect();
    let tables = file.iter().filter(|(_, value)| value.is_table()).map(|(name, _)| name.as_str());
    assert_eq!(
        sections.iter().copied().collect::<std::collections::BTreeSet<_>>(),
        tables.collect()
    );
    for section in SECTIONS {
        let table = file[section.name].as_table().unwrap();
        assert_eq!(section.keys.len(), table.len(), "{}", section.name);
        for key in section.keys {
            let line: toml::Table =
                format!("{} = {}", key.name, key.value(&config)).parse().unwrap();
            assert_eq!(line[key.name], table[key.name], "{}", key.dotted());
        }
    }
}

/// Which keys follow from the car, and which from the track too: all cars on all tracks that ship.
#[test]
fn what_the_table_says_of_derived_values_holds() {
    let preset = Config::preset(Preset::Race);
    let mut values: BTreeMap<String, Vec<Vec<String>>> = BTreeMap::new();
    for car in CarParams::builtin_names() {
        let car = CarParams::builtin(car).unwrap();
        let tracks = Track::builtin_names().map(|name| Track::builtin(name).unwrap());
        let configs: Vec<_> =
            tracks.map(|track| Config::derived(Preset::Race, &car, &track)).collect();
        for key in SECTIONS.iter().flat_map(|section| section.keys) {
            let of_car = configs.iter().map(|config| key.value(config).to_string()).collect();
            values.entry(key.dotted()).or_default().push(of_car);
        }
    }
    for key in SECTIONS.iter().flat_map(|section| section.keys) {
        let (name, fixed) = (key.dotted(), key.value(&preset).to_string());
        let by_car = &values[&name];
        let derived = by_car.iter().flatten().any(|value| *value != fixed);
        assert_eq!(derived, key.derivation != Derivation::Preset, "{name} follows from the car");
        if matches!(key.derivation, Derivation::Car(_)) {
            let same = by_car.iter().all(|of_car| of_car.iter().all(|value| *value == of_car[0]));
            assert!(same, "{name} depends on the track");
        }
    }
}
