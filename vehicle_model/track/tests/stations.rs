//! Bank, slope, friction and speed limits along s.

#![allow(clippy::unwrap_used)]

mod common;

use common::ellipse;
use track::{ImportOptions, Imported, Station, Track, TrackError, points_to_toml};

const OVAL: &str = "name = \"oval\"\nwidth_left_m = 4.0\nwidth_right_m = 4.0\n\
    [[segment]]\nlength_m = 100.0\n[[segment]]\nradius_m = 20.0\nangle_deg = 180.0\n\
    [[segment]]\nlength_m = 100.0\n[[segment]]\nradius_m = 20.0\nangle_deg = 180.0\n";
const STATIONS: &str = "[[station]]\ns_m = 90.0\nbank_deg = 0.0\nspeed_limit_mps = 22.5\n\
    [[station]]\ns_m = 110.0\nbank_deg = 9.0\nfriction = 0.8\n\
    [[station]]\ns_m = 150.0\nbank_deg = 9.0\nslope_deg = -1.5\nspeed_limit_mps = \"none\"\n\
    [[station]]\ns_m = 30.0\nbank_deg = 0.0\nfriction = 1.0\n";

#[test]
fn values_are_linear_between_their_stations_and_around_the_lap() {
    let flat = Track::from_toml(OVAL).unwrap();
    let track = Track::from_toml(&format!("{OVAL}{STATIONS}")).unwrap();
    let length = track.length();
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
    for (s, bank) in [(30.0, 0.0), (60.0, 0.0), (100.0, 4.5), (110.0, 9.0), (130.0, 9.0)] {
        near(track.bank(s).to_degrees(), bank);
        near(track.bank(s + length), track.bank(s));
    }
    // From 150 m to 30 m of the next lap.
    let rest = length - 120.0;
    near(track.bank(200.0).to_degrees(), 9.0 * (1.0 - 50.0 / rest));
    near(track.bank(0.0).to_degrees(), 9.0 * 30.0 / rest);
    near(track.friction(70.0), 0.9);
    near(track.slope(3.0).to_degrees(), -1.5);
    for (s, limit) in [(0.0, f64::INFINITY), (89.9, f64::INFINITY), (90.0, 22.5), (149.0, 22.5)] {
        assert_eq!(track.speed_limit(s), limit, "{s}");
    }
    assert_eq!(track.speed_limit(150.0), f64::INFINITY);
    let plain = (flat.bank(5.0), flat.slope(5.0), flat.friction(5.0), flat.speed_limit(5.0));
    assert_eq!(plain, (0.0, 0.0, 1.0, f64::INFINITY));
    assert_ne!(track.fingerprint(), flat.fingerprint());
    assert_eq!(flat.clone().with_stations(&[]).unwrap(), flat);
}

#[test]
fn a_written_track_keeps_its_stations() {
    let track = Track::from_toml(&format!("{OVAL}{STATIONS}")).unwrap();
    assert_eq!(Track::from_toml(&track.to_toml().unwrap()).unwrap(), track);
    let text = format!("{}{STATIONS}", points_to_toml("e", &ellipse(90), None));
    let options = ImportOptions::default();
    let imported: Imported = Track::import("e.toml", &text, &options).unwrap();
    assert_eq!(imported.track.stations().len(), 4);
    assert_eq!(Track::from_toml(&imported.to_toml()).unwrap(), imported.track);
}

#[test]
fn wrong_stations_are_named() {
    for (found, replaced, words) in [
        ("s_m = 110.0", "s_m = 1100.0", "line 18: station 2: s is 1100"),
        ("bank_deg = 9.0", "bank_deg = 95.0", "bank_deg is 95.0"),
        ("friction = 0.8", "friction = 0.0", "friction is 0.0"),
        ("= 22.5", "= \"fast\"", "\"none\""),
        ("slope_deg", "slope", "unknown key `slope`"),
    ] {
        let text = format!("{OVAL}{STATIONS}").replacen(found, replaced, 1);
        let error = Track::from_toml(&text).unwrap_err().to_string();
        assert!(error.contains(words) && error.contains("expected"), "{error}");
    }
    let flat = Track::builtin("l").unwrap();
    let bad = Station { s: 3.0, friction: Some(-1.0), ..Station::default() };
    assert!(matches!(flat.with_stations(&[bad]), Err(TrackError::Value { key: "friction", .. })));
}
