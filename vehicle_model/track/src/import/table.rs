//! Centre lines as tables of numbers: one point a line.

use super::FORMATS;
use super::columns::{Columns, Position, WidthColumns, are_units};
use super::globe::{self, Fix};
use crate::{ImportOptions, Imported, TrackError, TrackPoint, hills, survey};

/// A number and the column of its first character, from 1.
type Cell = (f64, usize);

/// More wrong widths than this have one cause.
const MOST_PROBLEMS: usize = 5;

/// More columns than this have no table.
const MOST_COLUMNS: usize = 1000;
/// Characters of a word that a message repeats.
const WORD: usize = 32;

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
        // A carriage return is no part of the table.
        let content = content.trim_end();
        if content.trim().is_empty() {
            continue;
        }
        if let Some(comment) = content.trim_start().strip_prefix('#') {
            header = header.or_else(|| Columns::named(comment));
            continue;
        }
        if rows.is_empty() && header.is_none() {
            header = Columns::named(content);
            if header.is_some() {
                continue;
            }
            let separator = separator(content).unwrap_or(' ');
            if cells(content).all(|(_, word)| number(word, separator).is_none()) {
                return Err(vec![no_header(line, content)]);
            }
        }
        if rows.is_empty() && header.is_some() && are_units(content) {
            continue;
        }
        match numbers(line, content) {
            Ok(cells) => rows.push(Row { line, cells }),
            Err(wrong) => problems.extend(wrong),
        }
    }
    let columns =
        header.unwrap_or_else(|| Columns::unnamed(rows.first().map_or(0, |row| row.cells.len())));
    if let Some(column) = columns.foreign {
        let found = format!("a header whose column {} is not in metres or degrees", column + 1);
        let expected = "x, y, heights and widths in m, latitude and longitude in deg".to_owned();
        return Err(vec![TrackError::Syntax { line: 1, column: 1, found, expected }]);
    }
    let odd: Vec<&Row> = rows.iter().filter(|row| row.cells.len() != columns.count).collect();
    for (i, row) in odd.iter().enumerate() {
        let more = odd.len() - i - 1;
        let mut found = format!("{} columns", row.cells.len());
        let many = more >= MOST_PROBLEMS && i == 0;
        if many {
            found = format!("{found}, and {more} more lines with a wrong number");
        }
        let column = row.cells.get(columns.count).or(row.cells.last()).map_or(1, |cell| cell.1);
        let expected = columns.expected(header.is_some());
        problems.push(TrackError::Syntax { line: row.line, column, found, expected });
        if many {
            break;
        }
    }
    if problems.is_empty() && rows.is_empty() {
        let (found, expected) = ("no numbers".to_owned(), FORMATS.to_owned());
        problems.push(TrackError::Syntax { line: 1, column: 1, found, expected });
    }
    if !problems.is_empty() {
        problems.sort_by_key(TrackError::line_and_column);
        return Err(problems);
    }
    let cell = |row: &Row, i: usize| row.cells[i].0;
    let (places, origin) = match columns.position {
        Position::Plane(x, y) => (rows.iter().map(|r| (cell(r, x), cell(r, y))).collect(), None),
        Position::Globe(lat, lon) => {
            let fixes: Vec<Fix> = rows
                .iter()
                .map(|r| Fix {
                    latitude: cell(r, lat),
                    longitude: cell(r, lon),
                    height: columns.height.map_or(0.0, |h| cell(r, h)),
                })
                .collect();
            let line = |i: usize| format!("line {}: point {}", rows[i].line, i + 1);
            let (places, origin) = globe::project(&fixes, &line)?;
            (places, Some(origin))
        }
    };
    let points = with_widths(&rows, &places, columns.widths, options.half_width)?;
    let item = |i: usize| match rows.get(i) {
        Some(row) => format!("line {}: point {}", row.line, i + 1),
        None => format!("point {}", i + 1),
    };
    let imported = survey::build(name, &points, options, &item)?;
    let heights = columns.height.map(|column| rows.iter().map(|row| cell(row, column)).collect());
    hills::with_heights(Imported { origin, ..imported }, heights)
}

/// The character that separates the columns of a line; none if blanks do.
fn separator(content: &str) -> Option<char> {
    let found = [';', ','].into_iter().find(|s| content.contains(*s));
    found.filter(|s| *s == ';' || !blanks_separate(content))
}

/// Whether the commas of a line are decimal points of numbers that blanks separate.
fn blanks_separate(content: &str) -> bool {
    let mut words = content.split_whitespace();
    words.clone().nth(1).is_some()
        && words.all(|word| !word.ends_with(',') && number(word, ' ').is_some())
}

/// The words of a line, separated by semicolons, commas or blanks, each with the byte where it begins.
/// Separators at the end of the line close it.
fn cells(content: &str) -> impl Iterator<Item = (usize, &str)> {
    let separator = separator(content);
    let closed = content.trim_end_matches(|c| separator == Some(c) || c == ' ' || c == '\t');
    let mut byte = 0;
    closed
        .split(move |c| match separator {
            Some(separator) => c == separator,
            None => c == ' ' || c == '\t',
        })
        .map(move |piece| {
            let begin = byte + piece.len() - piece.trim_start().len();
            byte += piece.len() + 1;
            (begin, piece.trim().trim_matches('"').trim())
        })
        .filter(move |(_, word)| separator.is_some() || !word.is_empty())
}

/// The number of a word. Where semicolons or blanks separate, a comma is a decimal point.
fn number(word: &str, separator: char) -> Option<f64> {
    let value = match separator {
        ';' | ' ' if !word.contains('.') => word.replacen(',', ".", 1).parse::<f64>(),
        _ => word.parse(),
    };
    value.ok()
}

/// A word as a message repeats it.
fn shown(word: &str) -> String {
    match word.char_indices().nth(WORD) {
        Some((end, _)) => format!("`{}..`", word.get(..end).unwrap_or_default()),
        None => format!("`{word}`"),
    }
}

/// A first line of words that names no position.
fn no_header(line: usize, content: &str) -> TrackError {
    let mut names = cells(content);
    let found: Vec<String> = names.by_ref().take(6).map(|(_, word)| shown(word)).collect();
    let more = if names.next().is_some() { ", .." } else { "" };
    let found = format!(
        "neither numbers nor columns x and y, or lat and lon, in {}{more}",
        found.join(", ")
    );
    TrackError::Syntax { line, column: 1, found, expected: FORMATS.to_owned() }
}

/// The numbers of a line, separated by commas, semicolons or blanks; or what is none.
fn numbers(line: usize, content: &str) -> Result<Vec<Cell>, Vec<TrackError>> {
    let separator = separator(content).unwrap_or(' ');
    let mut found = Vec::new();
    let mut problems = Vec::new();
    for (i, (begin, word)) in cells(content).enumerate() {
        if i == MOST_COLUMNS {
            let found = format!("more than {MOST_COLUMNS} columns");
            let expected = "one point a line".to_owned();
            return Err(vec![TrackError::Syntax { line, column: 1, found, expected }]);
        }
        let column = content.get(..begin).map_or(begin, |c| c.chars().count()) + 1;
        match number(word, separator).filter(|value| value.is_finite()) {
            Some(value) => found.push((value, column)),
            None => problems.push(TrackError::Syntax {
                line,
                column,
                found: shown(word),
                expected: "a finite number".to_owned(),
            }),
        }
    }
    if problems.is_empty() { Ok(found) } else { Err(problems) }
}

/// The places with their widths; the edge point of a TTL table must lie on its side of the line.
fn with_widths(
    rows: &[Row],
    places: &[(f64, f64)],
    columns: WidthColumns,
    half_width: Option<f64>,
) -> Result<Vec<TrackPoint>, Vec<TrackError>> {
    let n = rows.len();
    let mut problems = Vec::new();
    let mut points = Vec::with_capacity(n);
    for (i, (row, &(x, y))) in rows.iter().zip(places).enumerate() {
        let mut positive = |name: &str, column: usize| {
            let (width, column) = row.cells[column];
            if width <= 0.0 {
                problems.push(TrackError::Syntax {
                    line: row.line,
                    column,
                    found: format!("{name} of {width} m"),
                    expected: "a width above 0 m".to_owned(),
                });
            }
            width
        };
        let (width_left, width_right) = match columns {
            WidthColumns::Sides(right, left) => {
                let right = positive("w_tr_right_m", right);
                (positive("w_tr_left_m", left), right)
            }
            WidthColumns::Whole(width) => {
                let half = 0.5 * positive("width", width);
                (half, half)
            }
            WidthColumns::Edges(left, right) => {
                let (before, after) = (places[(i + n - 1) % n], places[(i + 1) % n]);
                let (along_x, along_y) = (after.0 - before.0, after.1 - before.1);
                let mut width = |[x_at, y_at]: [usize; 2], side: f64, name: &str| {
                    let (dx, dy) = (row.cells[x_at].0 - x, row.cells[y_at].0 - y);
                    if side * (along_x * dy - along_y * dx) <= 0.0 {
                        problems.push(TrackError::Syntax {
                            line: row.line,
                            column: row.cells[x_at].1,
                            found: format!(
                                "a {name} edge point that is not {name} of the centre line"
                            ),
                            expected: format!("a point to the {name}, in the order of driving"),
                        });
                    }
                    // Not hypot: its last bit, and with it the fingerprint, depends on the platform.
                    (dx * dx + dy * dy).sqrt()
                };
                (width(left, 1.0, "left"), width(right, -1.0, "right"))
            }
            WidthColumns::Absent => match half_width {
                Some(half) => (half, half),
                None => return Err(vec![TrackError::NoWidth { line: row.line }]),
            },
        };
        points.push(TrackPoint { x, y, width_left, width_right });
    }
    if problems.len() > MOST_PROBLEMS
        && let Some(TrackError::Syntax { line, column, found, expected }) = problems.first()
    {
        let (line, column) = (*line, *column);
        let found = format!("{found}, and {} more like it", problems.len() - 1);
        let expected = format!("{expected}; check the order of the columns");
        return Err(vec![TrackError::Syntax { line, column, found, expected }]);
    }
    if problems.is_empty() { Ok(points) } else { Err(problems) }
}
