//! `Config`.

use std::path::PathBuf;

use bounded_file::Limit;
use controller::config::keys::ConfigValue;
use hosting::settings::{Layers, SettingOrigin};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyString};

use crate::arrays::shown;
use crate::car::Car;
use crate::errors::{ConfigError, raise};
use crate::track::Track;

/// What is set of a configuration. The rest follows from the preset, the car and the track.
///
/// A file, over it a preset (``race`` or ``paper``), over it keys such as
/// ``{"horizon.steps": 12}``.
///
/// Raises:
///     ConfigError: a key or a value is not allowed.
#[pyclass(from_py_object, module = "racing_lmpc")]
#[derive(Clone, Default)]
pub(crate) struct Config {
    pub(crate) layers: Layers,
    /// What made it, in order: how it is pickled and shown.
    made: Vec<(String, String)>,
}

impl Config {
    /// The configuration of an argument: a `Config`, `None`, or keys with values.
    pub(crate) fn of(value: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let Some(value) = value else { return Ok(Self::default()) };
        if let Ok(config) = value.cast::<Self>() {
            return Ok(config.try_borrow()?.clone());
        }
        let mut config = Self::default();
        config.update(value.cast::<PyDict>()?)?;
        Ok(config)
    }

    fn update(&mut self, keys: &Bound<'_, PyDict>) -> PyResult<()> {
        for (key, value) in keys {
            self.assign(key.extract()?, literal(&value)?)?;
        }
        Ok(())
    }

    fn assign(&mut self, key: String, text: String) -> PyResult<()> {
        if key == "preset" {
            return self.preset(text.trim_matches('"'));
        }
        self.layers.set(&format!("{key}={text}")).map_err(|error| {
            let text = error.to_string();
            PyErr::new::<ConfigError, _>(text.trim_start_matches("--set ").to_owned())
        })?;
        self.made.push((key, text));
        Ok(())
    }

    fn preset(&mut self, name: &str) -> PyResult<()> {
        let text = format!("preset = {name:?}");
        self.layers.text(&text, SettingOrigin::CommandLine).map_err(raise::<ConfigError>)?;
        self.made.push(("preset".to_owned(), format!("{name:?}")));
        Ok(())
    }

    fn file(&mut self, text: &str, name: &str) -> PyResult<()> {
        let origin = SettingOrigin::File(name.to_owned());
        self.layers
            .text(text, origin)
            .map_err(|error| PyErr::new::<ConfigError, _>(format!("{name}: {error:#}")))?;
        self.made.push((format!("file {name}"), text.to_owned()));
        Ok(())
    }
}

#[pymethods]
impl Config {
    #[new]
    #[pyo3(signature = (preset = None, file = None, keys = None))]
    fn new(
        preset: Option<&str>,
        file: Option<PathBuf>,
        keys: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let mut config = Self::default();
        if let Some(path) = file {
            let name = path.display().to_string();
            let text = bounded_file::text(&path, Limit::SETTINGS)
                .map_err(|error| PyErr::new::<ConfigError, _>(error.to_string()))?;
            config.file(&text, &name)?;
        }
        if let Some(preset) = preset {
            config.preset(preset)?;
        }
        if let Some(keys) = keys {
            config.update(keys)?;
        }
        Ok(config)
    }

    /// Sets one key, e.g. ``set("regression.mode", "full")``; returns the configuration.
    fn set<'py>(
        mut this: PyRefMut<'py, Self>,
        key: String,
        value: &Bound<'py, PyAny>,
    ) -> PyResult<PyRefMut<'py, Self>> {
        let text = literal(value)?;
        this.assign(key, text)?;
        Ok(this)
    }

    /// Every key with its value for a controller that believes in this car, on this track.
    fn values<'py>(
        &self,
        py: Python<'py>,
        car: &Bound<'py, PyAny>,
        track: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyDict>> {
        self.each(py, car, track, |value, _| value)
    }

    /// Every key with where its value comes from.
    fn origins<'py>(
        &self,
        py: Python<'py>,
        car: &Bound<'py, PyAny>,
        track: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyDict>> {
        self.each(py, car, track, |_, origin| origin)
    }

    /// A copy that changes on its own.
    fn copy(&self) -> Self {
        self.clone()
    }

    fn __repr__(&self) -> String {
        let parts: Vec<String> = self
            .made
            .iter()
            .map(
                |(key, text)| {
                    if key.starts_with("file ") { key.clone() } else { format!("{key} = {text}") }
                },
            )
            .collect();
        format!("Config({})", parts.join(", "))
    }

    /// Pickled as what made it.
    #[expect(clippy::type_complexity, reason = "a class method and its argument")]
    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, (Vec<(String, String)>,))> {
        Ok((py.get_type::<Self>().getattr("_made")?, (self.made.clone(),)))
    }

    #[staticmethod]
    fn _made(made: Vec<(String, String)>) -> PyResult<Self> {
        let mut config = Self::default();
        for (key, text) in made {
            match key.strip_prefix("file ") {
                Some(name) => config.file(&text, name)?,
                None => config.assign(key, text)?,
            }
        }
        Ok(config)
    }
}

impl Config {
    /// Something of every key, by its dotted name.
    fn each<'py>(
        &self,
        py: Python<'py>,
        car: &Bound<'py, PyAny>,
        track: &Bound<'py, PyAny>,
        pick: impl Fn(Py<PyAny>, Py<PyAny>) -> Py<PyAny>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (car, track) = (Car::of(car)?, Track::of(track)?);
        let built = self.layers.build_for(&car.inner, &track.get().inner);
        let config = built.map_err(raise::<ConfigError>)?;
        let all = PyDict::new(py);
        for setting in self.layers.explain(&config) {
            let value = match setting.value {
                ConfigValue::Count(count) => count.into_py_any(py)?,
                ConfigValue::Number(number) => number.into_py_any(py)?,
                ConfigValue::Switch(on) => on.into_py_any(py)?,
                ConfigValue::Word(word) => word.into_py_any(py)?,
                ConfigValue::Numbers(numbers) => numbers.to_vec().into_py_any(py)?,
            };
            let origin = setting.origin.to_string().into_py_any(py)?;
            all.set_item(setting.key.dotted(), pick(value, origin))?;
        }
        Ok(all)
    }
}

/// A value as TOML has it.
pub(crate) fn literal(value: &Bound<'_, PyAny>) -> PyResult<String> {
    if let Ok(text) = value.cast::<PyString>() {
        let text = text.to_string();
        let escaped = text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n");
        return Ok(format!("\"{escaped}\""));
    }
    if value.is_instance_of::<PyBool>() {
        return Ok(value.extract::<bool>()?.to_string());
    }
    if let Ok(whole) = value.extract::<i64>() {
        return Ok(whole.to_string());
    }
    if let Ok(number) = value.extract::<f64>() {
        return Ok(format!("{number:?}"));
    }
    if let Ok(on) = value.extract::<bool>() {
        return Ok(on.to_string());
    }
    let items: Vec<Bound<'_, PyAny>> = value
        .try_iter()
        .map_err(|_| {
            let text = format!("found {}, expected a number, a word or a list", shown(value));
            PyErr::new::<ConfigError, _>(text)
        })?
        .collect::<PyResult<_>>()?;
    let parts: Vec<String> = items.iter().map(literal).collect::<PyResult<_>>()?;
    Ok(format!("[{}]", parts.join(", ")))
}
