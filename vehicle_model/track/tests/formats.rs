//! Formats without widths, and positions on the globe.

#![allow(clippy::unwrap_used)]

mod common;

use common::ellipse;
use std::fmt::Write;
use track::{ImportOptions, Imported, Track, TrackError};

/// The file with a half width of 4 m.
fn import(file: &str, text: &str) -> Imported {
    Track::import(file, text, &ImportOptions { half_width: Some(4.0), ..Default::default() })
        .unwrap()
}

/// Degrees of latitude and longitude of a place near (50, 8) degrees, by the radii of curvature
/// of the ellipsoid there.
fn degrees(x: f64, y: f64) -> (f64, f64) {
    let (a, e2) = (6_378_137.0, 6.694_379_990_141e-3);
    let (sin, cos) = 50.0_f64.to_radians().sin_cos();
    let w = 1.0 - e2 * sin * sin;
    let (meridian, transverse) = (a * (1.0 - e2) / (w * w.sqrt()), a / w.sqrt());
    (50.0 + (y / meridian).to_degrees(), 8.0 + (x / (transverse * cos)).to_degrees())
}

#[test]
fn tables_without_widths_are_the_line_with_the_given_one() {
    let points = ellipse(90);
    let (mut plain, mut raceline) =
        (String::new(), "# s_m; x_m; y_m; psi_rad; kappa_radpm; vx_mps; ax_mps2\n".to_owned());
    for p in &points {
        writeln!(plain, "{}, {}", p.x, p.y).unwrap();
        writeln!(raceline, "0.0;{};{};0.0;0.0;30.0;0.0", p.x, p.y).unwrap();
    }
    let bare: String = raceline.lines().skip(1).flat_map(|line| [line, "\n"]).collect();
    let same: Vec<_> = points
        .iter()
        .map(|p| track::TrackPoint { width_left: 4.0, width_right: 4.0, ..*p })
        .collect();
    let exact = Track::from_points("a", &same).unwrap();
    for text in [&plain, &raceline, &bare, &format!("x,y\n{plain}")] {
        let imported = import("a.csv", text);
        assert_eq!(imported.track, exact);
        assert_eq!(imported.origin, None);
        let error = Track::parse("a.csv", text).unwrap_err();
        assert!(matches!(error, TrackError::NoWidth { .. }), "{error}");
    }
    let text = points.iter().fold("x,y,width_m\n".to_owned(), |mut text, p| {
        writeln!(text, "{},{},8.0", p.x, p.y).unwrap();
        text
    });
    assert_eq!(Track::parse("a.csv", &text).unwrap(), exact);
}

#[test]
fn a_comma_between_semicolons_is_a_decimal_point() {
    let points = ellipse(90);
    let (mut with_points, mut with_commas) = (String::new(), String::new());
    for p in &points {
        let line = format!("{:.6};{:.6};{:.6};{:.6}\n", p.x, p.y, p.width_right, p.width_left);
        with_commas.push_str(&line.replace('.', ","));
        with_points.push_str(&line);
    }
    let [a, b] = [with_points, with_commas].map(|text| Track::parse("a.csv", &text).unwrap());
    assert_eq!(a, b);
}

#[test]
fn a_comma_between_blanks_or_tabs_is_a_decimal_point_and_beside_one_it_separates() {
    let points = ellipse(90);
    let row = |x: f64, y: f64| [x, y, 4.0, 4.0].map(|number| format!("{number:.6}"));
    let text = |separator: &str, point: &str| {
        points.iter().fold(
            "x_m y_m w_tr_right_m w_tr_left_m\n".replace(' ', separator),
            |text, p| {
                text + &row(p.x, p.y).map(|word| word.replace('.', point)).join(separator) + "\n"
            },
        )
    };
    let exact = import("a.csv", &text(",", ".")).track;
    for (separator, point) in [("\t", ","), (" ", ","), (", ", "."), (",\t", "."), (";", ",")] {
        assert_eq!(import("a.csv", &text(separator, point)).track, exact, "{separator:?} {point}");
    }
    let whole = |separator: &str| text(separator, ".").replace(".000000", "");
    assert_eq!(import("a.csv", &whole(", ")).track, exact);
}

/// Smoothing takes time by the point.
#[test]
fn of_a_dense_survey_a_part_of_the_points_is_taken_and_said() {
    let text = ellipse(50_000).iter().fold("x,y\n".to_owned(), |mut text, p| {
        writeln!(text, "{},{}", p.x, p.y).unwrap();
        text
    });
    let dense = import("a.csv", &text);
    let said: Vec<String> = dense.changes.iter().map(ToString::to_string).collect();
    assert_eq!(said, ["took one of 3 points, as 50000 are more than a track needs"]);
    assert!(dense.line.len() <= 20_000 && dense.points.len() == 50_000);
    let coarse = Track::from_points("a", &ellipse(2_000)).unwrap();
    assert!((dense.track.length() / coarse.length() - 1.0).abs() < 1e-6);
    // What is to go through the points goes through all of them.
    let options = ImportOptions { half_width: Some(4.0), smooth: Some(0.0) };
    let exact = Track::import("a.csv", &text, &options).unwrap();
    assert!(exact.changes.is_empty() && exact.line.len() == 50_000);
}

#[test]
fn positions_on_the_globe_have_their_true_shape() {
    let points = ellipse(90);
    let exact = Track::from_points("a", &points).unwrap();
    let mut table = "lat,lon,height\n".to_owned();
    let mut places = Vec::new();
    for p in &points {
        let (lat, lon) = degrees(p.x, p.y);
        writeln!(table, "{lat},{lon},320.5").unwrap();
        places.push(format!("[{lon}, {lat}, 320.5]"));
    }
    // A ring repeats its first position.
    places.push(places[0].clone());
    let line = |kind: &str, coordinates: String| {
        format!(
            "{{\"type\": \"FeatureCollection\", \"features\": [{{\"type\": \"Feature\", \
             \"properties\": {{\"name\": \"ring\", \"width\": \"8\"}}, \
             \"geometry\": {{\"type\": \"{kind}\", \"coordinates\": {coordinates}}}}}]}}"
        )
    };
    let list = format!("[{}]", places.join(","));
    for (file, text) in [
        ("a.csv", table),
        ("a.geojson", line("LineString", list.clone())),
        ("a.geojson", line("Polygon", format!("[{list}]"))),
    ] {
        let Imported { track, origin, line, .. } = import(file, &text);
        let origin = origin.unwrap();
        assert!((origin.latitude - 50.0).abs() < 1e-4 && (origin.height - 320.5).abs() < 1e-9);
        // At 320 m above the ellipsoid a degree is longer by 320 m in the radius of the earth.
        let scale = 1.0 + 320.5 / 6_380_000.0;
        assert!((track.length() - scale * exact.length()).abs() < 0.01, "{}", track.length());
        assert!((track.max_abs_kappa() / exact.max_abs_kappa() - 1.0).abs() < 0.02);
        assert!(line.iter().all(|p| (p.width_left - 4.0).abs() < 0.02));
    }
    // The origin is kept.
    let imported = import("a.geojson", &line("LineString", list));
    assert_eq!(imported.track.name(), "ring");
    let text = imported.to_toml();
    let again = Track::import("ring.toml", &text, &ImportOptions::default()).unwrap();
    assert_eq!((again.origin, again.track), (imported.origin, imported.track));
}
