//! `matrix.html`: every cell of the matrix, failed ones first.

use std::fmt::Write as _;

use super::axes::Refused;
use super::book::trace_name;
use super::case::TracksCase;
use super::cell::{Cell, cells};
use super::row::TracksRow;
use super::summary::{HEAD, Summary};
use super::thumbnail::{Place, thumbnail};
use svg_page::{card, escape, page as html_page, table};

/// Most maps on the page.
const MOST_MAPS: usize = 100;

/// The page.
#[must_use]
pub fn page(
    lead: &str,
    cases: &[TracksCase],
    rows: &[TracksRow],
    sums: &[Summary],
    no: &[Refused],
) -> String {
    let cells = cells(cases, rows);
    let failed = rows.iter().filter(|row| row.failed()).count();
    let mut body = facts(cases, rows, failed);
    body.push_str(&grid(&cells));
    body.push_str(&failures(&cells));
    let lines: Vec<Vec<String>> = sums.iter().map(Summary::cells).collect();
    body.push_str(&card(
        "Cars and tracks",
        "Lap times and ratios are of the runs that did not fail.",
        &table(&HEAD, &lines),
    ));
    body.push_str(&runs(&cells));
    if !no.is_empty() {
        let lines: Vec<Vec<String>> =
            no.iter().map(|r| vec![r.file.clone(), r.reason.clone()]).collect();
        body.push_str(&card(
            "Files that hold no track to drive on",
            "`lmpc check FILE` lists every problem.",
            &table(&["file", "reason"], &lines),
        ));
    }
    html_page("Cars on tracks", lead, &body, "")
}

fn facts(cases: &[TracksCase], rows: &[TracksRow], failed: usize) -> String {
    let fact = |value: String, what: &str, style: &str| {
        format!("<div class=\"fact {style}\"><b>{value}</b><span>{what}</span></div>")
    };
    let mut ratios: Vec<f64> =
        rows.iter().filter(|r| !r.failed()).filter_map(|r| r.ratio).collect();
    let mut text = String::from("<div class=\"facts\">");
    text += &fact(format!("{} of {}", rows.len(), cases.len()), "runs done", "");
    text += &fact(failed.to_string(), "runs failed", if failed == 0 { "good" } else { "bad" });
    if !ratios.is_empty() {
        let median = racing::record::median(&mut ratios);
        text += &fact(format!("{median:.3}"), "best lap / optimum, median", "");
        let worst = ratios.last().copied().unwrap_or(f64::NAN);
        text += &fact(format!("{worst:.3}"), "best lap / optimum, worst", "");
    }
    let solver: u64 = rows.iter().map(|r| r.solver_steps).sum();
    let clarabel: u64 = rows.iter().map(|r| r.clarabel_steps).sum();
    if solver > 0 {
        let share = 100.0 * clarabel as f64 / solver as f64;
        text += &fact(format!("{share:.2} %"), "of the QPs solved by Clarabel", "");
    }
    text + "</div>\n"
}

/// Tracks down, cars and plants across.
fn grid(cells: &[Cell<'_>]) -> String {
    let (mut tracks, mut columns) = (Vec::new(), Vec::new());
    for cell in cells {
        if !tracks.contains(&cell.track) {
            tracks.push(cell.track);
        }
        if !columns.contains(&(cell.car, cell.plant)) {
            columns.push((cell.car, cell.plant));
        }
    }
    columns.sort_unstable();
    let mut text =
        String::from("<div class=\"scroll\"><table class=\"matrix\"><thead><tr><th></th>");
    for (car, plant) in &columns {
        let plant = if *plant == "none" { String::new() } else { format!("<br>{}", escape(plant)) };
        let _ = write!(text, "<th>{}{plant}</th>", escape(car));
    }
    text.push_str("</tr></thead>\n<tbody>\n");
    for track in tracks {
        let _ = write!(text, "<tr><th>{}</th>", escape(track));
        for (car, plant) in &columns {
            let cell =
                cells.iter().find(|c| c.track == track && c.car == *car && c.plant == *plant);
            match cell {
                Some(cell) => text.push_str(&square(cell)),
                None => text.push_str("<td></td>"),
            }
        }
        text.push_str("</tr>\n");
    }
    text.push_str("</tbody></table></div>\n");
    let note = "\u{2713} every run stayed on the track, with the slowest ratio of best lap to \
                optimum, or the slowest best lap; \u{2717} failed runs of all; \u{2026} runs are \
                missing. A cell leads to its runs.";
    card("Matrix", note, &text)
}

fn square(cell: &Cell<'_>) -> String {
    let (symbol, style) = cell.look();
    let text = match style {
        "failed" => format!("{} of {}", cell.failed(), cell.runs.len()),
        "open" => format!("{} of {}", cell.runs.len(), cell.planned),
        _ => cell.worth(),
    };
    format!(
        "<td class=\"{style}\" title=\"{}\"><a href=\"#{}\">{symbol} {text}</a></td>",
        escape(&cell.hover()),
        cell.id()
    )
}

/// A map for each cell with failed runs.
fn failures(cells: &[Cell<'_>]) -> String {
    let mut maps = String::new();
    let all = cells.iter().filter(|cell| cell.failed() > 0).count();
    for cell in cells.iter().filter(|cell| cell.failed() > 0).take(MOST_MAPS) {
        let failed = || cell.runs.iter().filter(|run| run.failed());
        let places: Vec<Place> = failed()
            .filter_map(|run| {
                let text = format!("seed {}: {}", run.seed, run.fail_message);
                Some(Place { s: run.fail_s_m?, e_y: run.fail_e_y_m?, text })
            })
            .collect();
        let list: String = failed()
            .map(|run| format!("<li>seed {}: {}</li>", run.seed, escape(&run.fail_message)))
            .collect();
        let _ = writeln!(
            maps,
            "<figure><a href=\"#{}\">{}</a><figcaption><b>{} on {}</b>, {}<ul>{list}</ul>\
             </figcaption></figure>",
            cell.id(),
            thumbnail(cell.case.track(), &places),
            escape(cell.car),
            escape(cell.track),
            escape(cell.plant)
        );
    }
    if maps.is_empty() {
        return String::new();
    }
    let note = if all > MOST_MAPS {
        format!("{MOST_MAPS} of {all} cells with failed runs, those with most of them.")
    } else {
        String::new()
    };
    let maps = format!("<div class=\"thumbnails\">\n{maps}</div>\n");
    card("Where cars failed", &note, &maps)
}

/// Every run, cell by cell.
fn runs(cells: &[Cell<'_>]) -> String {
    let head = [
        "seed",
        "laps",
        "best [s]",
        "ratio",
        "to 5 %",
        "warm-up [s]",
        "overhang [m]",
        "Clarabel",
        "fell back",
        "step [us]",
        "99 % [us]",
        "failure",
        "last steps",
        "trace",
    ];
    let head: String = head.iter().map(|h| format!("<th>{h}</th>")).collect();
    let mut text = String::new();
    for cell in cells {
        let (symbol, style) = cell.look();
        let open = if style == "failed" { " open" } else { "" };
        let _ = write!(
            text,
            "<details id=\"{}\"{open}><summary>{symbol} {} on {}, {}</summary>\
             <div class=\"scroll\"><table><thead><tr>{head}</tr></thead><tbody>",
            cell.id(),
            escape(cell.car),
            escape(cell.track),
            escape(cell.plant)
        );
        for run in &cell.runs {
            text.push_str(&line(run));
        }
        text.push_str("</tbody></table></div></details>\n");
    }
    card("Runs", "", &text)
}

fn line(run: &TracksRow) -> String {
    let number = |value: Option<f64>, digits: usize| {
        value.map_or("\u{2013}".to_owned(), |v| format!("{v:.digits$}"))
    };
    let numbers = [
        run.seed.to_string(),
        run.laps.to_string(),
        number(run.best_lap_s, 3),
        number(run.ratio, 3),
        run.lap_within_5_percent.map_or("\u{2013}".to_owned(), |n| n.to_string()),
        number(run.warm_up_lap_mean_s, 2),
        number(run.overhang_max_m, 3),
        format!("{} of {}", run.clarabel_steps, run.solver_steps),
        run.fallbacks.to_string(),
        number(run.step_median_us, 0),
        number(run.step_p99_us, 0),
    ];
    let mut text = String::from("<tr>");
    for number in numbers {
        let _ = write!(text, "<td>{number}</td>");
    }
    for words in [&run.fail_message, &run.fail_last_steps] {
        let _ = write!(text, "<td class=\"text\">{}</td>", escape(words));
    }
    let trace = trace_name(run);
    if run.fail_lap.is_some() {
        let _ = write!(text, "<td><a href=\"failures/{0}\">{0}</a></td>", escape(&trace));
    } else {
        text.push_str("<td></td>");
    }
    text + "</tr>\n"
}
