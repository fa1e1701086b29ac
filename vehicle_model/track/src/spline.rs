//! A closed cubic spline through points: twice continuously differentiable, so that its
//! curvature is continuous.
//!
//! On the interval i of length h_i the spline is determined by its values and its second
//! derivatives M at the knots, and the M follow from the continuity of the first derivative:
//! h_(i-1) M_(i-1) + 2 (h_(i-1) + h_i) M_i + h_i M_(i+1)
//! = 6 ((y_(i+1) - y_i) / h_i - (y_i - y_(i-1)) / h_(i-1)).

use super::frenet::wrap_angle;
use super::path::walk;

/// Newton steps in the search for a foot; it converges quadratically from the middle of a
/// piece much shorter than its radius, so this is never reached.
const FOOT_STEPS: usize = 30;
/// A Newton step this small ends the search [m]; the step is still taken.
const FOOT_RESOLUTION: f64 = 1e-12;

/// One interval of the spline.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Piece {
    /// Coefficients of x in powers of the distance from the interval's beginning.
    x: [f64; 4],
    /// Coefficients of y.
    y: [f64; 4],
    /// Heading at the beginning, continuous along the lap [rad].
    psi: f64,
}

/// A closed curve of cubics.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Spline {
    /// Parameter at the beginning of each piece, and at the end of the last.
    knots: Vec<f64>,
    pieces: Vec<Piece>,
}

/// Value, first and second derivative of a cubic.
#[inline]
fn cubic(c: &[f64; 4], u: f64) -> (f64, f64, f64) {
    let value = c[0] + u * (c[1] + u * (c[2] + u * c[3]));
    (value, c[1] + u * (2.0 * c[2] + 3.0 * u * c[3]), 2.0 * c[2] + 6.0 * u * c[3])
}

impl Spline {
    /// The closed spline through the points, point i at the parameter `knots[i]`; the last knot
    /// is that of the first point one lap later. Needs at least three points and rising knots.
    pub(super) fn through(knots: Vec<f64>, points: &[(f64, f64)]) -> Self {
        let h: Vec<f64> = knots.windows(2).map(|k| k[1] - k[0]).collect();
        let x = coefficients(&h, &points.iter().map(|p| p.0).collect::<Vec<_>>());
        let y = coefficients(&h, &points.iter().map(|p| p.1).collect::<Vec<_>>());
        let mut psi = libm::atan2(y[0][1], x[0][1]);
        let mut pieces = Vec::with_capacity(h.len());
        for (x, y) in x.into_iter().zip(y) {
            psi += wrap_angle(libm::atan2(y[1], x[1]) - psi);
            pieces.push(Piece { x, y, psi });
        }
        Self { knots, pieces }
    }

    /// Number of pieces.
    pub(super) fn len(&self) -> usize {
        self.pieces.len()
    }

    /// Piece that holds the parameter s, found at once where the knots are equidistant.
    #[inline]
    pub(super) fn index_of(&self, s: f64) -> usize {
        let n = self.pieces.len();
        // A negative or undefined quotient becomes 0.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let near = (s / self.knots[n] * n as f64) as usize;
        walk(s, near, n, |i| self.knots[i])
    }

    /// Parameter at the beginning of piece i.
    #[inline]
    pub(super) fn start_of(&self, i: usize) -> f64 {
        self.knots[i]
    }

    /// Length of piece i in the parameter.
    pub(super) fn length_of(&self, i: usize) -> f64 {
        self.knots[i + 1] - self.knots[i]
    }

    /// Pose (x, y, psi) at distance u in piece i.
    pub(super) fn pose_in(&self, i: usize, u: f64) -> (f64, f64, f64) {
        let piece = &self.pieces[i];
        let (x, dx, _) = cubic(&piece.x, u);
        let (y, dy, _) = cubic(&piece.y, u);
        let (dx_0, dy_0) = (piece.x[1], piece.y[1]);
        let turn = libm::atan2(dx_0 * dy - dy_0 * dx, dx_0 * dx + dy_0 * dy);
        (x, y, piece.psi + turn)
    }

    /// Point (x, y) at distance u in piece i.
    pub(super) fn point_in(&self, i: usize, u: f64) -> (f64, f64) {
        (cubic(&self.pieces[i].x, u).0, cubic(&self.pieces[i].y, u).0)
    }

    /// Length of the tangent vector at distance u in piece i; 1 where the parameter is the arc
    /// length.
    pub(super) fn speed_in(&self, i: usize, u: f64) -> f64 {
        libm::hypot(cubic(&self.pieces[i].x, u).1, cubic(&self.pieces[i].y, u).1)
    }

    /// Curvature (x' y'' - y' x'') / (x'^2 + y'^2)^(3/2) at distance u in piece i [1/m].
    #[inline]
    pub(super) fn kappa_in(&self, i: usize, u: f64) -> f64 {
        let (_, dx, ddx) = cubic(&self.pieces[i].x, u);
        let (_, dy, ddy) = cubic(&self.pieces[i].y, u);
        let square = dx * dx + dy * dy;
        (dx * ddy - dy * ddx) / (square * square.sqrt())
    }

    /// Distance in [0, length] of the point of piece i nearest to (x, y): the root of
    /// g(u) = (p - r(u)) . r'(u), by Newton steps kept inside a shrinking bracket.
    pub(super) fn foot_in(&self, i: usize, x: f64, y: f64) -> f64 {
        let piece = &self.pieces[i];
        let g = |u: f64| {
            let (x_u, dx, ddx) = cubic(&piece.x, u);
            let (y_u, dy, ddy) = cubic(&piece.y, u);
            let (ex, ey) = (x - x_u, y - y_u);
            (ex * dx + ey * dy, ex * ddx + ey * ddy - dx * dx - dy * dy)
        };
        // Below this a step is rounding noise, which would throw the search out of its bracket.
        let resolution = FOOT_RESOLUTION + 4.0 * f64::EPSILON * (x.abs() + y.abs());
        let end = self.length_of(i);
        let (mut low, mut high) = (0.0, end);
        if g(low).0 <= 0.0 {
            return low;
        }
        if g(high).0 >= 0.0 {
            return high;
        }
        let mut u = 0.5 * end;
        for _ in 0..FOOT_STEPS {
            let (value, slope) = g(u);
            if value > 0.0 {
                low = u
            } else {
                high = u
            }
            let newton = u - value / slope;
            if (newton - u).abs() <= resolution {
                return newton.clamp(0.0, end);
            }
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            u = next;
        }
        u
    }
}

/// Coefficients of the closed cubic spline through y with intervals h.
fn coefficients(h: &[f64], y: &[f64]) -> Vec<[f64; 4]> {
    let n = h.len();
    let (prev, next) = (|i: usize| (i + n - 1) % n, |i: usize| (i + 1) % n);
    let slope = |i: usize| (y[next(i)] - y[i]) / h[i];
    let diagonal: Vec<f64> = (0..n).map(|i| 2.0 * (h[prev(i)] + h[i])).collect();
    let right: Vec<f64> = (0..n).map(|i| 6.0 * (slope(i) - slope(prev(i)))).collect();
    let m = solve_cyclic(&diagonal, h, right);
    (0..n)
        .map(|i| {
            let (m_0, m_1) = (m[i], m[next(i)]);
            [y[i], slope(i) - h[i] * (2.0 * m_0 + m_1) / 6.0, m_0 / 2.0, (m_1 - m_0) / (6.0 * h[i])]
        })
        .collect()
}

/// Solution of the symmetric cyclic tridiagonal system with `diagonal`, and `off[i]` between
/// the unknowns i and i + 1 (the last one between the last and the first).
///
/// The corners are taken out by a rank-one change (Sherman and Morrison): A = T + v w' with
/// v = (-d_0, 0, .., c)', w = (1, 0, .., -c / d_0)', c the corner.
fn solve_cyclic(diagonal: &[f64], off: &[f64], right: Vec<f64>) -> Vec<f64> {
    let n = diagonal.len();
    let (d_0, corner) = (diagonal[0], off[n - 1]);
    let mut diagonal = diagonal.to_vec();
    diagonal[0] += d_0;
    diagonal[n - 1] += corner * corner / d_0;
    let mut v = vec![0.0; n];
    v[0] = -d_0;
    v[n - 1] = corner;
    let y = solve_tridiagonal(&diagonal, off, right);
    let q = solve_tridiagonal(&diagonal, off, v);
    let w = |z: &[f64]| z[0] - corner / d_0 * z[n - 1];
    let factor = w(&y) / (1.0 + w(&q));
    y.iter().zip(&q).map(|(y, q)| y - factor * q).collect()
}

/// Solution of a symmetric tridiagonal system with a dominant diagonal (Thomas).
fn solve_tridiagonal(diagonal: &[f64], off: &[f64], mut b: Vec<f64>) -> Vec<f64> {
    let n = diagonal.len();
    let mut d = diagonal.to_vec();
    for i in 1..n {
        let factor = off[i - 1] / d[i - 1];
        d[i] -= factor * off[i - 1];
        b[i] -= factor * b[i - 1];
    }
    b[n - 1] /= d[n - 1];
    for i in (0..n - 1).rev() {
        b[i] = (b[i] - off[i] * b[i + 1]) / d[i];
    }
    b
}
