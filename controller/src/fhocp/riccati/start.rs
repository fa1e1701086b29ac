//! The starting point.

use super::Work;
use super::rows::{SOFT, quantities};
use super::super::Fhocp;

impl Work {
    /// Inputs held at the previous one, slacks and gaps wide enough for what that predicts.
    pub(super) fn start(&mut self, problem: &Fhocp) {
        let range = problem.u_max - problem.u_min;
        let (least, most) = (problem.u_min + range * 0.1, problem.u_max - range * 0.1);
        let u = problem.u_prev.sup(&least).inf(&most);
        let shape = self.rows.shape;
        self.point.u.fill(u);
        self.point.lambda.fill(1.0 / shape.hull as f64);
        self.point.x[0] = problem.x_0;
        self.rows.bounds(problem, &mut self.barrier.b);
        for t in 0..shape.horizon {
            self.point.x[t + 1] = problem.model[t].apply(&self.point.x[t], &u);
            let y = quantities(problem, t, &self.point.x[t], &u, &self.point.x[t + 1]);
            let b = self.rows.stage(t, &self.barrier.b);
            for k in 0..SOFT {
                self.point.s[t][k] = match self.rows.soft(b, k) {
                    Some([high, low, _]) => {
                        let low = if k == super::rows::SPEED { f64::INFINITY } else { low };
                        (y[k] - high).max(-y[k] - low).max(0.0) + 0.1
                    }
                    None => 0.0,
                };
            }
        }
        self.hull.load(problem);
        self.rows.image(problem, &self.point, problem.u_prev, &mut self.barrier.image);
        let hull = self.rows.hull();
        for i in 0..self.rows.count() {
            let w = self.barrier.b[i] - self.barrier.image[i];
            let w = if i < hull { w.max(0.1) } else { w };
            self.barrier.w[i] = w;
            self.barrier.z[i] = 0.1 / w;
        }
    }
}
