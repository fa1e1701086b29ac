//! Settings that follow from the car and the track.
//!
//! Cars of one shape and grip drive alike in units of their own: length l (wheelbase), speed
//! `V = sqrt(mu g l)` and time `T = l / V` (dynamic similarity, Froude's number). The preset `race`
//! was measured on the 1/10-scale car; [`Config::derived`] carries each setting that has a unit over
//! to another car through the ratios of these scales. What a scale cannot know, the car's file
//! says: the tyres' peak slip, the body, the brakes and the steering stop.

use vehicle_model::{CarParams, GRAVITY, Track, Tyre};

use crate::config::Config;
use crate::presets::Preset;

/// Share of the tyres' peak slip at which the slip guards stand.
const PEAK_SHARE: f64 = 0.85;
/// Slip guard of tyres whose curve has no peak, and the greatest of any \[rad\].
const GREATEST_SLIP: f64 = 0.8;
/// Speed of the initial laps as a share of the mean speed that grip and drive allow.
const WARM_UP_SHARE: f64 = 0.3;

/// The scales of a car.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scales {
    /// Wheelbase \[m\].
    pub(crate) length: f64,
    /// Speed sqrt(mu g l) \[m/s\].
    pub(crate) speed: f64,
    /// Time l / speed \[s\].
    pub(crate) time: f64,
}

impl Scales {
    /// Of a car.
    pub(crate) fn new(car: &CarParams) -> Self {
        Self::of(car.wheelbase(), car.tyre_front.mu.min(car.tyre_rear.mu))
    }

    fn of(length: f64, mu: f64) -> Self {
        let speed = (mu * GRAVITY * length).sqrt();
        Self { length, speed, time: length / speed }
    }

    /// Of the car the preset was measured on.
    fn reference() -> Self {
        Self::of(0.26, 1.2)
    }
}

impl Config {
    /// The settings of a preset for this car on this track; `paper` stays as it is printed.
    #[must_use]
    pub fn derived(preset: Preset, car: &CarParams, track: &Track) -> Self {
        let mut config = Self::preset(preset);
        if preset == Preset::Race {
            config.scale(car);
            config.warm_up.speed = warm_up_speed(car, track);
        }
        config
    }

    fn scale(&mut self, car: &CarParams) {
        let (own, reference) = (Scales::new(car), Scales::reference());
        let length = own.length / reference.length;
        let speed = own.speed / reference.speed;
        let time = own.time / reference.time;
        let acceleration = 0.5 * car.a_max.max(-car.a_min);

        let steps = |count: usize| ((count as f64 * time).round() as usize).clamp(count, 4 * count);
        self.horizon.steps = steps(self.horizon.steps);
        self.safe_set.neighbors = steps(self.safe_set.neighbors);

        let metric = &mut self.regression.metric;
        let squares = [speed, speed, speed / length, acceleration, 1.0];
        for (weight, scale) in metric.iter_mut().zip(squares) {
            *weight /= scale * scale;
        }

        // Costs count steps of the sampling period: a longer time scale makes each worth less.
        let cost = &mut self.cost;
        cost.input_acceleration *= time / (acceleration * acceleration);
        cost.input *= time;
        cost.acceleration_rate *= time * time / (acceleration * acceleration) * time;
        cost.gentle_start *= time * time / (acceleration * acceleration) * time;
        cost.steering_rate *= time * time * time;
        cost.steering_rate_floor *= time * time * time;
        let state = [speed, speed, speed / length, 1.0, length, length];
        for (weight, scale) in cost.terminal_slack.iter_mut().zip(state) {
            *weight *= time / (scale * scale);
        }
        cost.lane_linear *= time / length;
        cost.lane_quadratic *= time / (length * length);
        cost.slip *= time;
        cost.speed *= time / speed;

        let limits = &mut self.limits;
        limits.lane_margin = 0.5 * car.width + reserve(car, self.horizon.period);
        limits.front_slip = slip_guard(&car.tyre_front);
        limits.rear_slip = slip_guard(&car.tyre_rear);

        self.warm_up.noise_a *= acceleration;
        self.warm_up.noise_delta *= car.delta_max / 0.436;
    }
}

/// What is kept free beside the body: between two samples the path bows out by at most
/// `a_y dt^2 / 8` \[m\].
fn reserve(car: &CarParams, dt: f64) -> f64 {
    let mu = car.tyre_front.mu.min(car.tyre_rear.mu);
    mu * GRAVITY * dt * dt / 8.0
}

/// A share of the peak slip.
fn slip_guard(tyre: &Tyre) -> f64 {
    (PEAK_SHARE * tyre.peak_slip()).min(GREATEST_SLIP)
}

/// Speed of the initial laps: a share of the mean speed of the fastest lap of the centre line by
/// grip, drive and brakes, no faster than the tightest bend takes at that share.
fn warm_up_speed(car: &CarParams, track: &Track) -> f64 {
    let n = 2000;
    let ds = track.length() / f64::from(n);
    let mu = car.tyre_front.mu.min(car.tyre_rear.mu);
    let top = 300.0_f64;
    let limit = |i: u32| {
        let kappa = track.kappa(f64::from(i) * ds).abs();
        (mu * GRAVITY / kappa.max(mu * GRAVITY / (top * top))).sqrt()
    };
    let mut v: Vec<f64> = (0..n).map(limit).collect();
    let count = v.len();
    for i in 0..2 * count {
        let (here, next) = (v[i % count], (i + 1) % count);
        v[next] = v[next].min((here * here + 2.0 * car.a_max * ds).sqrt());
    }
    for i in (0..2 * count).rev() {
        let (here, next) = (i % count, v[(i + 1) % count]);
        v[here] = v[here].min((next * next - 2.0 * car.a_min * ds).sqrt());
    }
    let time: f64 = v.iter().map(|v| ds / v).sum();
    WARM_UP_SHARE * track.length() / time
}
