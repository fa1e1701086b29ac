//! Curvature that a place of the track asks for at most, however sharply a lap turned there.
//!
//! A car that brakes late and turns sharply uses all grip at a low speed, and looks as if the bend allowed no
//! more. A line parallel to the centre line is possible as well:
//!
//! ```text
//! kappa_needed = min(|kappa_driven|, kappa_b / (1 - kappa_b |e_y|))
//! kappa_b(s) = max_{s'} |kappa(s')| exp(-|s - s'| / d)         d = sqrt(2 W / max |kappa|)
//! ```
//!
//! A car turns before a bend begins and after it ends: the bend fades over the length d in which the
//! tightest one of the track crosses its least width W.

use vehicle_model::{CarParams, Track};

use super::braking::{backward, between, grid};

/// kappa_b on the grid of the envelope. No lap changes it.
#[derive(Debug, Clone)]
pub(crate) struct Bends {
    pub(super) kappa: Vec<f64>,
    pub(super) ds: f64,
}

impl Bends {
    pub(crate) fn new(car: &CarParams, track: &Track) -> Self {
        let (points, ds) = grid(car, track);
        let mut kappa: Vec<f64> = (0..points).map(|i| track.kappa(i as f64 * ds).abs()).collect();
        let fading = (2.0 * track.narrowest() / track.max_abs_kappa()).sqrt();
        let left = libm::exp(-ds / fading);
        for _ in 0..2 {
            backward(&mut kappa, |_, here, after| here.max(left * after));
            kappa.reverse();
        }
        Self { kappa, ds }
    }

    /// What is needed at s and e_y where a lap turned by `driven` \[1/m\].
    pub(crate) fn needed(&self, s: f64, e_y: f64, driven: f64) -> f64 {
        let kappa = between(&self.kappa, self.ds, s);
        let parallel = kappa / (1.0 - kappa * e_y.abs()).max(f64::EPSILON);
        driven.abs().min(parallel)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use std::f64::consts::PI;

    use vehicle_model::Segment;

    use super::*;

    /// Two straights of 100 m joined by half circles of 20 m, 10 m wide.
    fn bends() -> Bends {
        let half = [Segment::straight(100.0), Segment::arc(20.0, PI)];
        let track = Track::from_segments("oval", &[half, half].concat(), 5.0, 5.0).unwrap();
        Bends::new(&CarParams::builtin("barc").unwrap(), &track)
    }

    #[test]
    fn a_sharper_turn_than_the_bend_does_not_count() {
        let bends = bends();
        let middle = 100.0 + 10.0 * PI;
        assert!((bends.needed(middle, 0.0, 0.2) - 0.05).abs() < 1e-9);
        assert!((bends.needed(middle, 0.0, -0.03) - 0.03).abs() < 1e-9);
        // The parallel 4 m nearer to its centre has a radius of 16 m.
        assert!((bends.needed(middle, 4.0, 0.2) - 1.0 / 16.0).abs() < 1e-9);
    }

    #[test]
    fn a_bend_fades_on_both_sides() {
        let bends = bends();
        let fading = (2.0 * 10.0 / 0.05_f64).sqrt();
        for distance in [5.0, 20.0, 40.0] {
            let expected = 0.05 * (-distance / fading).exp();
            let behind = 100.0 + 20.0 * PI + distance;
            for s in [100.0 - distance, behind] {
                assert!((bends.needed(s, 0.0, 1.0) - expected).abs() < 0.02 * expected, "{s}");
            }
        }
    }
}
