//! A closed curve of quintic B-splines on equal intervals, four times continuously
//! differentiable.

/// Degree of the splines.
const DEGREE: usize = 5;
/// Number of splines that differ from zero on an interval.
pub(super) const ACTIVE: usize = DEGREE + 1;
/// Nodes and weights of the three-point rule of Gauss and Legendre on [0, 1].
const GAUSS: [(f64, f64); 3] = [
    (0.112_701_665_379_258_3, 5.0 / 18.0),
    (0.5, 4.0 / 9.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];

/// The active splines of this degree at the part u in [0, 1] of an interval (de Boor).
fn splines(u: f64, degree: usize) -> [f64; ACTIVE] {
    let mut b = [0.0; ACTIVE];
    b[0] = 1.0;
    for p in 1..=degree {
        let scale = 1.0 / p as f64;
        for k in (0..=p).rev() {
            let left = if k > 0 { (u + (p - k) as f64) * b[k - 1] } else { 0.0 };
            b[k] = scale * (left + ((k + 1) as f64 - u) * b[k]);
        }
    }
    b
}

/// The derivatives of what [`splines`] gives, with respect to u.
fn slopes(u: f64, degree: usize) -> [f64; ACTIVE] {
    let b = splines(u, degree - 1);
    let mut d = [0.0; ACTIVE];
    for k in 0..=degree {
        d[k] = if k > 0 { b[k - 1] } else { 0.0 } - if k < degree { b[k] } else { 0.0 };
    }
    d
}

/// The second derivatives of what [`splines`] gives, with respect to u.
fn bends(u: f64, degree: usize) -> [f64; ACTIVE] {
    let b = splines(u, degree - 2);
    std::array::from_fn(|k| {
        let at = |shift: usize| if k >= shift { b[k - shift] } else { 0.0 };
        at(0) - 2.0 * at(1) + at(2)
    })
}

/// Equal intervals of a closed parameter.
#[derive(Debug, Clone, Copy)]
pub(super) struct Grid {
    /// Number of intervals, and of splines.
    pub count: usize,
    /// Length of an interval.
    pub interval: f64,
}

/// The active splines at a parameter: the first of them and their values.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    first: usize,
    values: [f64; ACTIVE],
}

impl Grid {
    /// Interval that holds t and the part of it that lies before t.
    fn place(&self, t: f64) -> (usize, f64) {
        let cell = t / self.interval;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let i = (cell.floor().max(0.0) as usize).min(self.count - 1);
        (i, cell - i as f64)
    }

    /// The active splines at t in [0, count * interval].
    pub(super) fn row(&self, t: f64) -> Row {
        let (first, u) = self.place(t);
        Row { first, values: splines(u, DEGREE) }
    }

    /// Derivative of the splines at t.
    pub(super) fn slope(&self, t: f64) -> Row {
        let (first, u) = self.place(t);
        Row { first, values: slopes(u, DEGREE).map(|d| d / self.interval) }
    }

    /// Second derivative of the splines at t.
    pub(super) fn bend(&self, t: f64) -> Row {
        let (first, u) = self.place(t);
        let square = self.interval * self.interval;
        Row { first, values: bends(u, DEGREE).map(|d| d / square) }
    }

    /// The splines at a knot.
    pub(super) fn knot_row(&self) -> [f64; ACTIVE] {
        splines(0.0, DEGREE)
    }

    /// Their second derivatives.
    pub(super) fn knot_bend(&self) -> [f64; ACTIVE] {
        let square = self.interval * self.interval;
        bends(0.0, DEGREE).map(|d| d / square)
    }

    /// Length of the whole parameter.
    pub(super) fn end(&self) -> f64 {
        self.count as f64 * self.interval
    }
}

impl Row {
    /// The values, of the splines from `first` on.
    pub(super) fn values(&self) -> &[f64; ACTIVE] {
        &self.values
    }

    /// Spline number and value of each.
    pub(super) fn entries(&self, count: usize) -> [(usize, f64); ACTIVE] {
        std::array::from_fn(|k| ((self.first + k) % count, self.values[k]))
    }

    /// Value of the curve with these coefficients.
    pub(super) fn times(&self, coefficients: &[f64]) -> f64 {
        self.entries(coefficients.len()).iter().map(|(i, b)| b * coefficients[*i]).sum()
    }
}

/// A closed plane curve.
#[derive(Debug, Clone)]
pub(super) struct Curve {
    /// The intervals of its parameter.
    pub grid: Grid,
    /// Coefficients of x.
    pub x: Vec<f64>,
    /// Coefficients of y.
    pub y: Vec<f64>,
}

impl Curve {
    /// Point (x, y) at t.
    pub(super) fn point(&self, t: f64) -> (f64, f64) {
        let row = self.grid.row(t);
        (row.times(&self.x), row.times(&self.y))
    }

    /// Tangent (x', y') at t.
    pub(super) fn tangent(&self, t: f64) -> (f64, f64) {
        let row = self.grid.slope(t);
        (row.times(&self.x), row.times(&self.y))
    }

    /// Second derivative (x'', y'') at t.
    pub(super) fn bend(&self, t: f64) -> (f64, f64) {
        let row = self.grid.bend(t);
        (row.times(&self.x), row.times(&self.y))
    }

    /// Arc length from 0 to the end of each interval, beginning with 0.
    pub(super) fn lengths(&self) -> Vec<f64> {
        let mut lengths = vec![0.0];
        let mut s = 0.0;
        for i in 0..self.grid.count {
            let from = i as f64 * self.grid.interval;
            s += self.grid.interval
                * GAUSS
                    .iter()
                    .map(|(part, weight)| {
                        // Not hypot: its last bit depends on the platform.
                        let (x, y) = self.tangent(from + part * self.grid.interval);
                        weight * (x * x + y * y).sqrt()
                    })
                    .sum::<f64>();
            lengths.push(s);
        }
        lengths
    }

    /// Arc length up to t, by the lengths of the intervals; linear inside an interval.
    pub(super) fn length_at(&self, t: f64, lengths: &[f64]) -> f64 {
        let (i, part) = self.grid.place(t);
        lengths[i] + part * (lengths[i + 1] - lengths[i])
    }
}

#[cfg(test)]
mod tests {
    use super::{ACTIVE, bends, slopes, splines};

    #[test]
    fn the_splines_sum_to_one_and_slope_as_their_differences_do() {
        for u in [0.0, 0.2, 0.5, 0.9, 1.0] {
            let sum: f64 = splines(u, 5).iter().sum();
            assert!((sum - 1.0).abs() < 1e-14);
            let step = 1e-5;
            let (a, b, d) = (splines(u - step, 5), splines(u + step, 5), slopes(u, 5));
            let (before, after, second) = (slopes(u - step, 5), slopes(u + step, 5), bends(u, 5));
            for k in 0..ACTIVE {
                assert!((d[k] - (b[k] - a[k]) / (2.0 * step)).abs() < 1e-9, "{u} {k}");
                let difference = (after[k] - before[k]) / (2.0 * step);
                assert!((second[k] - difference).abs() < 1e-9, "{u} {k}");
            }
        }
        // Values of the quintic at its knots: 1, 26, 66, 26, 1 in 120.
        let b = splines(0.0, 5).map(|b| b * 120.0);
        assert!((b[0] - 1.0).abs() < 1e-12 && (b[2] - 66.0).abs() < 1e-12 && b[5] == 0.0, "{b:?}");
    }
}
