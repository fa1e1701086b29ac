//! What the columns of a table are.

/// Number of columns of a TTL table.
const TTL: usize = 17;
/// Number of columns of a TUM raceline.
const RACELINE: usize = 7;
/// Units in which a column is taken as it is.
const UNITS: [&str; 10] =
    ["", "m", "meter", "meters", "metre", "metres", "deg", "degree", "degrees", "\u{b0}"];
/// Units that a column may not have.
const FOREIGN: [&str; 12] =
    ["km", "dm", "cm", "mm", "ft", "feet", "foot", "yd", "in", "mi", "rad", "gon"];
/// Names of the quantities that a column may hold, in lower case and without the unit.
const NAMES: [(Quantity, &[&str]); 8] = [
    (Quantity::X, &["x", "x_ref", "east", "easting"]),
    (Quantity::Y, &["y", "y_ref", "north", "northing"]),
    (Quantity::Right, &["w_tr_right", "width_right", "right_width", "w_right", "right"]),
    (Quantity::Left, &["w_tr_left", "width_left", "left_width", "w_left", "left"]),
    (Quantity::Width, &["width", "w"]),
    (Quantity::Latitude, &["lat", "latitude"]),
    (Quantity::Longitude, &["lon", "lng", "long", "longitude"]),
    (Quantity::Height, &["height", "alt", "altitude", "ele", "elevation", "z"]),
];

/// What a column may hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Quantity {
    X,
    Y,
    Right,
    Left,
    Width,
    Latitude,
    Longitude,
    Height,
}

/// Where a point's position stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Position {
    /// Columns of x and y.
    Plane(usize, usize),
    /// Columns of latitude and longitude.
    Globe(usize, usize),
}

/// Where a point's widths stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum WidthColumns {
    /// Columns of the right and the left width.
    Sides(usize, usize),
    /// Column of the width from edge to edge.
    Whole(usize),
    /// Columns of x and y of the left edge's point, then of the right edge's.
    Edges([usize; 2], [usize; 2]),
    /// Nowhere.
    Absent,
}

/// The columns of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Columns {
    /// How many there are.
    pub count: usize,
    /// The position.
    pub position: Position,
    /// The widths.
    pub widths: WidthColumns,
    /// Column of the height.
    pub height: Option<usize>,
    /// Column of one of these whose unit is another than metres or degrees.
    pub foreign: Option<usize>,
}

/// The words of a header or of a line of units, without quotation marks and in lower case; and whether
/// commas, semicolons or tabs separate them.
fn words(header: &str) -> (Vec<String>, bool) {
    let separators: &[char] = &[',', ';', '\t'];
    let header = header.trim().trim_end_matches(separators);
    // A blank of any kind may stand beside a comma or a semicolon.
    let separator = [';', ',', '\t'].into_iter().find(|separator| header.contains(*separator));
    let words: Vec<&str> = match separator {
        Some(separator) => header.split(separator).collect(),
        None => header.split_whitespace().collect(),
    };
    let plain = |word: &str| word.trim().trim_matches(['"', '\'']).trim().to_lowercase();
    (words.into_iter().map(plain).collect(), separator.is_some())
}

/// A name and its unit: `x [m]`, `x (m)`, `x_m` or `x`.
fn name_and_unit(word: &str) -> (String, &str) {
    let (name, unit) = match word.split_once(['[', '(']) {
        Some((name, unit)) => (name, unit.trim_end_matches([']', ')'])),
        None => match word.rsplit_once('_') {
            Some((name, unit)) if UNITS.contains(&unit) || FOREIGN.contains(&unit) => (name, unit),
            _ => (word, ""),
        },
    };
    (name.trim().trim_end_matches('_').replace([' ', '-'], "_"), unit.trim())
}

/// Whether a line below the header names the units of the columns, all of them metres or degrees.
pub(super) fn are_units(line: &str) -> bool {
    let known = |word: &String| UNITS.contains(&word.trim_matches(['[', ']', '(', ')']));
    let (words, _) = words(line);
    words.iter().any(|word| !word.is_empty()) && words.iter().all(known)
}

impl Columns {
    /// The columns that a header names; none if it names no position.
    pub(super) fn named(header: &str) -> Option<Self> {
        let (names, separated) = words(header);
        let quantity = |word: &str| {
            let (name, _) = name_and_unit(word);
            NAMES.iter().find(|(_, known)| known.contains(&name.as_str())).map(|(what, _)| *what)
        };
        // A sentence may have the word `x` in it.
        if !separated && names.iter().any(|name| quantity(name).is_none()) {
            return None;
        }
        let at = |wanted| names.iter().position(|name| quantity(name) == Some(wanted));
        let globe = || {
            let (lat, lon) = (at(Quantity::Latitude)?, at(Quantity::Longitude)?);
            Some(Position::Globe(lat, lon))
        };
        let plane = || Some(Position::Plane(at(Quantity::X)?, at(Quantity::Y)?));
        let position = plane().or_else(globe)?;
        let widths = match (at(Quantity::Right), at(Quantity::Left), at(Quantity::Width)) {
            (Some(right), Some(left), _) => WidthColumns::Sides(right, left),
            (_, _, Some(width)) => WidthColumns::Whole(width),
            _ => WidthColumns::Absent,
        };
        let foreign = names
            .iter()
            .position(|word| quantity(word).is_some() && FOREIGN.contains(&name_and_unit(word).1));
        Some(Self { count: names.len(), position, widths, height: at(Quantity::Height), foreign })
    }

    /// The columns of a table of `count` columns without a header.
    pub(super) fn unnamed(count: usize) -> Self {
        let position = Position::Plane;
        let plane = |x, y, widths| {
            let position = position(x, y);
            Self { count, position, widths, height: None, foreign: None }
        };
        match count {
            2 => plane(0, 1, WidthColumns::Absent),
            RACELINE => plane(1, 2, WidthColumns::Absent),
            TTL => {
                let height = Some(2);
                Self { height, ..plane(0, 1, WidthColumns::Edges([9, 10], [11, 12])) }
            }
            _ => Self { count: 4, ..plane(0, 1, WidthColumns::Sides(2, 3)) },
        }
    }

    /// What a line without this many columns should have had.
    pub(super) fn expected(&self, named: bool) -> String {
        match (named, self.count) {
            (true, count) => format!("{count} columns, as the header names"),
            (false, 4) => format!(
                "4 columns (x_m, y_m, w_tr_right_m, w_tr_left_m), 2 (x, y), {RACELINE} (TUM \
                 raceline) or {TTL} (TTL); a header line can name others"
            ),
            (false, count) => format!("{count} columns, as in the first line"),
        }
    }
}
