//! The time-optimal lap as a nonlinear program, in scaled variables:
//!
//! min f(z)  s.t.  c(z) = 0,  g(z) >= 0,  lower <= z <= upper
//!
//! with the time as cost, the defects of the collocation as equations, and the actuators' limits
//! as inequalities. Everything couples the two nodes of an interval only; the last interval ends
//! at the first node.

use crate::dynamics::Dynamics;

use crate::interval::{
    Block, Curvature, Defect, DefectBlock, Derivatives, Interval, NS, NZ, Node, Values,
};
use crate::rules::Rules;

/// The program of one mesh.
#[derive(Debug, Clone)]
pub(crate) struct Problem {
    pub(crate) model: Dynamics,
    pub(crate) intervals: Vec<Interval>,
    pub(crate) rules: Rules,
    /// Units of the variables of a node.
    pub(crate) scale: Node,
    /// Bounds of every node, scaled.
    pub(crate) lower: Vec<Node>,
    pub(crate) upper: Vec<Node>,
    /// Cost of a second.
    pub(crate) cost_of_time: f64,
    /// Cost of the squared change of the inputs over an interval, scaled: it makes the solution
    /// unique where the time does not.
    pub(crate) cost_of_change: f64,
}

/// Values at a point.
pub(crate) struct Evaluation {
    pub(crate) cost: f64,
    pub(crate) defects: Vec<Defect>,
    pub(crate) inequalities: Vec<f64>,
}

/// Values and first derivatives at a point, and what second ones need.
pub(crate) struct Expansion {
    pub(crate) values: Evaluation,
    /// Gradient of the cost.
    pub(crate) gradient: Vec<Node>,
    /// Slopes of the defects of each interval by both nodes.
    pub(crate) defects: Vec<[DefectBlock; 2]>,
    /// Slopes of the inequalities, interval by interval.
    pub(crate) inequalities: Vec<[Node; 2]>,
    intervals: Vec<Derivatives>,
    nodes: Vec<Node>,
}

/// Second derivatives of the Lagrangian: blocks of the nodes and of each interval's two nodes.
pub(crate) struct Hessian {
    pub(crate) nodes: Vec<Block>,
    pub(crate) mixed: Vec<Block>,
}

impl Problem {
    /// Number of nodes, and of intervals.
    pub(crate) fn len(&self) -> usize {
        self.intervals.len()
    }

    /// Node at the end of interval `k`.
    pub(crate) fn after(&self, k: usize) -> usize {
        if k + 1 == self.len() { 0 } else { k + 1 }
    }

    /// A node in its own units.
    pub(crate) fn unscaled(&self, z: &Node) -> Node {
        z.component_mul(&self.scale)
    }

    /// Values at scaled nodes; `None` where the car does not go forward.
    pub(crate) fn values(&self, z: &[Node]) -> Option<Evaluation> {
        let nodes: Vec<Node> = z.iter().map(|z| self.unscaled(z)).collect();
        let mut out = Evaluation {
            cost: 0.0,
            defects: Vec::with_capacity(self.len()),
            inequalities: Vec::with_capacity(self.len() * self.rules.len()),
        };
        for (k, interval) in self.intervals.iter().enumerate() {
            let ends = [&nodes[k], &nodes[self.after(k)]];
            let values = interval.values(&self.model, ends)?;
            self.collect(k, z, ends, &values, &mut out);
        }
        Some(out)
    }

    /// Takes the values of interval `k`.
    fn collect(
        &self,
        k: usize,
        z: &[Node],
        ends: [&Node; 2],
        values: &Values,
        out: &mut Evaluation,
    ) {
        let change = inputs(&(z[self.after(k)] - z[k]));
        out.cost +=
            self.cost_of_time * values.time + 0.5 * self.cost_of_change * change.norm_squared();
        let states = self.scale.fixed_rows::<NS>(0);
        out.defects.push(values.defect.component_div(&states));
        out.inequalities.extend(self.rules.values(
            ends,
            self.intervals[k].length,
            values,
            &self.scale,
        ));
    }

    /// Values and slopes at scaled nodes.
    pub(crate) fn expand(&self, z: &[Node]) -> Expansion {
        let nodes: Vec<Node> = z.iter().map(|z| self.unscaled(z)).collect();
        let n = self.len();
        let mut out = Expansion {
            values: Evaluation { cost: 0.0, defects: Vec::new(), inequalities: Vec::new() },
            gradient: vec![Node::zeros(); n],
            defects: Vec::with_capacity(n),
            inequalities: Vec::with_capacity(n * self.rules.len()),
            intervals: Vec::with_capacity(n),
            nodes: Vec::new(),
        };
        for (k, interval) in self.intervals.iter().enumerate() {
            let next = self.after(k);
            let ends = [&nodes[k], &nodes[next]];
            let d = interval.derivatives(&self.model, ends);
            self.collect(k, z, ends, &d.values, &mut out.values);
            let change = inputs(&(z[next] - z[k])) * self.cost_of_change;
            out.gradient[k] += d.time[0].component_mul(&self.scale) * self.cost_of_time - change;
            out.gradient[next] += d.time[1].component_mul(&self.scale) * self.cost_of_time + change;
            out.defects.push(d.defect.map(|block| self.scale_defect(&block)));
            for index in 0..self.rules.len() {
                let slope = self.rules.slope(index, ends, &d, &self.scale);
                out.inequalities.push(slope.map(|g| g.component_mul(&self.scale)));
            }
            out.intervals.push(d);
        }
        out.nodes = nodes;
        out
    }

    /// Second derivatives of the Lagrangian f + lambda' c - y' g.
    pub(crate) fn hessian(&self, at: &Expansion, lambda: &[Defect], y: &[f64]) -> Hessian {
        let n = self.len();
        let mut out = Hessian { nodes: vec![Block::zeros(); n], mixed: Vec::with_capacity(n) };
        let states = self.scale.fixed_rows::<NS>(0);
        let rules = self.rules.len();
        for (k, d) in at.intervals.iter().enumerate() {
            let next = self.after(k);
            let ends = [&at.nodes[k], &at.nodes[next]];
            let mut more =
                Curvature { begin: Block::zeros(), mixed: Block::zeros(), end: Block::zeros() };
            let mut on_pace = [0.0; 2];
            for (index, y) in y[k * rules..(k + 1) * rules].iter().enumerate() {
                let (end, weight) =
                    self.rules.curvature(index, -y, ends, d, &self.scale, &mut more);
                on_pace[end] += weight;
            }
            let own = d.curvature(self.cost_of_time, on_pace, &lambda[k].component_div(&states));
            out.nodes[k] += self.scale_block(&(own.begin + more.begin));
            out.nodes[next] += self.scale_block(&(own.end + more.end));
            let mut mixed = self.scale_block(&(own.mixed + more.mixed));
            for i in NS..NZ {
                out.nodes[k][(i, i)] += self.cost_of_change;
                out.nodes[next][(i, i)] += self.cost_of_change;
                mixed[(i, i)] -= self.cost_of_change;
            }
            out.mixed.push(mixed);
        }
        out
    }

    fn scale_defect(&self, block: &DefectBlock) -> DefectBlock {
        DefectBlock::from_fn(|i, j| block[(i, j)] * self.scale[j] / self.scale[i])
    }

    fn scale_block(&self, block: &Block) -> Block {
        Block::from_fn(|i, j| block[(i, j)] * self.scale[i] * self.scale[j])
    }
}

/// The inputs of a node, its states set to 0.
fn inputs(z: &Node) -> Node {
    Node::from_fn(|i, _| if i < NS { 0.0 } else { z[i] })
}
