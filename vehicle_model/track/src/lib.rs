//! Race tracks: the closed path tau of length L that the paper's states are measured along.
//!
//! A track is a centre line with its curvature kappa(s), and the distances to its left and
//! right edge. It is made once, checked then, and never changes. Progress s may be asked for
//! in any lap; it is wrapped to [0, L).
//!
//! ```
//! use track::{State, Track};
//!
//! let track = Track::builtin("l").ok_or("ships with the crate")?;
//! let x = State { s: 3.0, e_y: 0.2, ..State::default() };
//! let g = track.to_global(&x);
//! let back = track.to_frenet(&g, Some(2.9)); // the s of the step before
//! assert!((back.s - x.s).abs() < 1e-9 && (back.e_y - x.e_y).abs() < 1e-9);
//! # Ok::<(), &str>(())
//! ```
#![forbid(unsafe_code)]
// The same bits on every machine: no function of the platform's mathematical library.
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod along;
mod arc;
mod builtin;
mod car_size;
mod changes;
mod crossing;
mod drivable;
mod error;
mod fingerprint;
mod frenet;
mod hills;
mod import;
mod outliers;
mod path;
mod points;
mod random;
mod road;
mod segment;
mod smooth;
mod spline;
mod state;
mod survey;
mod widths;
mod write;

pub use along::Station;
pub use car_size::CarSize;
pub use changes::{Change, ImportOptions, Imported, Origin, Side};
pub use error::{Place, TrackError};
pub use fingerprint::fingerprint;
pub use frenet::{Projection, wrap_angle};
pub use points::TrackPoint;
pub use random::random;
pub use road::{MIN_FRENET_SCALE, Road, Surface, TrackRoad};
pub use segment::Segment;
pub use state::{GlobalState, NX, State};
pub use write::points_to_toml;

use along::Along;
use path::Path;
use std::fmt;
use widths::Widths;

/// A closed race track.
#[derive(Clone, PartialEq)]
pub struct Track {
    name: String,
    path: Path,
    widths: Widths,
    bridges: Vec<(Place, Place)>,
    along: Along,
    length: f64,
    max_abs_kappa: f64,
    min_width: f64,
    max_width: f64,
    fingerprint: u64,
}

impl fmt::Debug for Track {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Track")
            .field("name", &self.name)
            .field("length", &self.length)
            .field("pieces", &self.path.len())
            .finish_non_exhaustive()
    }
}

impl Track {
    /// A track of straights and arcs that starts at (0, 0) along +x. `width_left` and
    /// `width_right` \[m\] hold where a segment has no widths of its own.
    ///
    /// # Errors
    /// The first of everything that is wrong with the segments.
    pub fn from_segments(
        name: &str,
        segments: &[Segment],
        width_left: f64,
        width_right: f64,
    ) -> Result<Self, TrackError> {
        let item = |i: usize| format!("segment {}", i + 1);
        segment::build(name, segments, width_left, width_right, &item).map_err(import::first)
    }

    /// A track through points of its centre line in the order of driving; the list is open (the
    /// last point is one step before the first) or repeats the first point at its end.
    ///
    /// # Errors
    /// The first of everything that is wrong with the points.
    pub fn from_points(name: &str, points: &[TrackPoint]) -> Result<Self, TrackError> {
        let item = |i: usize| format!("point {}", i + 1);
        points::build(name, points, &item).map_err(import::first)
    }

    /// The track of parts that have been checked.
    fn assemble(
        name: &str,
        path: Path,
        widths: Widths,
        bridges: Vec<(Place, Place)>,
        fingerprint: u64,
    ) -> Self {
        let last = path.len() - 1;
        let length = path.start_of(last) + path.length_of(last);
        let max_abs_kappa =
            (0..path.len()).map(|i| path.kappa_in(i, 0.0).abs()).fold(0.0, f64::max);
        let (min_width, max_width) = widths.range();
        let name = name.to_owned();
        Self {
            name,
            path,
            widths,
            bridges,
            along: Along::default(),
            length,
            max_abs_kappa,
            min_width,
            max_width,
            fingerprint,
        }
    }

    /// Name of the track.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Length L of the centre line \[m\].
    #[must_use]
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Progress s of any lap brought into [0, L) \[m\]; 0 for what is no finite number.
    #[must_use]
    #[inline]
    pub fn wrap(&self, s: f64) -> f64 {
        if (0.0..self.length).contains(&s) {
            return s;
        }
        // The remainder of a tiny negative number rounds to L itself.
        let wrapped = s.rem_euclid(self.length);
        if wrapped < self.length { wrapped } else { 0.0 }
    }

    /// Curvature of the centre line at s, positive to the left [1/m]. On a track of segments it
    /// is constant on each [s_i, s_i+1).
    #[must_use]
    pub fn kappa(&self, s: f64) -> f64 {
        self.path.kappa(self.wrap(s))
    }

    /// [`Track::kappa`] as a function that looks first where it found the place last: for many
    /// places that follow one another.
    pub fn kappa_along(&self) -> impl Fn(f64) -> f64 {
        let road = self.road();
        move |s| road.kappa(s)
    }

    /// Curvature [1/m] and distances to the left and the right edge \[m\] from s - `reach` to s + `reach`, if
    /// that lies within one straight or arc and neither changes.
    #[must_use]
    pub fn even_around(&self, s: f64, reach: f64) -> Option<(f64, [f64; 2])> {
        let s = self.wrap(s);
        let kappa = self.path.constant(s - reach, s + reach)?;
        let (left, right) = self.widths.even(s - reach, s + reach)?;
        Some((kappa, [left, right]))
    }

    /// Places in [0, L) where the curvature jumps, in order \[m\]: the ends of the segments of a
    /// track of straights and arcs. A spline's curvature has no jumps.
    #[must_use]
    pub fn curvature_jumps(&self) -> Vec<f64> {
        let n = self.path.len();
        let jumps = |i: &usize| {
            let before = (i + n - 1) % n;
            let change = self.path.kappa_in(before, self.path.length_of(before))
                - self.path.kappa_in(*i, 0.0);
            change.abs() > 1e-6 * self.max_abs_kappa
        };
        (0..n).filter(jumps).map(|i| self.path.start_of(i)).collect()
    }

    /// Largest |kappa| of the centre line [1/m].
    #[must_use]
    pub fn max_abs_kappa(&self) -> f64 {
        self.max_abs_kappa
    }

    /// Distance from the centre line to the left edge at s \[m\].
    #[must_use]
    pub fn width_left(&self, s: f64) -> f64 {
        self.widths.at(self.wrap(s)).0
    }

    /// Distance from the centre line to the right edge at s \[m\].
    #[must_use]
    pub fn width_right(&self, s: f64) -> f64 {
        self.widths.at(self.wrap(s)).1
    }

    /// Width from edge to edge at the narrowest place \[m\].
    #[must_use]
    pub fn narrowest(&self) -> f64 {
        self.min_width
    }

    /// Where the centre line crosses itself, on a bridge: both passages of each crossing.
    #[must_use]
    pub fn bridges(&self) -> &[(Place, Place)] {
        &self.bridges
    }

    /// Point of the centre line at s \[m\].
    #[must_use]
    pub fn position(&self, s: f64) -> (f64, f64) {
        let (x, y, _) = self.pose(s);
        (x, y)
    }

    /// Heading of the centre line at s, zero along +x, continuous along the lap from s = 0 to L:
    /// at the end of a counter-clockwise lap it has grown by 2 pi \[rad\].
    #[must_use]
    pub fn heading(&self, s: f64) -> f64 {
        self.pose(s).2
    }

    /// A number that tells this track's geometry and widths from any other's: a hash of the
    /// segments or points it was made of, the same on every machine. The name has no part in it.
    #[must_use]
    pub fn fingerprint(&self) -> u64 {
        self.fingerprint
    }

    /// Pose (x, y, psi) of the centre line at s.
    fn pose(&self, s: f64) -> (f64, f64, f64) {
        let s = self.wrap(s);
        let i = self.path.index_of(s);
        self.path.pose_in(i, s - self.path.start_of(i))
    }
}
