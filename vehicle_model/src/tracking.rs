//! Centre-line tracking: the initial laps, and what is left when no plan is.

use crate::params::{CarParams, GRAVITY};
use crate::state::{Input, State};
use crate::track::Track;

/// Rise time of the speed loop [s].
const SPEED_TIME: f64 = 0.5;
/// Distance over which a deviation decays, in wheelbases, at low speed.
const REACH_WHEELBASES: f64 = 3.0;
/// The same in seconds of travel, at high speed.
const REACH_TIME: f64 = 0.8;
/// Share of the tyres' grip that a bend of the centre line may take.
const BEND_SHARE: f64 = 0.3;
/// Share of the strongest braking with which bends are approached.
const BEND_BRAKE: f64 = 0.3;
/// Deviation by slow steering that is allowed, as a share of the width of the track.
const STEER_ASTRAY: f64 = 0.02;
/// Places looked at ahead.
const LOOKED_AT: f64 = 20.0;
/// Share of the tyres' grip that braking may use.
const BRAKE_SHARE: f64 = 0.8;
/// Share of the tyres' grip up to which slip grows about linearly with the lateral acceleration.
const LINEAR_SHARE: f64 = 0.5;

/// Tracking law of a car.
#[derive(Debug, Clone)]
pub struct Tracker {
    wheelbase: f64,
    /// Centre of gravity to rear axle \[m\].
    l_r: f64,
    /// Slip angles of front and rear axle for each lateral acceleration \[rad s^2/m\].
    slip: [f64; 2],
    /// Lateral acceleration the tyres hold [m/s^2].
    grip: f64,
    /// Rate of the steering, where it is limited \[rad/s\].
    steering_rate: Option<f64>,
    least: Input,
    most: Input,
}

impl Tracker {
    /// Of this car.
    #[must_use]
    pub fn new(car: &CarParams) -> Self {
        let mu = car.tyre_front.mu.min(car.tyre_rear.mu);
        Self {
            wheelbase: car.l_f + car.l_r,
            l_r: car.l_r,
            slip: [&car.tyre_front, &car.tyre_rear].map(|t| 1.0 / (GRAVITY * t.mu * t.b * t.c)),
            grip: 9.81 * mu,
            steering_rate: car.delta_rate_max,
            least: Input { a: car.a_min, delta: -car.delta_max },
            most: Input { a: car.a_max, delta: car.delta_max },
        }
    }

    /// Follows the centre line at speed `v_ref` \[m/s\], slower where a bend ahead asks for it.
    #[must_use]
    pub fn track(&self, x: &State, track: &Track, v_ref: f64) -> Input {
        let climb = if track.is_flat() { 0.0 } else { GRAVITY * libm::sin(track.slope(x.s)) };
        let wanted = self.speed_loop(x, v_ref.min(self.bend_speed(x, track))) + climb;
        let a = wanted.clamp(self.least.a, self.most.a);
        let kappa = parallel(x, track);
        let [side_slip, more] = self.steady_bend(x.v_x, kappa);
        let delta = self.steer(x, kappa, side_slip) + more;
        let delta = delta.clamp(self.least.delta, self.most.delta);
        Input { a: a.max(self.hardest_brake(x, track)), delta }
    }

    /// Distance over which a deviation decays at a speed \[m\].
    #[must_use]
    pub fn reach(&self, v: f64) -> f64 {
        (REACH_WHEELBASES * self.wheelbase).max(REACH_TIME * v)
    }

    /// Acceleration towards a speed.
    #[must_use]
    pub fn speed_loop(&self, x: &State, v_ref: f64) -> f64 {
        ((v_ref - x.v_x) / SPEED_TIME).clamp(self.least.a, self.most.a)
    }

    /// Braking that what the car's turning uses of the grip leaves \[m/s^2\].
    #[must_use]
    pub fn brakes(&self, x: &State) -> f64 {
        self.left_for_braking(x.v_x * x.omega_z)
    }

    /// Curvature that takes a share of the grip at a speed \[1/m\].
    #[must_use]
    pub fn bend_curvature(&self, share: f64, v: f64) -> f64 {
        share * self.grip / (v * v).max(1e-9)
    }

    /// Speed at which a bend takes the share of the grip that bends may take \[m/s\].
    #[must_use]
    pub fn turning_speed(&self, kappa: f64) -> f64 {
        (BEND_SHARE * self.grip / kappa.max(1e-9)).sqrt()
    }

    /// Speed from which comfortable braking reaches what each bend ahead allows.
    fn bend_speed(&self, x: &State, track: &Track) -> f64 {
        let brake = BEND_BRAKE * -self.least.a;
        let stopping = x.v_x * x.v_x / (2.0 * brake) + x.v_x * SPEED_TIME;
        let step = self.wheelbase.max(stopping / LOOKED_AT);
        let mut slowest = f64::INFINITY;
        for i in 0..=LOOKED_AT as u32 {
            let ahead = f64::from(i) * step;
            let kappa = track.kappa(x.s + ahead).abs().max(1e-9);
            let room = ((ahead - x.v_x * SPEED_TIME).max(0.0)) * 2.0 * brake;
            let grip = BEND_SHARE * self.grip * track.friction(x.s + ahead);
            let limit = track.speed_limit(x.s + ahead);
            slowest = slowest.min(grip / kappa + room).min(limit * limit + room);
            let turned = (track.kappa(x.s + ahead + step) - track.kappa(x.s + ahead)).abs();
            let steered = self.steering_speed(turned, step, x, track);
            slowest = slowest.min(steered * steered + room);
        }
        slowest.sqrt()
    }

    /// Speed at which the wheels follow a change of curvature within `length`: while they turn at
    /// their rate, an abrupt change leads the car `turned v^2 T^2 / 6` astray, T the time it takes
    /// them \[m/s\].
    fn steering_speed(&self, turned: f64, length: f64, x: &State, track: &Track) -> f64 {
        let Some(rate) = self.steering_rate.filter(|_| turned > 1e-9) else { return f64::INFINITY };
        let astray = STEER_ASTRAY * (track.width_left(x.s) + track.width_right(x.s));
        rate / (self.wheelbase * turned) * length.max((6.0 * astray / turned).sqrt())
    }

    /// Brakes along the centre line, as hard as cornering leaves grip for. At the limit of grip, where a stop may
    /// begin, the front axle has nothing to add to a bend: only the path steers.
    #[must_use]
    pub fn brake(&self, x: &State, track: &Track) -> Input {
        let stopping = (-x.v_x / SPEED_TIME).clamp(self.least.a, 0.0);
        let delta = self.steer(x, parallel(x, track), 0.0);
        Input { a: stopping.max(self.hardest_brake(x, track)), delta }
    }

    /// Path curvature with which e_y decays critically damped over the reach:
    /// e_y'' = -e_y / r^2 - 2 e_y' / r, derivatives along the path, with the curvature [`parallel`] and the body's
    /// side slip \[rad\].
    fn steer(&self, x: &State, parallel: f64, side_slip: f64) -> f64 {
        let reach = self.reach(x.v_x);
        let course = x.e_psi + side_slip;
        let wanted = parallel - x.e_y / (reach * reach) - 2.0 * libm::sin(course) / reach;
        libm::atan(self.wheelbase * wanted).clamp(self.least.delta, self.most.delta)
    }

    /// Side slip `l_r kappa - alpha_r` of the body in a steady bend, and the angle `alpha_f - alpha_r` by which the
    /// wheels turn more than the path (Rajamani, Vehicle Dynamics and Control, ch. 3) \[rad\]. Left to the
    /// feedback, both would be paid for with e_y.
    fn steady_bend(&self, v: f64, kappa: f64) -> [f64; 2] {
        let linear = LINEAR_SHARE * self.grip;
        let lateral = (v * v * kappa).clamp(-linear, linear);
        let [front, rear] = self.slip.map(|slip| slip * lateral);
        [self.l_r * kappa - rear, front - rear]
    }

    /// Friction circle: what the lateral acceleration leaves of the grip.
    fn hardest_brake(&self, x: &State, track: &Track) -> f64 {
        -self.left_for_braking(x.v_x * x.v_x * track.kappa(x.s))
    }

    fn left_for_braking(&self, lateral: f64) -> f64 {
        let left = (self.grip * self.grip - lateral * lateral).max(0.0).sqrt();
        (BRAKE_SHARE * left).max(0.1 * self.grip)
    }
}

/// Curvature of the line through the car that is parallel to the centre line \[1/m\].
fn parallel(x: &State, track: &Track) -> f64 {
    let kappa = track.kappa(x.s);
    kappa / (1.0 - kappa * x.e_y).max(0.2)
}
