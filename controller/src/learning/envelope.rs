//! The speed a plan may reach along the track: what driven laps and the grip known so far support,
//! and what the brakes can take away again before the places that allow less.
//!
//! On a grid along s, over the laps of the safe set, with the speed v_c at which a point mass on the curvature
//! that the place needs (`bends.rs`) uses a share of the grip:
//!
//! ```text
//! kappa_needed v_c^2 = share mu (g + downforce(v_c) / m)
//! v_0(s) = max_laps clamp(v_c, (1 + min(least, 0.1 W / L)) v(s), (1 + most) v(s))
//! L = v(s) sqrt(2 W / (mu g))         length of way on which all grip crosses the width W of the track
//! v(s)^2 = min(v_0(s)^2, v(s + ds)^2 + 2 ds (brake |a_min| + drag(v) / m))     backward, twice round
//! ```
//!
//! where the driven speed falls faster than that, as in bends, whose tyres slow the car down too, by what
//! it falls;
//!
//! and nowhere less than the fastest lap was: what was driven can be driven again.
//!
//! The horizon of the optimal control problem thus needs not reach as far as the braking distance.

use serde::{Deserialize, Serialize};
use vehicle_model::{CarParams, GRAVITY, RoadPoint, State, Track};

use super::bends::Bends;
use super::braking::{backward, between, deceleration, grid};
use super::dataset::{Sample, Seen};
use crate::config::EnvelopeConfig;

/// Share of the reserve beside the body whose use is no near miss.
const TOLERATED: f64 = 0.5;
/// Share of the speed taken back where the whole reserve was used up.
const SLOWER: f64 = 0.05;
/// Share of the speed given again with each lap since.
const TRUST: f64 = 0.01;
/// Laps after which a near miss is forgotten.
pub(crate) const REMEMBERED: usize = 8;

/// Least growth times L / W, at most: a bend that is taken too fast leads astray by growth times its angle
/// times its length.
const PER_CROSSING: f64 = 0.1;

/// Greatest speed along the track.
#[derive(Debug, Clone, Default)]
pub(crate) struct Envelope {
    /// Distance of the grid points \[m\].
    ds: f64,
    /// Speed at each grid point \[m/s\]; empty if there is no bound.
    speed: Vec<f64>,
    /// Greatest driven speed \[m/s\].
    driven: Vec<f64>,
}

/// A lap with the samples before and behind it, where the car drove on without interruption.
pub(crate) struct Driven<'a> {
    pub(crate) samples: &'a [Sample],
    pub(crate) before: Option<Seen<'a>>,
    pub(crate) behind: Option<Seen<'a>>,
}

/// A stretch on which the body came closer to an edge than the lane margin allows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct NearMiss {
    /// Index of the lap among all.
    pub(crate) lap: usize,
    /// Where the stretch begins and ends \[m\].
    pub(crate) s: [f64; 2],
    /// Speed there \[m/s\].
    pub(crate) speed: f64,
    /// Share of the reserve beside the body that was used up, 0 to 1.
    pub(crate) used: f64,
}

impl NearMiss {
    /// Adds those between samples of a lap; `used` gives the share of the reserve that a state uses up.
    pub(crate) fn find(
        list: &mut Vec<Self>,
        lap: usize,
        samples: &[Sample],
        used: impl Fn(&State) -> f64,
    ) {
        for pair in samples.windows(2) {
            let used = used(&pair[0].x);
            if used > TOLERATED {
                let s = [pair[0].x.s, pair[1].x.s];
                list.push(Self { lap, s, speed: pair[0].x.v_x, used: used.min(1.0) });
            }
        }
    }

    /// Greatest speed there after `age` more laps \[m/s\].
    fn allowed(&self, age: usize) -> f64 {
        let slower = 1.0 - SLOWER * self.used;
        self.speed * slower * libm::pow(1.0 + TRUST, age as f64)
    }
}

impl Envelope {
    /// The envelope of `laps`; without laps, or switched off, there is no bound.
    pub(crate) fn new<'a>(
        config: &EnvelopeConfig,
        car: &CarParams,
        grip: [f64; 2],
        (track, bends): (&Track, &Bends),
        laps: impl Iterator<Item = Driven<'a>>,
        misses: (&[NearMiss], usize),
    ) -> Self {
        if !config.active {
            return Self::default();
        }
        let (points, ds) = grid(car, track);
        let mut envelope = Self { ds, speed: vec![0.0; points], driven: vec![0.0; points] };
        let room = Room {
            track,
            grip: Grip::new(car, grip),
            bends,
            share: config.grip_share,
            least: config.growth_least,
            most: config.growth_most,
        };
        for lap in laps {
            envelope.add(&room, &lap);
        }
        if envelope.speed.iter().all(|v| *v == 0.0) {
            envelope.speed.clear();
            envelope.driven.clear();
            return envelope;
        }
        let braking = Braking { car, track, brake: config.brake_share * car.hardest_braking(), ds };
        let driven = &envelope.driven;
        backward(&mut envelope.speed, |i, here, after| {
            here.min(braking.reaching(i, after, driven)).max(driven[i])
        });
        envelope.slow_down(&braking, misses);
        envelope
    }

    /// Greatest speed at s \[m/s\]; infinite where nothing bounds it.
    pub(crate) fn at(&self, s: f64) -> f64 {
        between(&self.speed, self.ds, s)
    }

    /// Greatest driven speed at s \[m/s\]; infinite without laps.
    pub(crate) fn driven_at(&self, s: f64) -> f64 {
        between(&self.driven, self.ds, s)
    }

    /// Raises the grid to what a lap supports, between each two samples.
    fn add(&mut self, room: &Room<'_>, lap: &Driven<'_>) {
        let length = room.track.length();
        let (Some(first), Some(last)) = (lap.samples.first(), lap.samples.last()) else { return };
        // Every lap counts up to the line: where one ended a step before it, its neighbours would be a slower
        // lap's, and plans would brake for them.
        let before = lap.before.map_or(State { s: 0.0, ..first.x }, |before| before.place());
        let behind = lap.behind.map_or(State { s: length, ..last.x }, |behind| behind.place());
        self.raise(room, [&before, &first.x]);
        for pair in lap.samples.windows(2) {
            self.raise(room, [&pair[0].x, &pair[1].x]);
        }
        self.raise(room, [&last.x, &behind]);
    }

    /// Raises the grid between two states of a lap, where it lies between line and line.
    fn raise(&mut self, room: &Room<'_>, [from, to]: [&State; 2]) {
        if to.s <= from.s {
            return;
        }
        let n = self.speed.len();
        let (low, high) = (room.speed(from), room.speed(to));
        let first = (from.s.max(0.0) / self.ds).ceil() as usize;
        for i in first..n {
            let share = (i as f64 * self.ds - from.s) / (to.s - from.s);
            if share > 1.0 {
                break;
            }
            let here = &mut self.speed[i];
            *here = here.max(low + share * (high - low));
            let driven = &mut self.driven[i];
            *driven = driven.max(from.v_x + share * (to.v_x - from.v_x));
        }
    }

    /// Less where `misses`, of `count` laps in all, say so, and as far before as braking takes: the
    /// brakes of the envelope, or where a driven lap braked harder, those of that lap.
    fn slow_down(&mut self, braking: &Braking<'_>, (misses, count): (&[NearMiss], usize)) {
        if misses.is_empty() {
            return;
        }
        let n = self.speed.len();
        let mut allowed = vec![f64::INFINITY; n];
        for miss in misses {
            let age = count - 1 - miss.lap;
            let first = (miss.s[0] / self.ds).floor().max(0.0) as usize;
            let last = (miss.s[1] / self.ds).ceil().max(0.0) as usize;
            for i in first..=last {
                let here = &mut allowed[i % n];
                *here = here.min(miss.allowed(age));
            }
        }
        let driven = &self.driven;
        backward(&mut allowed, |i, here, after| here.min(braking.reaching(i, after, driven)));
        for (speed, most) in self.speed.iter_mut().zip(&allowed) {
            *speed = speed.min(*most);
        }
    }
}

/// The car's brakes on the grid.
struct Braking<'a> {
    car: &'a CarParams,
    track: &'a Track,
    /// Deceleration by the brakes \[m/s^2\].
    brake: f64,
    /// Distance of the grid points \[m\].
    ds: f64,
}

impl Braking<'_> {
    /// Greatest speed at grid point i from which `after` is reached at the next \[m/s\]: by brakes and
    /// drag, or by what the driven speeds fall there, to which the tyres add in a bend.
    fn reaching(&self, i: usize, after: f64, driven: &[f64]) -> f64 {
        let brake = deceleration(self.track, i as f64 * self.ds, self.brake);
        let car = self.car;
        let drag =
            0.5 * car.rho * car.cd * car.area * after * after / car.mass + car.linear_drag * after;
        let next = driven[(i + 1) % driven.len()];
        let fell = driven[i] * driven[i] - next * next;
        (after * after + fell.max(2.0 * self.ds * (brake + drag)).max(0.0)).sqrt()
    }
}

/// What the tyres hold across the road.
pub(super) struct Grip {
    /// Friction coefficient.
    pub(super) mu: f64,
    /// Downforce per mass and squared speed \[1/m\].
    pub(super) down: f64,
}

impl Grip {
    pub(super) fn new(car: &CarParams, grip: [f64; 2]) -> Self {
        let mu = (car.tyre_front.mu * grip[0]).min(car.tyre_rear.mu * grip[1]);
        let down = 0.5 * car.rho * car.area * (car.cl_front + car.cl_rear) / car.mass;
        Self { mu, down }
    }
}

/// The speed that a lap supports.
struct Room<'a> {
    track: &'a Track,
    grip: Grip,
    bends: &'a Bends,
    /// Share of the grip that may be used.
    share: f64,
    /// Least growth as configured, as a share of the driven speed.
    least: f64,
    /// Greatest growth, as a share of the driven speed.
    most: f64,
}

impl Room<'_> {
    /// The speed at which a point mass uses the share of the grip where the lap was in this state \[m/s\].
    fn speed(&self, x: &State) -> f64 {
        let road = RoadPoint::of(&self.track.road(), x.s);
        let bank = road.surface.map_or(0.0, |surface| surface.bank);
        let driven = x.omega_z / (x.v_x.max(1e-3) * libm::cos(bank));
        let kappa = self.bends.needed(x.s, x.e_y, driven).copysign(driven);
        let corner = road.corner_speed(kappa, self.share * self.grip.mu, self.grip.down);
        let v = x.v_x.max(0.0);
        corner.clamp((1.0 + self.least_growth(x.s, v)) * v, (1.0 + self.most) * v)
    }

    /// Least growth at s and speed v, `min(least, 0.1 W / L)`.
    fn least_growth(&self, s: f64, v: f64) -> f64 {
        let width = self.track.width_left(s) + self.track.width_right(s);
        let crossing = v * (2.0 / (self.grip.mu * GRAVITY * width)).sqrt();
        self.least.min(PER_CROSSING / crossing)
    }
}

#[cfg(test)]
mod tests;
