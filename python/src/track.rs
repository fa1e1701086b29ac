//! `Track`.

use std::sync::Arc;

use hosting::load;
use numpy::{PyArray1, PyArrayDyn};
use pyo3::prelude::*;
use vehicle_model::track::{ImportOptions, Imported, TrackPoint, points_to_toml};
use vehicle_model::{Segment, Track as Inner};

use crate::arrays::{Places, column, from_global, from_state, global, map, points, state};
use crate::car::Car;
use crate::errors::{TrackError, raise};

/// A closed race track: a centre line of length L with its curvature, and both edges.
///
/// Progress s [m] may lie in any lap. Methods take a number or an array of any shape.
/// Tracks are equal if their geometry is; they can be pickled.
///
/// A track that ships with the package, or a file in any format that ``lmpc`` reads.
///
/// Points of a file are smoothed as their noise asks for; see `changes`.
///
/// Raises:
///     TrackError: there is no such track, or the file is wrong.
#[pyclass(frozen, module = "racing_lmpc")]
pub(crate) struct Track {
    pub(crate) inner: Arc<Inner>,
    /// What the import changed of a file's points, in sentences.
    #[pyo3(get)]
    changes: Vec<String>,
    /// Its points in our own format; none for segments, which write themselves.
    toml: Option<String>,
}

impl Track {
    fn exact(inner: Inner) -> Self {
        Self { inner: Arc::new(inner), changes: Vec::new(), toml: None }
    }

    fn imported(imported: Imported) -> Self {
        let changes = imported.changes.iter().map(ToString::to_string).collect();
        let toml = Some(imported.to_toml());
        Self { inner: Arc::new(imported.track), changes, toml }
    }

    /// The track of an argument: a `Track`, a name or a file.
    pub(crate) fn of(value: &Bound<'_, PyAny>) -> PyResult<Py<Self>> {
        if let Ok(track) = value.cast::<Self>() {
            return Ok(track.clone().unbind());
        }
        let name: std::path::PathBuf = value.extract()?;
        Py::new(value.py(), Self::new(name)?)
    }
}

fn import(name: &str, text: &str, options: &ImportOptions) -> PyResult<Track> {
    match Inner::import(name, text, options) {
        Ok(imported) => Ok(Track::imported(imported)),
        Err(problems) => {
            let texts: Vec<String> = problems.iter().map(ToString::to_string).collect();
            Err(PyErr::new::<TrackError, _>(format!("{name}: {}", texts.join("; "))))
        }
    }
}

#[pymethods]
impl Track {
    #[new]
    fn new(name: std::path::PathBuf) -> PyResult<Self> {
        let name = name.display().to_string();
        if let Some(track) = Inner::builtin(&name) {
            return Ok(Self::exact(track));
        }
        let text = load::track_text(&name).map_err(raise::<TrackError>)?;
        import(&name, &text, &ImportOptions::default())
    }

    /// Names of the tracks that ship with the package.
    #[staticmethod]
    fn names() -> Vec<&'static str> {
        Inner::builtin_names().collect()
    }

    /// The track of a file's text. `smooth`: as in `from_points`.
    #[staticmethod]
    #[pyo3(signature = (text, name = "track", smooth = None))]
    fn from_text(text: &str, name: &str, smooth: Option<f64>) -> PyResult<Self> {
        import(name, text, &ImportOptions { smooth, ..ImportOptions::default() })
    }

    /// A track through points of its centre line in the order of driving, the last one step
    /// before the first.
    ///
    /// Args:
    ///     x: positions (n,) [m].
    ///     y: positions (n,) [m].
    ///     width_left: distances to the left edge, (n,) or one number [m].
    ///     width_right: distances to the right edge, (n,) or one number [m].
    ///     name: name in reports.
    ///     smooth: distance by which smoothing moves the points, in the root mean square [m];
    ///         0 for a line exactly through them, `None` for what their noise asks for.
    #[staticmethod]
    #[pyo3(signature = (x, y, width_left, width_right, name = "track", smooth = 0.0))]
    fn from_points(
        x: &Bound<'_, PyAny>,
        y: &Bound<'_, PyAny>,
        width_left: &Bound<'_, PyAny>,
        width_right: &Bound<'_, PyAny>,
        name: &str,
        smooth: Option<f64>,
    ) -> PyResult<Self> {
        let x = column(x, "x", None)?;
        let n = Some(x.len());
        let (y, left, right) = (
            column(y, "y", n)?,
            column(width_left, "width_left", n)?,
            column(width_right, "width_right", n)?,
        );
        let points: Vec<TrackPoint> = (0..x.len())
            .map(|i| TrackPoint { x: x[i], y: y[i], width_left: left[i], width_right: right[i] })
            .collect();
        if smooth == Some(0.0) {
            let inner = Inner::from_points(name, &points).map_err(raise::<TrackError>)?;
            let toml = Some(points_to_toml(name, &points, None));
            return Ok(Self { toml, ..Self::exact(inner) });
        }
        // As a file of these points is read: its text prints every bit of a number.
        let mut text = "# x_m, y_m, w_tr_right_m, w_tr_left_m\n".to_owned();
        for p in &points {
            let line = format!("{}, {}, {}, {}\n", p.x, p.y, p.width_right, p.width_left);
            text.push_str(&line);
        }
        import(name, &text, &ImportOptions { smooth, ..ImportOptions::default() })
    }

    /// A track of straights and arcs that starts at (0, 0) along +x and must close.
    ///
    /// Args:
    ///     lengths: of the segments (n,) [m].
    ///     curvatures: of the segments, positive to the left, 0 for a straight (n,) [1/m].
    ///     width_left: distance to the left edge [m].
    ///     width_right: distance to the right edge [m].
    ///     name: name in reports.
    #[staticmethod]
    #[pyo3(signature = (lengths, curvatures, width_left, width_right, name = "track"))]
    fn from_segments(
        lengths: &Bound<'_, PyAny>,
        curvatures: &Bound<'_, PyAny>,
        width_left: f64,
        width_right: f64,
        name: &str,
    ) -> PyResult<Self> {
        let lengths = column(lengths, "lengths", None)?;
        let kappas = column(curvatures, "curvatures", Some(lengths.len()))?;
        let segments: Vec<Segment> = lengths
            .iter()
            .zip(kappas)
            .map(|(length, kappa)| Segment { kappa, ..Segment::straight(*length) })
            .collect();
        let inner = Inner::from_segments(name, &segments, width_left, width_right);
        Ok(Self::exact(inner.map_err(raise::<TrackError>)?))
    }

    /// A random track at the scale of a car; the same seed gives the same track.
    #[staticmethod]
    fn random(seed: u64, car: &Car) -> PyResult<Self> {
        let track = vehicle_model::track::random(seed, &car.inner).map_err(raise::<TrackError>)?;
        Ok(Self::exact(track))
    }

    /// Name of the track.
    #[getter]
    fn name(&self) -> &str {
        self.inner.name()
    }

    /// Length L of the centre line [m].
    #[getter]
    fn length(&self) -> f64 {
        self.inner.length()
    }

    /// Width from edge to edge at the narrowest place [m].
    #[getter]
    fn narrowest(&self) -> f64 {
        self.inner.narrowest()
    }

    /// Largest curvature of the centre line, without sign [1/m].
    #[getter]
    fn max_abs_kappa(&self) -> f64 {
        self.inner.max_abs_kappa()
    }

    /// Hash of geometry and widths, the same on every machine.
    #[getter]
    fn fingerprint(&self) -> u64 {
        self.inner.fingerprint()
    }

    /// Progress brought into [0, L) [m].
    fn wrap<'py>(&self, py: Python<'py>, s: Places<'py>) -> Bound<'py, PyArrayDyn<f64>> {
        map(py, &s, |s| self.inner.wrap(s))
    }

    /// Curvature of the centre line, positive to the left [1/m].
    fn kappa<'py>(&self, py: Python<'py>, s: Places<'py>) -> Bound<'py, PyArrayDyn<f64>> {
        map(py, &s, self.inner.kappa_along())
    }

    /// Distance from the centre line to the left edge [m].
    fn width_left<'py>(&self, py: Python<'py>, s: Places<'py>) -> Bound<'py, PyArrayDyn<f64>> {
        map(py, &s, |s| self.inner.width_left(s))
    }

    /// Distance from the centre line to the right edge [m].
    fn width_right<'py>(&self, py: Python<'py>, s: Places<'py>) -> Bound<'py, PyArrayDyn<f64>> {
        map(py, &s, |s| self.inner.width_right(s))
    }

    /// Heading of the centre line, continuous along the lap [rad].
    fn heading<'py>(&self, py: Python<'py>, s: Places<'py>) -> Bound<'py, PyArrayDyn<f64>> {
        map(py, &s, |s| self.inner.heading(s))
    }

    /// Places `e_y` [m] to the left of the centre line: x, y as the last axis (..., 2) [m].
    #[pyo3(signature = (s, e_y = 0.0))]
    fn position<'py>(
        &self,
        py: Python<'py>,
        s: Places<'py>,
        e_y: f64,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        points(py, &s, |s| self.inner.beside(s, e_y))
    }

    /// Places of the left edge (..., 2) [m].
    fn left_edge<'py>(
        &self,
        py: Python<'py>,
        s: Places<'py>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        points(py, &s, |s| self.inner.beside(s, self.inner.width_left(s)))
    }

    /// Places of the right edge (..., 2) [m].
    fn right_edge<'py>(
        &self,
        py: Python<'py>,
        s: Places<'py>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        points(py, &s, |s| self.inner.beside(s, -self.inner.width_right(s)))
    }

    /// The global state (6,) of a state (6,).
    fn to_global<'py>(
        &self,
        py: Python<'py>,
        x: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(from_global(py, &self.inner.to_global(&state(x)?)))
    }

    /// The state (6,) of a global state (6,). `hint`: the s of the step before [m].
    #[pyo3(signature = (g, hint = None))]
    fn to_frenet<'py>(
        &self,
        py: Python<'py>,
        g: &Bound<'py, PyAny>,
        hint: Option<f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(from_state(py, &self.inner.to_frenet(&global(g)?, hint)))
    }

    /// Why a car does not get round, in sentences; empty if it does.
    fn problems_for(&self, car: &Car) -> Vec<String> {
        self.inner.problems_for(&car.inner).iter().map(ToString::to_string).collect()
    }

    /// The track as a file of ours; reading it gives the same track to the last bit.
    fn to_toml(&self) -> String {
        self.toml.clone().or_else(|| self.inner.to_toml()).unwrap_or_default()
    }

    fn __repr__(&self) -> String {
        format!("Track({:?}, {:.3} m)", self.inner.name(), self.inner.length())
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.inner.fingerprint() == other.inner.fingerprint()
    }

    fn __hash__(&self) -> u64 {
        self.inner.fingerprint()
    }

    /// Pickled as a file of the same track.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String, String))> {
        let name = self.inner.name().to_owned();
        Ok((py.get_type::<Self>().getattr("from_text")?, (self.to_toml(), name)))
    }
}
