//! Dynamic bicycle of 1:10 scale on a track of straights and arcs.

use nalgebra::{Matrix6, Matrix6x2, Vector2, Vector6};

/// Sampling period [s].
pub const PERIOD: f64 = 0.1;

const MASS: f64 = 2.2187;
const INERTIA: f64 = 0.02723;
const ARM: f64 = 0.13;

/// Car and track.
pub struct Car {
    pub mu: f64,
    /// Segments: length [m] and curvature [1/m].
    segments: Vec<(f64, f64)>,
}

impl Default for Car {
    fn default() -> Self {
        let turn = std::f64::consts::FRAC_PI_2;
        let left = (turn, 1.0);
        let right = (turn, -1.0);
        // An L: five left corners and one right.
        let straight = |length: f64| (length, 0.0);
        let segments = vec![
            straight(1.5),
            left,
            straight(1.0),
            left,
            straight(0.75),
            right,
            straight(0.75),
            left,
            straight(1.0),
            left,
            straight(2.5),
            left,
            straight(1.5),
        ];
        Self { mu: 0.9, segments }
    }
}

impl Car {
    /// Length of the lap [m].
    pub fn length(&self) -> f64 {
        self.segments.iter().map(|segment| segment.0).sum()
    }

    fn curvature(&self, s: f64) -> f64 {
        let mut s = s.rem_euclid(self.length());
        for (length, curvature) in &self.segments {
            if s < *length {
                return *curvature;
            }
            s -= length;
        }
        0.0
    }

    /// Front and rear slip angle.
    pub fn slip(&self, x: &Vector6<f64>, delta: f64) -> (f64, f64) {
        let v_x = x[0].max(0.05);
        (delta - ((x[1] + ARM * x[2]) / v_x).atan(), -((x[1] - ARM * x[2]) / v_x).atan())
    }

    fn rate(&self, x: &Vector6<f64>, u: &Vector2<f64>, kappa: f64) -> Vector6<f64> {
        let (alpha_f, alpha_r) = self.slip(x, u[1]);
        let tyre = |alpha: f64| 0.5 * self.mu * MASS * 9.81 * (2.28 * (5.0 * alpha).atan()).sin();
        let (f_f, f_r) = (tyre(alpha_f), tyre(alpha_r));
        let (sin, cos) = u[1].sin_cos();
        let s_dot = (x[0] * x[3].cos() - x[1] * x[3].sin()) / (1.0 - kappa * x[5]).max(0.2);
        Vector6::new(
            u[0] - f_f * sin / MASS + x[2] * x[1],
            (f_f * cos + f_r) / MASS - x[2] * x[0],
            ARM * (f_f * cos - f_r) / INERTIA,
            x[2] - kappa * s_dot,
            s_dot,
            x[0] * x[3].sin() + x[1] * x[3].cos(),
        )
    }

    fn integrate(&self, x: &Vector6<f64>, u: &Vector2<f64>, local: Option<f64>) -> Vector6<f64> {
        let mut x = *x;
        let substeps = 10;
        let h = PERIOD / f64::from(substeps);
        for _ in 0..substeps {
            let kappa = local.unwrap_or_else(|| self.curvature(x[4]));
            let k_1 = self.rate(&x, u, kappa);
            let k_2 = self.rate(&(x + k_1 * (h / 2.0)), u, kappa);
            let k_3 = self.rate(&(x + k_2 * (h / 2.0)), u, kappa);
            let k_4 = self.rate(&(x + k_3 * h), u, kappa);
            x += (k_1 + (k_2 + k_3) * 2.0 + k_4) * (h / 6.0);
        }
        x
    }

    /// The state one period later.
    pub fn step(&self, x: &Vector6<f64>, u: &Vector2<f64>) -> Vector6<f64> {
        self.integrate(x, u, None)
    }

    /// Jacobians by central differences, the curvature held, and the state one period later.
    pub fn linearise(
        &self,
        x: &Vector6<f64>,
        u: &Vector2<f64>,
    ) -> (Matrix6<f64>, Matrix6x2<f64>, Vector6<f64>) {
        let kappa = Some(self.curvature(x[4] + 0.5 * PERIOD * x[0]));
        let h = 1e-5;
        let mut a = Matrix6::zeros();
        for j in 0..6 {
            let mut d = Vector6::zeros();
            d[j] = h;
            let difference =
                self.integrate(&(x + d), u, kappa) - self.integrate(&(x - d), u, kappa);
            a.set_column(j, &(difference / (2.0 * h)));
        }
        let mut b = Matrix6x2::zeros();
        for j in 0..2 {
            let mut d = Vector2::zeros();
            d[j] = h;
            let difference =
                self.integrate(x, &(u + d), kappa) - self.integrate(x, &(u - d), kappa);
            b.set_column(j, &(difference / (2.0 * h)));
        }
        (a, b, self.step(x, u))
    }

    /// Centre-line tracking.
    pub fn follow(&self, x: &Vector6<f64>, speed: f64) -> Vector2<f64> {
        let kappa = self.curvature(x[4] + 0.2);
        let delta = 0.26 * kappa - 0.6 * x[5] - 0.9 * x[3];
        Vector2::new((1.5 * (speed - x[0])).clamp(-2.0, 2.0), delta.clamp(-0.436, 0.436))
    }
}
