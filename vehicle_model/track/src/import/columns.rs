//! What the columns of a table are.

/// Number of columns of a TTL table.
const TTL: usize = 17;
/// Number of columns of a TUM raceline.
const RACELINE: usize = 7;
/// Names of the quantities that a column may hold, in lower case.
const NAMES: [(Quantity, &[&str]); 8] = [
    (Quantity::X, &["x_m", "x", "x_ref_m", "east", "easting", "east_m"]),
    (Quantity::Y, &["y_m", "y", "y_ref_m", "north", "northing", "north_m"]),
    (Quantity::Right, &["w_tr_right_m", "width_right_m", "width_right", "w_right", "right"]),
    (Quantity::Left, &["w_tr_left_m", "width_left_m", "width_left", "w_left", "left"]),
    (Quantity::Width, &["width_m", "width", "w_m", "w"]),
    (Quantity::Latitude, &["lat", "latitude", "lat_deg", "latitude_deg"]),
    (Quantity::Longitude, &["lon", "lng", "long", "longitude", "lon_deg", "longitude_deg"]),
    (Quantity::Height, &["height", "height_m", "alt", "altitude", "altitude_m", "ele", "z", "z_m"]),
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
}

impl Columns {
    /// The columns that a header names; none if it names no position.
    pub(super) fn named(header: &str) -> Option<Self> {
        let separated = header.contains([',', ';']);
        let names: Vec<String> = match separated {
            true => header.split([',', ';']).map(|n| n.trim().to_lowercase()).collect(),
            false => header.split_whitespace().map(str::to_lowercase).collect(),
        };
        let quantity = |name: &str| {
            NAMES.iter().find(|(_, known)| known.contains(&name)).map(|(quantity, _)| *quantity)
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
        Some(Self { count: names.len(), position, widths, height: at(Quantity::Height) })
    }

    /// The columns of a table of `count` columns without a header.
    pub(super) fn unnamed(count: usize) -> Self {
        let position = Position::Plane;
        let plane = |x, y, widths| Self { count, position: position(x, y), widths, height: None };
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
