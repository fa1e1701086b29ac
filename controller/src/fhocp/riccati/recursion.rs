//! The Riccati recursion with the previous input as state.
//!
//! The cost-to-go of a direction from stage t is the quadratic
//!
//! ```text
//! V_t(x, v) = 1/2 x'P x + x'M v + 1/2 v'N v + p'x + n'v,       v = u_{t-1}
//! ```
//!
//! Only the rates `u - v` hold v, with the diagonal curvature D, so no product is larger than
//! 6 x 6. With P, M, N, p, n of stage t+1 (P and p hold the soft constraints on x_{t+1} already)
//! and stage t's own curvature and gradient:
//!
//! ```text
//! G   = R + B'P B + B'M + M'B + N,     H = G + D
//! F   = A'(P B + M) + front slip                        6 x 2
//! u   = -H^-1 (F'x + h) + H^-1 D v,    h = r + d + B'p + n
//! P_t = A'P A - F H^-1 F' + front slip
//! M_t = F H^-1 D
//! N_t = D - D H^-1 D = G H^-1 D
//! p_t = A'p - F H^-1 h + front slip,   n_t = D H^-1 h - d
//! ```
//!
//! A defect c = A x + B u + C - x_{t+1} of the iterate moves p to p + P c and n to n + M'c. The
//! costate of x_{t+1} after a full step is `P dx + M du + p`.
//!
//! N is formed as `G H^-1 D`: an active rate limit makes D large, and the difference would lose
//! the digits of G.

use nalgebra::{Matrix2, Matrix6, Matrix6x2, Vector2, Vector6};

use super::super::Fhocp;
use super::rows::{FRONT, LANE, REAR, SPEED};
use super::stage::{Curvature, Gradient};

/// Feedback of one stage: u = offset - (F H^-1)' x + (H^-1 D) v.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Gain {
    /// F H^-1.
    state: Matrix6x2<f64>,
    /// H^-1 D.
    previous: Matrix2<f64>,
    /// H^-1.
    inverse: Matrix2<f64>,
    /// H^-1 h.
    offset: Vector2<f64>,
    /// P of x_{t+1}.
    p: Matrix6<f64>,
    /// M of x_{t+1} and u_t.
    m: Matrix6x2<f64>,
    /// p of x_{t+1}.
    gradient: Vector6<f64>,
}

/// Factors the stages backward from the terminal curvature.
#[inline(always)]
pub(super) fn factor(
    problem: &Fhocp,
    curvature: &[Curvature],
    terminal: &Matrix6<f64>,
    gains: &mut [Gain],
) {
    let (mut p, mut m, mut n) = (*terminal, Matrix6x2::zeros(), Matrix2::zeros());
    for t in (0..problem.horizon()).rev() {
        let (model, own) = (&problem.model[t], &curvature[t]);
        let (rear, front) = (&problem.rear[t].velocity, &problem.front[t]);
        for j in 0..3 {
            for i in 0..3 {
                p[(i, j)] += own.soft[REAR] * rear[i] * rear[j];
            }
        }
        p[(0, 0)] += own.soft[SPEED];
        p[(5, 5)] += own.soft[LANE];

        let pb = p * model.b;
        let bm = model.b.tr_mul(&m);
        let mut g = model.b.tr_mul(&pb) + bm + bm.transpose() + n;
        g += Matrix2::from_diagonal(&own.input);
        g[(1, 1)] += own.soft[FRONT] * front.steering * front.steering;
        let h = g + Matrix2::from_diagonal(&own.rate);
        let inverse = inverse(&h);
        let mut f = model.a.tr_mul(&(pb + m));
        for i in 0..3 {
            f[(i, 1)] += own.soft[FRONT] * front.velocity[i] * front.steering;
        }
        let gain = &mut gains[t];
        gain.p = p;
        gain.m = m;
        gain.inverse = inverse;
        gain.state = f * inverse;
        gain.previous = inverse * Matrix2::from_diagonal(&own.rate);
        if t == 0 {
            break;
        }
        let pa = p * model.a;
        p = model.a.tr_mul(&pa) - gain.state * f.transpose();
        for j in 0..3 {
            for i in 0..3 {
                p[(i, j)] += own.soft[FRONT] * front.velocity[i] * front.velocity[j];
            }
        }
        p = symmetric(&p);
        m = gain.state * Matrix2::from_diagonal(&own.rate);
        n = g * gain.previous;
        let off = 0.5 * (n[(0, 1)] + n[(1, 0)]);
        n[(0, 1)] = off;
        n[(1, 0)] = off;
    }
}

/// Offsets of the feedback, backward from the terminal gradient.
#[inline(always)]
pub(super) fn backward(
    problem: &Fhocp,
    curvature: &[Curvature],
    gradient: &[Gradient],
    defect: Option<&[Vector6<f64>]>,
    terminal: &Vector6<f64>,
    gains: &mut [Gain],
) {
    let (mut p, mut n) = (*terminal, Vector2::zeros());
    for t in (0..problem.horizon()).rev() {
        let (model, own, gain) = (&problem.model[t], &gradient[t], &mut gains[t]);
        p += own.next_state(problem, t);
        if let Some(defect) = defect {
            p += gain.p * defect[t];
            n += gain.m.tr_mul(&defect[t]);
        }
        gain.gradient = p;
        let h = own.input(problem, t) + own.rate + model.b.tr_mul(&p) + n;
        gain.offset = gain.inverse * h;
        p = model.a.tr_mul(&p) - gain.state * h + own.state(problem, t);
        n = curvature[t].rate.component_mul(&gain.offset) - own.rate;
    }
}

/// The direction, forward from x_0 and u_{-1}, which do not move.
#[inline(always)]
pub(super) fn forward(
    problem: &Fhocp,
    gains: &[Gain],
    defect: Option<&[Vector6<f64>]>,
    dx: &mut [Vector6<f64>],
    du: &mut [Vector2<f64>],
) {
    let mut v = Vector2::zeros();
    dx[0] = Vector6::zeros();
    for (t, (model, gain)) in problem.model.iter().zip(gains).enumerate() {
        let u = gain.previous * v - gain.state.tr_mul(&dx[t]) - gain.offset;
        dx[t + 1] = model.a * dx[t] + model.b * u;
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
        costates[t] = gain.p * dx[t + 1] + gain.m * du[t] + gain.gradient;
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

#[inline(always)]
fn symmetric(p: &Matrix6<f64>) -> Matrix6<f64> {
    (p + p.transpose()) * 0.5
}
