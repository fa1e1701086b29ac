//! `race` and what comes of it.

use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

use anyhow::Context as _;
use controller::{Learned, Response};
use hosting::settings::Usage;
use hosting::timing::StepTime;
use hosting::{learned, timing};
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyBytes, PyDict};
use racing::record::{Failure, LapRow, StepRow};
use racing::{Parts, Race as Inner, RaceOptions, columns, files};

use crate::arrays::{rows, state_numbers};
use crate::car::Car;
use crate::config::Config;
use crate::errors::{CarError, ConfigError, DataError, RaceError, raise};
use crate::plant;
use crate::rule::limit;
use crate::table;
use crate::track::Track;

/// A race that has been driven.
#[pyclass(frozen, module = "racing_lmpc")]
pub(crate) struct Race {
    laps: Vec<LapRow>,
    steps: Vec<StepRow>,
    times: Vec<StepTime>,
    failure: Option<Failure>,
    incidents: Vec<Failure>,
    learned: Learned,
    grip: [f64; 2],
    response: Response,
    /// The track.
    #[pyo3(get)]
    track: Py<Track>,
    lap_table: PyOnceLock<Py<PyDict>>,
    step_table: PyOnceLock<Py<PyDict>>,
}

/// Where a race begins: nothing, the bytes of learned data, or a file of them.
enum Start {
    Fresh,
    Bytes(Vec<u8>),
    File(PathBuf),
}

impl Start {
    fn of(value: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let Some(value) = value else { return Ok(Self::Fresh) };
        match value.cast::<PyBytes>() {
            Ok(bytes) => Ok(Self::Bytes(bytes.as_bytes().to_vec())),
            Err(_) => Ok(Self::File(value.extract()?)),
        }
    }

    fn load(&self, race: &mut Inner) -> PyResult<()> {
        match self {
            Self::Fresh => Ok(()),
            Self::Bytes(bytes) => race.controller_mut().load(bytes).map_err(raise::<DataError>),
            Self::File(path) => {
                learned::load(path, race.controller_mut()).map_err(raise::<DataError>)
            }
        }
    }
}

#[pyfunction]
#[pyo3(signature = (
    car = None, track = None, config = None, *, laps = 20, seed = 0, plant = None,
    nominal_mu = None, body = None, recover = false, learned = None, on_lap = None
))]
/// Races the simulated car: ``lmpc race`` with the same options, to the same bits.
///
/// Releases the interpreter's lock, so that threads race side by side. Ctrl-C ends it at the end
/// of a lap.
///
/// Args:
///     car: ``barc`` by default.
///     track: ``l`` by default.
///     config: a `Config`, or keys such as ``{"horizon.steps": 12}``.
///     laps: laps to drive after the warm-up laps.
///     seed: of the warm-up laps, the sensor noise and the disturbances.
///     plant: changes of the simulated car, e.g. ``{"mu": 0.7, "delay": 0.1}``.
///     nominal_mu: friction the controller believes in; see `Car.nominal` [-].
///     body: whether the whole body has to stay inside, or only the centre of gravity.
///     recover: whether the car drives back after a failure and races on.
///     learned: learned data to start from, as bytes or as a file.
///     on_lap: called with each lap as a dictionary as it ends; what it raises ends the race.
///
/// Raises:
///     CarError, TrackError, ConfigError, DataError, RaceError: it cannot begin. A car that fails
///         under way is no exception: see `Race.failure`.
#[expect(clippy::too_many_arguments, reason = "keywords in Python")]
pub(crate) fn race(
    py: Python<'_>,
    car: Option<&Bound<'_, PyAny>>,
    track: Option<&Bound<'_, PyAny>>,
    config: Option<&Bound<'_, PyAny>>,
    laps: u32,
    seed: u64,
    plant: Option<&Bound<'_, PyAny>>,
    nominal_mu: Option<f64>,
    body: Option<bool>,
    recover: bool,
    learned: Option<&Bound<'_, PyAny>>,
    on_lap: Option<Py<PyAny>>,
) -> PyResult<Race> {
    let word = |text: &str| pyo3::types::PyString::new(py, text).into_any();
    let car = Car::of(car.unwrap_or(&word(racing::SMALL_CAR)))?;
    let track = Track::of(track.unwrap_or(&word("l")))?;
    let shared = Arc::clone(&track.get().inner);
    let changes = plant::texts(plant)?;
    let parts = Parts {
        name: &car.given,
        car: car.inner.clone(),
        track: shared,
        plant: &changes,
        nominal_mu,
        laps,
    };
    let layers = Config::of(config)?.layers;
    let options = parts.assemble(|car, track| layers.build_for(car, track));
    let refuse = |error: anyhow::Error| match error.is::<Usage>() {
        true => raise::<CarError>(error),
        false => raise::<ConfigError>(error),
    };
    let mut options = options.map_err(refuse)?.with_seed(seed);
    options.recover = recover;
    options.limit = limit(body, &options.config);
    if recover {
        options.config.recovery.active = true;
    }
    let start = Start::of(learned)?;
    py.detach(|| drive(options, &start, track, on_lap.as_ref()))
}

/// Drives without the interpreter's lock; after each lap it is taken for `on_lap` and for Ctrl-C.
fn drive(
    options: RaceOptions,
    start: &Start,
    track: Py<Track>,
    on_lap: Option<&Py<PyAny>>,
) -> PyResult<Race> {
    let mut race = Inner::new(options).map_err(raise::<RaceError>)?;
    start.load(&mut race)?;
    let mut interrupt = None;
    let ran = race.run_while(|lap| {
        let seen = Python::attach(|py| -> PyResult<()> {
            py.check_signals()?;
            if let Some(call) = on_lap {
                call.call1(py, (table::row(py, columns::LAPS, lap)?,))?;
            }
            Ok(())
        });
        interrupt = seen.err();
        interrupt.is_none()
    });
    if let Some(interrupt) = interrupt {
        return Err(interrupt);
    }
    ran.map_err(raise::<RaceError>)?;
    race.controller_mut().finish_learning();
    let controller = race.controller();
    Ok(Race {
        learned: controller.learned_data(),
        grip: controller.grip(),
        response: controller.response(),
        laps: race.laps,
        steps: race.steps,
        times: race.times,
        failure: race.failure,
        incidents: race.incidents,
        track,
        lap_table: PyOnceLock::new(),
        step_table: PyOnceLock::new(),
    })
}

/// A failure as a dictionary.
fn failure<'py>(py: Python<'py>, failure: &Failure) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    all.set_item("reason", failure.reason.as_str())?;
    all.set_item("iteration", failure.iteration)?;
    all.set_item("time", failure.time)?;
    all.set_item("x", PyArray1::from_slice(py, &state_numbers(&failure.x)))?;
    all.set_item("beyond", failure.beyond)?;
    all.set_item("message", failure.to_string())?;
    Ok(all)
}

#[pymethods]
impl Race {
    /// The columns of ``laps.csv``, an array (laps,) each.
    #[getter]
    fn laps<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let make = || table::columns(py, columns::LAPS, &self.laps).map(Bound::unbind);
        Ok(self.lap_table.get_or_try_init(py, make)?.bind(py).clone())
    }

    /// The columns of ``trajectory.csv``, an array (steps,) each; units end the names.
    #[getter]
    fn trajectory<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let make = || table::columns(py, columns::STEPS, &self.steps).map(Bound::unbind);
        Ok(self.step_table.get_or_try_init(py, make)?.bind(py).clone())
    }

    /// True states (steps, 6).
    #[getter]
    fn x<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(py, self.steps.iter().map(|step| state_numbers(&step.x)))
    }

    /// Inputs (steps, 2).
    #[getter]
    fn u<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(py, self.steps.iter().map(|step| [step.u.a, step.u.delta]))
    }

    /// Times of the steps, whole (``step``) and by phase, (steps,) each [s].
    #[getter]
    fn step_times<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        for (i, (_, name)) in timing::PHASES.iter().enumerate() {
            let times: Vec<f64> = self.times.iter().map(|time| time.phases[i]).collect();
            all.set_item(name.replace(' ', "_"), times.into_pyarray(py))?;
        }
        let times: Vec<f64> = self.times.iter().map(|time| time.total).collect();
        all.set_item("step", times.into_pyarray(py))?;
        Ok(all)
    }

    /// Fastest valid learned lap [s].
    #[getter]
    fn best_lap(&self) -> Option<f64> {
        let valid = self.laps.iter().filter(|lap| lap.is_learning() && lap.result.valid);
        valid.map(|lap| lap.result.lap_time).min_by(f64::total_cmp)
    }

    /// Why it ended early: ``reason``, ``iteration``, ``time`` [s], state ``x`` (6,),
    /// ``beyond`` [m], ``message``.
    #[getter]
    fn failure<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        self.failure.as_ref().map(|f| failure(py, f)).transpose()
    }

    /// Failures from which the car drove back, with `recover`.
    #[getter]
    fn incidents<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        self.incidents.iter().map(|f| failure(py, f)).collect()
    }

    /// What was learned, for `Controller.load` or another race.
    #[getter]
    fn learned<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        let mut bytes = Vec::new();
        let written: Result<(), std::convert::Infallible> = self.learned.write(|part| {
            bytes.extend_from_slice(part);
            Ok(())
        });
        let Ok(()) = written;
        PyBytes::new(py, &bytes)
    }

    /// Writes what was learned; an earlier file stays as ``.bak``.
    fn save_file(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let learned = &self.learned;
        let write = || {
            learned::write(&path, learned)
                .with_context(|| format!("cannot save {}", path.display()))
        };
        py.detach(write).map_err(raise::<DataError>)
    }

    /// Fitted factors on front and rear grip [-].
    #[getter]
    fn grip(&self) -> (f64, f64) {
        (self.grip[0], self.grip[1])
    }

    /// Time from a command to the beginning of its effect, given or found [s].
    #[getter]
    fn delay(&self) -> f64 {
        self.response.delay
    }

    /// Time constant of the actuators, given or found [s].
    #[getter]
    fn lag(&self) -> f64 {
        self.response.lag
    }

    /// Writes ``laps.csv``, ``trajectory.csv`` and ``timings.csv`` as ``lmpc race`` does.
    fn write(&self, py: Python<'_>, folder: PathBuf) -> PyResult<()> {
        let (laps, steps, times) = (&self.laps, &self.steps, &self.times);
        py.detach(|| {
            let write = || -> std::io::Result<()> {
                fs::create_dir_all(&folder)?;
                files::write_laps(&folder.join("laps.csv"), laps)?;
                files::write_trajectory(&folder.join("trajectory.csv"), steps)?;
                files::write_timings(&folder.join("timings.csv"), steps, times)
            };
            write().with_context(|| format!("cannot write to {}", folder.display()))
        })
        .map_err(raise::<RaceError>)
    }

    fn __repr__(&self) -> String {
        let best = self.best_lap().map_or(String::new(), |best| format!(", best {best:.3} s"));
        let failed = self.failure.as_ref().map_or(String::new(), |f| format!(", {f}"));
        format!("Race({} laps{best}{failed})", self.laps.len())
    }
}
