//! Damaged files: whatever the bytes, an answer and no panic.

mod common;

use common::ellipse;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::fmt::Write;
use track::Track;

/// Small files of each format.
fn files() -> Vec<(&'static str, String)> {
    let mut csv = "# x_m, y_m, w_tr_right_m, w_tr_left_m\n".to_owned();
    let mut ttl = String::new();
    for p in ellipse(40) {
        let (x, y) = (p.x, p.y);
        let line = writeln!(csv, "{x:.4}, {y:.4}, {:.3}, {:.3}", p.width_right, p.width_left);
        assert!(line.is_ok());
        // Edges at nine and eleven tenths of the way from the middle of the ellipse.
        let edges = format!("{} {} {} {}", 0.9 * x, 0.9 * y, 1.1 * x, 1.1 * y);
        assert!(writeln!(ttl, "{x} {y} 0 0 -100 0 0 0 0 {edges} 0 0 0 0").is_ok());
    }
    let toml = include_str!("../../../tracks/road_course.toml").to_owned();
    vec![("a.csv", csv), ("a.txt", ttl), ("a.toml", toml)]
}

#[test]
fn damaged_files_are_answered() {
    let mut rng = Pcg64Mcg::seed_from_u64(3);
    let pieces =
        ["", " ", "\n", "-", ",", "e9", "nan", "inf", "0", "[", "\"", "\u{e9}", "=", "#", "1e308"];
    let (mut refused, mut taken) = (0, 0);
    for (name, text) in files() {
        assert_eq!(Track::check(name, &text), vec![], "{name} is a good file");
        for _ in 0..700 {
            let mut chars: Vec<char> = text.chars().collect();
            for _ in 0..rng.random_range(1..4) {
                let at = rng.random_range(0..chars.len());
                let end = (at + rng.random_range(0..12)).min(chars.len());
                chars.splice(at..end, pieces[rng.random_range(0..pieces.len())].chars());
            }
            let damaged: String = chars.into_iter().collect();
            let problems = Track::check(name, &damaged);
            match Track::parse(name, &damaged) {
                Ok(track) => {
                    assert!(problems.is_empty(), "{problems:?}");
                    assert!(track.length().is_finite() && track.length() > 0.0);
                    assert!(track.max_abs_kappa().is_finite());
                    taken += 1;
                }
                Err(error) => {
                    assert_eq!(Some(&error), problems.first());
                    assert!(
                        problems.iter().all(|p| p.to_string().contains("expected")),
                        "{problems:?}"
                    );
                    refused += 1;
                }
            }
        }
    }
    assert!(refused > 1000 && taken > 20, "{refused} refused, {taken} taken");
}
