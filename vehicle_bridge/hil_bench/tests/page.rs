//! The page of a verdict, structure and looks: a browser lays it out at 1,200 px and on the width of
//! A4 and finds no text cut off and nothing that scrolls sideways. Needs chromium
//! (`tools/setup.sh test`).
#![allow(clippy::unwrap_used, clippy::panic, reason = "code of tests")]

use std::path::{Path, PathBuf};
use std::process::Command;

use hil_bench::measure::Measure;
use hil_bench::timeline::{Applied, CarSample, Since};
use hil_bench::verdict::{self, Tested};
use hil_bench::{Bench, RunOutcome, Timeline, Verdict};

const BENCH: &str = r#"
title = "Faults between controller and car, with a title that goes on for longer than a line of A4 does"

[[scenario]]
name = "no fault"
row = 3
expected = "no stop"
expect = [{ measure = "trips", most = 0 }, { measure = "beyond_m", most = 0 }]

[[scenario]]
name = "command loss, a_name_without_any_place_to_break_it_that_is_much_too_long_for_its_column"
row = 12
expected = "follows the plan, then stops along the track within one timeout of the command that was due"
fault = [
  { for_s = 0.4, channel = "LMPC/CMD", share = 0.5, action = { drop = {} } },
  { at_s = 0.5, car = true, action = { bias = { field = "steer", value = 0.15 } } },
]
expect = [
  { measure = "loss_to_stop_ms", least = 10, most = 110 },
  { measure = "beyond_m", most = -0.05 },
  { measure = "plan_ticks", least = 1 },
]
"#;

/// A run of the second scenario, with its reaction after so many milliseconds.
fn run(seed: u64, reaction_ms: f64) -> RunOutcome {
    let mut run = RunOutcome::default();
    (run.seed, run.duration) = (seed, 3.5);
    run.values.insert(Measure::LossToStopMs, reaction_ms);
    run.values.reacted(Measure::LossToStopMs, 0.02);
    run.values.insert(Measure::BeyondM, -0.1 - 1e-3 * seed as f64);
    run.values.insert(Measure::PlanTicks, 3.0);
    run.values.insert(Measure::Trips, 0.0);
    if reaction_ms > 110.0 {
        run.broken.push(format!("loss_to_stop_ms: {reaction_ms:.4}, limit 10 to 110"));
    }
    let stop = 0.02 + 1e-3 * reaction_ms;
    let since = |time_s, state: &str| Since { time_s, state: state.to_owned() };
    let at = |tick: i32| -1.0 + 0.01 * f64::from(tick);
    let driven = |tick| {
        let braking = (at(tick) - stop).max(0.0);
        CarSample { time_s: at(tick), v_x_mps: (2.0 - 3.0 * braking).max(0.0), beyond_m: -0.2 }
    };
    let applied = |tick| Applied {
        time_s: at(tick),
        a_mps2: if at(tick) < stop { 0.1 } else { -3.0 },
        delta_rad: 0.1 * (5.0 * at(tick)).sin(),
    };
    run.timeline = Timeline {
        car: (0..400).map(driven).collect(),
        applied: (0..400).map(applied).collect(),
        source: vec![since(-1.0, "command"), since(0.03, "plan"), since(stop, "stop")],
        bridge: vec![since(-1.0, "RUNNING"), since(stop, "SAFE_STOP"), since(1.2, "IDLE")],
        controller: vec![since(-1.0, "RUNNING")],
        solver: vec![since(-1.0, "SOLVED"), since(1.0, "FALLBACK")],
    };
    run
}

fn tested() -> Tested {
    Tested {
        version: "0.2.0 (0123456789abcdef)".to_owned(),
        build: "release, x86_64 linux, SHA-256 0123456789abcdef".to_owned(),
        car: "barc (0123456789abcdef)".to_owned(),
        track: "l (0123456789abcdef), 17.5 m".to_owned(),
        bench: format!(
            "/a/{}/bench.toml, SHA-256 0123456789abcdef",
            "folder-without-break".repeat(8)
        ),
        options: "--repeats 20".to_owned(),
        machine: "host: 16 x A Processor With A Long Name @ 3.00GHz, Linux 6.1".to_owned(),
        date: "2026-01-31T12:00:00Z".to_owned(),
        duration_s: 4000.0,
        stalls: 3,
        longest_stall_s: 0.0123,
        tester: String::new(),
    }
}

/// The page of both scenarios; the second failed in one run of twenty if `failed`.
fn with_page<T>(failed: bool, judge: impl FnOnce(&Bench, &Tested, &[Verdict<'_>]) -> T) -> T {
    let bench: Bench = toml::from_str(BENCH).unwrap();
    assert_eq!(bench.problems(), Vec::<String>::new());
    let good = (0..20).map(|seed| run(seed, 31.0)).collect();
    let of = |seed: u64| {
        let late = if failed && seed == 7 { 210.0 } else { 0.0 };
        run(seed, 31.0 + seed as f64 + late)
    };
    let verdicts = [
        Verdict { scenario: &bench.scenarios[0], runs: good },
        Verdict { scenario: &bench.scenarios[1], runs: (0..20).map(of).collect() },
    ];
    judge(&bench, &tested(), &verdicts)
}

#[test]
fn it_opens_with_the_verdict_and_lists_what_failed_first() {
    for (failed, word) in [(false, "PASS"), (true, "FAIL")] {
        let page = with_page(failed, verdict::page);
        let main = page.split("<main>").nth(1).unwrap();
        let places = [format!("<p class=\"word\">{word}</p>"), "<th>version</th>".to_owned()];
        let at: Vec<_> = places.iter().map(|text| main.find(text.as_str()).unwrap()).collect();
        assert!(at.is_sorted() && !page.contains("http://") && !page.contains("https://"));
        let order = [main.find("<b>command loss").unwrap(), main.find("<b>no fault").unwrap()];
        assert_eq!(order[0] < order[1], failed);
        for (name, value) in tested().lines() {
            assert!(main.contains(&format!("<tr><th>{name}</th><td>")), "{name}");
            assert!(value.is_empty() || main.contains(&value), "{name} {value}");
        }
    }
    let page = with_page(true, verdict::page);
    for text in [
        "seed 7: loss_to_stop_ms: 248.0000, limit 10 to 110",
        "failed 1 of 20",
        "broken in 1",
        "loss to stop: limit 110 ms",
        "loss to stop: measured 248 ms",
        "fault: drop on LMPC/CMD",
        "fault: bias field=steer value=0.15 on the car",
        ">SAFE_STOP</text>",
        ">v_x [m/s]</text>",
        ">a [m/s^2]</text>",
        ">delta [rad]</text>",
        "31 to 248 ms<br>p50 41, p99 248",
    ] {
        assert!(page.contains(text), "{text}");
    }
}

#[test]
fn json_and_junit_have_the_content_of_the_page() {
    let text = with_page(true, verdict::json).unwrap();
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!((&json["verdict"], &json["format"]), (&"FAIL".into(), &"lmpc-verdict-1".into()));
    assert_eq!(json["tested"]["stalls"], 3);
    let first = &json["scenarios"][0];
    assert_eq!(first["runs"].as_array().unwrap().len(), 20);
    assert_eq!(first["runs"][7]["values"]["loss_to_stop_ms"], 248.0);
    assert_eq!(first["limits"][0]["p99"], 248.0);
    assert_eq!(first["timeline_seed"], 7);
    assert_eq!(first["timeline"]["bridge"][1]["state"], "SAFE_STOP");
    let junit = with_page(true, verdict::junit);
    let junit = roxmltree::Document::parse(&junit).unwrap();
    let properties: Vec<_> = junit
        .descendants()
        .filter(|node| node.has_tag_name("property"))
        .map(|node| (node.attribute("name").unwrap(), node.attribute("value").unwrap()))
        .collect();
    for (name, value) in tested().lines() {
        assert!(properties.contains(&(name, value.as_str())), "{name}");
    }
    let measured = "limit 10 to 110: 31 to 248, p50 41, p99 248; broken by 1 of 20";
    assert!(properties.contains(&("loss_to_stop_ms", measured)), "{properties:?}");
}

/// What the browser finds wrong: elements that scroll or are cut off, texts beyond their drawing.
const LOOK: &str = r#"<script>
const wrong = [], width = document.documentElement.clientWidth;
if (document.documentElement.scrollWidth > width)
  wrong.push('the page scrolls: ' + document.documentElement.scrollWidth + ' in ' + width);
for (const e of document.querySelectorAll('main *')) {
  const hides = getComputedStyle(e).overflowX !== 'visible';
  if (hides && e.clientWidth > 0 && e.scrollWidth > e.clientWidth + 1)
    wrong.push('cut off: ' + e.tagName + ' ' + e.textContent.slice(0, 40));
  const box = e.getBoundingClientRect();
  if (box.width > 0 && (box.right > width + 1 || box.left < -1))
    wrong.push('beyond the page: ' + e.tagName + ' ' + e.textContent.slice(0, 40));
}
for (const t of document.querySelectorAll('svg text')) {
  const box = t.getBoundingClientRect(), all = t.ownerSVGElement.getBoundingClientRect();
  if (box.left < all.left - 1 || box.right > all.right + 1 || box.top < all.top - 1 || box.bottom > all.bottom + 1)
    wrong.push('beyond its drawing: ' + t.textContent);
}
{
  for (const c of document.querySelectorAll('td, th, h1, h2, p, li')) {
    const range = document.createRange(); range.selectNodeContents(c);
    if (range.getBoundingClientRect().right > c.getBoundingClientRect().right + 1)
      wrong.push('beyond its box: ' + c.textContent.slice(0, 40));
  }
}
document.body.dataset.look = 'width ' + width + '; texts ' + document.querySelectorAll('svg text').length
  + '; wrong: ' + (wrong.join(' | ') || 'nothing');
</script>"#;

fn browser() -> Command {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let found = names.into_iter().find(|name| {
        Command::new(name).arg("--version").output().is_ok_and(|output| output.status.success())
    });
    Command::new(found.unwrap_or_else(|| panic!("no chromium; tools/setup.sh test installs it")))
}

/// What the browser says of a page at a width.
fn look(page: &Path, width: u32) -> String {
    let profile = tempfile::tempdir().unwrap();
    let output = browser()
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--dump-dom"])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg(format!("--window-size={width},900"))
        .arg(format!("file://{}", page.display()))
        .output()
        .unwrap();
    let dom = String::from_utf8_lossy(&output.stdout).into_owned();
    let look = dom.split("data-look=\"").nth(1).and_then(|rest| rest.split('"').next());
    look.unwrap_or_else(|| panic!("no look: {output:?}")).to_owned()
}

#[test]
fn a_browser_cuts_nothing_off_and_scrolls_nothing_sideways() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    let page = with_page(true, verdict::page);
    let write = |name: &str, text: String| {
        let file = folder.join(name);
        std::fs::write(&file, text.replace("</body>", &format!("{LOOK}</body>"))).unwrap();
        file
    };
    let file = write("verdict.html", page.clone());
    // 718 px are the width of A4 between its margins.
    for width in [1200, 718] {
        let found = look(&file, width);
        assert!(found.starts_with(&format!("width {width}; texts ")), "{found}");
        assert!(found.ends_with("wrong: nothing"), "{found}");
        assert!(!found.contains("texts 0;"), "{found}");
    }
    // The look sees a text that is too wide, in a cell, in a box that scrolls and in a drawing.
    let wide = "x".repeat(400);
    let box_that_scrolls =
        format!("<div class=\"scroll\"><table><tr><td>{wide}</td></tr></table></div>");
    let drawing = format!("<svg viewBox=\"0 0 9 9\"><text>{wide}</text></svg>");
    for (name, wrong) in [("cut off", box_that_scrolls), ("beyond its drawing", drawing)] {
        let file = write("wrong.html", page.replacen("</main>", &format!("{wrong}</main>"), 1));
        let found = look(&file, 1200);
        assert!(found.contains(name), "{name}: {found}");
    }
}
