//! The JSON schema of configuration files, from the table of keys.

use controller::Preset;
use controller::config::SECTIONS;
use controller::config::keys::{Choice, ConfigKey, Derivation, ValueKind};
use serde_json::{Map, Value as Json, json};

use super::config::{meaning, words};

/// The schema, in the draft that editors of TOML files read.
pub(super) fn schema() -> Json {
    let mut properties = Map::new();
    properties.insert("preset".to_owned(), one_of(Preset::CHOICES, "The set of defaults."));
    for section in SECTIONS {
        let keys: Map<String, Json> =
            section.keys.iter().map(|key| (key.name.to_owned(), of_key(key))).collect();
        let table = json!({
            "type": "object", "description": section.about(), "additionalProperties": false,
            "properties": keys,
        });
        properties.insert(section.name.to_owned(), table);
    }
    json!({
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "Configuration of the racing LMPC",
        "type": "object",
        "additionalProperties": false,
        "properties": properties,
    })
}

fn of_key(key: &ConfigKey) -> Json {
    let mut description = meaning(key);
    match key.derivation {
        Derivation::Preset => {}
        Derivation::Car(rule) => description += &format!(" By default from the car: {rule}."),
        Derivation::CarAndTrack(rule) => {
            description += &format!(" By default from car and track: {rule}.");
        }
    }
    let mut number = Map::new();
    if let Some([least, most]) = key.range {
        number.insert("minimum".to_owned(), json!(least));
        number.insert("maximum".to_owned(), json!(most));
    }
    let mut typed = |kind: &str| {
        number.insert("type".to_owned(), json!(kind));
        Json::Object(std::mem::take(&mut number))
    };
    let mut schema = match key.kind {
        ValueKind::Count => typed("integer"),
        ValueKind::Number => typed("number"),
        ValueKind::Switch => json!({ "type": "boolean" }),
        ValueKind::Choice(choices) => one_of(choices, ""),
        ValueKind::Numbers(labels) => json!({
            "type": "array", "items": typed("number"),
            "minItems": labels.len(), "maxItems": labels.len(),
        }),
    };
    if let ValueKind::Numbers(labels) = key.kind {
        description += &format!(" Entries: {}.", labels.join(", "));
    }
    if let ValueKind::Choice(choices) = key.kind {
        for choice in choices {
            description += &format!(" {}: {}", choice.word, choice.meaning());
        }
    }
    schema["description"] = json!(description);
    schema
}

fn one_of(choices: &[Choice], description: &str) -> Json {
    json!({ "type": "string", "enum": words(choices), "description": description })
}
