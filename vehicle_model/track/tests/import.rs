//! Every file format, on files written here, and on real ones where they are at hand.

#![allow(clippy::unwrap_used)]

mod common;

use common::{clockwise, ellipse};
use std::f64::consts::PI;
use std::fmt::Write;
use std::path::PathBuf;
use track::{Segment, Track, TrackError, TrackPoint};

/// A centre line as TUMFTM writes it.
fn tumftm(points: &[TrackPoint]) -> String {
    points.iter().fold("# x_m,y_m,w_tr_right_m,w_tr_left_m\n".to_owned(), |mut text, p| {
        writeln!(text, "{},{},{},{}", p.x, p.y, p.width_right, p.width_left).unwrap();
        text
    })
}

/// A centre line as F1TENTH writes it.
fn f1tenth(points: &[TrackPoint]) -> String {
    points.iter().fold("# x_m, y_m, w_tr_right_m, w_tr_left_m\n".to_owned(), |mut text, p| {
        writeln!(text, "{}, {}, {}, {}", p.x, p.y, p.width_right, p.width_left).unwrap();
        text
    })
}

/// A TTL table of 17 columns; the edges are set off across the line from point to point.
fn ttl(points: &[TrackPoint]) -> String {
    let n = points.len();
    (0..n).fold(String::new(), |mut text, i| {
        let (before, p, after) = (&points[(i + n - 1) % n], &points[i], &points[(i + 1) % n]);
        let yaw = (after.y - before.y).atan2(after.x - before.x);
        let (sin, cos) = yaw.sin_cos();
        let mut row = [0.0; 17];
        (row[0], row[1], row[3], row[4]) = (p.x, p.y, yaw, -100.0);
        (row[9], row[10]) = (p.x - p.width_left * sin, p.y + p.width_left * cos);
        (row[11], row[12]) = (p.x + p.width_right * sin, p.y - p.width_right * cos);
        let row: Vec<String> = row.iter().map(|v| format!("{v:.16e}")).collect();
        writeln!(text, "{}", row.join("   ")).unwrap();
        text
    })
}

/// The places where two tracks differ by more than 1e-9.
fn assert_same(a: &Track, b: &Track) {
    assert!((a.length() - b.length()).abs() < 1e-9, "{} {}", a.length(), b.length());
    for k in 0..200 {
        let s = a.length() * f64::from(k) / 200.0;
        assert!((a.position(s).0 - b.position(s).0).abs() < 1e-9);
        assert!((a.position(s).1 - b.position(s).1).abs() < 1e-9);
        assert!((a.kappa(s) - b.kappa(s)).abs() < 1e-9);
        assert!((a.width_left(s) - b.width_left(s)).abs() < 1e-9);
        assert!((a.width_right(s) - b.width_right(s)).abs() < 1e-9);
    }
}

#[test]
fn every_table_of_the_same_points_is_the_same_track() {
    for points in [ellipse(90), clockwise(&ellipse(90))] {
        let track = Track::from_points("ellipse", &points).unwrap();
        for (file, text) in [
            ("maps/ellipse.csv", tumftm(&points)),
            ("ellipse.csv", f1tenth(&points)),
            ("ellipse.txt", ttl(&points)),
            // Windows line ends, a byte order mark, blank lines, no header.
            ("ellipse.csv", format!("\u{feff}{}\r\n\r\n", tumftm(&points).replace('\n', "\r\n"))),
            ("ellipse.csv", tumftm(&points).lines().skip(1).collect::<Vec<_>>().join("\n")),
            ("ellipse.csv", tumftm(&points).replace("# ", "")),
        ] {
            let read = Track::parse(file, &text).unwrap();
            assert_eq!(read.name(), "ellipse");
            assert_same(&read, &track);
            assert_eq!(Track::check(file, &text), vec![]);
        }
        // Text holds every digit, so the learned data of one fits the other.
        assert_eq!(
            Track::parse("a.csv", &tumftm(&points)).unwrap().fingerprint(),
            track.fingerprint()
        );
    }
}

#[test]
fn a_header_may_order_the_columns_otherwise() {
    let points = ellipse(90);
    let text = points.iter().fold("w_tr_left_m;y_m;x_m;w_tr_right_m\n".to_owned(), |mut t, p| {
        writeln!(t, "{};{};{};{}", p.width_left, p.y, p.x, p.width_right).unwrap();
        t
    });
    assert_same(&Track::parse("a.csv", &text).unwrap(), &Track::from_points("a", &points).unwrap());
}

#[test]
fn segments_in_toml_are_the_segments_in_code() {
    let text = "
        name = \"oval\"
        width_left_m = 3.0
        width_right_m = 4.0
        segment = [
            { length_m = 80.0, width_left_end_m = 6.0, width_right_end_m = 5.0 },
            { radius_m = 25.0, angle_deg = 180.0, width_left_m = 6.0, width_right_m = 5.0 },
            { length_m = 80.0, width_left_m = 6.0, width_right_m = 5.0,
              width_left_end_m = 3.0, width_right_end_m = 4.0 },
            { radius_m = 25.0, length_m = 78.53981633974483 },
        ]";
    let read = Track::parse("whatever.toml", text).unwrap();
    let code = common::tapered();
    assert_eq!(read.name(), "oval");
    assert_same(&read, &code);
    assert_eq!(read.fingerprint(), code.fingerprint());
}

#[test]
fn a_fingerprint_tells_shapes_and_widths_apart_but_not_names() {
    let oval = |name, length, left| {
        let half = [Segment::straight(length), Segment::arc(20.0, PI)];
        Track::from_segments(name, &half.repeat(2), left, 4.0).unwrap().fingerprint()
    };
    // Computed by another program from the segments of the L track.
    assert_eq!(Track::builtin("l").unwrap().fingerprint(), 0x2715_4024_61ca_3b84);
    let base = oval("a", 50.0, 4.0);
    assert_eq!(base, oval("b", 50.0, 4.0));
    assert_ne!(base, oval("a", 50.0_f64.next_up(), 4.0));
    assert_ne!(base, oval("a", 50.0, 4.0_f64.next_up()));
    let mut points = ellipse(90);
    let ellipse = Track::from_points("e", &points).unwrap().fingerprint();
    points[17].width_right = points[17].width_right.next_up();
    assert_ne!(ellipse, Track::from_points("e", &points).unwrap().fingerprint());
}

#[test]
fn a_bad_file_shows_every_problem_at_once() {
    let mut lines: Vec<String> = tumftm(&ellipse(90)).lines().map(str::to_owned).collect();
    lines[3] = "1.0,two,3.0,4.0".to_owned();
    lines[7] = "1.0,2.0,3.0".to_owned();
    lines[9] = "1.0,2.0,3.0,nan".to_owned();
    let problems: Vec<String> =
        Track::check("a.csv", &lines.join("\n")).iter().map(ToString::to_string).collect();
    assert_eq!(
        problems,
        [
            "line 4, column 5: `two`; expected a finite number",
            "line 8, column 9: 3 columns; expected 4 columns, as the header names",
            "line 10, column 13: `nan`; expected a finite number",
        ]
    );
    let mut lines: Vec<String> = tumftm(&ellipse(90)).lines().map(str::to_owned).collect();
    lines[5] = "58.0, 9.0, -1.0, 5.0".to_owned();
    let first = Track::parse("a.csv", &lines.join("\n")).unwrap_err().to_string();
    assert_eq!(first, "line 6, column 12: w_tr_right_m of -1 m; expected a width above 0 m");
}

#[test]
fn a_bad_toml_file_shows_every_problem_at_once() {
    let text = "name = \"bad\"
width_left_m = -4.5
widht_right_m = 4.5

[[segment]]
length_m = \"long\"

[[segment]]
radius_m = 0.0
angle_deg = 400

[[segment]]
length_m = 10.0
radius_m = 25.0
angle_deg = 90.0
";
    let problems: Vec<String> =
        Track::check("a.toml", text).iter().map(ToString::to_string).collect();
    assert_eq!(
        problems,
        [
            "line 1, column 1: no width_right_m; expected the distance from centre line to edge \
             [m]",
            "line 2, column 16: width_left_m is -4.5; expected a number above 0, at most 1e8",
            "line 3, column 1: unknown key `widht_right_m`; expected one of name, width_left_m, \
             width_right_m, segment, station",
            "line 6, column 12: length_m is of type string; expected a number above 0, at most 1e8",
            "line 9, column 12: radius_m is 0.0; expected a number other than 0, positive to the \
             left",
            "line 10, column 13: angle_deg is 400; expected a number above 0 and below 360",
            "line 12, column 1: both angle_deg and length_m; expected length_m alone, or radius_m \
             with one of angle_deg and length_m",
        ]
    );
    let text = "name = \"open\"\nwidth_left_m = 30\nwidth_right_m = 3\nsegment = [\n\
                { length_m = 9 },\n{ radius_m = 20, angle_deg = 90 }]";
    let problems = Track::check("a.toml", text);
    assert!(matches!(problems[..], [TrackError::TooTight { .. }]), "{problems:?}");
    assert_eq!(Track::from_toml(text).unwrap_err(), problems[0]);
}

#[test]
fn a_ttl_edge_on_the_wrong_side_is_named() {
    let points = ellipse(90);
    let text = ttl(&points);
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let mut cells: Vec<&str> = lines[4].split("   ").collect();
    (cells[9], cells[11]) = (cells[11], cells[9]);
    (cells[10], cells[12]) = (cells[12], cells[10]);
    let swapped = cells.join("   ");
    lines[4] = swapped;
    let problems = Track::check("a.txt", &lines.join("\n"));
    assert_eq!(problems.len(), 2, "{problems:?}");
    for (problem, side) in problems.iter().zip(["left", "right"]) {
        let text = problem.to_string();
        assert!(text.starts_with("line 5, column "), "{text}");
        assert!(text.contains(&format!("a {side} edge point that is not {side}")), "{text}");
    }
    lines[4].push_str("   0.0");
    let first = Track::parse("a.txt", &lines.join("\n")).unwrap_err().to_string();
    assert!(first.contains("18 columns; expected 17 columns"), "{first}");
}

#[test]
fn what_is_no_track_is_told_so() {
    for text in ["", "\n\n", "# only a comment\n"] {
        let error = Track::parse("a.csv", text).unwrap_err();
        assert!(matches!(error, TrackError::Syntax { line: 1, .. }), "{error}");
        assert!(error.to_string().contains("no numbers"), "{error}");
    }
    let error = Track::parse("a.csv", "1 2 3\n3 4 5\n").unwrap_err().to_string();
    assert!(error.starts_with("line 1, column 5: 3 columns; expected 4 columns"), "{error}");
    for (text, place, words) in [
        (
            "name = 3\nwidth_left_m = 1\nwidth_right_m = 1\nsegment = []",
            "line 1, column 8",
            "expected a string",
        ),
        ("name = \"a\"\nwidth = 3.0", "line 1, column 1", "no width_left_m"),
        ("name = \"a\"\nwidth_left_m = ", "line 2, column", ""),
        (
            "name = \"a\"\nwidth_left_m = 1.0\nwidth_right_m = 1.0\n[[segment]]\nangle_deg = 9.0",
            "line 4, column 1",
            "angle_deg without radius_m",
        ),
    ] {
        let error = Track::parse("a.toml", text).unwrap_err().to_string();
        assert!(error.starts_with(place) && error.contains(words), "{text:?}: {error}");
    }
}

/// Real files: name, length [m], its tolerance [m], the largest curvature that is sane [1/m], and
/// the turns of a lap: all but the first are driven clockwise.
const REAL: [(&str, f64, f64, f64, f64); 5] = [
    ("02_barc_center.txt", 17.01, 0.02, 1.2, 1.0),
    ("04_putnam_short_center.txt", 882.0, 1.0, 0.12, -1.0),
    ("3_putnam_center.txt", 2852.0, 1.0, 0.14, -1.0),
    ("Budapest.csv", 4378.0, 5.0, 0.1, -1.0),
    ("Monza.csv", 5791.0, 5.0, 0.13, -1.0),
];

#[test]
fn real_files_are_taken_where_they_are_at_hand() {
    let shared = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/tracks");
    for (name, length, tolerance, kappa, turns) in REAL {
        let Ok(text) = std::fs::read_to_string(shared.join(name)) else { continue };
        let track = Track::parse(name, &text).unwrap();
        assert!((track.length() - length).abs() < tolerance, "{name}: {}", track.length());
        assert!(track.max_abs_kappa() < kappa, "{name}: {}", track.max_abs_kappa());
        let turn = track.heading(track.length().next_down()) - track.heading(0.0);
        assert!((turn / (2.0 * PI) - turns).abs() < 1e-3, "{name}: {turn}");
    }
}
