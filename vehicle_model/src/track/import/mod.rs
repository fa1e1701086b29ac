//! Readers of track files. They take text and give a track or everything wrong with the text.

mod segments_toml;

use super::{Track, TrackError};

impl Track {
    /// The track of our own format: straights and arcs in TOML.
    ///
    /// ```toml
    /// name = "oval"
    /// width_left_m = 4.5          # distances to the edges, where a segment has no own ones
    /// width_right_m = 4.5
    ///
    /// [[segment]]
    /// length_m = 100.0            # a straight
    ///
    /// [[segment]]
    /// radius_m = 20.0             # positive to the left
    /// angle_deg = 180.0           # or length_m
    /// width_left_m = 6.0          # along this segment; width_left_end_m makes it a taper
    ///
    /// [[segment]]
    /// length_m = 100.0
    ///
    /// [[segment]]
    /// radius_m = 20.0
    /// angle_deg = 180.0
    /// ```
    ///
    /// # Errors
    /// The first of everything wrong with the text or the track it describes.
    pub fn from_toml(text: &str) -> Result<Self, TrackError> {
        segments_toml::read(text).map_err(first)
    }
}

/// The first of the problems, which are never none.
fn first(problems: Vec<TrackError>) -> TrackError {
    problems.into_iter().next().unwrap_or(TrackError::TooFew {
        what: "segments",
        found: 0,
        expected: 2,
    })
}
