//! A figure: any column over any axis, with lines and panels for further ones.

use anyhow::{Result, ensure};
use racing::record::{mean, median};
use svg_page::facets::{Facet, Facets, Line, Spot};
use svg_page::scale::ScaleKind;

use super::groups::{Groups, MOST};
use super::samples::{DRIVING, FAILED, LAP, LAP_TIME, Sample, is_share, samples};
use super::table::{RunTable, places};
use super::words::{bare, label, wilson};
use crate::campaign::{ranges_of, short};

/// An axis with more numbers than this shows single runs, and medians of ranges.
const SINGLE: usize = 12;
/// Least number of runs of a range of such an axis, on average.
const OF_A_RANGE: usize = 4;
/// Most ranges of such an axis.
const RANGES: usize = 8;
/// An axis of positive numbers is logarithmic if they span this quotient.
const DECADES: f64 = 15.0;
/// Places that each have their mark on the axis.
const MARKED: usize = 10;
/// Most panels.
const PANELS: usize = 36;

/// What a figure shows.
#[derive(Debug, Clone, Default)]
pub struct Figure {
    /// Heading; by default from the columns.
    pub title: String,
    /// Axis to the right: a column, or `lap`.
    pub x: String,
    /// What is measured: a column; `failed`, the share of the runs that failed; over `lap`
    /// `lap_time_s` and `driving`, the share of the runs that finished the lap.
    pub y: String,
    /// Column whose values are lines.
    pub by: Option<String>,
    /// Column whose values are panels side by side.
    pub across: Option<String>,
    /// Column whose values are panels below one another.
    pub down: Option<String>,
    /// Known values to compare with: name and points of a line.
    pub known: Vec<(String, Vec<(f64, f64)>)>,
}

/// A figure drawn.
#[derive(Debug, Clone)]
pub(super) struct Drawing {
    pub(super) title: String,
    /// What its marks are.
    pub(super) note: String,
    pub(super) facets: Facets,
    /// Panel, line, place, runs, failed, middle, least, greatest.
    pub(super) numbers: Vec<Vec<String>>,
}

/// Where the values of the axis to the right lie.
struct Places {
    ats: Vec<f64>,
    texts: Vec<String>,
    words: bool,
}

impl Places {
    fn new(samples: &[Sample]) -> Self {
        let (texts, numbers) = places(samples.iter().map(|s| s.x.as_ref()));
        let words = numbers.is_none();
        Self {
            ats: numbers.unwrap_or_else(|| (0..texts.len()).map(|i| i as f64).collect()),
            texts: texts.into_iter().map(str::to_owned).collect(),
            words,
        }
    }

    fn of(&self, sample: &Sample) -> usize {
        self.texts.iter().position(|text| *text == sample.x).unwrap_or(0)
    }

    fn kind(&self) -> ScaleKind {
        kind(self.words, &self.ats)
    }
}

/// Logarithmic for positive numbers that span decades.
fn kind(words: bool, values: &[f64]) -> ScaleKind {
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values.iter().copied().fold(0.0, f64::max);
    if !words && least > 0.0 && most / least >= DECADES {
        ScaleKind::Log
    } else {
        ScaleKind::Linear
    }
}

impl Figure {
    /// A figure of two columns.
    #[must_use]
    pub fn new(x: &str, y: &str) -> Self {
        Self { x: x.to_owned(), y: y.to_owned(), ..Self::default() }
    }

    pub(super) fn draw(&self, table: &RunTable) -> Result<Drawing> {
        let samples = samples(table, &self.x, &self.y)?;
        let places = Places::new(&samples);
        let [by, across, down] = [&self.by, &self.across, &self.down]
            .map(|column| Groups::new(table, column.as_deref()));
        let (by, across, down) = (by?, across?, down?);
        ensure!(
            by.names.len() <= MOST,
            "{} lines in a panel, expected at most {MOST}: use --across for this column",
            by.names.len()
        );
        let panels = across.names.len() * down.names.len();
        ensure!(panels <= PANELS, "{panels} panels, expected at most {PANELS}");
        let single = !places.words && places.ats.len() > SINGLE && self.x != LAP;
        let (mut facets, mut numbers) = (Vec::new(), Vec::new());
        for (i, below) in down.names.iter().enumerate() {
            for (j, beside) in across.names.iter().enumerate() {
                let title = join(&self.down, below, &self.across, beside);
                let mut lines = Vec::new();
                for (k, name) in by.names.iter().enumerate() {
                    let own: Vec<&Sample> = samples
                        .iter()
                        .filter(|s| {
                            down.of[s.run] == i && across.of[s.run] == j && by.of[s.run] == k
                        })
                        .collect();
                    let line = self.line(&own, &places, single);
                    let spots = line.spots.iter();
                    numbers.extend(spots.map(|(texts, _)| {
                        [vec![title.clone(), name.clone()], texts.clone()].concat()
                    }));
                    lines.push(Line {
                        spots: line.spots.into_iter().map(|(_, spot)| spot).collect(),
                        dots: line.dots,
                        failures: line.failures,
                    });
                }
                lines.extend(self.known.iter().map(|(name, points)| known(name, points)));
                facets.push(Facet { title, lines });
            }
        }
        let names = by.names.into_iter().chain(self.known.iter().map(|(name, _)| name.clone()));
        let values: Vec<f64> = samples.iter().filter_map(|s| s.y).collect();
        let marked = places.words || places.ats.len() <= MARKED;
        let ticks = places
            .ats
            .iter()
            .zip(&places.texts)
            .map(|(at, text)| (*at, if places.words { text.clone() } else { short(*at) }));
        Ok(Drawing {
            title: self.heading(),
            note: self.note(single),
            facets: Facets {
                x_label: label(&self.x),
                y_label: label(&self.y),
                x_kind: places.kind(),
                y_kind: if is_share(&self.y) { ScaleKind::Linear } else { kind(false, &values) },
                x_ticks: if marked { ticks.collect() } else { Vec::new() },
                y_range: is_share(&self.y).then_some((0.0, 1.03)),
                bands: single || self.x == LAP,
                joined: !places.words,
                names_of: self.by.clone().unwrap_or_default(),
                names: names.collect(),
                across: if self.down.is_none() {
                    across.names.len().min(4)
                } else {
                    across.names.len()
                },
                facets,
            },
            numbers,
        })
    }

    fn line(&self, own: &[&Sample], places: &Places, single: bool) -> Marks {
        let at = |s: &Sample| places.ats[places.of(s)];
        let mut groups: Vec<(String, f64, Vec<&Sample>)> = Vec::new();
        if single {
            let mut ats: Vec<f64> = own.iter().map(|s| at(s)).collect();
            ats.sort_by(f64::total_cmp);
            for (from, to) in
                ranges_of(&ats, (ats.len() / OF_A_RANGE).clamp(1, RANGES).min(ats.len()))
            {
                let inside: Vec<&Sample> =
                    own.iter().copied().filter(|s| (from..=to).contains(&at(s))).collect();
                let middle = median(&mut inside.iter().map(|s| at(s)).collect::<Vec<f64>>());
                groups.push((format!("{} to {}", short(from), short(to)), middle, inside));
            }
        } else {
            for (i, place) in places.ats.iter().enumerate() {
                let inside: Vec<&Sample> =
                    own.iter().copied().filter(|s| places.of(s) == i).collect();
                if !inside.is_empty() {
                    groups.push((places.texts[i].clone(), *place, inside));
                }
            }
        }
        let share = is_share(&self.y);
        let spots =
            groups.iter().map(|(name, x, inside)| self.spot(name, *x, inside, single || share));
        let shown = |s: &&&Sample| single && !share && s.y.is_some();
        Marks {
            spots: spots.collect(),
            dots: own.iter().filter(shown).map(|s| (at(s), s.y.unwrap_or(f64::NAN))).collect(),
            failures: if single && !share {
                own.iter().filter(|s| s.failed).map(|s| at(s)).collect()
            } else {
                Vec::new()
            },
        }
    }

    /// One place of a line, and its numbers as text.
    fn spot(&self, name: &str, x: f64, inside: &[&Sample], apart: bool) -> (Vec<String>, Spot) {
        let mut values: Vec<f64> = inside.iter().filter_map(|s| s.y).collect();
        let failed = inside.iter().filter(|s| s.failed).count();
        let (middle, range) = if is_share(&self.y) {
            let share = mean(&values);
            // Over the laps the intervals of several lines would hide one another.
            (share, wilson(share, values.len()).filter(|_| self.y == FAILED))
        } else {
            let middle = median(&mut values);
            (middle, values.first().copied().zip(values.last().copied()))
        };
        let middle = middle.is_finite().then_some(middle);
        let text = |value: Option<f64>| value.map_or_else(|| "\u{2013}".to_owned(), short);
        let texts = vec![
            name.to_owned(),
            inside.len().to_string(),
            failed.to_string(),
            text(middle),
            text(range.map(|r| r.0)),
            text(range.map(|r| r.1)),
        ];
        let title = format!(
            "{} {name}: {} of {} runs failed; {} {} ({} to {})",
            self.x, texts[2], texts[1], self.y, texts[3], texts[4], texts[5]
        );
        (texts, Spot { x, middle, range, failed: if apart { 0 } else { failed }, title })
    }

    fn heading(&self) -> String {
        if !self.title.is_empty() {
            return self.title.clone();
        }
        let further: Vec<&str> =
            [&self.by, &self.across, &self.down].into_iter().filter_map(|c| c.as_deref()).collect();
        let further = if further.is_empty() {
            String::new()
        } else {
            format!(", by {}", further.join(" and "))
        };
        let y = bare(&self.y);
        let first = y.chars().next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
        let rest: String = y.chars().skip(1).collect();
        format!("{first}{rest} over {}{further}", bare(&self.x))
    }

    fn note(&self, single: bool) -> String {
        match (self.y.as_str(), single) {
            (FAILED, _) => "Share of the runs that failed, with its interval of 95 %.",
            (DRIVING, _) => "Share of the runs that finished the lap.",
            (LAP_TIME, _) if self.x == LAP => {
                "Median and range over the runs that drove the lap; crosses above are failures."
            }
            (_, true) => {
                "Each run is a dot; the line joins medians of ranges with as many runs each, the band \
                 is their range; crosses above are runs that failed."
            }
            (_, false) => {
                "Median and range of the runs that did not fail; crosses above count those that did."
            }
        }
        .to_owned()
    }
}

struct Marks {
    spots: Vec<(Vec<String>, Spot)>,
    dots: Vec<(f64, f64)>,
    failures: Vec<f64>,
}

fn known(name: &str, points: &[(f64, f64)]) -> Line {
    let spot = |(x, y): &(f64, f64)| Spot {
        x: *x,
        middle: Some(*y),
        range: None,
        failed: 0,
        title: format!("{name}: {} at {}", short(*y), short(*x)),
    };
    Line { spots: points.iter().map(spot).collect(), ..Line::default() }
}

fn join(a: &Option<String>, a_name: &str, b: &Option<String>, b_name: &str) -> String {
    let part = |column: &Option<String>, name: &str| {
        column
            .as_ref()
            .map(|column| format!("{} {name}", column.rsplit('.').next().unwrap_or(column)))
    };
    let parts: Vec<String> = part(a, a_name).into_iter().chain(part(b, b_name)).collect();
    parts.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(lines: &str) -> RunTable {
        RunTable::parse(&format!("run,mu,mode,seed,failure,best_lap_s\n{lines}")).unwrap()
    }

    #[test]
    fn medians_and_ranges_are_of_the_runs_that_stayed() {
        let table =
            table("0,0.8,a,0,,5\n1,0.8,a,1,,7\n2,0.8,a,2,,6\n3,0.8,a,3,spin,2\n4,1,a,0,,4\n");
        let drawing = Figure::new("mu", "best_lap_s").draw(&table).unwrap();
        let spots = &drawing.facets.facets[0].lines[0].spots;
        let of = |i: usize| (spots[i].x, spots[i].middle, spots[i].range, spots[i].failed);
        assert_eq!(of(0), (0.8, Some(6.0), Some((5.0, 7.0)), 1));
        assert_eq!(of(1), (1.0, Some(4.0), Some((4.0, 4.0)), 0));
        assert_eq!(drawing.numbers[0][2..], ["0.8", "4", "1", "6", "5", "7"]);
        assert_eq!(drawing.facets.y_label, "best lap [s]");
    }

    #[test]
    fn every_run_is_in_one_panel_and_one_line() {
        let rows: String = (0..48)
            .map(|i| format!("{i},{},{},{i},,5\n", ["1", "2", "3"][i % 3], ["a", "b"][i / 3 % 2]))
            .collect();
        let table = table(&rows);
        let figure = Figure {
            by: Some("mode".into()),
            across: Some("seed".into()),
            ..Figure::new("mu", "best_lap_s")
        };
        let drawing = figure.draw(&table).unwrap();
        let runs: usize = drawing.numbers.iter().map(|row| row[3].parse::<usize>().unwrap()).sum();
        assert_eq!((runs, drawing.facets.facets.len(), drawing.facets.names.len()), (48, 5, 2));
    }

    #[test]
    fn many_numbers_are_dots_with_medians_of_ranges() {
        let rows: String = (0..40)
            .map(|i| {
                format!("{i},{},a,0,{},{i}\n", 0.1 * f64::from(i), if i == 7 { "spin" } else { "" })
            })
            .collect();
        let drawing = Figure::new("mu", "best_lap_s").draw(&table(&rows)).unwrap();
        let line = &drawing.facets.facets[0].lines[0];
        assert_eq!((line.spots.len(), line.dots.len(), line.failures.len()), (8, 39, 1));
        assert!(line.spots.windows(2).all(|w| w[0].middle < w[1].middle));
    }
}
