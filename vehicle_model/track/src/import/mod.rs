//! Readers of track files. They take text and give a track or everything wrong with the text.

mod columns;
mod geojson;
mod globe;
mod points_toml;
mod segments_toml;
mod stations_toml;
mod table;

use super::{ImportOptions, Imported, Track, TrackError};

/// File formats, for messages.
const FORMATS: &str = "a track: segments or points in TOML, a comma-separated centre line \
     (x_m, y_m, w_tr_right_m, w_tr_left_m; lat, lon; x, y), a TUM raceline, a TTL table of 17 \
     columns, or GeoJSON";

/// Binary data show within this many characters.
const LOOK: usize = 1000;

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
    /// In place of widths and segments the file may hold points of the centre line, as `lmpc track
    /// convert` writes them: `point = [ { x_m = .., y_m = .., width_left_m = .., width_right_m
    /// = .. }, .. ]`, with `smooth_m` for the smoothing of [`ImportOptions`].
    ///
    /// Either may have places along s, see [`Station`](super::Station):
    /// `[[station]]` with `s_m` and any of `bank_deg`, `slope_deg`, `friction` and
    /// `speed_limit_mps` (`"none"` ends a limit).
    ///
    /// # Errors
    /// The first of everything wrong with the text or the track it describes.
    pub fn from_toml(text: &str) -> Result<Self, TrackError> {
        segments_toml::read(text, &ImportOptions::default())
            .map(|imported| imported.track)
            .map_err(first)
    }

    /// The track of a file's text, in any of the formats known, told apart by their content:
    /// - segments in TOML, see [`Track::from_toml`];
    /// - the centre lines of the TUMFTM race track database and of F1TENTH: columns x, y, right
    ///   width, left width, separated by commas, after a `#` line that names them;
    /// - the same with other columns that a header names: `x, y` without widths, `lat, lon` and
    ///   perhaps `height`, which are projected to the plane that touches the globe there;
    /// - the racelines of TUMFTM, of 7 columns;
    /// - the 17-column TTL tables of the paper's authors, whose edge points give the widths;
    /// - a line of GeoJSON.
    ///
    /// Points are smoothed as their noise asks for, see [`Track::import`]; segments are exact.
    /// The file's name gives the track its name where the text does not.
    ///
    /// # Errors
    /// The first of everything wrong with the text or the track it describes.
    pub fn parse(file_name: &str, text: &str) -> Result<Self, TrackError> {
        Self::import(file_name, text, &ImportOptions::default())
            .map(|imported| imported.track)
            .map_err(first)
    }

    /// [`Track::parse`] with a say in how points become a track, and with the list of what was
    /// changed. A width larger than 0.85 of the radius on the inner side of a bend is cut to it,
    /// however the points are smoothed.
    ///
    /// # Errors
    /// Everything wrong with the text or the track it describes.
    pub fn import(
        file_name: &str,
        text: &str,
        options: &ImportOptions,
    ) -> Result<Imported, Vec<TrackError>> {
        read(file_name, text, options)
    }

    /// Everything that is wrong with a track file; nothing if [`Track::parse`] takes it.
    #[must_use]
    pub fn check(file_name: &str, text: &str) -> Vec<TrackError> {
        read(file_name, text, &ImportOptions::default()).err().unwrap_or_default()
    }
}

/// The track, or everything wrong with the text.
fn read(file_name: &str, text: &str, options: &ImportOptions) -> Result<Imported, Vec<TrackError>> {
    let base = file_name.rsplit(['/', '\\']).next().unwrap_or(file_name);
    let stem = base.rsplit_once('.').map_or(base, |(stem, _)| stem);
    let text = text.trim_start_matches('\u{feff}');
    // Lines may end in carriage returns alone.
    let lines = (!text.contains('\n')).then(|| text.replace('\r', "\n"));
    let text = lines.as_deref().unwrap_or(text);
    if let Some(found) = no_table(text) {
        let (found, expected) = (found.to_owned(), FORMATS.to_owned());
        return Err(vec![TrackError::Syntax { line: 1, column: 1, found, expected }]);
    }
    if text.trim_start().starts_with('{') {
        return geojson::read(stem, text, options);
    }
    let looks_like_toml = |line: &str| {
        let line = line.trim_start();
        !line.starts_with('#') && (line.starts_with("[[") || line.contains('='))
    };
    if text.lines().any(looks_like_toml) {
        return segments_toml::read(text, options);
    }
    table::read(stem, text, options)
}

/// What a text is that holds neither lines of numbers nor keys.
fn no_table(text: &str) -> Option<&'static str> {
    if text.trim_start().starts_with('<') {
        return Some("XML or HTML, as of GPX or KML");
    }
    let strange = |c: char| c.is_control() && !c.is_whitespace();
    text.chars().take(LOOK).any(strange).then_some("binary data")
}

/// The first of the problems, which are never none.
pub(super) fn first(problems: Vec<TrackError>) -> TrackError {
    problems.into_iter().next().unwrap_or(TrackError::TooFew {
        what: "segments",
        found: 0,
        expected: 2,
    })
}
