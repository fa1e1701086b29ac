//! Newton's system of the stages, their slacks eliminated.
//!
//! A soft constraint on y with slack s has the penalty `l s + q s^2` and the rows high, low and
//! slack with curvatures `h`, `g`, `k` (their sigma) and pulls `h'`, `g'`, `k'`. Its part of the
//! system is
//!
//! ```text
//! [ h + g    g - h         ] [dy]     [ h' - g'                    ]
//! [ g - h    2q + h + g + k ] [ds] = - [ l + 2 q s - h' - g' - k'  ]
//! ```
//!
//! and eliminating ds leaves the curvature `((h + g)(2q + k) + 4 h g) / (2q + h + g + k)` on y,
//! written so that no two large numbers are subtracted.

use nalgebra::{Vector2, Vector6};

use super::super::Fhocp;
use super::columns::each;
use super::rows::{FRONT, INPUT, LANE, QUANTITIES, RATE, REAR, Rows, SPEED};
use vector_sums::dot;

/// What the quantities of the stages and their slacks cost: `1/2 weight (q + shift)^2` and
/// `linear s + 1/2 twice s^2`.
#[derive(Debug, Clone, Default)]
pub(super) struct Costs {
    weight: Vec<f64>,
    shift: Vec<f64>,
    linear: Vec<f64>,
    twice: Vec<f64>,
    /// Slopes at the iterate: of the quantities and of the slacks.
    slope: Vec<f64>,
    slack: Vec<f64>,
}

/// Hessian of the stages: all of it is diagonal in the right quantities.
#[derive(Debug, Clone, Default)]
pub(super) struct Curvature {
    /// On each quantity, its slack eliminated.
    pub(super) on: Vec<f64>,
    /// (g - h) / (2q + h + g + k) of each slack.
    cross: Vec<f64>,
    /// 1 / (2q + h + g + k) of each slack.
    inverse: Vec<f64>,
}

/// Gradient of the stages.
#[derive(Debug, Clone, Default)]
pub(super) struct Gradient {
    /// On each quantity.
    pub(super) on: Vec<f64>,
    /// On each slack.
    pub(super) slack: Vec<f64>,
}

/// Penalty l s + q s^2 of the slack of a quantity.
#[inline(always)]
pub(super) fn penalty(problem: &Fhocp, quantity: usize) -> (f64, f64) {
    match quantity {
        LANE => (problem.lane_linear, problem.lane_quadratic),
        REAR | FRONT => (problem.slip_linear, 0.0),
        SPEED => (problem.speed_linear, 0.0),
        _ => (0.0, 0.0),
    }
}

impl Costs {
    pub(super) fn resize(&mut self, rows: &Rows) {
        for column in [&mut self.weight, &mut self.shift, &mut self.slope] {
            column.resize(rows.quantities(), 0.0);
        }
        for column in [&mut self.linear, &mut self.twice, &mut self.slack] {
            column.resize(rows.slacks().len(), 0.0);
        }
    }

    #[inline(always)]
    pub(super) fn load(&mut self, problem: &Fhocp, rows: &Rows) {
        for i in 0..INPUT.len() {
            self.weight[rows.range(INPUT[i])].fill(2.0 * problem.input_cost[i]);
            self.weight[rows.range(RATE[i])].fill(2.0 * problem.rate_cost[i]);
        }
        for (quantity, slips) in [(REAR, &problem.rear), (FRONT, &problem.front)] {
            let range = rows.range(quantity);
            let columns = self.weight[range.clone()].iter_mut().zip(&mut self.shift[range]);
            for ((weight, shift), row) in columns.zip(slips) {
                *weight = 2.0 * row.weight;
                *shift = row.offset - row.reference;
            }
        }
        let first = rows.slacks().start;
        for quantity in LANE..QUANTITIES {
            if rows.bounds(quantity) {
                let range = rows.range(quantity);
                let range = range.start - first..range.end - first;
                let (linear, quadratic) = penalty(problem, quantity);
                self.linear[range.clone()].fill(linear);
                self.twice[range].fill(2.0 * quadratic);
            }
        }
    }

    /// Takes the slopes where the quantities are `q` and the slacks `s`.
    #[inline(always)]
    pub(super) fn set(&mut self, q: &[f64], s: &[f64]) {
        let of = [&self.weight[..], q, &self.shift];
        each(&mut self.slope, of, |[weight, q, shift]| weight * (q + shift));
        let of = [&self.linear[..], &self.twice, s];
        each(&mut self.slack, of, |[linear, twice, s]| linear + twice * s);
    }

    /// The cost itself, there.
    #[inline(always)]
    pub(super) fn cost(&self, q: &[f64], s: &[f64]) -> f64 {
        let quantities = dot(&self.slope, q) + dot(&self.slope, &self.shift);
        0.5 * (quantities + dot(&self.slack, s) + dot(&self.linear, s))
    }
}

impl Curvature {
    pub(super) fn resize(&mut self, rows: &Rows) {
        self.on.resize(rows.quantities(), 0.0);
        for column in [&mut self.cross, &mut self.inverse] {
            column.resize(rows.slacks().len(), 0.0);
        }
    }

    /// Curvature from the sigma of the rows.
    #[inline(always)]
    pub(super) fn set(&mut self, costs: &Costs, rows: &Rows, sigma: &[f64]) {
        let [highs, lows, slacks, _] = rows.split(sigma);
        let [low, high] = rows.bounded();
        let first = rows.slacks().start;
        let (on, rest) = self.on.split_at_mut(first);
        let of = [&costs.weight[..first], &highs[..first], &lows[..first]];
        each(on, of, |[weight, high, low]| weight + (high + low));

        // With two bounds, and with the upper one alone.
        let two = low - first;
        let (h, g, k, twice) = (&highs[first..], &lows[first..], slacks, &costs.twice);
        let (inverse, inverse_one) = self.inverse.split_at_mut(two);
        let (cross, cross_one) = self.cross.split_at_mut(two);
        each(inverse, [&twice[..two], &k[..two], h, g], |[own, k, h, g]| 1.0 / (own + k + h + g));
        each(cross, [h, g, inverse], |[h, g, inverse]| (g - h) * inverse);
        let (on, rest) = rest.split_at_mut(two);
        let weight = &costs.weight[first..];
        each(on, [weight, &twice[..two], k, h, g, inverse], |[weight, own, k, h, g, inverse]| {
            ((h + g) * (own + k) + 4.0 * h * g) * inverse + weight
        });
        let (h, k, twice, weight) = (&h[two..], &k[two..], &twice[two..], &weight[two..]);
        each(inverse_one, [twice, k, h], |[own, k, h]| 1.0 / (own + k + h));
        each(cross_one, [h, inverse_one], |[h, inverse]| -h * inverse);
        let (on, rest) = rest.split_at_mut(high - low);
        each(on, [weight, twice, k, h, inverse_one], |[weight, own, k, h, inverse]| {
            h * (own + k) * inverse + weight
        });
        rest.copy_from_slice(&costs.weight[high..]);
    }

    /// The gradient with the slacks eliminated.
    #[inline(always)]
    pub(super) fn eliminate(&self, rows: &Rows, gradient: &mut Gradient) {
        let slacks = self.cross.iter().zip(&gradient.slack);
        for (on, (cross, slack)) in gradient.on[rows.slacks()].iter_mut().zip(slacks) {
            *on -= cross * slack;
        }
    }

    /// Steps of the slacks, from those of the quantities.
    #[inline(always)]
    pub(super) fn slacks(&self, rows: &Rows, gradient: &Gradient, dq: &[f64], out: &mut [f64]) {
        let of = [&self.inverse[..], &gradient.slack, &self.cross, &dq[rows.slacks()]];
        each(out, of, |[inverse, slack, cross, dq]| -inverse * slack - cross * dq);
    }
}

impl Gradient {
    pub(super) fn resize(&mut self, rows: &Rows) {
        self.on.resize(rows.quantities(), 0.0);
        self.slack.resize(rows.slacks().len(), 0.0);
    }

    /// Gradient of the Lagrangian: that of the costs, with multipliers (or pulls) of the rows.
    #[inline(always)]
    pub(super) fn set(&mut self, costs: &Costs, rows: &Rows, multipliers: &[f64]) {
        let [highs, lows, slacks, _] = rows.split(multipliers);
        let [low, high] = rows.bounded();
        let (on, rest) = self.on.split_at_mut(low);
        each(on, [&costs.slope[..low], &highs[..low], lows], |[slope, h, l]| slope + (h - l));
        let (on, rest) = rest.split_at_mut(high - low);
        each(on, [&costs.slope[low..high], &highs[low..]], |[slope, high]| slope + high);
        rest.copy_from_slice(&costs.slope[high..]);

        let first = rows.slacks().start;
        let (two, one) = self.slack.split_at_mut(low - first);
        let of = [&costs.slack[..], &highs[first..], &lows[first..], slacks];
        each(two, of, |[slope, high, low, slack]| slope - (high + low + slack));
        let of = [&costs.slack[low - first..], &highs[low..], &slacks[low - first..]];
        each(one, of, |[slope, high, slack]| slope - (high + slack));
    }

    /// Its parts by stage.
    #[inline(always)]
    pub(super) fn stages<'a>(&'a self, problem: &'a Fhocp, rows: &Rows) -> Stages<'a> {
        let column = |quantity| rows.column(quantity, &self.on);
        Stages {
            problem,
            input: INPUT.map(column),
            rate: RATE.map(column),
            lane: column(LANE),
            rear: column(REAR),
            front: column(FRONT),
            speed: column(SPEED),
        }
    }
}

/// A gradient stage by stage.
pub(super) struct Stages<'a> {
    problem: &'a Fhocp,
    input: [&'a [f64]; 2],
    rate: [&'a [f64]; 2],
    lane: &'a [f64],
    rear: &'a [f64],
    front: &'a [f64],
    speed: &'a [f64],
}

impl Stages<'_> {
    /// Adds the part of stage t on x_{t+1}. Only to what it touches: zeros would be added one by one too.
    #[inline(always)]
    pub(super) fn add_next_state(&self, t: usize, out: &mut Vector6<f64>) {
        let rear = self.problem.rear[t].velocity.map(|g| g * self.rear[t]);
        out[0] += rear[0] + self.speed[t];
        out[1] += rear[1];
        out[2] += rear[2];
        out[3] += self.problem.lane_heading[t] * self.lane[t];
        out[5] += self.lane[t];
    }

    /// Adds the part of stage t on x_t, from the front slip angle.
    #[inline(always)]
    pub(super) fn add_state(&self, t: usize, out: &mut Vector6<f64>) {
        let front = self.problem.front[t].velocity.map(|g| g * self.front[t]);
        for (out, front) in out.iter_mut().zip(front) {
            *out += front;
        }
    }

    /// The part on u_t, the rate apart.
    #[inline(always)]
    pub(super) fn input(&self, t: usize) -> Vector2<f64> {
        let front = self.problem.front[t].steering * self.front[t];
        Vector2::new(self.input[0][t], self.input[1][t] + front)
    }

    /// The part on u_t - u_{t-1}.
    #[inline(always)]
    pub(super) fn rate(&self, t: usize) -> Vector2<f64> {
        Vector2::new(self.rate[0][t], self.rate[1][t])
    }
}
