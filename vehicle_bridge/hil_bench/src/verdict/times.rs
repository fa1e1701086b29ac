//! A run over time, drawn: speed, room, inputs and states, with faults, limits and reactions.

use svg_page::panels::{Curve, Instant, Panel, Panels, Span};

use super::{Verdict, number};
use crate::measure::{Expectation, Measure};
use crate::run::RunOutcome;
use crate::timeline::{Since, Timeline};

/// States in which the car is stopped or held, drawn darker.
const STOPPED: [&str; 8] =
    ["SAFE_STOP", "FAULT", "ESTOP", "stop", "FALLBACK", "INFEASIBLE", "NUMERIC", "TIMEOUT"];

/// The drawing of a run; empty if it has no timeline.
pub(super) fn drawing(verdict: &Verdict<'_>, run: &RunOutcome) -> String {
    let timeline = &run.timeline;
    if timeline.is_empty() {
        return String::new();
    }
    let times = timeline.car.iter().map(|p| p.time_s);
    let times = times.chain(timeline.applied.iter().map(|p| p.time_s));
    let (from, to) = times.fold((0.0_f64, 0.0_f64), |(a, b), t| (a.min(t), b.max(t)));
    let faults = verdict.scenario.faults.iter().map(|fault| Span {
        from: fault.at_s.min(to),
        to: fault.for_s.map_or(to, |length| (fault.at_s + length).min(to)),
        text: format!("fault: {}", fault.words()),
        class: String::new(),
    });
    let drawing = Panels {
        label: "time since the faults began [s]".to_owned(),
        range: (from, to),
        shaded: faults.collect(),
        instants: instants(verdict, run, to),
        panels: panels(timeline, verdict, to),
    };
    drawing.html()
}

/// When a reaction was due and when it came.
fn instants(verdict: &Verdict<'_>, run: &RunOutcome, to: f64) -> Vec<Instant> {
    let mut instants = Vec::new();
    for Expectation { measure, most, .. } in &verdict.scenario.expectations {
        let (words, unit) = measure.words();
        let Some(from) = run.values.origin(measure).filter(|_| unit == "ms") else { continue };
        let mut add = |ms: f64, text: String, class: &str| {
            let at = from + ms * 1e-3;
            if at <= to {
                instants.push(Instant { at, text, class: class.to_owned() });
            }
        };
        if let Some(most) = *most {
            add(most, format!("{words}: limit {} ms", number(most)), "limit");
        }
        if let Some(ms) = run.values.get(measure) {
            add(ms, format!("{words}: measured {} ms", number(ms)), "measured");
        }
    }
    instants
}

fn panels(timeline: &Timeline, verdict: &Verdict<'_>, to: f64) -> Vec<Panel> {
    let plot = |label: &str, points: Vec<(f64, f64)>, steps: bool| Panel::Plot {
        label: label.to_owned(),
        curves: vec![Curve { class: String::new(), points, steps }],
        references: Vec::new(),
    };
    let car = |value: fn(&crate::timeline::CarSample) -> f64| {
        timeline.car.iter().map(|p| (p.time_s, value(p))).collect::<Vec<_>>()
    };
    let applied = |value: fn(&crate::timeline::Applied) -> f64| {
        timeline.applied.iter().map(|p| (p.time_s, value(p))).collect::<Vec<_>>()
    };
    let mut panels = Vec::new();
    if !timeline.car.is_empty() {
        panels.push(plot("v_x [m/s]", car(|p| p.v_x_mps), false));
        let limit = |e: &&Expectation| e.measure == Measure::BeyondM.into();
        let limit = verdict.scenario.expectations.iter().find(limit).and_then(|e| e.most);
        let limit = limit.unwrap_or(0.0);
        let text =
            if limit == 0.0 { "edge".to_owned() } else { format!("limit {}", number(limit)) };
        let mut room = plot("beyond [m]", car(|p| p.beyond_m), false);
        if let Panel::Plot { references, .. } = &mut room {
            references.push((limit, text));
        }
        panels.push(room);
    }
    if !timeline.applied.is_empty() {
        panels.push(plot("a [m/s^2]", applied(|p| p.a_mps2), true));
        panels.push(plot("delta [rad]", applied(|p| p.delta_rad), true));
    }
    let lanes = [
        ("input from", &timeline.source),
        ("bridge", &timeline.bridge),
        ("controller", &timeline.controller),
        ("solver", &timeline.solver),
    ];
    for (label, states) in lanes {
        if !states.is_empty() {
            panels.push(Panel::Lane { label: label.to_owned(), spans: spans(states, to) });
        }
    }
    panels
}

/// Each state until the next one.
fn spans(states: &[Since], to: f64) -> Vec<Span> {
    let ends = states.iter().skip(1).map(|s| s.time_s).chain([to]);
    let span = |(since, end): (&Since, f64)| Span {
        from: since.time_s,
        to: end,
        text: since.state.clone(),
        class: if STOPPED.contains(&since.state.as_str()) {
            "stopped".into()
        } else {
            String::new()
        },
    };
    states.iter().zip(ends).map(span).collect()
}
