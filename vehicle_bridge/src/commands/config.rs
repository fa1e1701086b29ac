//! `lmpc config`.

use std::fmt::Write as _;

use anyhow::{Result, bail};
use comfy_table::{Table, presets};
use controller::config::SECTIONS;
use controller::config::keys::{Choice, ConfigKey, ConfigValue, ValueKind};
use serde_json::{Value as Json, json};

use super::{Outcome, config_schema, setup};
use command_line::{ConfigArgs, ControllerArgs};
use hosting::load;
use hosting::settings::{Setting, SettingOrigin, Usage};
use terminal::{SOFT, paint, result};

/// Significant digits of a value in the table.
pub(super) const DIGITS: usize = 5;

/// Prints the settings.
pub(super) fn run(args: &ConfigArgs) -> Result<Outcome> {
    if args.schema {
        terminal::json(&config_schema::schema())?;
        return Ok(Outcome::Done);
    }
    let ControllerArgs { car: car_name, track: track_name, .. } = &args.controller;
    let (car, track) = (load::car(car_name)?, load::track(track_name)?);
    let car = racing::nominal(car_name, car, args.controller.nominal_mu)?;
    let layers = setup::layers(&args.controller)?;
    let config = layers.build_for(&car, &track)?;
    let mut settings = layers.explain(&config);
    choose(&mut settings, &args.keys)?;
    let preset = config.preset.word();
    if args.json {
        terminal::json(&settings.iter().map(row).collect::<Vec<_>>())?;
    } else if args.toml {
        let head = format!("# {car_name} on {track_name}, lmpc {}.", env!("CARGO_PKG_VERSION"));
        result(toml(&head, preset, &settings).trim_end())?;
    } else {
        let grip = [car.tyre_front.mu, car.tyre_rear.mu];
        let grip = if grip[0].to_bits() == grip[1].to_bits() {
            format!("mu {}", grip[0])
        } else {
            format!("mu {} and {}", grip[0], grip[1])
        };
        result(&paint(SOFT, &format!("{car_name} ({grip}) on {track_name}, preset {preset}")))?;
        result(&table(&settings))?;
    }
    Ok(Outcome::Done)
}

/// Keeps the sections and keys asked for.
fn choose(settings: &mut Vec<Setting<'_>>, wanted: &[String]) -> Result<()> {
    let is = |key: &ConfigKey, name: &str| key.section == name || key.dotted() == name;
    for name in wanted {
        if !settings.iter().any(|setting| is(setting.key, name)) {
            let sections: Vec<&str> = SECTIONS.iter().map(|section| section.name).collect();
            bail!(Usage(format!(
                "`{name}` is neither a section nor a key; sections are {}",
                sections.join(", ")
            )));
        }
    }
    settings.retain(|s| wanted.is_empty() || wanted.iter().any(|name| is(s.key, name)));
    Ok(())
}

fn table(settings: &[Setting<'_>]) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header(["key", "symbol", "value", "unit", "from"]);
    for Setting { key, value, origin } in settings {
        let (value, origin) = (format!("{value:.DIGITS$}"), origin.to_string());
        table.add_row([&key.dotted(), key.symbol, &value, key.unit, &origin]);
    }
    table.to_string()
}

/// A configuration file with these settings.
fn toml(head: &str, preset: &str, settings: &[Setting<'_>]) -> String {
    let mut text = format!("{head}\npreset = \"{preset}\"\n");
    let mut section = "";
    for Setting { key, value, origin } in settings {
        if section != key.section {
            section = key.section;
            let about = SECTIONS.iter().find(|s| s.name == section).map_or("", |s| s.about());
            let _ = write!(text, "\n# {about}\n[{section}]\n");
        }
        let _ = write!(text, "# {}\n{} = {value}\n", describe(key, origin), key.name);
    }
    text
}

/// Meaning and unit of a key.
pub(super) fn meaning(key: &ConfigKey) -> String {
    let mut text = key.meaning().to_owned();
    if !key.unit.is_empty() {
        let _ = write!(text, " [{}]", key.unit);
    }
    text
}

/// Meaning, unit, allowed values and origin of a key, in one line.
fn describe(key: &ConfigKey, origin: &SettingOrigin) -> String {
    let mut text = meaning(key);
    let _ = match (key.range, key.kind) {
        (Some([least, most]), _) => write!(text, " {least} to {most}."),
        (None, ValueKind::Choice(choices)) => write!(text, " {}.", words(choices).join(", ")),
        (None, _) => Ok(()),
    };
    let _ = match origin {
        SettingOrigin::Car(rule) | SettingOrigin::CarAndTrack(rule) => {
            write!(text, " From {origin}: {rule}.")
        }
        _ => write!(text, " From {origin}."),
    };
    text
}

/// The words that may be chosen.
pub(super) fn words(choices: &[Choice]) -> Vec<&'static str> {
    choices.iter().map(|choice| choice.word).collect()
}

/// A setting for programs.
pub(super) fn row(setting: &Setting<'_>) -> Json {
    let Setting { key, value, origin } = setting;
    let value = match value {
        ConfigValue::Count(count) => json!(count),
        ConfigValue::Number(number) => json!(number),
        ConfigValue::Switch(on) => json!(on),
        ConfigValue::Word(word) => json!(word),
        ConfigValue::Numbers(numbers) => json!(numbers),
    };
    let (choices, entries) = match key.kind {
        ValueKind::Choice(choices) => (Some(words(choices)), None),
        ValueKind::Numbers(labels) => (None, Some(labels)),
        ValueKind::Count | ValueKind::Number | ValueKind::Switch => (None, None),
    };
    let rule = match origin {
        SettingOrigin::Car(rule) | SettingOrigin::CarAndTrack(rule) => Some(rule),
        _ => None,
    };
    json!({
        "key": key.dotted(), "symbol": key.symbol, "value": value, "unit": key.unit,
        "entries": entries, "origin": origin.to_string(), "rule": rule, "range": key.range,
        "choices": choices, "meaning": key.meaning(),
    })
}
