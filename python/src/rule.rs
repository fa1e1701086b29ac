//! `FailureRule`.

use hosting::rule::{FailureRule as Inner, TrackLimit};
use pyo3::prelude::*;

use crate::arrays::state;
use crate::car::Car;
use crate::config::Config;
use crate::errors::{ConfigError, raise};
use crate::track::Track;

/// When a run counts as failed, as in ``lmpc race``.
///
/// The rule for a car on a track. `body`: whether its whole body has to stay inside, or
/// only its centre of gravity; by default as the preset has it.
#[pyclass(frozen, module = "racing_lmpc")]
pub(crate) struct FailureRule {
    inner: Inner,
    track: Py<Track>,
}

#[pymethods]
impl FailureRule {
    #[new]
    #[pyo3(signature = (car, track, config = None, body = None))]
    fn new(
        car: &Bound<'_, PyAny>,
        track: &Bound<'_, PyAny>,
        config: Option<&Bound<'_, PyAny>>,
        body: Option<bool>,
    ) -> PyResult<Self> {
        let (car, track) = (Car::of(car)?, Track::of(track)?);
        let shared = &track.get().inner;
        let built = Config::of(config)?.layers.build_for(&car.inner, shared);
        let config = built.map_err(raise::<ConfigError>)?;
        let inner = Inner::new(&config, shared, &car.inner, limit(body, &config));
        Ok(Self { inner, track })
    }

    /// Why a true state (6,), `lap_time` [s] after the line, ends the run: ``off_track``,
    /// ``spin``, ``wrong_way``, ``standstill``, ``no_lap``, ``not_finite``; else `None`.
    fn broken(&self, x: &Bound<'_, PyAny>, lap_time: f64) -> PyResult<Option<&'static str>> {
        let broken = self.inner.broken(&self.track.get().inner, &state(x)?, lap_time);
        Ok(broken.map(|reason| reason.as_str()))
    }

    /// How far what has to stay inside is beyond an edge; negative inside [m].
    fn beyond(&self, x: &Bound<'_, PyAny>) -> PyResult<f64> {
        Ok(self.inner.edges.beyond(&self.track.get().inner, &state(x)?))
    }

    /// Longest time a lap may take [s].
    #[getter]
    fn lap_time_limit(&self) -> f64 {
        self.inner.lap_time_limit
    }
}

/// What has to stay inside: the body, the centre of gravity, or what the preset says.
pub(crate) fn limit(body: Option<bool>, config: &controller::Config) -> TrackLimit {
    match body {
        Some(true) => TrackLimit::Body,
        Some(false) => TrackLimit::CentreOfGravity,
        None => TrackLimit::of(config),
    }
}
