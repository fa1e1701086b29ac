//! Heights of a track's points become its slope.
#![allow(clippy::unwrap_used)]

use std::f64::consts::TAU;
use std::fmt::Write as _;

use rand::{RngExt, SeedableRng};
use track::Track;

const RADIUS: f64 = 80.0;
/// Height of the two hills \[m\].
const HEIGHT: f64 = 3.0;

/// A circle over two hills, z = HEIGHT cos(2 phi), measured with a uniform error of this size.
fn hills(points: u32, error: f64) -> String {
    let mut rng = rand_pcg::Pcg64::seed_from_u64(4);
    let mut text = "x_m,y_m,z_m,width_m\n".to_owned();
    for i in 0..points {
        let phi = TAU * f64::from(i) / f64::from(points);
        let wrong = if error > 0.0 { rng.random_range(-error..error) } else { 0.0 };
        let z = HEIGHT * (2.0 * phi).cos() + wrong;
        let _ = writeln!(text, "{},{},{z},8", RADIUS * phi.cos(), RADIUS * phi.sin());
    }
    text
}

/// Largest deviation from the slope of the hills, atan(dz/ds) with s = RADIUS phi \[rad\].
fn deviation(track: &Track) -> f64 {
    let off = |i: u32| {
        let s = track.length() * f64::from(i) / 1000.0;
        let rise = -2.0 * HEIGHT / RADIUS * (2.0 * TAU * s / track.length()).sin();
        (track.slope(s) - rise.atan()).abs()
    };
    (0..1000).map(off).fold(0.0, f64::max)
}

#[test]
fn slope_of_an_analytic_hill() {
    let track = Track::parse("hills.csv", &hills(200, 0.0)).unwrap();
    assert!(!track.is_flat());
    assert!(deviation(&track) < 2e-4, "{}", deviation(&track));
    // Two points 2.5 m apart that are wrong by 0.2 m would make a slope of 0.16 of nothing.
    let noisy = Track::parse("hills.csv", &hills(200, 0.2)).unwrap();
    assert!(deviation(&noisy) < 0.015, "{}", deviation(&noisy));
}

#[test]
fn level_points_give_the_flat_track_to_the_last_bit() {
    let flat =
        hills(100, 0.0).lines().skip(1).fold("x_m,y_m,width_m\n".to_owned(), |text, line| {
            let cells: Vec<&str> = line.split(',').collect();
            text + &[cells[0], cells[1], cells[3]].join(",") + "\n"
        });
    let level = flat.replace("width_m", "width_m,z").replace(",8\n", ",8,412.5\n");
    let [flat, level] = [flat, level].map(|text| Track::parse("level.csv", &text).unwrap());
    assert!(level.is_flat());
    assert_eq!(level.fingerprint(), flat.fingerprint());
}

#[test]
fn our_own_format_keeps_the_slope() {
    let imported = Track::import("hills.csv", &hills(120, 0.0), &Default::default()).unwrap();
    let again = Track::parse("hills.toml", &imported.to_toml()).unwrap();
    assert_eq!(again.fingerprint(), imported.track.fingerprint());
    assert_eq!(again.stations(), imported.track.stations());
}

#[test]
fn heights_of_a_ttl_table_and_of_the_globe_count() {
    let mut ttl = String::new();
    let mut globe = "lat,lon,height,width\n".to_owned();
    for i in 0..200 {
        let phi = TAU * f64::from(i) / 200.0;
        let (sin, cos) = phi.sin_cos();
        let z = HEIGHT * (2.0 * phi).cos();
        let mut row = [0.0; 17];
        (row[0], row[1], row[2]) = (RADIUS * cos, RADIUS * sin, z);
        (row[9], row[10]) = ((RADIUS - 4.0) * cos, (RADIUS - 4.0) * sin);
        (row[11], row[12]) = ((RADIUS + 4.0) * cos, (RADIUS + 4.0) * sin);
        let row: Vec<String> = row.iter().map(f64::to_string).collect();
        let _ = writeln!(ttl, "{}", row.join(" "));
        // At the equator a degree of longitude is 111319.5 m long, one of latitude 110574.3 m.
        let (lat, lon) = (RADIUS * sin / 110_574.3, RADIUS * cos / 111_319.5);
        let _ = writeln!(globe, "{lat},{lon},{z},8");
    }
    for (name, text, tolerance) in [("hills.txt", ttl, 3e-4), ("hills.csv", globe, 1e-3)] {
        let track = Track::parse(name, &text).unwrap();
        assert!(deviation(&track) < tolerance, "{name}: {}", deviation(&track));
    }
}
