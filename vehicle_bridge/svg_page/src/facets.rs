//! Small multiples: the same two axes in every panel, in each panel lines of medians with their range,
//! and above them a row of failures a line. Lines differ in colour, dashes and the shape of their
//! marks, so that they read without colour.

use std::fmt::Write as _;

use super::escape;
use super::marks::{failures, mark};
use super::scale::{Scale, ScaleKind};

const LEFT: f64 = 76.0;
const RIGHT: f64 = 14.0;
const BOTTOM: f64 = 46.0;
/// Height of the panel's title.
const TITLE: f64 = 20.0;
/// Height of a row of failures.
const ROW: f64 = 15.0;
/// Between a panel and the one on its right.
const GAP: f64 = 18.0;
/// Pixels between the whiskers of two lines at the same place.
const ASIDE: f64 = 8.0;
/// Room of a character of a tick, about.
const CHARACTER: f64 = 7.5;
/// Dashes of the lines in turn.
const DASHES: [&str; 6] = ["none", "7 4", "2 4", "10 4 2 4", "none", "7 4"];

/// What came of the runs at one place.
#[derive(Debug, Clone, PartialEq)]
pub struct Spot {
    /// Place on the axis to the right.
    pub x: f64,
    /// Median or share; none if no run has a value.
    pub middle: Option<f64>,
    /// Least and greatest value, or the interval of a share.
    pub range: Option<(f64, f64)>,
    /// Runs that failed here.
    pub failed: usize,
    /// Shown when the mouse rests on it.
    pub title: String,
}

/// One line of a panel.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Line {
    /// What came of the runs, along the axis.
    pub spots: Vec<Spot>,
    /// Single runs behind the line.
    pub dots: Vec<(f64, f64)>,
    /// Places of failures that belong to no spot.
    pub failures: Vec<f64>,
}

/// One panel.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Facet {
    /// Heading; empty for a figure with one panel.
    pub title: String,
    /// A line for each of [`Facets::names`], perhaps empty.
    pub lines: Vec<Line>,
}

/// Panels with common axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Facets {
    /// Label of the axis to the right, with unit.
    pub x_label: String,
    /// Label of the axis upwards, with unit.
    pub y_label: String,
    /// Division of the axis to the right.
    pub x_kind: ScaleKind,
    /// Division of the axis upwards.
    pub y_kind: ScaleKind,
    /// Marked places of the axis to the right; empty for round numbers.
    pub x_ticks: Vec<(f64, String)>,
    /// Ends of the axis upwards; by default around the points.
    pub y_range: Option<(f64, f64)>,
    /// Whether ranges are bands; otherwise whiskers, and failures have their count.
    pub bands: bool,
    /// Whether marks are joined; words on the axis have nothing between them.
    pub joined: bool,
    /// What the names of the lines are values of; may be empty.
    pub names_of: String,
    /// Names of the lines; without lines to tell apart one empty name.
    pub names: Vec<String>,
    /// Panels side by side.
    pub across: usize,
    /// The panels, row by row.
    pub facets: Vec<Facet>,
}

/// Where things are in a panel.
pub(crate) struct Frame {
    left: f64,
    top: f64,
    width: f64,
    height: f64,
    x: Scale,
    y: Scale,
}

impl Frame {
    pub(crate) fn x(&self, value: f64) -> f64 {
        self.left + self.width * self.x.part(value)
    }

    fn y(&self, value: f64) -> f64 {
        self.top + self.height * (1.0 - self.y.part(value).clamp(0.0, 1.0))
    }
}

impl Facets {
    /// The drawing as an `svg` element.
    #[must_use]
    pub fn svg(&self) -> String {
        let across = self.across.clamp(1, self.facets.len().max(1));
        let down = self.facets.len().div_ceil(across);
        let total: f64 = if across == 1 { 720.0 } else { 1180.0 };
        let width = (total - LEFT - RIGHT - GAP * (across - 1) as f64) / across as f64;
        let height = if down == 1 { 230.0 } else { 160.0 };
        let rows = ROW * self.rows().len() as f64;
        let title = if self.facets.iter().any(|f| !f.title.is_empty()) { TITLE } else { 6.0 };
        let step = title + rows + height + 14.0;
        let whole = step * down as f64 + BOTTOM;
        let (x, y) = self.scales();
        let mut out = format!(
            "<svg class=\"chart facets\" viewBox=\"0 0 {total} {whole}\" role=\"img\" \
             aria-label=\"{} over {}\">\n",
            escape(&self.y_label),
            escape(&self.x_label)
        );
        for (i, facet) in self.facets.iter().enumerate() {
            let (column, row) = (i % across, i / across);
            let frame = Frame {
                left: LEFT + (width + GAP) * column as f64,
                top: step * row as f64 + title + rows,
                width,
                height,
                x,
                y,
            };
            let lowest = i + across >= self.facets.len();
            self.axes(&frame, column == 0, lowest, &mut out);
            if column == 0 && rows > 0.0 {
                let (x, y) = (LEFT - 7.0, frame.top - rows + 10.0);
                let _ = write!(
                    out,
                    "<text class=\"count\" x=\"{x}\" y=\"{y:.1}\" text-anchor=\"end\">failed</text>"
                );
            }
            self.panel(&frame, facet, &mut out);
        }
        let low = step * down as f64;
        let _ = writeln!(
            out,
            "<text class=\"label\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>\
             <text class=\"label\" transform=\"translate(13 {:.1}) rotate(-90)\" \
             text-anchor=\"middle\">{}</text>\n</svg>",
            f64::midpoint(LEFT, total - RIGHT),
            low + 28.0,
            escape(&self.x_label),
            f64::midpoint(title + rows, low),
            escape(&self.y_label)
        );
        out
    }

    /// The names of the lines with their marks; empty if there is one line.
    #[must_use]
    pub fn legend(&self) -> String {
        if self.names.len() < 2 {
            return String::new();
        }
        let entry = |(i, name): (usize, &String)| {
            format!(
                "<span><svg viewBox=\"0 0 26 10\"><path class=\"line s{0}\" \
                 stroke-dasharray=\"{1}\" d=\"M1 5H25\"/>{2}</svg>{3}</span>",
                i % 6,
                DASHES[i % 6],
                mark(i, 13.0, 5.0),
                escape(name)
            )
        };
        let all: String = self.names.iter().enumerate().map(entry).collect();
        let of = if self.names_of.is_empty() {
            String::new()
        } else {
            format!("<b>{}</b>", escape(&self.names_of))
        };
        format!("<div class=\"legend\">{of}{all}</div>\n")
    }

    /// Numbers of the lines of which some run failed.
    fn rows(&self) -> Vec<usize> {
        let fails =
            |line: &Line| !line.failures.is_empty() || line.spots.iter().any(|s| s.failed > 0);
        let any = |i: &usize| self.facets.iter().filter_map(|f| f.lines.get(*i)).any(fails);
        (0..self.names.len()).filter(any).collect()
    }

    fn scales(&self) -> (Scale, Scale) {
        let lines = || self.facets.iter().flat_map(|facet| &facet.lines);
        let spots = || lines().flat_map(|line| &line.spots);
        let dots = || lines().flat_map(|line| &line.dots);
        let failures = lines().flat_map(|line| line.failures.iter().copied());
        let ticks = self.x_ticks.iter().map(|tick| tick.0);
        let xs = spots().map(|s| s.x).chain(dots().map(|d| d.0)).chain(failures).chain(ticks);
        let x = Scale::around(self.x_kind, xs);
        let ends = spots().filter_map(|s| s.range).flat_map(|(low, high)| [low, high]);
        let ys = ends.chain(spots().filter_map(|s| s.middle)).chain(dots().map(|d| d.1));
        let y = match self.y_range {
            Some((least, most)) => Scale::exactly(least, most),
            None => Scale::around(self.y_kind, ys),
        };
        (x, y)
    }

    fn axes(&self, frame: &Frame, first: bool, lowest: bool, out: &mut String) {
        let (right, low) = (frame.left + frame.width, frame.top + frame.height);
        for (value, label) in frame.y.ticks(5) {
            let y = frame.y(value);
            let _ = write!(
                out,
                "<line class=\"grid\" x1=\"{:.1}\" x2=\"{right:.1}\" y1=\"{y:.1}\" y2=\"{y:.1}\"/>",
                frame.left
            );
            if first {
                let _ = write!(
                    out,
                    "<text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
                    frame.left - 7.0,
                    y + 4.0
                );
            }
        }
        let ticks = if self.x_ticks.is_empty() {
            frame.x.ticks((frame.width / 70.0) as usize)
        } else {
            self.x_ticks.clone()
        };
        let mut free = f64::NEG_INFINITY;
        for (value, label) in ticks {
            let (x, half) = (frame.x(value), 0.5 * CHARACTER * label.chars().count() as f64);
            let _ = write!(
                out,
                "<line class=\"grid\" x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"{:.1}\" y2=\"{low:.1}\"/>",
                frame.top
            );
            // A label that would lie on the one before is left out.
            if lowest && x - half > free {
                free = x + half;
                let _ = write!(
                    out,
                    "<text class=\"tick\" x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
                    low + 16.0,
                    escape(&label)
                );
            }
        }
        out.push('\n');
    }

    fn draw(&self, line: &Line, i: usize, frame: &Frame, aside: f64, out: &mut String) {
        let class = format!("s{}", i % 6);
        for (x, y) in &line.dots {
            let (x, y) = (frame.x(*x), frame.y(*y));
            let _ = write!(
                out,
                "<circle class=\"dot faint {class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2\"/>"
            );
        }
        let ranged = || line.spots.iter().filter_map(|s| s.range.map(|range| (s.x, range)));
        if self.bands {
            let above = ranged().map(|(x, (_, high))| (frame.x(x), frame.y(high)));
            let below: Vec<_> = ranged().map(|(x, (low, _))| (frame.x(x), frame.y(low))).collect();
            let d = super::path(above.chain(below.into_iter().rev()), 1);
            let _ = write!(out, "<path class=\"band {class}\" d=\"{d}Z\"/>");
        }
        let at =
            |spot: &Spot| (frame.x(spot.x) + aside, spot.middle.map_or(f64::NAN, |m| frame.y(m)));
        if self.joined {
            let d = super::path(line.spots.iter().map(at), 1);
            let _ = write!(
                out,
                "<path class=\"line {class}\" stroke-dasharray=\"{}\" d=\"{d}\"/>",
                DASHES[i % 6]
            );
        }
        for spot in line.spots.iter().filter(|spot| spot.middle.is_some()) {
            let (x, y) = at(spot);
            let _ = write!(out, "<g><title>{}</title>", escape(&spot.title));
            if let Some((low, high)) = spot.range.filter(|_| !self.bands) {
                let (low, high) = (frame.y(low), frame.y(high));
                let _ = write!(
                    out,
                    "<path class=\"whisker {class}\" d=\"M{0:.1} {low:.1}H{1:.1}M{x:.1} {low:.1}\
                 V{high:.1}M{0:.1} {high:.1}H{1:.1}\"/>",
                    x - 3.0,
                    x + 3.0
                );
            }
            let _ = write!(out, "{}</g>", mark(i, x, y));
        }
    }

    fn panel(&self, frame: &Frame, facet: &Facet, out: &mut String) {
        let rows = self.rows();
        if !facet.title.is_empty() {
            let _ = writeln!(
                out,
                "<text class=\"label\" x=\"{:.1}\" y=\"{:.1}\">{}</text>",
                frame.left,
                frame.top - ROW * rows.len() as f64 - 6.0,
                escape(&facet.title)
            );
        }
        for (i, line) in facet.lines.iter().enumerate() {
            let middle = 0.5 * (facet.lines.len().saturating_sub(1)) as f64;
            let many = self.bands;
            let aside = if many { 0.0 } else { ASIDE * (i as f64 - middle) };
            let _ = write!(out, "<g class=\"series\">");
            self.draw(line, i, frame, aside, out);
            if let Some(row) = rows.iter().position(|r| *r == i) {
                let y = frame.top - ROW * (rows.len() - row) as f64 + 10.0;
                failures(line, i, frame, (aside, y), many, out);
            }
            out.push_str("</g>\n");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spot(x: f64, middle: f64, failed: usize) -> Spot {
        let range = Some((middle - 1.0, middle + 1.0));
        Spot { x, middle: Some(middle), range, failed, title: "a < b".into() }
    }

    fn two(lines: usize) -> Facets {
        let line = |i: usize| Line {
            spots: vec![spot(1.0, 5.0, 0), spot(2.0, 6.0 + i as f64, 3 * i)],
            ..Line::default()
        };
        let facet =
            |title: &str| Facet { title: title.into(), lines: (0..lines).map(line).collect() };
        Facets {
            x_label: "grip [-]".into(),
            y_label: "best lap [s]".into(),
            x_kind: ScaleKind::Linear,
            y_kind: ScaleKind::Linear,
            x_ticks: Vec::new(),
            y_range: None,
            bands: false,
            joined: true,
            names_of: String::new(),
            names: (0..lines).map(|i| format!("line {i}")).collect(),
            across: 2,
            facets: vec![facet("one"), facet("two")],
        }
    }

    #[test]
    fn panels_share_their_scales() {
        let svg = two(1).svg();
        let heights: Vec<&str> = svg
            .split("class=\"line s0\"")
            .skip(1)
            .map(|part| part.split('"').nth(3).unwrap())
            .collect();
        let y =
            |d: &str| d.split(['M', 'L', ' ']).filter_map(|n| n.parse().ok()).collect::<Vec<f64>>();
        let (one, two) = (y(heights[0]), y(heights[1]));
        assert_eq!((one[1], one[3]), (two[1], two[3]));
        assert!(one[0] < two[0] && one[1] > one[3], "{one:?}");
        assert!(svg.contains("a &lt; b"));
    }

    #[test]
    fn failures_have_a_row_with_their_number() {
        assert!(!two(1).svg().contains("class=\"cross"));
        let svg = two(2).svg();
        assert_eq!(svg.matches("class=\"cross s1\"").count(), 2);
        assert_eq!(svg.matches(">3</text>").count(), 2);
        assert!(two(1).legend().is_empty() && two(2).legend().contains("line 1"));
    }
}
