//! Parameters of a car and the files they come from.
//!
//! Keys of the TOML file carry their unit (`mass_kg`), fields in code do not. An optional
//! effect is off by default and each has a value that switches it off, so a file that leaves
//! it out describes the plain single-track model.

mod check;
mod file;
mod keys;
mod random;
mod tyre_file;
mod units;

use serde::{Deserialize, Serialize};

use track::{CarSize, fingerprint};

pub use check::ParamProblem;
pub use keys::{CAR_KEYS, CarDefault, CarGroup, CarKey, CarRange};

/// Standard gravity, as the reference numbers use it [m/s^2].
pub const GRAVITY: f64 = 9.81;

/// Key that joined the fingerprint later than all others.
const TOP_SPEED: &str = "speed_max_mps";
/// Share of the peak slip from which on derivatives may be secants.
const SECANT_FROM: f64 = 0.4;
/// Share of the peak slip from which on secants have their full length.
const SECANT_FULL: f64 = 0.85;
/// How fast driving gives way to what holds the top speed as that comes near \[1/s\].
pub const GOVERNOR_GAIN: f64 = 20.0;

/// Lateral tyre of one axle: F_y = D sin(C atan(B alpha)) with D = mu F_z (Pacejka 2012, eq. 4.6,
/// without curvature term).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Tyre {
    /// Stiffness factor B [-].
    pub b: f64,
    /// Shape factor C [-].
    pub c: f64,
    /// Peak friction coefficient of the axle [-].
    pub mu: f64,
    /// Where derivatives of the force are secants.
    #[serde(skip)]
    pub secant: Secant,
}

/// Where derivatives of the lateral force are slopes of secants instead of tangents.
///
/// Near its peak the curve is flat to the outside and steep to the inside: a tangent there says
/// that less slip costs no force. The secant to a smaller slip angle says what it costs. Values are
/// not affected, only derivatives. The default is tangents everywhere.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Secant {
    /// Slip angle from which on \[rad\].
    pub from: f64,
    /// Slip angle from which on they have their full length \[rad\].
    pub full: f64,
    /// Their full length \[rad\]; 0: tangents.
    pub length: f64,
}

impl Tyre {
    /// The same tyre with secants of `share` of its peak slip at `SECANT_FULL` of that; curves
    /// without a peak keep their tangents.
    #[must_use]
    pub fn with_secant(self, share: f64) -> Self {
        let peak = self.peak_slip();
        if share <= 0.0 || !peak.is_finite() {
            return Self { secant: Secant::default(), ..self };
        }
        let secant = Secant {
            from: SECANT_FROM * peak,
            full: SECANT_FULL * peak,
            length: share.min(SECANT_FROM) * peak,
        };
        Self { secant, ..self }
    }

    /// Slip angle of the peak lateral force, tan(pi/(2C))/B \[rad\]; infinite for C <= 1, whose
    /// curve has no peak.
    #[must_use]
    pub fn peak_slip(&self) -> f64 {
        if self.c <= 1.0 {
            return f64::INFINITY;
        }
        libm::tan(std::f64::consts::FRAC_PI_2 / self.c) / self.b
    }
}

/// All parameters of one car: nominal model, simulated plant and input limits.
///
/// Built from a car file with [`CarParams::from_toml`] or [`CarParams::builtin`]. Fields may be
/// changed afterwards; [`CarParams::validate`] tells whether they still make sense.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CarParams {
    /// Name shown in reports; no part of the fingerprint.
    pub name: String,
    /// Mass \[kg\].
    pub mass: f64,
    /// Yaw inertia [kg m^2].
    pub inertia_z: f64,
    /// Centre of gravity to front axle \[m\].
    pub l_f: f64,
    /// Centre of gravity to rear axle \[m\].
    pub l_r: f64,
    /// Lateral tyre of the front axle.
    pub tyre_front: Tyre,
    /// Lateral tyre of the rear axle.
    pub tyre_rear: Tyre,
    /// Height of the centre of gravity, moves load between the axles; 0 is off \[m\].
    pub h_cg: f64,
    /// Drag coefficient; 0 is off [-].
    pub cd: f64,
    /// Downforce coefficient of the front axle; 0 is off [-].
    pub cl_front: f64,
    /// Downforce coefficient of the rear axle; 0 is off [-].
    pub cl_rear: f64,
    /// Reference area of `cd` and `cl` [m^2].
    pub area: f64,
    /// Density of air [kg/m^3].
    pub rho: f64,
    /// Rolling resistance coefficient; 0 is off [-].
    pub rolling: f64,
    /// Deceleration per speed, v_x' -= linear_drag v_x, for studies; 0 is off [1/s].
    pub linear_drag: f64,
    /// Share of driving force on the steered front axle, 0 to 1 [-].
    pub drive_front: f64,
    /// Share of braking force on the steered front axle, 0 to 1 [-].
    pub brake_front: f64,
    /// Whether the longitudinal force of the steered front wheels turns the car (physics says
    /// so; the reference numbers leave it out).
    pub front_force_yaw: bool,
    /// Whether longitudinal force takes from the lateral force (friction ellipse).
    pub combined_slip: bool,
    /// Limit of driving power at the wheels; `None` is off \[W\].
    pub power_max: Option<f64>,
    /// Limit of driving force; `None` is off \[N\].
    pub drive_force_max: Option<f64>,
    /// Limit of braking force; `None` is off \[N\].
    pub brake_force_max: Option<f64>,
    /// Top speed that gearing or a governor allows; `None` is off \[m/s\].
    #[serde(default)]
    pub speed_max: Option<f64>,
    /// Body length \[m\].
    pub length: f64,
    /// Body width \[m\].
    pub width: f64,
    /// Strongest braking command, negative [m/s^2].
    pub a_min: f64,
    /// Strongest driving command [m/s^2].
    pub a_max: f64,
    /// Steering stop on each side \[rad\].
    pub delta_max: f64,
    /// Limit of the steering rate; `None` is off [rad/s].
    pub delta_rate_max: Option<f64>,
    /// Limit of the rate of the acceleration; `None` is off [m/s^3].
    pub a_rate_max: Option<f64>,
    /// First-order time constant of the actuators; 0 is off \[s\].
    pub actuator_lag: f64,
    /// Transport delay of the inputs; 0 is off \[s\].
    pub actuator_delay: f64,
    /// At and below this speed the lateral dynamics are kinematic [m/s].
    pub blend_speed_low: f64,
    /// At and above this speed the tyre model acts alone; both blend speeds 0 is off [m/s].
    pub blend_speed_high: f64,
}

impl CarParams {
    /// Distance between the axles, l_f + l_r \[m\].
    #[must_use]
    pub fn wheelbase(&self) -> f64 {
        self.l_f + self.l_r
    }

    /// Static vertical load of the front and rear axle, m g l_other / l \[N\].
    #[must_use]
    pub fn static_loads(&self) -> [f64; 2] {
        let weight = self.mass * GRAVITY;
        [weight * (self.l_r / self.wheelbase()), weight * (self.l_f / self.wheelbase())]
    }

    /// Vertical load of the front and rear axle at a constant speed: static load and downforce \[N\].
    #[must_use]
    pub fn loads_at(&self, v_x: f64) -> [f64; 2] {
        let [front, rear] = self.static_loads();
        let lift = |cl: f64| 0.5 * self.rho * self.area * cl * v_x * v_x;
        [front + lift(self.cl_front), rear + lift(self.cl_rear)]
    }

    /// Load that a deceleration \[m/s^2\] moves from the rear axle to the front axle \[N\].
    #[must_use]
    pub fn moved_load(&self, deceleration: f64) -> f64 {
        self.mass * deceleration * self.h_cg / self.wheelbase()
    }

    /// Strongest deceleration by the brakes: what may be commanded, or what their force gives \[m/s^2\].
    #[must_use]
    pub fn hardest_braking(&self) -> f64 {
        self.brake_force_max.map_or(f64::INFINITY, |force| force / self.mass).min(-self.a_min)
    }

    /// This car with the same friction coefficient on both axles, as the studies set it.
    #[must_use]
    pub fn with_mu(mut self, mu: f64) -> Self {
        self.tyre_front.mu = mu;
        self.tyre_rear.mu = mu;
        self
    }

    /// Switches the low-speed blend off: the tyre model acts at every speed.
    #[must_use]
    pub fn without_blend(mut self) -> Self {
        self.blend_speed_low = 0.0;
        self.blend_speed_high = 0.0;
        self
    }

    /// Hash of every number (not of the name): FNV-1a over the bits of the rows of
    /// [`CAR_KEYS`] in their order,
    /// the same on every machine. Two cars with equal fingerprints have equal equations.
    #[must_use]
    pub fn fingerprint(&self) -> u64 {
        let keys = CAR_KEYS.iter().filter(|key| key.key != TOP_SPEED);
        // An absent limit counts as infinite.
        let value = |key: &CarKey| (key.get)(self).unwrap_or(f64::INFINITY).to_bits();
        let mut words: Vec<u64> = keys.map(value).collect();
        // Absent it adds nothing: cars without it keep the fingerprint they had.
        if let Some(speed) = self.speed_max {
            words.push(speed.to_bits());
        }
        words.extend([self.front_force_yaw, self.combined_slip].map(u64::from));
        fingerprint(&words)
    }
}

impl<'a> From<&'a CarParams> for CarSize<'a> {
    fn from(car: &'a CarParams) -> Self {
        Self {
            name: &car.name,
            width: car.width,
            lock: car.wheelbase() / libm::tan(car.delta_max),
            grip: car.tyre_front.mu.min(car.tyre_rear.mu) * GRAVITY,
        }
    }
}
