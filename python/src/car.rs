//! `Car`.

use hosting::load;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use vehicle_model::CarParams;

use crate::config::literal;
use crate::errors::{CarError, raise};

/// All parameters of a car, by the keys of its file. Cars can be compared and pickled.
///
/// A car that ships with the package, or a car file.
///
/// Raises:
///     CarError: there is no such car, or the file is wrong.
#[pyclass(frozen, from_py_object, module = "racing_lmpc")]
#[derive(Clone)]
pub(crate) struct Car {
    pub(crate) inner: CarParams,
    /// How it was named: the grip that a controller believes in follows from it, as in `lmpc race`.
    pub(crate) given: String,
}

impl Car {
    /// The car of an argument: a `Car`, a name or a file.
    pub(crate) fn of(value: &Bound<'_, PyAny>) -> PyResult<Self> {
        if let Ok(car) = value.cast::<Self>() {
            return Ok(car.get().clone());
        }
        Self::new(value.extract()?)
    }

    fn read(text: &str, given: String) -> PyResult<Self> {
        let inner = CarParams::from_toml(text).map_err(raise::<CarError>)?;
        Ok(Self { inner, given })
    }
}

#[pymethods]
impl Car {
    #[new]
    fn new(name: std::path::PathBuf) -> PyResult<Self> {
        let given = name.display().to_string();
        let inner = load::car(&given).map_err(raise::<CarError>)?;
        Ok(Self { inner, given })
    }

    /// Names of the cars that ship with the package.
    #[staticmethod]
    fn names() -> Vec<&'static str> {
        CarParams::builtin_names().to_vec()
    }

    /// The car of a file's text.
    #[staticmethod]
    fn from_toml(text: &str) -> PyResult<Self> {
        Self::read(text, String::new())
    }

    /// The text of a car file with every key, each with unit and meaning.
    fn to_toml(&self) -> String {
        self.inner.to_toml()
    }

    /// This car with other values, e.g. ``{"mass_kg": 3.0, "tyre_front.mu": 0.8}``.
    fn with_keys(&self, keys: &Bound<'_, PyDict>) -> PyResult<Self> {
        let mut lines: Vec<String> = self.inner.to_toml().lines().map(str::to_owned).collect();
        for (key, value) in keys {
            let dotted: String = key.extract()?;
            let (section, key) = dotted.rsplit_once('.').unwrap_or(("", &dotted));
            let line = format!("{key} = {}", literal(&value)?);
            replace(&mut lines, section, key, line);
        }
        Self::read(&lines.join("\n"), self.given.clone())
    }

    /// This car with the same friction coefficient on both axles [-].
    fn with_mu(&self, mu: f64) -> PyResult<Self> {
        let inner = racing::nominal("", self.inner.clone(), Some(mu)).map_err(raise::<CarError>)?;
        Ok(Self { inner, given: self.given.clone() })
    }

    /// The car a controller believes in: with the friction `mu` [-], or by default with the
    /// paper's 1.2 for the car `barc` and its own for every other, as in ``lmpc race``.
    #[pyo3(signature = (mu = None))]
    fn nominal(&self, mu: Option<f64>) -> PyResult<Self> {
        let inner = racing::nominal(&self.given, self.inner.clone(), mu);
        Ok(Self { inner: inner.map_err(raise::<CarError>)?, given: self.given.clone() })
    }

    /// Name in reports.
    #[getter]
    fn name(&self) -> &str {
        &self.inner.name
    }

    /// Mass [kg].
    #[getter]
    fn mass(&self) -> f64 {
        self.inner.mass
    }

    /// Distance between the axles [m].
    #[getter]
    fn wheelbase(&self) -> f64 {
        self.inner.wheelbase()
    }

    /// Length and width of the body [m].
    #[getter]
    fn size(&self) -> (f64, f64) {
        (self.inner.length, self.inner.width)
    }

    /// Friction coefficient of front and rear axle [-].
    #[getter]
    fn mu(&self) -> (f64, f64) {
        (self.inner.tyre_front.mu, self.inner.tyre_rear.mu)
    }

    /// Strongest braking (negative) and driving command [m/s^2], steering stop [rad].
    #[getter]
    fn limits(&self) -> (f64, f64, f64) {
        (self.inner.a_min, self.inner.a_max, self.inner.delta_max)
    }

    /// Hash of every number, the same on every machine.
    #[getter]
    fn fingerprint(&self) -> u64 {
        self.inner.fingerprint()
    }

    fn __repr__(&self) -> String {
        format!("Car({:?}, {} kg)", self.inner.name, self.inner.mass)
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.inner == other.inner
    }

    fn __hash__(&self) -> u64 {
        self.inner.fingerprint()
    }

    /// Pickled as its file and the way it was named.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String, String))> {
        Ok((py.get_type::<Self>().getattr("_named")?, (self.to_toml(), self.given.clone())))
    }

    #[staticmethod]
    fn _named(text: &str, given: String) -> PyResult<Self> {
        Self::read(text, given)
    }
}

/// Puts a key's line in place of the one that a car file has, or at the head of its section.
fn replace(lines: &mut Vec<String>, section: &str, key: &str, line: String) {
    let mut current = "";
    let mut head = 0;
    let mut place = None;
    for (i, text) in lines.iter().enumerate() {
        let text = text.trim();
        if let Some(name) = text.strip_prefix('[').and_then(|rest| rest.split(']').next()) {
            current = name;
            head = if current == section { i + 1 } else { head };
        } else if current == section
            && text.split('=').next().is_some_and(|found| found.trim() == key)
        {
            place = Some(i);
        }
    }
    match place {
        Some(i) => lines[i] = line,
        None => lines.insert(head, line),
    }
}
