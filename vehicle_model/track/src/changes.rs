//! What an import changed of the points it was given.

use super::write::write_stations;
use super::{Place, Track, TrackPoint, points_to_toml};
use std::fmt;

/// How the points of a track file become a track.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ImportOptions {
    /// Distance by which smoothing moves the points, in the root mean square \[m\]; 0 for a line
    /// exactly through the points, `None` for the smoothing that the noise measured in the points
    /// asks for.
    pub smooth: Option<f64>,
    /// Distance from the centre line to either edge, for a file without widths \[m\].
    pub half_width: Option<f64>,
}

/// A track with what became of its points.
#[derive(Debug, Clone)]
pub struct Imported {
    /// The track.
    pub track: Track,
    /// Everything that differs from the file.
    pub changes: Vec<Change>,
    /// The points as the file has them; none for a track of segments.
    pub points: Vec<TrackPoint>,
    /// The points that the track goes through; none for a track of segments.
    pub line: Vec<TrackPoint>,
    /// Where x = y = 0 is on the globe, if the file says.
    pub origin: Option<Origin>,
}

/// A place on the globe (WGS 84).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Origin {
    /// Geodetic latitude \[degree\].
    pub latitude: f64,
    /// Longitude \[degree\].
    pub longitude: f64,
    /// Height above the ellipsoid \[m\].
    pub height: f64,
}

impl Imported {
    /// A track that is as its file says.
    #[must_use]
    pub fn exact(track: Track) -> Self {
        Self { track, changes: Vec::new(), points: Vec::new(), line: Vec::new(), origin: None }
    }

    /// The track in our own format; reading it again gives the same track to the last bit.
    #[must_use]
    pub fn to_toml(&self) -> String {
        self.track.to_toml().unwrap_or_else(|| {
            let mut text = points_to_toml(self.track.name(), &self.line, self.origin);
            write_stations(&mut text, self.track.stations());
            text
        })
    }
}

/// An edge of the track.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Left of the centre line.
    Left,
    /// Right of the centre line.
    Right,
}

/// A difference between a file's points and the track made of them.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Change {
    /// Points that repeat the one before them were left out.
    Repeated {
        /// How many.
        count: usize,
        /// Where the first of them is.
        first: Place,
    },
    /// Of more points than smoothing takes, one of several was taken.
    Thinned {
        /// How many there were.
        points: usize,
        /// Of how many one was taken.
        every: usize,
    },
    /// The points were moved onto a smooth line; the edges kept their place.
    Smoothed {
        /// How many points the file has.
        points: usize,
        /// Distance by which they moved, in the root mean square \[m\].
        rms: f64,
        /// The longest of these distances \[m\].
        largest: f64,
        /// Where the point that moved furthest was.
        place: Place,
        /// Standard deviation of the points' noise in each coordinate, as estimated \[m\].
        noise: f64,
    },
    /// A width was cut where the bend is tighter than the width on its inner side.
    Clipped {
        /// The edge that was moved.
        side: Side,
        /// Where the stretch begins \[m\].
        from: f64,
        /// Where it ends \[m\].
        to: f64,
        /// Width at the place where most was cut, before \[m\].
        before: f64,
        /// Width there, after \[m\].
        after: f64,
    },
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Left => "left",
            Self::Right => "right",
        })
    }
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Repeated { count, first } => {
                write!(f, "left out {count} repeated points, the first at {first}")
            }
            Self::Thinned { points, every } => {
                write!(f, "took one of {every} points, as {points} are more than a track needs")
            }
            Self::Smoothed { points, rms, largest, place, noise } => write!(
                f,
                "smoothed {points} points with a noise of {noise:.4} m: they moved by {rms:.4} m \
                 (root mean square), at most by {largest:.3} m at {place}"
            ),
            Self::Clipped { side, from, to, before, after } => write!(
                f,
                "cut the {side} width from s = {from:.2} to {to:.2} m, where the bend is tighter \
                 than it: {before:.3} to {after:.3} m at most"
            ),
        }
    }
}
