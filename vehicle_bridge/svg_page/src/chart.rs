//! Line charts as SVG. Colours and dashes come from the page's style sheet by class, so that one
//! drawing serves light, dark and paper.

use std::fmt::Write as _;

use super::escape;
use super::scale::{Scale, ScaleKind};

const WIDTH: f64 = 720.0;
const LEFT: f64 = 74.0;
const RIGHT: f64 = 16.0;
const TOP: f64 = 12.0;
const BOTTOM: f64 = 44.0;

/// How the points of a series are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// Joined by a line.
    Line,
    /// Dots joined by a line.
    DotLine,
    /// Dots alone.
    Dots,
    /// Bars from the lower edge.
    Bars,
}

/// Points of one kind.
#[derive(Debug, Clone)]
pub struct Series {
    /// Name in the legend; without one it has no entry there.
    pub label: Option<String>,
    /// Classes of the style sheet.
    pub class: String,
    /// Shown when the mouse rests on it.
    pub title: String,
    /// Lap that it belongs to, for the lap chooser.
    pub lap: Option<u32>,
    /// How it is drawn.
    pub mark: Mark,
    /// The points; a gap is left where one is not finite.
    pub points: Vec<(f64, f64)>,
}

impl Series {
    /// A named series.
    #[must_use]
    pub fn new(label: &str, class: &str, mark: Mark, points: Vec<(f64, f64)>) -> Self {
        let label = label.to_owned();
        Self {
            title: label.clone(),
            label: Some(label),
            class: class.into(),
            lap: None,
            mark,
            points,
        }
    }
}

/// A horizontal line at a known value.
#[derive(Debug, Clone)]
pub struct ReferenceLine {
    /// The value.
    pub y: f64,
    /// What it is.
    pub label: String,
}

/// A chart.
#[derive(Debug, Clone)]
pub struct Chart {
    /// Label of the axis to the right, with unit.
    pub x_label: String,
    /// Label of the axis upwards, with unit.
    pub y_label: String,
    /// Division of the axis upwards.
    pub y_kind: ScaleKind,
    /// Ends of the axis upwards; by default around the points.
    pub y_range: Option<(f64, f64)>,
    /// Ends of the axis to the right; by default around the points.
    pub x_range: Option<(f64, f64)>,
    /// Whether only whole numbers stand on the axis to the right.
    pub x_whole: bool,
    /// Height in pixels.
    pub height: f64,
    /// What it shows.
    pub series: Vec<Series>,
    /// Known values.
    pub references: Vec<ReferenceLine>,
}

impl Chart {
    /// An empty chart.
    #[must_use]
    pub fn new(x_label: &str, y_label: &str) -> Self {
        Self {
            x_label: x_label.into(),
            y_label: y_label.into(),
            y_kind: ScaleKind::Linear,
            y_range: None,
            x_range: None,
            x_whole: false,
            height: 260.0,
            series: Vec::new(),
            references: Vec::new(),
        }
    }

    /// The chart as an `svg` element followed by its legend.
    #[must_use]
    pub fn html(&self) -> String {
        let frame = self.frame();
        let mut out = format!(
            "<svg class=\"chart\" viewBox=\"0 0 {WIDTH} {}\" role=\"img\" aria-label=\"{} over {}\">\n",
            self.height,
            escape(&self.y_label),
            escape(&self.x_label)
        );
        self.axes(&frame, &mut out);
        for reference in &self.references {
            let y = frame.y(reference.y);
            let _ = writeln!(
                out,
                "<line class=\"reference\" x1=\"{LEFT}\" x2=\"{}\" y1=\"{y:.1}\" y2=\"{y:.1}\"/>\
                 <text class=\"reference\" x=\"{}\" y=\"{:.1}\">{}</text>",
                WIDTH - RIGHT,
                LEFT + 4.0,
                y - 4.0,
                escape(&reference.label)
            );
        }
        for series in &self.series {
            draw(series, &frame, &mut out);
        }
        out.push_str("</svg>\n");
        self.legend(&mut out);
        out
    }

    fn frame(&self) -> Frame {
        let points = || self.series.iter().flat_map(|s| &s.points);
        let x = match self.x_range {
            Some((least, most)) => Scale::exactly(least, most),
            None => Scale::around(ScaleKind::Linear, points().map(|p| p.0)),
        };
        let references = self.references.iter().map(|r| r.y);
        let y = match self.y_range {
            Some((least, most)) => Scale::exactly(least, most),
            None => Scale::around(self.y_kind, points().map(|p| p.1).chain(references)),
        };
        Frame { x, y, height: self.height }
    }

    fn axes(&self, frame: &Frame, out: &mut String) {
        let (right, low) = (WIDTH - RIGHT, self.height - BOTTOM);
        for (value, label) in frame.y.ticks(5) {
            let y = frame.y(value);
            let _ = writeln!(
                out,
                "<line class=\"grid\" x1=\"{LEFT}\" x2=\"{right}\" y1=\"{y:.1}\" y2=\"{y:.1}\"/>\
                 <text class=\"tick\" x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
                LEFT - 8.0,
                y + 4.0
            );
        }
        for (value, label) in self.x_ticks(frame) {
            let x = frame.x(value);
            let _ = writeln!(
                out,
                "<line class=\"grid\" x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"{TOP}\" y2=\"{low}\"/>\
                 <text class=\"tick\" x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{label}</text>",
                low + 18.0
            );
        }
        let _ = writeln!(
            out,
            "<text class=\"label\" x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\
             <text class=\"label\" transform=\"translate(13 {}) rotate(-90)\" \
             text-anchor=\"middle\">{}</text>",
            f64::midpoint(LEFT, right),
            self.height - 8.0,
            escape(&self.x_label),
            f64::midpoint(TOP, low),
            escape(&self.y_label)
        );
    }

    fn x_ticks(&self, frame: &Frame) -> Vec<(f64, String)> {
        let ticks = frame.x.ticks(10);
        if !self.x_whole {
            return ticks;
        }
        let whole = ticks.into_iter().filter(|(value, _)| value.fract() == 0.0);
        whole.map(|(value, _)| (value, format!("{value:.0}"))).collect()
    }

    fn legend(&self, out: &mut String) {
        let named: Vec<&Series> = self.series.iter().filter(|s| s.label.is_some()).collect();
        if named.len() < 2 {
            return;
        }
        out.push_str("<div class=\"legend\">");
        for series in named {
            let _ = write!(
                out,
                "<span><svg viewBox=\"0 0 26 10\"><path class=\"line {}\" d=\"M1 5H25\"/></svg>{}</span>",
                series.class,
                escape(series.label.as_deref().unwrap_or_default())
            );
        }
        out.push_str("</div>\n");
    }
}

struct Frame {
    x: Scale,
    y: Scale,
    height: f64,
}

impl Frame {
    fn x(&self, value: f64) -> f64 {
        LEFT + (WIDTH - LEFT - RIGHT) * self.x.part(value)
    }

    fn y(&self, value: f64) -> f64 {
        let low = self.height - BOTTOM;
        low - (low - TOP) * self.y.part(value)
    }
}

fn draw(series: &Series, frame: &Frame, out: &mut String) {
    let lap = series.lap.map(|lap| format!(" data-lap=\"{lap}\"")).unwrap_or_default();
    let _ = write!(out, "<g class=\"series\"{lap}><title>{}</title>", escape(&series.title));
    if matches!(series.mark, Mark::Line | Mark::DotLine) {
        let _ =
            write!(out, "<path class=\"line {}\" d=\"{}\"/>", series.class, path(series, frame));
    }
    let low = frame.height - BOTTOM;
    for &(x, y) in series.points.iter().filter(|p| p.0.is_finite() && p.1.is_finite()) {
        let (at, top) = (frame.x(x), frame.y(y));
        match series.mark {
            Mark::Line => {}
            Mark::Dots | Mark::DotLine => {
                let _ = write!(
                    out,
                    "<circle class=\"dot {}\" cx=\"{at:.1}\" cy=\"{top:.1}\" r=\"3\"/>",
                    series.class
                );
            }
            Mark::Bars => {
                let _ = write!(
                    out,
                    "<path class=\"bar {}\" d=\"M{at:.1} {low:.1}V{top:.1}\"/>",
                    series.class
                );
            }
        }
    }
    out.push_str("</g>\n");
}

fn path(series: &Series, frame: &Frame) -> String {
    crate::path(series.points.iter().map(|(x, y)| (frame.x(*x), frame.y(*y))), 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_runs_through_every_finite_point_and_leaves_gaps() {
        let points = vec![(0.0, 1.0), (1.0, f64::NAN), (2.0, 3.0), (3.0, 4.0)];
        let mut chart = Chart::new("s [m]", "v < w");
        chart.series.push(Series::new("a", "s0", Mark::Line, points));
        let html = chart.html();
        let d = html.split("d=\"").nth(1).unwrap();
        let d = &d[..d.find('"').unwrap()];
        assert_eq!((d.matches('M').count(), d.matches('L').count()), (2, 1));
        assert!(html.contains("v &lt; w") && !html.contains("NaN"));
    }
}
