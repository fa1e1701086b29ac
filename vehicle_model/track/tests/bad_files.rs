//! Files a user may come with that are no track: each gets a message with place and cure.

#![allow(clippy::unwrap_used)]

mod common;

use common::ellipse;
use std::fmt::Write;
use track::{Track, TrackPoint};

/// The points as TUMFTM writes them.
fn csv(points: &[TrackPoint]) -> String {
    points.iter().fold("# x_m,y_m,w_tr_right_m,w_tr_left_m\n".to_owned(), |mut text, p| {
        writeln!(text, "{},{},{},{}", p.x, p.y, p.width_right, p.width_left).unwrap();
        text
    })
}

/// A good line of points 5 m apart with one thing done to it.
fn with(change: impl Fn(&mut Vec<TrackPoint>)) -> String {
    let mut points = ellipse(90);
    change(&mut points);
    csv(&points)
}

#[test]
fn each_bad_file_gets_its_message() {
    let every = |f: fn(&mut TrackPoint)| with(move |points| points.iter_mut().for_each(f));
    let plain = with(|_| ());
    let cases: Vec<(&str, String, &str)> = vec![
        ("a hole", with(|p| drop(p.drain(36..54))), "add the missing points"),
        ("sparse", with(|p| *p = p.iter().step_by(8).copied().collect()), "too coarse at s ="),
        (
            "two laps",
            with(|p| {
                let second: Vec<TrackPoint> =
                    p.iter().map(|p| TrackPoint { x: p.x + 0.5, ..*p }).collect();
                p.extend(second);
            }),
            "go round 2 times",
        ),
        (
            "noise of metres",
            with(|p| {
                p.iter_mut().enumerate().for_each(|(i, p)| {
                    p.y += 4.0 * (f64::from(u32::try_from(i).unwrap()) * 2.3).sin();
                })
            }),
            "state the noise",
        ),
        ("empty", String::new(), "no numbers"),
        ("open", with(|p| p.truncate(45)), "open track"),
        ("too few", with(|p| p.truncate(6)), "points: found 6"),
        ("a point moved", with(|p| p[30].y += 5.0), "line 32: point 31 at s ="),
        ("a point far away", with(|p| p[30].y += 300.0), "line 32: point 31 at s ="),
        ("kilometres", every(|p| (p.x, p.y) = (p.x * 1e-3, p.y * 1e-3)), "all in metres"),
        (
            "widths in centimetres",
            every(|p| (p.width_left, p.width_right) = (450.0, 450.0)),
            "all in metres",
        ),
        (
            "columns swapped",
            every(|p| {
                *p = TrackPoint {
                    x: p.width_right,
                    y: p.width_left,
                    width_right: p.x,
                    width_left: p.y,
                }
            }),
            "order of the columns",
        ),
        ("no width", plain.replace("# x_m,y_m,w_tr_right_m,w_tr_left_m", "x,y,p,q"), "--width"),
        ("zero width", with(|p| p[3].width_left = 0.0), "line 5, column"),
        ("a word", plain.replacen("\n", "\n1,2,none,3\n", 1), "`none`"),
        ("a column more", plain.replacen("\n", "\n1,2,3,4,5\n", 1), "5 columns"),
        ("not finite", with(|p| p[7].x = f64::NAN), "`NaN`"),
        (
            "there and back",
            with(|p| {
                p.truncate(46);
                let back: Vec<TrackPoint> = p.iter().rev().skip(1).take(44).copied().collect();
                p.extend(back);
            }),
            "at s =",
        ),
        (
            "shuffled",
            with(|p| {
                for i in 0..45 {
                    p.swap(i, (i * 37) % 90)
                }
            }),
            "check the order of the points",
        ),
        (
            "crossing",
            with(|p| {
                p.iter_mut().enumerate().for_each(|(i, p)| {
                    let t = std::f64::consts::TAU * i as f64 / 90.0;
                    (p.x, p.y) = (80.0 * t.cos(), 8.0 * (2.0 * t).sin());
                })
            }),
            "crosses itself",
        ),
        ("degrees", every(|p| (p.x, p.y) = (8.0 + p.x * 1e-5, 50.0 + p.y * 1e-5)), "all in metres"),
        (
            "latitude",
            plain
                .replace("# x_m,y_m", "lat,lon")
                .replace("w_tr_right_m", "right")
                .replace("w_tr_left_m", "left"),
            "order of latitude",
        ),
        (
            "no line in GeoJSON",
            "{\"type\": \"FeatureCollection\", \"features\": []}".to_owned(),
            "0 lines",
        ),
    ];
    for (what, text, words) in cases {
        let problems = Track::check("bad.csv", &text);
        let messages: Vec<String> = problems.iter().map(ToString::to_string).collect();
        let first = messages.first().unwrap_or_else(|| panic!("{what} is taken"));
        println!("{what}: {} messages, {first}", messages.len());
        assert!(first.contains(words) && first.contains("expected"), "{what}: {first}");
    }
}
