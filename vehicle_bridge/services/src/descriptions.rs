//! A state says twice where the car is: beside the track's centre line, and in the world. One that
//! contradicts itself is not answered: which of the two is wrong cannot be known.

use std::cell::Cell;
use std::sync::Arc;

use lcm_types::VehicleState;
use vehicle_model::track::wrap_angle;
use vehicle_model::{CarParams, State, Track};

use protocol::convert;
use safety::DoubtLimits;

/// How far the two descriptions of a state are apart.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Contradiction {
    /// \[m\]
    position: f64,
    /// \[rad\]
    heading: f64,
}

/// Compares the two descriptions on a track.
#[derive(Debug)]
pub(super) struct Descriptions {
    track: Arc<Track>,
    track_id: i64,
    /// Most they may be apart.
    most: Contradiction,
    /// The last that were farther apart, and how many. \[-\]
    found: Cell<(u64, Option<Contradiction>)>,
}

impl Descriptions {
    /// Of states on this track.
    pub(super) fn new(car: &CarParams, track: &Arc<Track>) -> Self {
        let DoubtLimits { position, turn, .. } = DoubtLimits::new(car, track);
        let most = Contradiction { position, heading: turn };
        let (track, track_id) = (Arc::clone(track), convert::track_id(track));
        Self { track, track_id, most, found: Cell::default() }
    }

    /// Whether they agree; they do if there is but one.
    pub(super) fn agree(&self, state: &VehicleState) -> bool {
        let both = VehicleState::POSE | VehicleState::FRENET;
        if state.valid & both != both || state.frenet.track_id != self.track_id {
            return true;
        }
        let (s, e_y, e_psi) = (state.frenet.s, state.frenet.e_y, state.frenet.e_psi);
        let pose = self.track.to_global(&State { s, e_y, e_psi, ..State::default() });
        let found = Contradiction {
            position: (state.x - pose.x).hypot(state.y - pose.y),
            heading: wrap_angle(state.yaw - pose.psi).abs(),
        };
        // What is no number agrees with nothing.
        let agree = found.position <= self.most.position && found.heading <= self.most.heading;
        if !agree {
            self.found.set((self.found.get().0 + 1, Some(found)));
        }
        agree
    }

    /// What was found, in words.
    pub(super) fn complaint(&self) -> Option<String> {
        let (count, Some(Contradiction { position, heading })) = self.found.get() else {
            return None;
        };
        let most = self.most;
        Some(format!(
            "{count} states refused: place on the track and x, y are {position:.3} m and {heading:.3} \
             rad apart, expected at most {:.3} m and {:.3} rad: compare the sender's track with this one",
            most.position, most.heading
        ))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]
    use lcm_types::{Header, LapIndex, MonoTime};
    use vehicle_model::Input;

    use super::*;

    #[test]
    fn a_state_that_contradicts_itself_is_refused_and_named() {
        let (car, track) = (CarParams::builtin("barc").unwrap(), Track::builtin("l").unwrap());
        let track = Arc::new(track);
        let descriptions = Descriptions::new(&car, &track);
        let most = descriptions.most;
        assert!(most.position > 0.03 && most.position < 0.1, "{most:?}");
        let state = |s: f64| {
            let x = State { v_x: 1.0, s, e_y: 0.2, e_psi: 0.3, ..State::default() };
            let (h, at) = (Header::default(), MonoTime::from_ns(0));
            convert::state_message(h, at, &x, Input::default(), &track, LapIndex::new(0))
        };
        // All round the track, and where the angle leaps.
        for s in (0..200).map(|i| track.length() * f64::from(i) / 200.0) {
            assert!(descriptions.agree(&state(s)), "s = {s}");
            for sign in [-1.0, 1.0] {
                let moved = |by: f64| VehicleState { y: state(s).y + sign * by, ..state(s) };
                assert!(descriptions.agree(&moved(0.99 * most.position)), "s = {s}");
                assert!(!descriptions.agree(&moved(1.01 * most.position)), "s = {s}");
                let turned = |by: f64| VehicleState { yaw: state(s).yaw + sign * by, ..state(s) };
                assert!(descriptions.agree(&turned(0.99 * most.heading)), "s = {s}");
                assert!(!descriptions.agree(&turned(1.01 * most.heading)), "s = {s}");
            }
        }
        let words = descriptions.complaint().unwrap();
        assert!(words.starts_with("800 states refused"), "{words}");
        assert!(!descriptions.agree(&VehicleState { x: f64::NAN, ..state(1.0) }));
        // Another track's place, or one description alone, contradicts nothing.
        let mut other = VehicleState { x: 1e3, ..state(1.0) };
        other.frenet.track_id += 1;
        assert!(descriptions.agree(&other));
        let one =
            VehicleState { x: 1e3, valid: VehicleState::VEL | VehicleState::FRENET, ..state(1.0) };
        assert!(descriptions.agree(&one));
    }
}
