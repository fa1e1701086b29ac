//! Settings that follow from the car and the track.
//!
//! Cars of one shape and grip drive alike in units of their own: length l (wheelbase), speed
//! `V = sqrt(mu g l)` and time `T = l / V` (dynamic similarity, Froude's number). The preset `race`
//! was measured on the 1/10-scale car; [`Config::derived`] carries each setting that has a unit over
//! to another car through the ratios of these scales. What a scale cannot know, the car's file
//! says: the tyres' peak slip, the body, the brakes and the steering stop.

mod yaw;

use vehicle_model::{CarParams, GRAVITY, RoadPoint, Track, Tracker, Tyre};

use crate::config::Config;
use crate::presets::Preset;

/// Share of the tyres' peak slip at which the slip guards stand, front and rear: a front axle at its
/// peak runs wide, a rear axle beyond it spins the car.
const PEAK_SHARE: [f64; 2] = [1.0, 0.85];
/// Peak slip of tyres whose curve has no peak, and the greatest of any \[rad\].
const GREATEST_SLIP: f64 = 0.8;
/// Reserve beside the body as a share of its width.
const RESERVE_WIDTH: f64 = 0.05;
/// Reserve beside the body as an error of the way the car goes until a correction acts, as a share of the
/// peak slip: tyres that slip farther before they lose grip let the car go farther astray.
const RESERVE_SLIP: f64 = 0.13;
/// Least such error \[rad\].
const RESERVE_HEADING: f64 = 0.021;
/// Ridge weight where lag blurs the inputs: what few samples say of slopes is then noise.
const LAGGING_RIDGE: f64 = 30.0;
/// Secant length where lag makes corrections come late: tangents near the peak then make the
/// steering chatter.
const LAGGING_SECANT: f64 = 0.3;
/// Least growth of the speed from lap to lap where corrections come late.
const LAGGING_GROWTH: f64 = 0.02;
/// Factor of the weight of slip beyond its guards where corrections come late.
const LAGGING_SLIP: f64 = 10.0;
/// Lag, as a share of the sampling period, beyond which a fit of the grip from slow laps takes the
/// blurred inputs for grip.
const LAG_SHARE: f64 = 0.5;
/// Standard deviation by which excitation leads the car astray, at most, as a share of the room beside its
/// body where the track is narrowest; and places at which that is looked for.
const ASTRAY: f64 = 0.125;
const PLACES: u32 = 1000;
/// Speed of the initial laps as a share of the mean speed that grip and drive allow.
const WARM_UP_SHARE: f64 = 0.3;

/// No road car is faster \[m/s\].
const FASTEST: f64 = 150.0;
/// Greatest change of the speed within one sampling period, in speeds sqrt(mu g l): a car that gains or loses
/// more of it while it turns has left the bend that the plan was linearised in.
const SPEED_CHANGE: f64 = 0.27;
/// Greatest [`turn`] at top speed: a plan whose inputs turn the car by more in one step weaves.
const TURN: f64 = 4.5;
/// Top speed on the racing line over that on the centre line, at most.
const RACING_LINE: f64 = 1.25;
/// Sampling period at least \[ms\].
const SHORTEST: f64 = 10.0;
/// Horizon at most.
const MOST: usize = 100;

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
            let lap = PointMass::new(car, track);
            let substep = config.horizon.period / config.horizon.substeps as f64;
            let wanted = yaw::longest_period(car, slip_guards(car), RACING_LINE * lap.top);
            let (scales, strongest) = (Scales::new(car), car.a_max.max(-car.a_min));
            let wanted = wanted.min(SPEED_CHANGE * scales.speed / strongest);
            // A smaller car does as much in less time; a larger one is no slower to steer for that.
            let smaller = (scales.time / Scales::reference().time).min(1.0);
            // Whole milliseconds: hosts step in them.
            let period = (1e3 * wanted.min(smaller * config.horizon.period)).floor();
            let mut period = period.max(SHORTEST);
            // A shorter period does not make the tyres answer sooner.
            let reaction = period / 1e3;
            while period > SHORTEST && turn(car, lap.top, period / 1e3) > TURN {
                period -= 1.0;
            }
            config.horizon.period = period / 1e3;
            config.horizon.substeps = (config.horizon.period / substep).round().max(1.0) as usize;
            config.scale(car, &lap, reaction);
            let warm_up = &mut config.warm_up;
            warm_up.speed = round(WARM_UP_SHARE * lap.mean);
            let most = most_excitation(car, track, warm_up.speed, config.horizon.period);
            warm_up.noise_delta = warm_up.noise_delta.min(most);
        }
        config
    }

    fn scale(&mut self, car: &CarParams, lap: &PointMass, reaction: f64) {
        let (own, reference) = (Scales::new(car), Scales::reference());
        let length = own.length / reference.length;
        let speed = own.speed / reference.speed;
        // In sampling periods.
        let time = own.time / reference.time * (0.1 / self.horizon.period);
        let acceleration = 0.5 * car.a_max.max(-car.a_min);

        let steps = (self.horizon.steps as f64 * time).round() as usize;
        self.horizon.steps = steps.clamp(self.horizon.steps, MOST);

        if car.actuator_lag > LAG_SHARE * self.horizon.period {
            self.nominal.adapt_grip = false;
            self.regression.ridge = LAGGING_RIDGE;
            self.nominal.secant = LAGGING_SECANT;
            // Its force follows what acts, not what is commanded.
            self.nominal.inverse_tyre = false;
            self.envelope.growth_least = LAGGING_GROWTH;
            self.cost.slip *= LAGGING_SLIP;
        }
        let metric = &mut self.regression.metric;
        let squares = [speed, speed, speed / length, acceleration, 1.0];
        for (weight, scale) in metric.iter_mut().zip(squares) {
            *weight /= scale * scale;
        }

        // Costs are in steps. One of each stage comes as often as the steps of the lap time it is weighed
        // against, whatever the period; the terminal slack comes once.
        let each = own.time / reference.time;
        let rate = each * each * each;
        let cost = &mut self.cost;
        cost.input_acceleration *= each / (acceleration * acceleration);
        cost.input *= each;
        // A car whose drive and brakes are as strong as its tyres turns with every change of them: what noise
        // adds to the first input must not.
        let grip = speed * speed / length;
        cost.acceleration_rate *=
            rate / (acceleration * acceleration) * (acceleration / grip).sqrt();
        cost.gentle_start *= rate / (acceleration * acceleration);
        cost.steering_rate *= rate;
        cost.steering_rate_floor *= rate;
        let state = [speed, speed, speed / length, 1.0, length, length];
        for (weight, scale) in cost.terminal_slack.iter_mut().zip(state) {
            *weight *= time / (scale * scale);
        }
        cost.lane_linear *= each / length;
        cost.lane_quadratic *= each / (length * length);
        cost.slip *= each;
        cost.speed *= each / speed;

        let limits = &mut self.limits;
        limits.lane_margin = 0.5 * car.width + reserve(car, lap, reaction);
        [limits.front_slip, limits.rear_slip] = slip_guards(car);

        self.warm_up.noise_a *= acceleration;
        self.warm_up.noise_delta *= car.delta_max / 0.436;
    }
}

/// Greatest excitation of the steering in the initial laps \[rad\]. White noise of the steering angle leads
/// the tracked car astray, `e_y'' = -e_y / r^2 - 2 e_y' / r + delta / l` along its path, by the standard
/// deviation `sigma_delta sqrt(v dt r^3) / (2 l)`.
fn most_excitation(car: &CarParams, track: &Track, speed: f64, dt: f64) -> f64 {
    let reach = Tracker::new(car).reach(speed);
    let astray = 0.5 * (speed * dt * reach.powi(3)).sqrt() / car.wheelbase();
    let width = |s: f64| track.width_left(s).min(track.width_right(s));
    let places = (0..PLACES).map(|i| track.length() * f64::from(i) / f64::from(PLACES));
    let room = places.map(width).fold(f64::INFINITY, f64::min) - 0.5 * car.width;
    ASTRAY * room.max(0.0) / astray
}

/// What is kept free beside the body \[m\]: a share of its width, and what an error of heading leads
/// astray at top speed until most of a correction acts, the reaction time \[s\] and twice the lag.
fn reserve(car: &CarParams, lap: &PointMass, reaction: f64) -> f64 {
    let peak = peak_slip(&car.tyre_front).max(peak_slip(&car.tyre_rear));
    let error = (RESERVE_SLIP * peak).max(RESERVE_HEADING);
    RESERVE_WIDTH * car.width + error * lap.top * (reaction + 2.0 * car.actuator_lag)
}

/// Slip guards, front and rear [rad].
fn slip_guards(car: &CarParams) -> [f64; 2] {
    [PEAK_SHARE[0] * peak_slip(&car.tyre_front), PEAK_SHARE[1] * peak_slip(&car.tyre_rear)]
}

/// Slip angle of the greatest lateral force, as far as a plan may use it [rad].
fn peak_slip(tyre: &Tyre) -> f64 {
    tyre.peak_slip().min(GREATEST_SLIP)
}

/// The fastest lap of the centre line by grip, drive and brakes alone: a point mass, whose bends
/// do not take from its drive.
struct PointMass {
    /// Mean speed \[m/s\].
    mean: f64,
    /// Top speed \[m/s\].
    top: f64,
}

impl PointMass {
    fn new(car: &CarParams, track: &Track) -> Self {
        let n = 2000;
        let ds = track.length() / f64::from(n);
        let grip = car.tyre_front.mu.min(car.tyre_rear.mu) * GRAVITY;
        let road = track.road();
        let bend = |i: u32| {
            let s = f64::from(i) * ds;
            let kappa = track.kappa(s).abs();
            let limit = track.speed_limit(s).min(car.speed_max.unwrap_or(f64::INFINITY));
            let bend = match RoadPoint::of(&road, s) {
                RoadPoint { surface: None, .. } => {
                    (grip / kappa.max(grip / (FASTEST * FASTEST))).sqrt()
                }
                hills => hills.corner_speed(hills.kappa, grip / GRAVITY, 0.0).min(FASTEST),
            };
            bend.min(limit)
        };
        let mut v: Vec<f64> = (0..n).map(bend).collect();
        let count = v.len();
        for i in 0..2 * count {
            let (here, next) = (v[i % count], (i + 1) % count);
            let drag = 0.5 * car.rho * car.cd * car.area * here * here / car.mass;
            let force = car.drive_force_max.map_or(f64::INFINITY, |force| force / car.mass);
            let power = car.power_max.map_or(f64::INFINITY, |power| power / car.mass / here);
            let drive = car.a_max.min(force).min(power) - drag - car.linear_drag * here;
            let drive = drive - GRAVITY * libm::sin(track.slope((i % count) as f64 * ds));
            v[next] = v[next].min((here * here + 2.0 * drag_limited(drive) * ds).sqrt());
        }
        for i in (0..2 * count).rev() {
            let (here, next) = (i % count, v[(i + 1) % count]);
            v[here] = v[here].min((next * next - 2.0 * car.a_min * ds).sqrt());
        }
        let time: f64 = v.iter().map(|v| ds / v).sum();
        Self { mean: track.length() / time, top: v.iter().copied().fold(0.0, f64::max) }
    }
}

/// A speed in numbers a person would write: to 0.1 m/s, below 1 m/s to 0.01 m/s.
fn round(speed: f64) -> f64 {
    let parts = if speed < 1.0 { 100.0 } else { 10.0 };
    ((speed * parts).round() / parts).max(0.1)
}

/// A car at its top speed is not slowed down by its drive.
fn drag_limited(drive: f64) -> f64 {
    drive.max(0.0)
}

/// Yaw rate that the front axle's grip gives within one sampling period, over that of the sharpest bend
/// at this speed, mu g / v:
///
/// ```text
/// m l_f l_r v / (l I) (dt - tau (1 - exp(-dt / tau)))        tau: lag of the steering
/// ```
fn turn(car: &CarParams, v: f64, dt: f64) -> f64 {
    let lag = car.actuator_lag;
    let missing = if lag > 0.0 { lag * (1.0 - libm::exp(-dt / lag)) } else { 0.0 };
    let arms = car.l_f * car.l_r / car.wheelbase();
    car.mass * arms * v / car.inertia_z * (dt - missing)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use rand::SeedableRng as _;
    use rand_distr::{Distribution as _, StandardNormal};

    use super::*;

    const OVAL: &str = "name = \"oval\"\nwidth_left_m = 0.1\nwidth_right_m = 0.1\n
        [[segment]]\nlength_m = 4.0\n[[segment]]\nlength_m = 3.141592653589793\nradius_m = 1.0\n
        [[segment]]\nlength_m = 4.0\n[[segment]]\nlength_m = 3.141592653589793\nradius_m = 1.0\n";

    /// Noise of the steering in the path's own equation, step by step.
    #[test]
    fn excitation_leads_the_car_astray_by_a_share_of_the_room() {
        let (car, track) = (CarParams::builtin("mini").unwrap(), Track::from_toml(OVAL).unwrap());
        let (speed, dt) = (1.1, 0.056);
        let sigma = most_excitation(&car, &track, speed, dt);
        let reach = Tracker::new(&car).reach(speed);
        let mut random = rand_pcg::Pcg64::seed_from_u64(1);
        let (mut e_y, mut slope, mut squares) = (0.0_f64, 0.0, 0.0);
        let (steps, fine) = (100_000, 10);
        let ds = speed * dt / f64::from(fine);
        for _ in 0..steps {
            let noise: f64 = StandardNormal.sample(&mut random);
            for _ in 0..fine {
                let turn = sigma * noise / car.wheelbase();
                slope += ds * (turn - e_y / (reach * reach) - 2.0 * slope / reach);
                e_y += ds * slope;
            }
            squares += e_y * e_y;
        }
        let deviation = (squares / f64::from(steps)).sqrt();
        let room = 0.1 - 0.5 * car.width;
        assert!((deviation / (ASTRAY * room) - 1.0).abs() < 0.1, "{deviation} of {room} m");
    }

    /// The moment of a front axle at its grip, behind a steering that lags, integrated over a period.
    #[test]
    fn the_turn_of_a_period_is_that_of_the_front_axle() {
        let (v, dt, steps) = (30.0, 0.09, 10_000);
        for name in ["barc", "iac"] {
            let car = CarParams::builtin(name).unwrap();
            let force = 0.9 * GRAVITY * car.mass * car.l_r / car.wheelbase();
            let (mut acting, mut yaw_rate) = (0.0, 0.0);
            let h = dt / f64::from(steps);
            for _ in 0..steps {
                let rate = if car.actuator_lag > 0.0 { h / car.actuator_lag } else { 1.0 };
                acting += rate * (1.0 - acting);
                yaw_rate += h * acting * force * car.l_f / car.inertia_z;
            }
            let expected = yaw_rate / (0.9 * GRAVITY / v);
            let found = turn(&car, v, dt);
            assert!((found / expected - 1.0).abs() < 1e-3, "{name}: {found} not {expected}");
        }
    }

    /// Cars whose drive and brakes are strong for their size are controlled in shorter periods.
    #[test]
    fn no_car_changes_its_speed_by_much_in_one_period() {
        let track = Track::builtin("l").unwrap();
        let period = |car: &CarParams| Config::derived(Preset::Race, car, &track).horizon.period;
        let mut car = CarParams::builtin("barc").unwrap();
        assert_eq!(period(&car), 0.1);
        for (a_min, a_max) in [(-8.0, 2.0), (-2.0, 8.0)] {
            (car.a_min, car.a_max) = (a_min, a_max);
            let scale = (car.tyre_front.mu * GRAVITY * car.wheelbase()).sqrt();
            let change = 8.0 * period(&car) / scale;
            assert!(change < SPEED_CHANGE && change > 0.95 * SPEED_CHANGE, "{change}");
        }
    }

    #[test]
    fn only_a_narrow_track_takes_excitation_away() {
        let car = CarParams::builtin("mini").unwrap();
        let excitation =
            |track: &Track| Config::derived(Preset::Race, &car, track).warm_up.noise_delta;
        let wide = excitation(&Track::builtin("l").unwrap());
        assert!((wide - 0.02 * car.delta_max / 0.436).abs() < 1e-12, "{wide} rad");
        assert!(excitation(&Track::from_toml(OVAL).unwrap()) < 0.7 * wide);
    }
}
