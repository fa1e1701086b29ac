//! A snapshot as lines of text.

use anstyle::Style;
use lcm_types::{ActuationReport, VehicleState};

use crate::{BAD, GOOD, SOFT, WARN, paint};
use network_watch::{CarSeen, ChannelSeen, Estimates, ProgramSeen, Snapshot, TrackSeen};

/// A silence of this many of a channel's own intervals is one to look at. \[-\]
const LATE: f64 = 5.0;
/// Turns tighter than this share of the track's tightest are drawn as turns. \[-\]
const TURN: f32 = 0.3;

/// The whole view, at most `width` characters wide, with colours (`anstream` takes them out where
/// they are not wanted).
#[must_use]
pub fn draw(seen: &Snapshot, title: &str, width: usize) -> Vec<String> {
    let width = width.clamp(60, 160);
    let mut lines = vec![paint(Style::new().bold(), &cut(title, width))];
    car(seen, width, &mut lines);
    lines.push(String::new());
    programs(seen, width, &mut lines);
    orders(seen, width, &mut lines);
    step(seen, width, &mut lines);
    lines.push(String::new());
    channels(&seen.channels, width, &mut lines);
    lines
}

/// At most `width` characters.
fn cut(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.to_owned();
    }
    let kept: String = text.chars().take(width.saturating_sub(1)).collect();
    format!("{kept}…")
}

/// A time as short as it can be read.
fn age(seconds: f64) -> String {
    match seconds {
        s if s < 0.9995 => format!("{:.0} ms", s * 1e3),
        s if s < 100.0 => format!("{s:.1} s"),
        s => format!("{s:.0} s"),
    }
}

fn car(seen: &Snapshot, width: usize, lines: &mut Vec<String>) {
    let track = seen.track.as_ref();
    let Some(car) = &seen.car else {
        lines.push(paint(WARN, "no state of the car (CAR/STATE)"));
        return;
    };
    let name = track.map_or("unknown track", |track| track.name.as_str());
    let at = match (car.s_m, car.e_y_m, track) {
        (Some(s), Some(e_y), Some(track)) => {
            format!("s {s:.2} of {:.2} m  e_y {e_y:+.3} m", track.length_m)
        }
        _ => "place unknown".to_owned(),
    };
    let words = format!("{name}  lap {}  {at}  v {:.2} m/s", car.lap, car.v_x_mps);
    lines.push(cut(&words, width));
    if let (Some(track), Some(s)) = (track, car.s_m) {
        lines.push(strip(track, s, width));
        if let (Some(e_y), Some((left, right))) = (car.e_y_m, car.width_m) {
            lines.push(lane(e_y, left, right, width));
        }
    }
    let quality = match car.quality {
        VehicleState::GOOD => "good",
        VehicleState::DEGRADED => "degraded",
        _ => "bad",
    };
    let driven = format!(
        "driven by {}: {:+.2} m/s^2, {:+.3} rad{}  state {} old, {quality}, of {}",
        car.driven_by,
        car.accel_mps2,
        car.steer_rad,
        limits(car),
        age(car.age_s),
        car.sender
    );
    lines.push(cut(&driven, width));
}

fn limits(car: &CarSeen) -> String {
    const NAMES: [(i32, &str); 6] = [
        (ActuationReport::STEERING, "steering"),
        (ActuationReport::STEERING_RATE, "steering rate"),
        (ActuationReport::ACCELERATION, "accel"),
        (ActuationReport::ACCELERATION_RATE, "jerk"),
        (ActuationReport::SPEED_CAP, "speed cap"),
        (ActuationReport::NOT_FINITE, "NaN"),
    ];
    let named = NAMES.iter().filter(|(bit, _)| car.limited & bit != 0);
    let named: Vec<_> = named.map(|(_, name)| *name).collect();
    if named.is_empty() { String::new() } else { format!(" (limited: {})", named.join(", ")) }
}

/// The lap from the line to the line: `(` turns left, `)` turns right, the car on it.
fn strip(track: &TrackSeen, s: f64, width: usize) -> String {
    let cells = width - 2;
    let tightest = track.kappa.iter().fold(0.0_f32, |most, kappa| most.max(kappa.abs()));
    let place = s / track.length_m;
    let cell = index(place, cells);
    let mut line: Vec<char> = (0..cells)
        .map(|i| {
            let at = index((i as f64 + 0.5) / cells as f64, track.kappa.len());
            match track.kappa.get(at) {
                Some(kappa) if *kappa > TURN * tightest => '(',
                Some(kappa) if *kappa < -TURN * tightest => ')',
                _ => '-',
            }
        })
        .collect();
    line.get_mut(cell).into_iter().for_each(|c| *c = '●');
    let line: String = line.into_iter().collect();
    format!("|{}|", line.replace('●', &paint(GOOD, "●")))
}

/// Across the track, seen in the direction of travel.
fn lane(e_y: f64, left: f64, right: f64, width: usize) -> String {
    let cells = (width / 2).saturating_sub(16).max(11);
    let cell = index((left - e_y) / (left + right), cells);
    let middle = index(left / (left + right), cells);
    let line: String = (0..cells)
        .map(|i| {
            if i == cell {
                '●'
            } else if i == middle {
                ':'
            } else {
                ' '
            }
        })
        .collect();
    let margin = (left - e_y).min(right + e_y);
    let style = if margin < 0.0 { BAD } else { GOOD };
    let line = line.replace('●', &paint(style, "●"));
    format!("left {left:.2} [{line}] {right:.2} m right  margin {margin:.2} m")
}

/// The cell of a share of the whole.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to cells")]
fn index(share: f64, cells: usize) -> usize {
    ((share.max(0.0) * cells as f64) as usize).min(cells.saturating_sub(1))
}

fn programs(seen: &Snapshot, width: usize, lines: &mut Vec<String>) {
    for (name, hint) in [("bridge", "lmpc bridge"), ("lmpc", "lmpc serve")] {
        if !seen.programs.iter().any(|program| program.name == name) {
            let text = format!("{name:8} no heartbeat (`{hint}` is not running)");
            lines.push(paint(SOFT, &text));
        }
    }
    for program in &seen.programs {
        program_lines(program, width, lines);
    }
    if let Some(why) = &seen.last_stop {
        lines.push(cut(&format!("last stop: {why}"), width));
    }
}

fn program_lines(p: &ProgramSeen, width: usize, lines: &mut Vec<String>) {
    let (style, state) = match p.state.as_str() {
        _ if !p.alive => (BAD, "silent"),
        "RUNNING" => (GOOD, "RUNNING"),
        "SAFE_STOP" | "ESTOP" | "FAULT" => (BAD, p.state.as_str()),
        other => (WARN, other),
    };
    let words = format!(
        "{} ago, up {}, {:.0} MB{}  {} ok, {} bad, {} old, {} stale, {} lost",
        age(p.age_s),
        age(p.uptime_s),
        p.rss_mb,
        if p.granted { ", granted" } else { "" },
        p.ok,
        p.bad,
        p.old,
        p.stale,
        p.lost
    );
    let head = format!("{:8} {}", p.name, paint(style, &format!("{state:9}")));
    lines.push(format!("{head} {}", cut(&words, width.saturating_sub(19))));
    for note in p.detail.split("; ").filter(|note| !note.is_empty()) {
        lines.push(paint(SOFT, &cut(&format!("         {note}"), width)));
    }
}

fn orders(seen: &Snapshot, width: usize, lines: &mut Vec<String>) {
    let Some(order) = &seen.order else {
        lines.push(paint(SOFT, "operator no order heard"));
        return;
    };
    let answers = order.answers.iter().map(|answer| {
        let word = if answer.accepted { "obeys" } else { "refuses" };
        let why = if answer.detail.is_empty() { "" } else { ": " };
        format!("{} {word}{why}{}", answer.who, answer.detail)
    });
    let answers: Vec<_> = answers.collect();
    let answers = if answers.is_empty() { "no answer".to_owned() } else { answers.join(", ") };
    let held = if order.deadman { ", dead man's switch" } else { "" };
    let words = format!("operator {}{held}  {} ago  {answers}", order.order, age(order.age_s));
    lines.push(cut(&words, width));
}

fn step(seen: &Snapshot, width: usize, lines: &mut Vec<String>) {
    let Some(step) = &seen.step else {
        lines.push(paint(SOFT, "step     no step of the controller heard"));
        return;
    };
    let cells = (width / 3).min(40);
    let share = step.total_ms / step.deadline_ms.max(1e-9);
    let full = if share > 0.0 { index(share, cells) + 1 } else { 0 };
    let style = match share {
        s if s > 1.0 => BAD,
        s if s > 0.7 => WARN,
        _ => GOOD,
    };
    let bar = paint(style, &"#".repeat(full)) + &".".repeat(cells - full);
    let words = format!(
        "{:.2} of {:.0} ms, worst {:.2}, {} too long  {}",
        step.total_ms, step.deadline_ms, step.worst_ms, step.overruns, step.status
    );
    lines.push(format!("step     [{bar}] {}", cut(&words, width.saturating_sub(cells + 12))));
    estimates(&step.estimates, width, lines);
}

/// What the controller does and what it has found out.
fn estimates(e: &Estimates, width: usize, lines: &mut Vec<String>) {
    let why = if e.reason.is_empty() { String::new() } else { format!(" ({})", e.reason) };
    let action = format!("{}{why}", e.action).replace('_', " ");
    let style = if e.recovering || !e.reason.is_empty() { WARN } else { GOOD };
    lines.push(format!("action   {}", paint(style, &cut(&action, width.saturating_sub(9)))));
    let found = if e.response_found { "estimated" } else { "configured" };
    let [front, rear] = e.grip;
    let mut words = format!(
        "grip {front:.2} {rear:.2} of nominal, road {:.2}  delay {:.0} ms, lag {:.0} ms {found}",
        e.road_grip,
        1e3 * e.delay_s,
        1e3 * e.lag_s
    );
    if let (Some([e_psi, e_y]), Some(noise)) = (e.sigma, e.noise) {
        words += &format!(
            "  filter {:.0} mm {:.0} mrad of {:.0} mm {:.0} mrad",
            1e3 * e_y,
            1e3 * e_psi,
            1e3 * noise[1],
            1e3 * noise[0]
        );
    }
    lines.push(format!("found    {}", cut(&words, width.saturating_sub(9))));
    if e.delay_change_s != 0.0 {
        let later = if e.delay_change_s > 0.0 { "later" } else { "sooner" };
        let words = format!(
            "commands act {:.0} ms {later} than estimated; not compensated",
            1e3 * e.delay_change_s.abs()
        );
        lines.push(paint(WARN, &cut(&format!("         {words}"), width)));
    }
}

fn channels(channels: &[ChannelSeen], width: usize, lines: &mut Vec<String>) {
    if channels.is_empty() {
        lines.push(paint(WARN, "nothing is said on this network"));
        return;
    }
    lines.push(paint(
        SOFT,
        &cut("channel           rate [Hz]      age    size [B]      heard   lost  senders", width),
    ));
    for channel in channels {
        let mut words = format!(
            "{:18}{:9.2} {:>8} {:>11} {:>10} {:>6} {:>8}",
            cut(&channel.name, 18),
            channel.rate_hz,
            age(channel.age_s),
            channel.bytes,
            channel.count,
            channel.lost,
            channel.senders
        );
        if channel.unreadable > 0 {
            words += &format!("  {} unreadable", channel.unreadable);
        }
        let late = channel.rate_hz > 0.0 && channel.age_s * channel.rate_hz > LATE;
        let odd = late || channel.unreadable > 0;
        lines.push(if odd { paint(WARN, &cut(&words, width)) } else { cut(&words, width) });
    }
}
