//! A configuration put together from layers: preset, embedded settings, the user's file, single
//! keys from the command line.

use std::fs;
use std::path::Path;

use anyhow::{Context as _, Result};
use controller::Config;
use toml::{Table, Value};
use vehicle_model::{CarParams, Track};

/// A command line that cannot be obeyed.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Usage(pub String);

/// Layers of a configuration, the later over the earlier.
#[derive(Debug, Clone, Default)]
pub struct Layers {
    table: Table,
}

impl Layers {
    /// Lays a file over what there is.
    ///
    /// # Errors
    /// If it cannot be read, or has a key or value that is not allowed.
    pub fn file(&mut self, path: &Path) -> Result<()> {
        let text =
            fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
        self.text(&text).with_context(|| path.display().to_string())
    }

    /// Lays TOML over what there is.
    ///
    /// # Errors
    /// If it has a key or value that is not allowed.
    pub fn text(&mut self, text: &str) -> Result<()> {
        Config::from_toml(text)?;
        let table: Table = toml::from_str(text)?;
        overlay(&mut self.table, table);
        Ok(())
    }

    /// Lays `section.key=value` over what there is.
    ///
    /// # Errors
    /// [`Usage`] if there is no such key or its value is not allowed.
    pub fn set(&mut self, assignment: &str) -> Result<()> {
        let usage = |why: String| Usage(format!("--set {assignment}: {why}"));
        let (key, value) = assignment
            .split_once('=')
            .ok_or_else(|| usage("expected SECTION.KEY=VALUE".to_owned()))?;
        let (key, value) = (key.trim(), value.trim());
        let text = format!("{key} = {value}");
        let quoted = format!("{key} = {value:?}");
        let text = if toml::from_str::<Table>(&text).is_ok() { text } else { quoted };
        self.text(&text).map_err(|e| usage(e.to_string()).into())
    }

    /// Sets one key of a section.
    pub fn insert(&mut self, section: &str, key: &str, value: impl Into<Value>) {
        let mut inner = Table::new();
        inner.insert(key.to_owned(), value.into());
        let mut outer = Table::new();
        outer.insert(section.to_owned(), Value::Table(inner));
        overlay(&mut self.table, outer);
    }

    /// Names the preset below all layers.
    pub fn preset(&mut self, name: &str) {
        self.table.insert("preset".to_owned(), Value::String(name.to_owned()));
    }

    /// The configuration of layers over a preset as it stands, for the paper's studies.
    ///
    /// # Errors
    /// If a value is out of range.
    pub fn build(&self) -> Result<Config> {
        Ok(Config::from_toml(&toml::to_string(&self.table)?)?)
    }

    /// The configuration: what follows from car and track below all layers.
    ///
    /// # Errors
    /// If a value is out of range.
    pub fn build_for(&self, car: &CarParams, track: &Track) -> Result<Config> {
        Ok(Config::from_toml_for(&toml::to_string(&self.table)?, car, track)?)
    }
}

fn overlay(base: &mut Table, above: Table) {
    for (key, value) in above {
        match (base.get_mut(&key), value) {
            (Some(Value::Table(below)), Value::Table(above)) => overlay(below, above),
            (_, value) => {
                base.insert(key, value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn later_layers_win_key_by_key() {
        let mut layers = Layers::default();
        layers.preset("paper");
        layers.text("[horizon]\nsteps = 11\nsubsteps = 7").unwrap();
        layers.set("horizon.steps=9").unwrap();
        layers.set("regression.mode=full").unwrap();
        let config = layers.build().unwrap();
        assert_eq!((config.horizon.steps, config.horizon.substeps), (9, 7));
        assert_eq!(config.regression.mode, controller::config::RegressionMode::Full);
        let below = Config::preset(controller::Preset::Paper);
        assert_eq!(config.safe_set, below.safe_set, "the preset below");
        assert_ne!(config.safe_set, Config::default().safe_set, "which is not the default");
    }

    #[test]
    fn a_wrong_key_is_a_usage_error_that_names_the_allowed_ones() {
        let error = Layers::default().set("horizon.stepz=9").unwrap_err();
        assert!(error.is::<Usage>());
        let text = error.to_string();
        assert!(text.contains("stepz") && text.contains("`steps`"), "{text}");
        assert!(Layers::default().set("horizon.steps=1").is_err(), "out of range");
        assert!(Layers::default().set("horizon.steps").is_err(), "no value");
    }
}
