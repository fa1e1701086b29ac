//! The report of a race, of a time-optimal lap, of the import of a track: one HTML file that needs nothing else.

mod curves;
mod import;
mod lost;
mod map;
pub mod picture;
mod tables;

use std::fmt::Write as _;

use controller::{Action, Config, LapNumber};
use vehicle_model::Track;

use hosting::timing::{StepTime, percentile};
use optimum_store::Known;
use racing::raceline::Raceline;
use racing::record::{Failure, LapRow, StepRow, is_fallback};
use racing::words::kind_word;
use svg_page::{Mark, Series, card, escape, page, table};

pub use import::import_page;

/// What a report shows.
#[derive(Debug)]
pub struct Report<'a> {
    /// Name of the car.
    pub car: &'a str,
    /// The track.
    pub track: &'a Track,
    /// The controller's configuration.
    pub config: &'a Config,
    /// What was run, in a sentence.
    pub lead: &'a str,
    /// Finished laps.
    pub laps: &'a [LapRow],
    /// Control steps.
    pub steps: &'a [StepRow],
    /// Their times.
    pub times: &'a [StepTime],
    /// The time-optimal lap, if it is known.
    pub optimum: Option<&'a Known>,
    /// A raceline to compare with, if one is given.
    pub raceline: Option<&'a Raceline>,
    /// How the run failed, if it did.
    pub failure: Option<&'a Failure>,
}

/// One lap as charts and map show it.
#[derive(Debug)]
pub struct LapView<'a> {
    /// Number of the lap.
    pub number: LapNumber,
    /// Name when the mouse rests on it.
    pub title: String,
    /// Whether it is the fastest.
    pub best: bool,
    /// Whether it is shown at first.
    pub shown: bool,
    /// `warmup`, `learning` or `unfinished`.
    pub kind: &'static str,
    /// Lap time; none if it was not finished \[s\].
    pub time: Option<f64>,
    /// Its control steps.
    pub steps: &'a [StepRow],
    /// The last step before it.
    pub before: Option<&'a StepRow>,
    /// The first step after it.
    pub after: Option<&'a StepRow>,
}

impl LapView<'_> {
    /// A line of the lap that the lap chooser shows and hides.
    fn line(&self, points: Vec<(f64, f64)>) -> Series {
        Series {
            label: None,
            class: if self.best {
                "best".to_owned()
            } else {
                format!("s{}", self.number.get() % 6)
            },
            title: self.title.clone(),
            lap: Some(self.number.get()),
            mark: Mark::Line,
            points,
        }
    }

    /// The steps up to the first behind the line again.
    fn closed(&self) -> Vec<StepRow> {
        self.steps.iter().chain(self.after).copied().collect()
    }
}

impl Report<'_> {
    /// The report as HTML.
    #[must_use]
    pub fn html(&self) -> String {
        let optimal = self.optimum;
        let views = self.views();
        let off = self.failure.and(self.steps.last()).map(|row| (row.pose.x, row.pose.y));
        let mut body = self.facts(optimal);
        body.push_str(&chooser(&views));
        let note = "Colour is speed; dashed is the time-optimal lap where one is known, dotted a \
                    raceline that was given.";
        let map = map::map(self.track, &views, (optimal, self.raceline), off);
        body.push_str(&card("Track", note, &map));
        let mut times = curves::lap_times(self.laps, optimal);
        if let Some(detail) = curves::learned_lap_times(self.laps, optimal) {
            times.push_str("<h2>From the third learned lap on</h2>\n");
            times.push_str(&detail);
        }
        body.push_str("<div class=\"columns\">\n");
        body.push_str(&card("Lap times", "", &times));
        let along = self.along();
        let lines = |at: usize| self.lines(at);
        let mut speed = along.chart(&views, "v_x [m/s]", |r| r.x.v_x, lines(2), Vec::new());
        speed.push_str(&along.chart(&views, "e_y [m]", |r| r.x.e_y, lines(3), Vec::new()));
        let note = "Dashed: time-optimal; dotted: the raceline.";
        body.push_str(&card("Speed and line over the lap", note, &speed));
        if let Some(known) = optimal {
            let note = "Against the time-optimal lap, from the line on.";
            body.push_str(&card("Time lost", note, &lost::html(&views, known, along.length)));
        }
        let mut inputs = along.chart(&views, "a [m/s²]", |r| r.u.a, Vec::new(), Vec::new());
        inputs.push_str(&along.chart(&views, "delta [rad]", |r| r.u.delta, Vec::new(), Vec::new()));
        body.push_str(&card("Inputs over the lap", "", &inputs));
        body.push_str(&self.tyres(&views));
        let note = "Distance between the learned linearisation and the simulated car's own, at \
                    the same state and input.";
        if self.laps.iter().any(|lap| lap.model_error_median.is_finite()) {
            body.push_str(&card("Model error", note, &curves::model_error(self.laps)));
        }
        let support = along.chart(
            &views,
            "sum of kernel weights",
            |r| r.status.data_support_mean,
            Vec::new(),
            Vec::new(),
        );
        let note = "How much driven data stands behind the model along the plan. 0: the nominal \
                    model alone.";
        body.push_str(&card("Data support", note, &support));
        body.push_str(&self.step_times());
        let note = "Every step that did not apply the optimal plan, or whose input was cut, and \
                    every soft limit that gave way.";
        body.push_str(&card(
            "Clipped and fallen back",
            note,
            &tables::events(self.laps, self.steps),
        ));
        body.push_str("</div>\n");
        body.push_str(&card("Laps", "", &tables::laps(self.laps)));
        body.push_str(&self.settings());
        let title = format!("{} on {}", self.car, self.track.name());
        page(&title, self.lead, &body, include_str!("report.js"))
    }

    /// Time-optimal lap and raceline over s: speed (2) or e_y (3).
    fn lines(&self, at: usize) -> Vec<curves::Line> {
        let optimal = self.optimum.map(|known| curves::Line {
            title: "time-optimal lap".to_owned(),
            class: "optimal",
            points: known.points.iter().map(|p| (p[0], p[at])).collect(),
        });
        let raceline = self.raceline.map(|line| {
            let value = |p: &[f64; 3]| if at == 2 { p[2] } else { p[1] };
            let points = line.along(self.track).iter().map(|p| (p[0], value(p))).collect();
            curves::Line { title: line.name.clone(), class: "raceline", points }
        });
        let known = |(_, y): &(f64, f64)| y.is_finite();
        optimal.into_iter().chain(raceline.filter(|r| r.points.iter().all(known))).collect()
    }

    fn views(&self) -> Vec<LapView<'_>> {
        let best = best_lap(self.laps).map(|lap| lap.result.lap);
        let first = self.laps.iter().find(|lap| lap.is_learning()).map(|lap| lap.result.lap);
        let last = self.steps.last().map(|row| row.status.lap);
        let shown = best.or(first).or(last);
        let mut end = 0;
        self.steps
            .chunk_by(|a, b| a.status.lap == b.status.lap)
            .filter_map(|steps| {
                let number = steps.first()?.status.lap;
                let begin = end;
                end += steps.len();
                let row = self.laps.iter().find(|lap| lap.result.lap == number);
                let time = row.map(|lap| lap.result.lap_time);
                let kind = row.map_or("unfinished", |lap| kind_word(lap.result.kind));
                let time_text = time.map_or("not finished".to_owned(), |t| format!("{t:.3} s"));
                Some(LapView {
                    number,
                    title: format!("lap {number}, {kind}, {time_text}"),
                    best: Some(number) == best,
                    shown: Some(number) == shown,
                    kind,
                    time,
                    steps,
                    before: begin.checked_sub(1).and_then(|i| self.steps.get(i)),
                    after: self.steps.get(end),
                })
            })
            .collect()
    }

    fn facts(&self, optimal: Option<&Known>) -> String {
        let mut facts = Vec::new();
        let learned = self.laps.iter().filter(|lap| lap.is_learning()).count();
        if let Some(best) = best_lap(self.laps) {
            let time = best.result.lap_time;
            facts.push((format!("{time:.3} s"), format!("best, lap {}", best.result.lap), ""));
            if let Some(optimal) = optimal {
                let ratio = format!("{:.3}", time / optimal.lap_time_s);
                facts.push((ratio, format!("times the optimal {:.3} s", optimal.lap_time_s), ""));
            }
        }
        facts.push((learned.to_string(), "laps learned".to_owned(), ""));
        let off = usize::from(self.failure.is_some());
        let tone = if off == 0 { "good" } else { "bad" };
        let text = self.failure.map_or("stayed on the track".to_owned(), ToString::to_string);
        facts.push((if off == 0 { "yes".into() } else { "failed".into() }, text, tone));
        let fallbacks = self.steps.iter().filter(|row| is_fallback(&row.status)).count();
        let tone = if fallbacks == 0 { "good" } else { "bad" };
        facts.push((fallbacks.to_string(), "steps fell back".to_owned(), tone));
        let mut totals: Vec<f64> = self.learned_times().iter().map(|t| t.total * 1e3).collect();
        totals.sort_by(f64::total_cmp);
        if !totals.is_empty() {
            let median = percentile(&totals, 0.5);
            let high = percentile(&totals, 0.99);
            facts.push((format!("{median:.2} ms"), format!("a step; 99 % below {high:.2} ms"), ""));
        }
        let cards: String = facts
            .iter()
            .map(|(value, text, tone)| {
                format!(
                    "<div class=\"fact {tone}\"><b>{}</b><span>{}</span></div>\n",
                    escape(value),
                    escape(text)
                )
            })
            .collect();
        format!("<div class=\"facts\">\n{cards}</div>\n")
    }

    fn along(&self) -> curves::Along {
        curves::Along { length: self.track.length() }
    }

    fn tyres(&self, views: &[LapView<'_>]) -> String {
        let along = self.along();
        let limits = &self.config.limits;
        let (front, rear) = (curves::guard(limits.front_slip), curves::guard(limits.rear_slip));
        let mut out = along.chart(views, "|alpha_f| [rad]", |r| r.alpha_f.abs(), Vec::new(), front);
        out.push_str(&along.chart(views, "|alpha_r| [rad]", |r| r.alpha_r.abs(), Vec::new(), rear));
        for (label, value) in [
            ("lateral force used, front", (|r| r.use_f) as fn(&StepRow) -> f64),
            ("lateral force used, rear", |r| r.use_r),
        ] {
            out.push_str(&along.chart(views, label, value, Vec::new(), Vec::new()));
        }
        card("Tyre use", "Slip angles, and the share of each axle's largest lateral force.", &out)
    }

    fn step_times(&self) -> String {
        let times = self.learned_times();
        let mut out = curves::step_times(&times);
        let head = ["phase [ms]", "median", "90 %", "99 %", "longest"];
        out.push_str(&table(&head, &curves::step_table(&times)));
        let note = "Steps that solved the optimal control problem, on the machine that made this \
                    report.";
        card("Control-step times", note, &out)
    }

    /// Times of the steps that learned; those of the warm-up laps would hide them.
    fn learned_times(&self) -> Vec<StepTime> {
        let both = self.steps.iter().zip(self.times);
        both.filter(|(row, _)| row.status.action == Action::Learned).map(|(_, t)| *t).collect()
    }

    fn settings(&self) -> String {
        let text = toml::to_string(self.config).unwrap_or_default();
        let content =
            format!("<details><summary>Show</summary><pre>{}</pre></details>\n", escape(&text));
        card("Configuration", "", &content)
    }
}

/// The fastest valid learned lap.
#[must_use]
pub fn best_lap(laps: &[LapRow]) -> Option<&LapRow> {
    laps.iter()
        .filter(|lap| lap.is_learning() && lap.result.valid)
        .min_by(|a, b| a.result.lap_time.total_cmp(&b.result.lap_time))
}

fn chooser(views: &[LapView<'_>]) -> String {
    let mut buttons = String::new();
    for view in views {
        let time = view.time.map_or("…".to_owned(), |t| format!("{t:.2}"));
        let best = if view.best { " class=\"best\"" } else { "" };
        let _ = write!(
            buttons,
            "<button{best} data-choose=\"{}\" data-kind=\"{}\" aria-pressed=\"{}\" title=\"{}\">{} · {time}</button>",
            view.number,
            view.kind,
            view.shown,
            escape(&view.title),
            view.number
        );
    }
    format!(
        "<section class=\"laps\">\n<h2>Laps shown</h2>\n<p>Click for one lap, Ctrl-click for \
         several, arrow keys to go through them.</p>\n<div class=\"buttons\">\
         <button data-all=\"all\">all</button><button data-all=\"learning\">learned</button>\
         <button data-all=\"none\">none</button>{buttons}</div>\n</section>\n"
    )
}
