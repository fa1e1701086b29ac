//! Different ways to write the same track, and files that do not hold a track.

#![allow(clippy::unwrap_used)]

mod common;

use common::ellipse;
use rand::SeedableRng;
use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::TAU;
use std::fmt::Write;
use track::{ImportOptions, Track};

/// The table as TUMFTM writes it, with another header.
fn table(header: &str) -> String {
    ellipse(90).iter().fold(format!("{header}\n"), |mut text, p| {
        let (right, left) = (p.width_right, p.width_left);
        writeln!(text, "{:.6},{:.6},{right:.6},{left:.6}", p.x, p.y).unwrap();
        text
    })
}

/// The first of everything wrong with a text.
fn problem(text: &str) -> String {
    Track::parse("a.csv", text).unwrap_err().to_string()
}

#[test]
fn one_table_in_many_hands_is_one_track() {
    let plain = table("# x_m,y_m,w_tr_right_m,w_tr_left_m");
    let exact = Track::parse("a.csv", &plain).unwrap();
    let body = plain.split_once('\n').unwrap().1;
    for text in [
        plain.replace('\n', "\r"),
        plain.replace('\n', "\r\n"),
        format!("\u{feff}{plain}"),
        table("x [m], y [m], Width right [m], Width left [m]"),
        table("X (m),Y (m),w_right (m),w_left (m)"),
        table("\"x_m\";\"y_m\";\"right width\";\"left width\""),
        table("easting,northing,right_m,left_m\nm,m,m,m"),
        table("x\ty\twidth_right\twidth_left\n[m]\t[m]\t[m]\t[m]"),
        body.replace('\n', ",\n"),
        body.replace('\n', ",,,\n"),
        body.replace(',', "\",\"")
            .replace('\n', "\"\n\"")
            .trim_end_matches('"')
            .replacen("", "\"", 1),
    ] {
        let start: String = text.chars().take(60).collect();
        let track = Track::parse("a.csv", &text).unwrap_or_else(|e| panic!("{start}: {e}"));
        assert_eq!(track, exact, "{start}");
    }
}

#[test]
fn what_is_no_table_is_said_in_one_short_message() {
    let long = format!("1.0,{}", "2.0,".repeat(200_000));
    for (text, words) in [
        (table("x_km,y_km,w_right_km,w_left_km"), "column 1 is not in metres"),
        (table("x [cm],y [cm],w_right [m],w_left [m]"), "column 1 is not in metres"),
        (table("s,kappa,w_right,w_left"), "in `s`, `kappa`, `w_right`, `w_left`; expected a track"),
        ("Dear Sir,\nthis is no track.\n".to_owned(), "neither numbers nor columns x and y"),
        ("<?xml version=\"1.0\"?>\n<gpx></gpx>".to_owned(), "XML or HTML"),
        ("\0".repeat(5000), "binary data"),
        ("PK\u{3}\u{4}abc".to_owned(), "binary data"),
        (long, "more than 1000 columns"),
        (format!("1,2,3,{}", "z".repeat(5000)), "`zzzz"),
        (table("x,y,width"), "4 columns, and 89 more lines"),
        (table("#").replacen("60.000000", "1e20", 1), "expected metres from -1e8 to 1e8"),
    ] {
        let message = problem(&text);
        let short: String = message.chars().take(100).collect();
        assert!(message.contains(words), "{words}: {short}");
        assert!(message.chars().count() < 600 && message.contains("expected"), "{short}");
    }
}

#[test]
fn lengths_that_no_track_has_are_refused() {
    let oval = "name = \"a\"\nwidth_left_m = 5\nwidth_right_m = 5\n[[segment]]\nlength_m = 9\n";
    let huge = problem(&oval.replace("= 9", "= 1e300"));
    assert!(
        huge.contains("line 5, column 12: length_m is 1e300; expected a number above 0"),
        "{huge}"
    );
    for (station, words) in [
        ("bank_deg = 89", "an angle between -60 and 60"),
        ("friction = 80", "a factor above 0, at most 3"),
    ] {
        let message = problem(&format!("{oval}[[station]]\ns_m = 1\n{station}\n"));
        assert!(message.contains(words), "{message}");
    }
}

#[test]
fn noise_of_a_metre_on_a_circuit_is_smoothed() {
    // An ellipse of about 2.4 km, 12 m wide.
    let normal = Normal::new(0.0, 1.0).unwrap();
    let at = |angle: f64| (480.0 * angle.cos(), 270.0 * angle.sin());
    let track = |n: usize, noise: f64, seed: u64| {
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let text = (0..n).fold(String::new(), |mut text, i| {
            let (x, y) = at(TAU * i as f64 / n as f64);
            let mut off = || noise * normal.sample(&mut rng);
            writeln!(text, "{},{},6,6", x + off(), y + off()).unwrap();
            text
        });
        Track::import("a.csv", &text, &ImportOptions::default()).unwrap().track
    };
    for (n, seed) in [(480, 1), (480, 2), (2400, 3)] {
        let (noisy, exact) = (track(n, 1.0, seed), track(n, 0.0, 0));
        for k in 0..200 {
            let (x, y) = at(TAU * f64::from(k) / 200.0);
            let off = noisy.project(x, y, None).e_y;
            assert!(off.abs() < 1.5, "{n} {seed}: {off}");
        }
        assert!(noisy.max_abs_kappa() < 3.0 * exact.max_abs_kappa(), "{}", noisy.max_abs_kappa());
    }
}

/// GeoJSON of the ellipse around a place, 4 m to each side: the coordinates of each line.
fn globe(latitude: f64, longitude: f64) -> Vec<String> {
    let metre = 1.0 / 111_320.0;
    let cos = latitude.to_radians().cos();
    ellipse(90)
        .iter()
        .map(|p| {
            let east = longitude + p.x * metre / cos;
            let east = if east > 180.0 { east - 360.0 } else { east };
            format!("[{east:.9},{:.9}]", latitude + p.y * metre)
        })
        .collect()
}

/// A feature with this geometry.
fn feature(kind: &str, coordinates: &str, width: &str) -> String {
    format!(
        "{{\"type\": \"Feature\", \"properties\": {{{width}}}, \"geometry\": {{\"type\": \
         \"{kind}\", \"coordinates\": {coordinates}}}}}"
    )
}

#[test]
fn a_track_may_lie_across_the_meridian_of_180_degrees() {
    let width = "\"width\": 8";
    let line = |at: f64| feature("LineString", &format!("[{}]", globe(65.0, at).join(",")), width);
    let [here, there] = [8.0, 180.0]
        .map(|at| Track::import("a.geojson", &line(at), &ImportOptions::default()).unwrap());
    assert!((here.track.length() - there.track.length()).abs() < 1e-3);
    let origin = there.origin.unwrap();
    assert!((origin.longitude.abs() - 180.0).abs() < 1e-6, "{origin:?}");
    // Degrees from 0 to 360.
    let table = globe(65.0, 180.0).iter().fold("lon,lat,width\n".to_owned(), |mut text, p| {
        let (lon, lat) = p.trim_matches(['[', ']']).split_once(',').unwrap();
        writeln!(text, "{:.9},{lat},8", lon.parse::<f64>().unwrap().rem_euclid(360.0)).unwrap();
        text
    });
    let table = Track::parse("a.csv", &table).unwrap();
    assert!((table.length() - there.track.length()).abs() < 1e-3);
}

#[test]
fn lines_of_geojson_are_joined_and_areas_with_holes_refused() {
    let points = globe(50.0, 8.0);
    let part = |from: usize, to: usize| {
        let part: Vec<&str> = (from..=to).map(|i| points[i % 90].as_str()).collect();
        format!("[{}]", part.join(","))
    };
    let parse = |text: &str| Track::parse("a.geojson", text);
    let whole = parse(&feature("LineString", &part(0, 90), "\"width\": 8")).unwrap();
    let parts = format!("[{},{},{}]", part(0, 30), part(60, 90), part(30, 60));
    for text in [
        feature("MultiLineString", &parts, "\"width_m\": 8"),
        format!("\u{feff}{}", feature("MultiLineString", &parts, "\"width\": \"8 m\"")),
    ] {
        assert_eq!(parse(&text).unwrap(), whole);
    }
    for (text, words) in [
        (feature("Polygon", &format!("[{},{}]", part(0, 90), part(0, 90)), "\"width\": 8"), "hole"),
        (feature("LineString", &part(0, 90), "\"width\": -3"), "width is -3, expected a width"),
        (feature("LineString", &part(0, 90), "\"name\": \"a\""), "in GeoJSON a property `width`"),
        (
            feature("MultiLineString", &format!("[{},{}]", part(0, 30), part(60, 80)), ""),
            "2 lines that do not begin where another ends",
        ),
    ] {
        let message = parse(&text).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
}
