//! Several quantities over one axis to the right: a panel each, with spans and instants that run
//! through all of them. What it says stands in words, so that it reads without colour.

use std::fmt::Write as _;

use super::escape;
use super::scale::{Scale, ScaleKind};

const WIDTH: f64 = 720.0;
const LEFT: f64 = 104.0;
const RIGHT: f64 = 14.0;
/// Height of a line of text above the panels.
const ROW: f64 = 16.0;
const GAP: f64 = 12.0;
const PLOT: f64 = 84.0;
const LANE: f64 = 24.0;
const AXIS: f64 = 40.0;
/// Width of a character, about: a text is left out where it does not fit.
const CHARACTER: f64 = 6.6;
/// From here on a text stands to the left of what it names.
const TURN: f64 = 0.55;

/// The pattern of shaded spans: once on a page that has panels, before them.
pub const HATCH: &str = "<svg style=\"position:absolute;width:0;height:0\" aria-hidden=\"true\">\
    <defs><pattern id=\"hatch\" width=\"6\" height=\"6\" patternUnits=\"userSpaceOnUse\" \
    patternTransform=\"rotate(45)\"><path class=\"hatch\" d=\"M0 0V6\"/></pattern></defs></svg>\n";

/// A line of a plot.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Classes of the style sheet.
    pub class: String,
    /// Points; a gap is left where one is not finite.
    pub points: Vec<(f64, f64)>,
    /// Whether a value holds until the next one: steps instead of slopes.
    pub steps: bool,
}

/// A state that lasts.
#[derive(Debug, Clone, PartialEq)]
pub struct Span {
    /// Begin.
    pub from: f64,
    /// End.
    pub to: f64,
    /// What it is.
    pub text: String,
    /// Class of the style sheet.
    pub class: String,
}

/// One of the quantities.
#[derive(Debug, Clone, PartialEq)]
pub enum Panel {
    /// A number over the axis.
    Plot {
        /// Name, with unit.
        label: String,
        /// Its lines.
        curves: Vec<Curve>,
        /// Known values, with what they are.
        references: Vec<(f64, String)>,
    },
    /// States one after another.
    Lane {
        /// Whose.
        label: String,
        /// The states.
        spans: Vec<Span>,
    },
}

/// An instant that was measured or that is a limit.
#[derive(Debug, Clone, PartialEq)]
pub struct Instant {
    /// Where.
    pub at: f64,
    /// What it is.
    pub text: String,
    /// Class of the style sheet: `limit` or `measured`.
    pub class: String,
}

/// Panels over one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Panels {
    /// Label of the axis, with unit.
    pub label: String,
    /// Its ends.
    pub range: (f64, f64),
    /// Spans shaded through all panels, such as a fault's.
    pub shaded: Vec<Span>,
    /// Instants drawn through all panels.
    pub instants: Vec<Instant>,
    /// The panels from above.
    pub panels: Vec<Panel>,
}

impl Panel {
    fn height(&self) -> f64 {
        match self {
            Self::Plot { .. } => PLOT,
            Self::Lane { .. } => LANE,
        }
    }
}

impl Panels {
    /// The drawing as an `svg` element.
    #[must_use]
    pub fn html(&self) -> String {
        let scale = Scale::exactly(self.range.0, self.range.1);
        let x = |at: f64| LEFT + (WIDTH - LEFT - RIGHT) * scale.part(at).clamp(0.0, 1.0);
        let head = ROW * (self.shaded.len() + self.instants.len()) as f64 + 6.0;
        let low = head + self.panels.iter().map(|p| p.height() + GAP).sum::<f64>() - GAP;
        let height = low + AXIS;
        let mut out = format!(
            "<svg class=\"chart panels\" viewBox=\"0 0 {WIDTH} {height}\" role=\"img\" \
             aria-label=\"{}\">\n",
            escape(&self.words())
        );
        for (row, span) in self.shaded.iter().enumerate() {
            let (from, to) = (x(span.from), x(span.to));
            let _ = writeln!(
                out,
                "<rect class=\"span\" x=\"{from:.1}\" y=\"{head}\" width=\"{:.1}\" height=\"{:.1}\"/>\
                 <path class=\"edge\" d=\"M{from:.1} {top:.1}V{low}M{to:.1} {top:.1}V{low}\
                 M{from:.1} {top:.1}H{to:.1}\"/>",
                to - from,
                low - head,
                top = ROW * (row as f64 + 0.9),
            );
            name(row, from, &span.text, scale.part(span.from), &mut out);
        }
        for (scale_at, at) in scale.ticks(10).iter().map(|(value, label)| (x(*value), label)) {
            let _ = writeln!(
                out,
                "<path class=\"grid\" d=\"M{scale_at:.1} {head}V{low}\"/><text class=\"tick\" \
                 x=\"{scale_at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{at}</text>",
                low + 16.0
            );
        }
        let mut top = head;
        for panel in &self.panels {
            match panel {
                Panel::Plot { label, curves, references } => {
                    plot(label, curves, references, top, &x, &mut out);
                }
                Panel::Lane { label, spans } => lane(label, spans, top, &x, &mut out),
            }
            top += panel.height() + GAP;
        }
        for (row, instant) in self.instants.iter().enumerate() {
            let (at, row) = (x(instant.at), row + self.shaded.len());
            let _ = writeln!(
                out,
                "<path class=\"instant {}\" d=\"M{at:.1} {:.1}V{low}\"/>",
                escape(&instant.class),
                ROW * row as f64 + 4.0
            );
            name(row, at, &instant.text, scale.part(instant.at), &mut out);
        }
        let _ = writeln!(
            out,
            "<text class=\"label\" x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n</svg>",
            f64::midpoint(LEFT, WIDTH - RIGHT),
            height - 6.0,
            escape(&self.label)
        );
        out
    }

    /// The drawing in words, for who cannot see it.
    fn words(&self) -> String {
        let panels = self.panels.iter().map(|panel| match panel {
            Panel::Plot { label, .. } | Panel::Lane { label, .. } => label.as_str(),
        });
        let named = self.shaded.iter().map(|s| s.text.as_str());
        let named = named.chain(self.instants.iter().map(|i| i.text.as_str()));
        panels.chain(named).collect::<Vec<_>>().join("; ")
    }
}

/// A text above the panels, beside `at`, on the side that has room for it.
fn name(row: usize, at: f64, text: &str, part: f64, out: &mut String) {
    let (x, anchor) = if part > TURN { (at - 5.0, "end") } else { (at + 5.0, "start") };
    let y = ROW * (row as f64 + 0.75);
    let room = if part > TURN { at } else { WIDTH - at };
    let text = shortened(text, room);
    let _ = writeln!(
        out,
        "<text class=\"name\" x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{}</text>",
        escape(&text)
    );
}

/// The text, or its beginning where there is no room for all of it.
fn shortened(text: &str, room: f64) -> String {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "few characters")]
    let most = (room / CHARACTER).max(1.0) as usize;
    if text.chars().count() <= most {
        return text.to_owned();
    }
    text.chars().take(most.saturating_sub(3)).chain("...".chars()).collect()
}

fn plot(
    label: &str,
    curves: &[Curve],
    references: &[(f64, String)],
    top: f64,
    x: &impl Fn(f64) -> f64,
    out: &mut String,
) {
    let values = curves.iter().flat_map(|c| &c.points).map(|p| p.1);
    let scale = Scale::around(ScaleKind::Linear, values.chain(references.iter().map(|r| r.0)));
    let (low, right) = (top + PLOT, WIDTH - RIGHT);
    let y = |value: f64| low - PLOT * scale.part(value);
    let _ = writeln!(
        out,
        "<rect class=\"frame\" x=\"{LEFT}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{PLOT}\"/>",
        right - LEFT
    );
    for (value, tick) in scale.ticks(3) {
        let y = y(value);
        let _ = writeln!(
            out,
            "<path class=\"grid\" d=\"M{LEFT} {y:.1}H{right}\"/><text class=\"tick\" x=\"{}\" \
             y=\"{:.1}\" text-anchor=\"end\">{tick}</text>",
            LEFT - 6.0,
            y + 4.0
        );
    }
    for (value, text) in references {
        let y = y(*value);
        let _ = writeln!(
            out,
            "<path class=\"reference\" d=\"M{LEFT} {y:.1}H{right}\"/><text class=\"name\" \
             x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            right - 4.0,
            y - 3.0,
            escape(text)
        );
    }
    for curve in curves {
        let mut points = curve.points.clone();
        if curve.steps {
            let corners = points.windows(2).flat_map(|p| [p[0], (p[1].0, p[0].1)]);
            points = corners.chain(points.last().copied()).collect();
        }
        let d = crate::path(points.iter().map(|(at, value)| (x(*at), y(*value))), 1);
        let _ = writeln!(out, "<path class=\"line {}\" d=\"{d}\"/>", escape(&curve.class));
    }
    let _ = writeln!(
        out,
        "<text class=\"label\" transform=\"translate(12 {:.1}) rotate(-90)\" \
         text-anchor=\"middle\">{}</text>",
        f64::midpoint(top, low),
        escape(label)
    );
}

fn lane(label: &str, spans: &[Span], top: f64, x: &impl Fn(f64) -> f64, out: &mut String) {
    let _ = writeln!(
        out,
        "<text class=\"label\" x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
        LEFT - 6.0,
        top + LANE * 0.68,
        escape(label)
    );
    for span in spans {
        let (from, to) = (x(span.from), x(span.to));
        let width = (to - from).max(1.0);
        let fits = span.text.chars().count() as f64 * CHARACTER + 12.0 <= width;
        let text = if fits { escape(&span.text) } else { String::new() };
        let _ = writeln!(
            out,
            "<g class=\"state {}\"><title>{}</title><rect x=\"{from:.1}\" y=\"{top:.1}\" \
             width=\"{width:.1}\" height=\"{LANE}\"/><text x=\"{:.1}\" y=\"{:.1}\" \
             text-anchor=\"middle\">{text}</text></g>",
            escape(&span.class),
            escape(&span.text),
            from + 0.5 * width,
            top + LANE * 0.68
        );
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]
    use super::*;

    fn drawing() -> Panels {
        let curve = |steps| Curve {
            class: "s0".into(),
            points: vec![(-1.0, 1.0), (0.0, 2.0), (1.0, f64::NAN), (2.0, 0.0)],
            steps,
        };
        let span = |from, to, text: &str| Span { from, to, text: text.into(), class: "a".into() };
        let plot = |steps| Panel::Plot {
            label: "v_x [m/s]".into(),
            curves: vec![curve(steps)],
            references: vec![(2.5, "most".into())],
        };
        Panels {
            label: "time [s]".into(),
            range: (-1.0, 2.0),
            shaded: vec![span(0.0, 9.0, "drop <x>")],
            instants: vec![
                Instant { at: 0.1, text: "limit 100 ms".into(), class: "limit".into() },
                Instant { at: 1.9, text: "x".repeat(200), class: "measured".into() },
            ],
            panels: vec![
                plot(false),
                plot(true),
                Panel::Lane {
                    label: "bridge".into(),
                    spans: vec![span(-1.0, 1.95, "RUNNING"), span(1.95, 2.0, "SAFE_STOP")],
                },
            ],
        }
    }

    /// Every number of an attribute.
    fn numbers(html: &str, name: &str) -> Vec<f64> {
        let start = format!(" {name}=\"");
        let parts = html.split(start.as_str()).skip(1);
        parts.filter_map(|rest| rest.split('"').next()?.parse().ok()).collect()
    }

    #[test]
    fn nothing_is_drawn_outside_the_picture() {
        let html = drawing().html();
        let height: f64 = html
            .split("viewBox=\"0 0 720 ")
            .nth(1)
            .and_then(|t| t.split('"').next()?.parse().ok())
            .unwrap();
        assert!(numbers(&html, "x").iter().all(|x| (0.0..=WIDTH).contains(x)), "{html}");
        assert!(numbers(&html, "y").iter().all(|y| (0.0..=height).contains(y)), "{html}");
        // Texts end inside as well: by their anchor and their length.
        for text in html.split("<text class=\"name\" ").skip(1) {
            let x: f64 =
                text.split("x=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap();
            let words = text.split('>').nth(1).unwrap().split('<').next().unwrap();
            let length = words.replace("&lt;", "<").replace("&gt;", ">").chars().count() as f64;
            let end = if text.contains("\"end\"") {
                x - length * CHARACTER
            } else {
                x + length * CHARACTER
            };
            assert!((-1.0..=WIDTH + 1.0).contains(&end), "{end}: {words}");
        }
    }

    #[test]
    fn states_are_named_where_there_is_room_and_on_the_pointer_everywhere() {
        let html = drawing().html();
        assert!(html.contains(">RUNNING</text>") && !html.contains(">SAFE_STOP</text>"));
        assert!(html.contains("<title>SAFE_STOP</title>"));
        assert!(html.contains("drop &lt;x&gt;") && !html.contains("NaN"));
    }

    #[test]
    fn a_value_that_holds_is_drawn_in_steps() {
        let html = drawing().html();
        let lines: Vec<&str> = html
            .split("<path class=\"line s0\" d=\"")
            .skip(1)
            .map(|rest| rest.split('"').next().unwrap())
            .collect();
        assert_eq!(lines.len(), 2);
        // A slope has two points before the gap, a step three.
        assert_eq!([lines[0].matches('L').count(), lines[1].matches('L').count()], [1, 3]);
    }
}
