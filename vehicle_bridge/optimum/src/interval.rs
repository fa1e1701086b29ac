//! One interval of the mesh: Hermite-Simpson collocation with inputs linear in s (Betts 2010,
//! sec. 3.5), its middle point eliminated, with exact first and second derivatives.

use nalgebra::{SMatrix, SVector};
use vehicle_model::{RoadPoint, SPATIAL_RATES, SpatialExpansion};

use crate::dynamics::{Dynamics, Mode};

/// Variables of a node: [v_x, v_y, omega_z, e_psi, e_y, a, delta].
pub(crate) const NZ: usize = 7;
/// States among them, which come first.
pub(crate) const NS: usize = 5;
/// Index of the time among the rates.
const TIME: usize = 5;

pub(crate) type Node = SVector<f64, NZ>;
pub(crate) type Defect = SVector<f64, NS>;
pub(crate) type Block = SMatrix<f64, NZ, NZ>;
pub(crate) type DefectBlock = SMatrix<f64, NS, NZ>;

/// Where an interval lies and how the centre line bends in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Interval {
    /// Where it begins \[m\].
    pub(crate) s: f64,
    /// Its length \[m\].
    pub(crate) length: f64,
    /// The road just inside its beginning, in its middle and just inside its end.
    pub(crate) road: [RoadPoint; 3],
    /// What the car does in it.
    pub(crate) mode: Mode,
}

/// Defects and time of an interval.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Values {
    /// Change of the state minus the integral of its rates.
    pub(crate) defect: Defect,
    /// Time from end to end \[s\].
    pub(crate) time: f64,
    /// dt/ds at beginning and end \[s/m\].
    pub(crate) pace: [f64; 2],
}

/// Defects and time of an interval with what their derivatives need; index 0 is the node at its
/// beginning, 1 the one at its end.
pub(crate) struct Derivatives {
    pub(crate) values: Values,
    pub(crate) defect: [DefectBlock; 2],
    pub(crate) time: [Node; 2],
    /// The rates at beginning, middle and end.
    points: [SpatialExpansion; 3],
    /// Derivatives of the middle point by the nodes.
    middle: [Block; 2],
    pub(crate) length: f64,
}

/// Second derivatives of an interval's part of the Lagrangian: by the node at its beginning, by
/// both nodes, by the node at its end.
pub(crate) struct Curvature {
    pub(crate) begin: Block,
    pub(crate) mixed: Block,
    pub(crate) end: Block,
}

type Rates = SVector<f64, SPATIAL_RATES>;

fn states(z: &Node) -> Defect {
    z.fixed_rows::<NS>(0).into_owned()
}

/// The middle point of the cubic through both nodes with their rates.
fn middle(z: [&Node; 2], rates: [&Rates; 2], length: f64) -> Node {
    let mut middle = (z[0] + z[1]) * 0.5;
    for i in 0..NS {
        middle[i] += length / 8.0 * (rates[0][i] - rates[1][i]);
    }
    middle
}

/// Defects and time of Simpson's rule.
fn simpson(z: [&Node; 2], rates: [&Rates; 3], length: f64) -> Values {
    let integral = (rates[0] + rates[1] * 4.0 + rates[2]) * (length / 6.0);
    let change = states(z[1]) - states(z[0]);
    let pace = [rates[0][TIME], rates[2][TIME]];
    Values { defect: change - integral.fixed_rows::<NS>(0), time: integral[TIME], pace }
}

impl Interval {
    /// Defects and time between two nodes; `None` where the car does not go forward.
    pub(crate) fn values(&self, model: &Dynamics, z: [&Node; 2]) -> Option<Values> {
        let rates = |z: &Node, road: &RoadPoint| -> Option<Rates> {
            let rates = Rates::from(model.rates(self.mode, &(*z).into(), road));
            (rates[TIME] > 0.0 && rates.iter().all(|rate| rate.is_finite())).then_some(rates)
        };
        let begin = rates(z[0], &self.road[0])?;
        let end = rates(z[1], &self.road[2])?;
        let between = rates(&middle(z, [&begin, &end], self.length), &self.road[1])?;
        Some(simpson(z, [&begin, &between, &end], self.length))
    }

    /// The node at the share `t` of the way between two nodes, on the cubic with their rates.
    pub(crate) fn between(&self, model: &Dynamics, z: [&Node; 2], t: f64) -> Node {
        let begin = model.rates(self.mode, &(*z[0]).into(), &self.road[0]);
        let end = model.rates(self.mode, &(*z[1]).into(), &self.road[2]);
        let rest = 1.0 - t;
        let mut node = z[0] + (z[1] - z[0]) * t;
        for i in 0..NS {
            let chord = z[1][i] - z[0][i];
            let (from, to) = (self.length * begin[i] - chord, self.length * end[i] - chord);
            node[i] += t * rest * (rest * from - t * to);
        }
        node
    }

    /// Defects and time with their derivatives.
    pub(crate) fn derivatives(&self, model: &Dynamics, z: [&Node; 2]) -> Derivatives {
        let at = |z: &Node, road: &RoadPoint| model.expansion(self.mode, &(*z).into(), road);
        let (begin, end) = (at(z[0], &self.road[0]), at(z[1], &self.road[2]));
        let rates = |point: &SpatialExpansion| Rates::from(point.value);
        let between_z = middle(z, [&rates(&begin), &rates(&end)], self.length);
        let between = at(&between_z, &self.road[1]);
        let values = simpson(z, [&rates(&begin), &rates(&between), &rates(&end)], self.length);

        let jacobian = |point: &SpatialExpansion| {
            SMatrix::<f64, SPATIAL_RATES, NZ>::from_fn(|row, column| point.jacobian[row][column])
        };
        let outer = [jacobian(&begin), jacobian(&end)];
        let inner = jacobian(&between);
        let mut middle = [Block::identity() * 0.5; 2];
        let mut defect = [DefectBlock::zeros(); 2];
        let mut time = [Node::zeros(); 2];
        for (node, sign) in [(0, 1.0), (1, -1.0)] {
            let own = outer[node].fixed_rows::<NS>(0) * (sign * self.length / 8.0);
            let mut rows = middle[node].fixed_rows_mut::<NS>(0);
            rows += own;
            let integral = (outer[node] + inner * middle[node] * 4.0) * (self.length / 6.0);
            defect[node] = -integral.fixed_rows::<NS>(0).into_owned();
            for i in 0..NS {
                defect[node][(i, i)] -= sign;
            }
            time[node] = integral.row(TIME).transpose();
        }
        let points = [begin, between, end];
        Derivatives { values, defect, time, points, middle, length: self.length }
    }
}

impl Derivatives {
    /// Slope of the pace at beginning (0) or end (1) by the node there.
    pub(crate) fn pace_slope(&self, end: usize) -> Node {
        Node::from(self.points[2 * end].jacobian[TIME])
    }

    /// Second derivatives of `on_time` times the time plus `on_pace` times the pace at both ends
    /// plus `on_defect` times the defects.
    pub(crate) fn curvature(
        &self,
        on_time: f64,
        on_pace: [f64; 2],
        on_defect: &Defect,
    ) -> Curvature {
        let share = self.length / 6.0;
        let mut weights = Rates::zeros();
        for i in 0..NS {
            weights[i] = -share * on_defect[i];
        }
        weights[TIME] = share * on_time;

        let inner = curvature_at(&self.points[1], &(weights * 4.0));
        // The middle point depends on the rates of the nodes, whose curvature passes on.
        let mut slope = Node::zeros();
        for (row, weight) in self.points[1].jacobian.iter().zip(&weights) {
            slope += Node::from(*row) * (4.0 * weight);
        }
        let mut through = Rates::zeros();
        for i in 0..NS {
            through[i] = self.length / 8.0 * slope[i];
        }
        let (mut at_begin, mut at_end) = (weights + through, weights - through);
        at_begin[TIME] += on_pace[0];
        at_end[TIME] += on_pace[1];
        let begin = curvature_at(&self.points[0], &at_begin);
        let end = curvature_at(&self.points[2], &at_end);
        let [from_begin, from_end] = &self.middle;
        Curvature {
            begin: begin + from_begin.transpose() * inner * from_begin,
            mixed: from_begin.transpose() * inner * from_end,
            end: end + from_end.transpose() * inner * from_end,
        }
    }
}

/// Weighted sum of the rates' second derivatives.
fn curvature_at(point: &SpatialExpansion, weights: &Rates) -> Block {
    let mut sum = Block::zeros();
    for (hessian, weight) in point.hessian.iter().zip(weights) {
        for (row, values) in hessian.iter().enumerate() {
            for (column, value) in values.iter().enumerate() {
                sum[(row, column)] += weight * value;
            }
        }
    }
    sum
}
