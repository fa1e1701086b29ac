//! Centre lines as tables of numbers: one point a line.

use super::FORMATS;
use crate::track::{ImportOptions, Imported, TrackError, TrackPoint, survey};

/// Number of columns of a TTL table.
const TTL: usize = 17;
/// Names of the centre line's columns, in the order they have without a header.
const CENTRE_LINE: [&str; 4] = ["x_m", "y_m", "w_tr_right_m", "w_tr_left_m"];

/// A number and the column of its first character, from 1.
type Cell = (f64, usize);

/// A line of numbers.
struct Row {
    line: usize,
    cells: Vec<Cell>,
}

/// The track, or everything wrong with the text.
pub(super) fn read(
    name: &str,
    text: &str,
    options: &ImportOptions,
) -> Result<Imported, Vec<TrackError>> {
    let mut problems = Vec::new();
    let mut header = None;
    let mut rows: Vec<Row> = Vec::new();
    for (line, content) in text.lines().enumerate().map(|(i, c)| (i + 1, c)) {
        // A byte order mark and a carriage return are no part of the table.
        let content = content.trim_start_matches('\u{feff}').trim_end();
        if content.trim().is_empty() {
            continue;
        }
        if let Some(comment) = content.trim_start().strip_prefix('#') {
            header = header.or_else(|| columns_of(comment));
            continue;
        }
        if rows.is_empty() && header.is_none() {
            header = columns_of(content);
            if header.is_some() {
                continue;
            }
        }
        match numbers(line, content) {
            Ok(cells) => rows.push(Row { line, cells }),
            Err(wrong) => problems.extend(wrong),
        }
    }
    let columns = match (&header, rows.first()) {
        (Some((_, columns)), _) => *columns,
        (None, Some(row)) if row.cells.len() == TTL => TTL,
        (None, _) => CENTRE_LINE.len(),
    };
    for row in rows.iter().filter(|row| row.cells.len() != columns) {
        let found = format!("{} columns", row.cells.len());
        let column = row.cells.get(columns).or(row.cells.last()).map_or(1, |cell| cell.1);
        let expected = match header {
            Some(_) => format!("{columns} columns, as the header names"),
            None if columns == TTL => format!("{TTL} columns, as in the first line"),
            None => format!("{columns} columns ({}), or {TTL} (TTL)", CENTRE_LINE.join(", ")),
        };
        problems.push(TrackError::Syntax { line: row.line, column, found, expected });
    }
    if problems.is_empty() && rows.is_empty() {
        let (found, expected) = ("no numbers".to_owned(), FORMATS.to_owned());
        problems.push(TrackError::Syntax { line: 1, column: 1, found, expected });
    }
    if !problems.is_empty() {
        problems.sort_by_key(TrackError::line_and_column);
        return Err(problems);
    }
    let points = match header {
        None if columns == TTL => ttl_points(&rows),
        _ => centre_line_points(&rows, header.map_or([0, 1, 2, 3], |(order, _)| order)),
    }?;
    let item = |i: usize| match rows.get(i) {
        Some(row) => format!("line {}: point {}", row.line, i + 1),
        None => format!("point {}", i + 1),
    };
    survey::build(name, &points, options, &item)
}

/// Where a header has the columns x, y, right and left width, and how many it has.
fn columns_of(header: &str) -> Option<([usize; 4], usize)> {
    let names: Vec<&str> =
        header.split([',', ';', ' ', '\t']).map(str::trim).filter(|n| !n.is_empty()).collect();
    let mut order = [0; 4];
    for (place, wanted) in order.iter_mut().zip(CENTRE_LINE) {
        *place = names.iter().position(|name| *name == wanted)?;
    }
    Some((order, names.len()))
}

/// The numbers of a line, separated by commas, semicolons or blanks; or what is none.
fn numbers(line: usize, content: &str) -> Result<Vec<Cell>, Vec<TrackError>> {
    let mut cells = Vec::new();
    let mut problems = Vec::new();
    let separator = [',', ';'].into_iter().find(|s| content.contains(*s));
    let mut byte = 0;
    let pieces: Vec<&str> = match separator {
        Some(separator) => content.split(separator).collect(),
        None => content.split([' ', '\t']).collect(),
    };
    for piece in pieces {
        let lead = piece.len() - piece.trim_start().len();
        let column = content.get(..byte + lead).map_or(byte, |c| c.chars().count()) + 1;
        byte += piece.len() + 1;
        let word = piece.trim();
        if word.is_empty() && separator.is_none() {
            continue;
        }
        match word.parse::<f64>() {
            Ok(value) if value.is_finite() => cells.push((value, column)),
            _ => problems.push(TrackError::Syntax {
                line,
                column,
                found: format!("`{word}`"),
                expected: "a finite number".to_owned(),
            }),
        }
    }
    if problems.is_empty() { Ok(cells) } else { Err(problems) }
}

/// Points of a centre line; `order` says where x, y, right and left width stand.
fn centre_line_points(rows: &[Row], order: [usize; 4]) -> Result<Vec<TrackPoint>, Vec<TrackError>> {
    let mut problems = Vec::new();
    let mut points = Vec::with_capacity(rows.len());
    for Row { line, cells } in rows {
        let [x, y, right, left] = order.map(|i| cells[i]);
        for (name, (width, column)) in [(CENTRE_LINE[2], right), (CENTRE_LINE[3], left)] {
            if width <= 0.0 {
                problems.push(TrackError::Syntax {
                    line: *line,
                    column,
                    found: format!("{name} of {width} m"),
                    expected: "a width above 0 m".to_owned(),
                });
            }
        }
        points.push(TrackPoint { x: x.0, y: y.0, width_left: left.0, width_right: right.0 });
    }
    if problems.is_empty() { Ok(points) } else { Err(problems) }
}

/// Points of a TTL table: x, y in the columns 1 and 2, the left edge in 10 and 11, the right
/// edge in 12 and 13. An edge point must lie on its side of the centre line.
fn ttl_points(rows: &[Row]) -> Result<Vec<TrackPoint>, Vec<TrackError>> {
    let n = rows.len();
    let mut problems = Vec::new();
    let mut points = Vec::with_capacity(n);
    for (i, Row { line, cells }) in rows.iter().enumerate() {
        let (x, y) = (cells[0].0, cells[1].0);
        let (before, after) = (&rows[(i + n - 1) % n].cells, &rows[(i + 1) % n].cells);
        let (along_x, along_y) = (after[0].0 - before[0].0, after[1].0 - before[1].0);
        let mut width = |first: usize, side: f64, name: &str| {
            let (dx, dy) = (cells[first].0 - x, cells[first + 1].0 - y);
            if side * (along_x * dy - along_y * dx) <= 0.0 {
                problems.push(TrackError::Syntax {
                    line: *line,
                    column: cells[first].1,
                    found: format!("a {name} edge point that is not {name} of the centre line"),
                    expected: format!("a point to the {name}, in the order of driving"),
                });
            }
            // Not hypot: its last bit, and with it the fingerprint, depends on the platform.
            (dx * dx + dy * dy).sqrt()
        };
        let (width_left, width_right) = (width(9, 1.0, "left"), width(11, -1.0, "right"));
        points.push(TrackPoint { x, y, width_left, width_right });
    }
    if problems.is_empty() { Ok(points) } else { Err(problems) }
}
