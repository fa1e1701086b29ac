//! The Riccati recursion with the previous input as state.
//!
//! The cost-to-go of a direction from stage t is the quadratic
//!
//! ```text
//! V_t(x, v) = 1/2 x'P x + x'M v + 1/2 v'N v + p'x + n'v,       v = u_{t-1}
//! ```
//!
//! Two things hold v: the rates `u - v`, with the diagonal curvature D, and, where the actuators
//! lag, the dynamics x_{t+1} = A x + B u + E v, with E a multiple of B. No product is larger than
//! 6 x 6. With P, M, N, p, n of stage t+1 (P and p hold the soft constraints on x_{t+1} already)
//! and stage t's own curvature and gradient:
//!
//! ```text
//! G   = R + B'P B + B'M + M'B + N,     H = G + D
//! F   = A'(P B + M) + front slip                        6 x 2
//! K   = B'P E + M'E                                     2 x 2
//! u   = -H^-1 (F'x + h) + H^-1 (D - K) v,    h = r + d + B'p + n
//! P_t = A'P A - F H^-1 F' + front slip
//! M_t = A'P E + F H^-1 (D - K)
//! N_t = E'P E + D - (D - K)' H^-1 (D - K)
//! p_t = A'p - F H^-1 h + front slip,   n_t = E'p + (D - K)' H^-1 h - d
//! ```
//!
//! A defect c = A x + B u + E v + C - x_{t+1} of the iterate moves p to p + P c and n to n + M'c.
//! The costate of x_{t+1} after a full step is `P dx + M du + p`.
//!
//! In N_t, `D - D H^-1 D` is formed as `G H^-1 D`: an active rate limit makes D large, and the
//! difference would lose the digits of G.

use nalgebra::{Matrix2, Matrix2x6, Matrix6, Matrix6x2, SMatrix, Vector2, Vector6};

use super::super::{Affine, Fhocp};
use super::product::{product, transpose};
use super::rows::{FRONT, INPUT, LANE, RATE, REAR, Rows, SPEED};
use super::stage::Stages;

/// A, B and their transposes of one stage.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Model {
    a: Matrix6<f64>,
    b: Matrix6x2<f64>,
    a_transposed: Matrix6<f64>,
    b_transposed: Matrix2x6<f64>,
    /// Whether velocities do not depend on the pose.
    flat: bool,
}

impl Model {
    #[inline(always)]
    pub(super) fn load(&mut self, model: &Affine, lag: f64) {
        self.a = model.a;
        self.b = model.b * (1.0 - lag);
        self.a_transposed = transpose(&model.a);
        self.b_transposed = transpose(&self.b);
        self.flat = model.a.data.0[3..].iter().all(|column| column[..3] == [0.0; 3]);
    }

    /// A x + B u.
    #[inline(always)]
    fn apply(&self, x: &Vector6<f64>, u: &Vector2<f64>) -> Vector6<f64> {
        product(&self.a, x) + product(&self.b, u)
    }

    /// A'p and B'p.
    #[inline(always)]
    pub(super) fn adjoint(&self, p: &Vector6<f64>) -> (Vector6<f64>, Vector2<f64>) {
        (product(&self.a_transposed, p), product(&self.b_transposed, p))
    }
}

/// Feedback of one stage: u = offset - (F H^-1)' x + H^-1 (D - K) v.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Gain {
    /// F H^-1.
    state: Matrix6x2<f64>,
    state_transposed: Matrix2x6<f64>,
    /// H^-1 (D - K).
    previous: Matrix2<f64>,
    /// H^-1.
    inverse: Matrix2<f64>,
    /// H^-1 h.
    offset: Vector2<f64>,
    /// P of x_{t+1}.
    p: Matrix6<f64>,
    /// P A. Memory that nobody else reads: what is stored is computed in vectors.
    pa: Matrix6<f64>,
    /// M of x_{t+1} and u_t.
    m: Matrix6x2<f64>,
    /// p of x_{t+1}.
    pub(super) gradient: Vector6<f64>,
}

/// Factors the stages backward from the terminal curvature.
///
/// Each P is written where it is kept and read from there: as a local variable it would be taken apart into
/// single numbers, and products with it would not become vector instructions.
#[inline(always)]
pub(super) fn factor(
    problem: &Fhocp,
    models: &[Model],
    (rows, curvature): (&Rows, &[f64]),
    terminal: &Matrix6<f64>,
    gains: &mut [Gain],
) {
    let (mut m, mut n) = (Matrix6x2::zeros(), Matrix2::zeros());
    let carry = carry(problem);
    let on = |quantity: usize| rows.column(quantity, curvature);
    let (soft_on, front_on) = ([on(REAR), on(SPEED), on(LANE)], on(FRONT));
    let (inputs_on, rates_on) = (INPUT.map(on), RATE.map(on));
    let Some(last) = problem.horizon().checked_sub(1) else { return };
    gains[last].p = *terminal;
    add_soft(problem, last, soft_on, &mut gains[last].p.data.0);
    for t in (0..=last).rev() {
        let model = &models[t];
        let front = &problem.front[t];
        let (before, rest) = gains.split_at_mut(t);
        let gain = &mut rest[0];

        let pb_m = product(&gain.p, &model.b) + m;
        let mut f = product(&model.a_transposed, &pb_m);
        let mut g = n;
        // Terms of v: A'P E, B'P E + M'E and E'P E.
        let carried = if carry == 0.0 {
            // Of B'(P B + 2 M) the mean with its transpose.
            let twice = product(&model.b_transposed, &(pb_m + m));
            let mean = 0.5 * (twice[(0, 1)] + twice[(1, 0)]);
            g += Matrix2::new(twice[(0, 0)], mean, mean, twice[(1, 1)]);
            None
        } else {
            let b_pb_m = product(&model.b_transposed, &pb_m);
            let m_b = product(&transpose(&m), &model.b);
            g += b_pb_m + m_b;
            let a_pe = (f - product(&model.a_transposed, &m)) * carry;
            Some((a_pe, transpose(&b_pb_m) * carry, (b_pb_m - transpose(&m_b)) * (carry * carry)))
        };
        for i in 0..3 {
            f[(i, 1)] += front_on[t] * front.velocity[i] * front.steering;
        }
        g[(1, 1)] += front_on[t] * front.steering * front.steering;
        g[(0, 0)] += inputs_on[0][t];
        g[(1, 1)] += inputs_on[1][t];
        let rate = &Vector2::new(rates_on[0][t], rates_on[1][t]);
        let inverse =
            inverse(&Matrix2::new(g[(0, 0)] + rate[0], g[(0, 1)], g[(1, 0)], g[(1, 1)] + rate[1]));
        let state = product(&f, &inverse);
        let mut previous = scale_columns(&inverse, rate);
        let kept = product(&g, &previous);
        if let Some((_, k, _)) = &carried {
            previous -= product(&inverse, k);
        }
        gain.m = m;
        gain.inverse = inverse;
        gain.state = state;
        gain.state_transposed = transpose(&state);
        gain.previous = previous;
        let Some(t_before) = t.checked_sub(1) else { break };
        let next = &mut before[t_before].p.data.0;
        let pa = &mut gain.pa.data.0;
        if model.flat {
            carry_back::<true>(model, &gain.p, &state, &f, pa, next);
        } else {
            carry_back::<false>(model, &gain.p, &state, &f, pa, next);
        }
        add_square(next, &front.velocity, front_on[t]);
        add_soft(problem, t_before, soft_on, next);
        m = scale_columns(&state, rate);
        n = kept;
        if let Some((a_pe, k, e_pe)) = &carried {
            let inverse_k = product(&inverse, k);
            let d_inverse_k = transpose(&scale_columns(&transpose(&inverse_k), rate));
            m += a_pe - product(&state, k);
            n += e_pe + d_inverse_k + transpose(&d_inverse_k) - product(&transpose(k), &inverse_k);
        }
        let mean = 0.5 * (n[(0, 1)] + n[(1, 0)]);
        (n[(0, 1)], n[(1, 0)]) = (mean, mean);
    }
}

/// A'P A - F H^-1 F', symmetric, and P A on the way there. `FLAT` skips the zeros of A: with V, L and Q for how
/// velocities and pose depend on velocities and pose, A is `[V 0; L Q]`.
#[expect(clippy::needless_range_loop, reason = "a matrix is mirrored in place")]
#[inline(always)]
fn carry_back<const FLAT: bool>(
    model: &Model,
    p: &Matrix6<f64>,
    state: &Matrix6x2<f64>,
    f: &Matrix6x2<f64>,
    pa: &mut [[f64; 6]; 6],
    out: &mut [[f64; 6]; 6],
) {
    let (a, a_transposed) = (&model.a.data.0, &model.a_transposed.data.0);
    let (p, state, f) = (&p.data.0, &state.data.0, &f.data.0);
    for column in 0..3 {
        pa[column] = combined::<6, 6>(p, &a[column]);
    }
    for column in 3..6 {
        pa[column] = if FLAT {
            combined::<6, 3>(&p[3..], &a[column][3..])
        } else {
            combined::<6, 6>(p, &a[column])
        };
    }
    for column in 0..3 {
        let mut sum = combined::<6, 3>(&a_transposed[3..], &pa[column][3..]);
        // A' of the velocities has zeros below.
        if FLAT {
            add(&mut sum, &combined::<4, 3>(&a_transposed[..3], &pa[column][..3]));
        } else {
            add(&mut sum, &combined::<6, 3>(&a_transposed[..3], &pa[column][..3]));
        }
        let feedback = combined::<6, 2>(state, &[f[0][column], f[1][column]]);
        for row in 0..6 {
            out[column][row] = sum[row] - feedback[row];
        }
    }
    for column in 3..6 {
        let mut sum = combined::<6, 3>(&a_transposed[3..], &pa[column][3..]);
        if !FLAT {
            add(&mut sum, &combined::<6, 3>(&a_transposed[..3], &pa[column][..3]));
        }
        let feedback = combined::<6, 2>(state, &[f[0][column], f[1][column]]);
        // Rows 3 to 5, in four lanes.
        for row in 2..6 {
            out[column][row] = sum[row] - feedback[row];
        }
    }
    // Above the diagonal what stands below it.
    for column in 0..6 {
        for row in 0..column {
            out[column][row] = out[row][column];
        }
    }
}

/// Sum of the first `R` rows of columns, each times a number.
#[inline(always)]
fn combined<const R: usize, const K: usize>(columns: &[[f64; 6]], by: &[f64]) -> [f64; R] {
    let mut sum = [0.0; R];
    for row in 0..R {
        sum[row] = columns[0][row] * by[0];
    }
    for k in 1..K {
        for row in 0..R {
            sum[row] += columns[k][row] * by[k];
        }
    }
    sum
}

/// Adds some numbers to the first of six.
#[inline(always)]
fn add<const R: usize>(sum: &mut [f64; 6], more: &[f64; R]) {
    for row in 0..R {
        sum[row] += more[row];
    }
}

/// Offsets of the feedback, backward from the terminal gradient.
#[inline(always)]
pub(super) fn backward(
    problem: &Fhocp,
    models: &[Model],
    rates: [&[f64]; 2],
    gradient: &Stages<'_>,
    defect: Option<&[Vector6<f64>]>,
    terminal: &Vector6<f64>,
    gains: &mut [Gain],
) {
    let (mut p, mut n) = (*terminal, Vector2::zeros());
    let carry = carry(problem);
    for t in (0..problem.horizon()).rev() {
        let (rate, gain) = (gradient.rate(t), &mut gains[t]);
        gradient.add_next_state(t, &mut p);
        if let Some(defect) = defect {
            p += gain.p * defect[t];
            n += gain.m.tr_mul(&defect[t]);
        }
        gain.gradient = p;
        let (a_p, b_p) = models[t].adjoint(&p);
        let h = gradient.input(t) + rate + b_p + n;
        gain.offset = product(&gain.inverse, &h);
        p = a_p - product(&gain.state, &h);
        gradient.add_state(t, &mut p);
        if carry == 0.0 {
            let own = Vector2::new(rates[0][t], rates[1][t]);
            n = own.component_mul(&gain.offset) - rate;
        } else {
            n = gain.previous.tr_mul(&h) - rate + b_p * carry;
        }
    }
}

/// E over B: how a stage's input before acts in terms of its own.
#[inline(always)]
pub(super) fn carry(problem: &Fhocp) -> f64 {
    problem.lag / (1.0 - problem.lag)
}

/// The direction, forward from x_0 and u_{-1}, which do not move.
#[inline(always)]
pub(super) fn forward(
    problem: &Fhocp,
    models: &[Model],
    gains: &[Gain],
    defect: Option<&[Vector6<f64>]>,
    dx: &mut [Vector6<f64>],
    du: &mut [Vector2<f64>],
) {
    let mut v = Vector2::zeros();
    dx[0] = Vector6::zeros();
    let carry = carry(problem);
    for (t, (model, gain)) in models.iter().zip(gains).enumerate() {
        let u = product(&gain.previous, &v) - product(&gain.state_transposed, &dx[t]) - gain.offset;
        dx[t + 1] = model.apply(&dx[t], &(u + v * carry));
        if let Some(defect) = defect {
            dx[t + 1] += defect[t];
        }
        du[t] = u;
        v = u;
    }
}

/// Costates of x_1..x_N after a full step along a direction without defects.
#[inline(always)]
pub(super) fn costates(
    gains: &[Gain],
    dx: &[Vector6<f64>],
    du: &[Vector2<f64>],
    costates: &mut [Vector6<f64>],
) {
    for (t, gain) in gains.iter().enumerate() {
        costates[t] = product(&gain.p, &dx[t + 1]) + product(&gain.m, &du[t]) + gain.gradient;
    }
}

/// Inverse of a symmetric positive definite 2 x 2 matrix, through its factor L D L'.
#[inline(always)]
fn inverse(h: &Matrix2<f64>) -> Matrix2<f64> {
    let l = h[(1, 0)] / h[(0, 0)];
    let second = 1.0 / (h[(1, 1)] - l * h[(1, 0)]);
    let first = 1.0 / h[(0, 0)] + l * l * second;
    Matrix2::new(first, -l * second, -l * second, second)
}

/// Adds the soft constraints of stage t on x_{t+1}: rear slip angle, speed and lane.
#[inline(always)]
fn add_soft(problem: &Fhocp, t: usize, [rear, speed, lane]: [&[f64]; 3], p: &mut [[f64; 6]; 6]) {
    add_square(p, &problem.rear[t].velocity, rear[t]);
    p[0][0] += speed[t];
    p[5][5] += lane[t];
    let heading = problem.lane_heading[t];
    let by = lane[t] * heading;
    p[3][3] += by * heading;
    p[3][5] += by;
    p[5][3] += by;
}

/// Adds curvature g g' on the velocities.
#[inline(always)]
fn add_square(p: &mut [[f64; 6]; 6], g: &[f64; 3], curvature: f64) {
    // In four lanes, the last one empty.
    let g = [g[0], g[1], g[2], 0.0];
    for column in 0..3 {
        let by = curvature * g[column];
        for row in 0..4 {
            p[column][row] += by * g[row];
        }
    }
}

/// A times a diagonal.
#[inline(always)]
fn scale_columns<const R: usize>(
    a: &SMatrix<f64, R, 2>,
    diagonal: &Vector2<f64>,
) -> SMatrix<f64, R, 2> {
    let mut out = *a;
    for (column, factor) in out.data.0.iter_mut().zip(&diagonal.data.0[0]) {
        for entry in column {
            *entry *= factor;
        }
    }
    out
}
