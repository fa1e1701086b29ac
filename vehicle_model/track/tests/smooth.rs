//! Noisy points become the line they were taken from.

#![allow(clippy::unwrap_used)]

use rand::SeedableRng;
use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64Mcg;
use std::fmt::Write;
use std::path::PathBuf;
use track::{Change, ImportOptions, Imported, Track, TrackError};

/// Points of the track's centre line at this spacing with normal noise, as TUMFTM writes them.
fn surveyed(track: &Track, spacing: f64, noise: f64, seed: u64) -> String {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let normal = Normal::new(0.0, noise).unwrap();
    let n = (track.length() / spacing).round() as usize;
    (0..n).fold("# x_m,y_m,w_tr_right_m,w_tr_left_m\n".to_owned(), |mut text, i| {
        let s = track.length() * i as f64 / n as f64;
        let (x, y) = track.position(s);
        let (x, y) = (x + normal.sample(&mut rng), y + normal.sample(&mut rng));
        writeln!(text, "{x},{y},{},{}", track.width_right(s), track.width_left(s)).unwrap();
        text
    })
}

/// The file as a track.
fn import(text: &str, smooth: Option<f64>) -> Result<Imported, Vec<TrackError>> {
    Track::import("a.csv", text, &ImportOptions { smooth, ..ImportOptions::default() })
}

/// Root mean square and largest distance of the track's line from the exact one [m], and the
/// largest error of its curvature further than `apart` from every jump of the exact one [1/m].
fn errors(track: &Track, exact: &Track, apart: f64) -> (f64, f64, f64) {
    let n = 2000;
    let (mut squares, mut largest, mut kappa) = (0.0, 0.0_f64, 0.0_f64);
    for k in 0..n {
        let (x, y) = track.position(track.length() * f64::from(k) / f64::from(n));
        let place = exact.project(x, y, None);
        squares += place.e_y * place.e_y;
        largest = largest.max(place.e_y.abs());
        let around = (-20..=20).map(|j| exact.kappa(place.s + apart * f64::from(j) / 20.0));
        let (low, high) =
            around.fold((f64::INFINITY, f64::NEG_INFINITY), |r, k| (r.0.min(k), r.1.max(k)));
        if high - low < 1e-9 {
            let s = track.length() * f64::from(k) / f64::from(n);
            kappa = kappa.max((track.kappa(s) - exact.kappa(place.s)).abs());
        }
    }
    ((squares / f64::from(n)).sqrt(), largest, kappa)
}

#[test]
fn every_real_file_loads() {
    let shared = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/tracks");
    for folder in ["", "tum", "f1tenth", "noisy"] {
        let Ok(entries) = std::fs::read_dir(shared.join(folder)) else { continue };
        for file in entries.map(|e| e.unwrap().path()).filter(|f| f.is_file()) {
            let name = file.file_name().unwrap().to_string_lossy();
            if name == "README.md" {
                continue;
            }
            let text = std::fs::read_to_string(&file).unwrap();
            let imported = Track::import(&name, &text, &ImportOptions::default());
            let Imported { track, changes, .. } =
                imported.unwrap_or_else(|e| panic!("{name} {e:?}"));
            // The inner edge keeps its distance from the centre of every bend.
            for k in 0..5000 {
                let s = track.length() * f64::from(k) / 5000.0;
                let kappa = track.kappa(s);
                let inner = if kappa > 0.0 { track.width_left(s) } else { track.width_right(s) };
                assert!(kappa.abs() * inner < 0.9, "{name} at {s}: {kappa} {inner}");
            }
            let width = track.width_left(0.0) + track.width_right(0.0);
            for change in changes {
                if let Change::Smoothed { largest, .. } = change {
                    assert!(largest < 0.1 * width, "{name}: {change}");
                }
            }
        }
    }
}

#[test]
fn the_line_is_recovered_within_its_noise_and_so_is_its_curvature() {
    // Spacing and noise [m]; the limits of rms and largest distance in units of the noise, and of
    // the curvature 0.1 m (median of the seeds), 0.2 m (median) and 0.4 m (all) from its jumps in
    // shares of the largest curvature.
    let cases = [
        (0.05, 0.001, [0.35, 1.6], [0.15, 0.09, 0.09]),
        (0.05, 0.005, [0.35, 1.1], [0.30, 0.12, 0.12]),
        (0.05, 0.010, [0.35, 1.1], [0.30, 0.12, 0.16]),
        (0.20, 0.010, [0.75, 2.2], [0.60, 0.40, 0.30]),
    ];
    let exact = Track::builtin("l").unwrap();
    for (spacing, noise, line, curvature) in cases {
        let mut kappas = [const { Vec::new() }; 3];
        for seed in 0..8 {
            let Imported { track, changes, .. } =
                import(&surveyed(&exact, spacing, noise, seed), None).unwrap();
            let (rms, largest, _) = errors(&track, &exact, 0.1);
            assert!(rms < line[0] * noise && largest < line[1] * noise, "{noise} {rms} {largest}");
            let found = changes.iter().find_map(|c| match c {
                Change::Smoothed { noise, .. } => Some(*noise),
                _ => None,
            });
            let share = found.unwrap() / noise;
            assert!((share - 1.0).abs() < if spacing < 0.1 { 0.15 } else { 0.35 }, "{share}");
            for (list, apart) in kappas.iter_mut().zip([0.1, 0.2, 0.4]) {
                list.push(errors(&track, &exact, apart).2 / exact.max_abs_kappa());
            }
        }
        for list in &mut kappas {
            list.sort_by(f64::total_cmp);
        }
        let [near, mid, far] = &kappas;
        println!("{spacing} {noise}: {kappas:.3?}");
        assert!(near[4] < curvature[0] && mid[4] < curvature[1], "{spacing} {noise} {kappas:?}");
        assert!(far[7] < curvature[2], "{spacing} {noise} {kappas:?}");
    }
}

#[test]
fn smoothing_by_nothing_and_by_a_distance() {
    let exact = Track::builtin("l").unwrap();
    let text = surveyed(&exact, 0.05, 0.0, 0);
    let through = import(&text, Some(0.0)).unwrap();
    assert_eq!(through.changes, vec![]);
    assert!(errors(&through.track, &exact, 0.1).1 < 0.001);
    for wanted in [0.002, 0.02] {
        let moved = import(&surveyed(&exact, 0.05, 0.001, 0), Some(wanted)).unwrap();
        let Some(Change::Smoothed { rms, .. }) = moved.changes.first() else {
            panic!("{:?}", moved.changes)
        };
        assert!((0.5 * wanted..=wanted).contains(rms), "{wanted} {rms}");
    }
}

#[test]
fn widths_follow_the_line_so_that_the_edges_stay() {
    let exact = Track::builtin("l").unwrap();
    let track = import(&surveyed(&exact, 0.2, 0.01, 1), None).unwrap().track;
    for k in 0..100 {
        let s = track.length() * f64::from(k) / 100.0;
        assert!((track.width_left(s) + track.width_right(s) - 1.1).abs() < 1e-9);
    }
}
