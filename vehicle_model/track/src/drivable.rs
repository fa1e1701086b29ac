//! Whether a car can drive a track: room for its body, and bends within its steering lock.

use super::error::{Place, TrackError};
use super::{CarSize, Track};

/// Largest width of a track at its narrowest place, in widths of the body: that of a runway.
const WIDEST: f64 = 100.0;
/// Places looked at, per width of the track.
const DENSITY: f64 = 20.0;
/// Most places looked at.
const MOST: usize = 200_000;

/// A stretch whose centre line is tighter than the car steers.
struct Bend {
    /// Where it is tightest.
    place: Place,
    /// Largest |kappa| there [1/m].
    kappa: f64,
    /// Length [m], and turn over it \[rad\].
    length: f64,
    turn: f64,
    /// Least distance from the centre line to the (inner, outer) edge [m].
    widths: (f64, f64),
}

impl Bend {
    /// Largest radius of a line through the bend that begins and ends at the outer edge and
    /// touches the inner one, for a body of this width: with the bend an arc of radius R between
    /// tangents, the circle through both has R_line = (R_out - R_in cos(turn / 2)) / (1 -
    /// cos(turn / 2)), at least R_out.
    fn widest(&self, body: f64) -> f64 {
        let radius = self.length / self.turn;
        let inner = radius - (self.widths.0 - 0.5 * body).max(0.0);
        let outer = radius + (self.widths.1 - 0.5 * body).max(0.0);
        if self.turn >= std::f64::consts::PI {
            return outer;
        }
        let cos = libm::cos(0.5 * self.turn);
        ((outer - inner * cos) / (1.0 - cos)).max(outer)
    }
}

impl Track {
    /// Why this car cannot drive the track: a place narrower than its body, a width of another
    /// scale than the car's, or a bend that no line
    /// between the edges takes within the steering lock at walking pace, the bend being an arc as
    /// long and as far round. Nothing if it can, as far as these two say; one entry for each kind,
    /// the worst place of it.
    ///
    /// A survey whose noise was not smoothed shows here as bends of small radius.
    #[must_use]
    pub fn problems_for<'a>(&self, car: impl Into<CarSize<'a>>) -> Vec<TrackError> {
        let CarSize { width: body, lock, .. } = car.into();
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let count = ((DENSITY * self.length() / self.narrowest()).ceil() as usize).clamp(64, MOST);
        let step = self.length() / count as f64;
        let mut narrow: Option<(Place, f64)> = None;
        let mut sharp: Option<(Place, f64)> = None;
        let mut bend: Option<Bend> = None;
        let kappa_at = self.kappa_along();
        let mut close = |bend: Option<Bend>| {
            let Some(bend) = bend else { return };
            let radius = bend.widest(body);
            if radius < lock && sharp.is_none_or(|(_, least)| radius < least) {
                sharp = Some((bend.place, radius));
            }
        };
        for i in 0..count {
            let s = i as f64 * step;
            let (left, right) = self.widths.at(s);
            let place = || {
                let (x, y) = self.position(s);
                Place { s, x, y }
            };
            if left + right <= body && narrow.is_none_or(|(_, width)| left + right < width) {
                narrow = Some((place(), left + right));
            }
            let kappa = kappa_at(s);
            if kappa.abs() * lock <= 1.0 {
                close(bend.take());
                continue;
            }
            let widths = if kappa > 0.0 { (left, right) } else { (right, left) };
            let turn = kappa.abs() * step;
            bend = Some(match bend.take() {
                Some(mut bend) => {
                    if kappa.abs() > bend.kappa {
                        (bend.kappa, bend.place) = (kappa.abs(), place());
                    }
                    bend.length += step;
                    bend.turn += turn;
                    bend.widths = (bend.widths.0.min(widths.0), bend.widths.1.min(widths.1));
                    bend
                }
                None => Bend { place: place(), kappa: kappa.abs(), length: step, turn, widths },
            });
        }
        close(bend);
        let narrow = narrow.map(|(place, width)| TrackError::TooNarrow { place, width, body });
        let sharp = sharp.map(|(place, radius)| TrackError::TooSharp { place, radius, lock });
        let width = self.narrowest();
        let share = width / body;
        let wide =
            (share > WIDEST).then_some(TrackError::TooWide { width, body, share, limit: WIDEST });
        narrow.into_iter().chain(wide).chain(sharp).collect()
    }
}
