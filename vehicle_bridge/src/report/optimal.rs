//! The time-optimal lap of the L track, where it applies.
//!
//! Found by direct collocation for the small car with grip 0.9, |a| <= 2 m/s^2 and
//! |e_y| <= 0.45 m: a local optimum within 1 to 2 %.

use vehicle_model::Track;

const CSV: &str = include_str!("../../data/timeopt_a2_hw0.45.csv");

/// A known lap to compare with.
#[derive(Debug, Clone)]
pub struct Optimal {
    /// Lap time [s].
    pub lap_time: f64,
    /// Points s [m], v_x [m/s], e_y [m] along the lap.
    pub points: Vec<[f64; 3]>,
}

impl Optimal {
    /// The time-optimal lap of this track, if one is known.
    #[must_use]
    pub fn of(track: &Track) -> Option<Self> {
        let known = Track::builtin("l")?;
        if known.fingerprint() != track.fingerprint() {
            return None;
        }
        let lap_time = CSV.split("T=").nth(1)?.split_whitespace().next()?.parse().ok()?;
        let points = CSV
            .lines()
            .filter(|line| !line.starts_with('#'))
            .filter_map(|line| {
                let column: Vec<f64> = line.split(',').filter_map(|c| c.parse().ok()).collect();
                Some([*column.first()?, *column.get(2)?, *column.get(6)?])
            })
            .collect();
        Some(Self { lap_time, points })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lap_runs_once_around_inside_its_lane_in_the_time_it_says() {
        let track = Track::builtin("l").unwrap();
        let lap = Optimal::of(&track).unwrap();
        assert!((lap.lap_time - 3.831).abs() < 1e-3);
        assert!(lap.points.windows(2).all(|p| p[1][0] > p[0][0]));
        assert!(lap.points.iter().all(|p| p[2].abs() < 0.4501 && p[0] < track.length() + 1e-9));
        // Independent of the header: the time from the speeds along the line.
        let seconds: f64 = lap
            .points
            .windows(2)
            .map(|p| (p[1][0] - p[0][0]) * (1.0 - track.kappa(p[0][0]) * p[0][2]) / p[0][1])
            .sum();
        assert!((seconds - lap.lap_time).abs() < 0.1 * lap.lap_time, "{seconds}");
    }
}
