//! The symmetric linear system of a Newton step, factorised by Clarabel's sparse LDL':
//!
//! [H + delta I   A'     ] [dz     ]   [r_z]
//! [A            -gamma I] [dlambda] = [r_c]
//!
//! Nodes and multipliers are eliminated along the lap, the first node last: the fill-in grows
//! with the number of nodes only.

use clarabel::algebra::CscMatrix;
use clarabel::qdldl::{QDLDLFactorisation, QDLDLSettings};

use crate::interval::{Block, Defect, DefectBlock, NS, NZ, Node};

/// Rows and columns of a node with its multipliers.
const STAGE: usize = NZ + NS;
/// Rounds of iterative refinement of a solution.
const REFINEMENTS: usize = 8;
/// Residual at which refinement ends, relative to the right-hand side.
const RESIDUAL: f64 = 1e-11;
/// Residual above which a solution is of no use, relative to the right-hand side.
const MOST_RESIDUAL: f64 = 1e-5;

/// The blocks of the system.
pub(crate) struct Blocks<'a> {
    /// Of each node, with barrier terms.
    pub(crate) nodes: &'a [Block],
    /// Of each interval's first and second node.
    pub(crate) mixed: &'a [Block],
    /// Slopes of each interval's defects.
    pub(crate) defects: &'a [[DefectBlock; 2]],
    /// Regularisation of the nodes, delta.
    pub(crate) primal: f64,
    /// Regularisation of the multipliers, gamma.
    pub(crate) dual: f64,
}

/// The system of one mesh.
pub(crate) struct Kkt {
    n: usize,
    matrix: CscMatrix<f64>,
    slots: Vec<usize>,
    indices: Vec<usize>,
    factors: Option<QDLDLFactorisation<f64>>,
}

impl Kkt {
    /// The pattern for `n` nodes, at least 3.
    pub(crate) fn new(n: usize) -> Self {
        let mut places = Vec::new();
        walk(n, None, &mut |row, column, _| places.push((row, column)));
        let size = n * STAGE;
        let mut order: Vec<usize> = (0..places.len()).collect();
        order.sort_by_key(|&i| (places[i].1, places[i].0));
        let mut slots = vec![0; places.len()];
        let mut columns = vec![0; size + 1];
        let mut rows = Vec::with_capacity(places.len());
        for (slot, &i) in order.iter().enumerate() {
            slots[i] = slot;
            columns[places[i].1 + 1] += 1;
            rows.push(places[i].0);
        }
        for column in 0..size {
            columns[column + 1] += columns[column];
        }
        let values = vec![1.0; places.len()];
        let indices = (0..places.len()).collect();
        let matrix = CscMatrix::new(size, size, columns, rows, values);
        Self { n, matrix, slots, indices, factors: None }
    }

    /// Factorises; whether the inertia is that of a convex step, with as many negative
    /// eigenvalues as there are equations and all others positive.
    pub(crate) fn factorise(&mut self, blocks: &Blocks<'_>) -> bool {
        let mut next = self.slots.iter();
        let values = &mut self.matrix.nzval;
        walk(self.n, Some(blocks), &mut |_, _, value| {
            if let Some(slot) = next.next() {
                values[*slot] = value;
            }
        });
        let done = match &mut self.factors {
            Some(factors) => {
                factors.update_values(&self.indices, &self.matrix.nzval);
                factors.refactor().is_ok()
            }
            None => {
                let settings = QDLDLSettings {
                    perm: Some((0..self.matrix.n).collect()),
                    regularize_enable: false,
                    ..QDLDLSettings::default()
                };
                self.factors = QDLDLFactorisation::new(&self.matrix, Some(settings)).ok();
                self.factors.is_some()
            }
        };
        let inertia = self.factors.as_ref().map(QDLDLFactorisation::positive_inertia);
        done && inertia == Some(self.n * NZ)
    }

    /// Solves for both parts; `None` if the factors are too inaccurate.
    pub(crate) fn solve(
        &mut self,
        nodes: &[Node],
        defects: &[Defect],
    ) -> Option<(Vec<Node>, Vec<Defect>)> {
        let mut b = vec![0.0; self.n * STAGE];
        for k in 0..self.n {
            let (at, below) = (node(self.n, k), multiplier(k));
            b[at..at + NZ].copy_from_slice(nodes[k].as_slice());
            b[below..below + NS].copy_from_slice(defects[k].as_slice());
        }
        let x = self.refined(&b)?;
        let dz = (0..self.n).map(|k| Node::from_column_slice(&x[node(self.n, k)..][..NZ]));
        let dlambda = (0..self.n).map(|k| Defect::from_column_slice(&x[multiplier(k)..][..NS]));
        Some((dz.collect(), dlambda.collect()))
    }

    fn refined(&mut self, b: &[f64]) -> Option<Vec<f64>> {
        let factors = self.factors.as_mut()?;
        let norm = |v: &[f64]| v.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let size = norm(b).max(f64::MIN_POSITIVE);
        let mut x = vec![0.0; b.len()];
        let mut residual = b.to_vec();
        let mut left = f64::INFINITY;
        for _ in 0..=REFINEMENTS {
            let mut step = residual.clone();
            factors.solve(&mut step);
            let moved: Vec<f64> = x.iter().zip(&step).map(|(x, step)| x + step).collect();
            let rest = residual_of(&self.matrix, &moved, b);
            let error = norm(&rest) / size;
            if error.is_nan() || error >= left {
                break;
            }
            (x, residual, left) = (moved, rest, error);
            if left < RESIDUAL {
                break;
            }
        }
        (left < MOST_RESIDUAL).then_some(x)
    }
}

/// b - M x of a symmetric matrix stored as its upper triangle.
fn residual_of(matrix: &CscMatrix<f64>, x: &[f64], b: &[f64]) -> Vec<f64> {
    let mut rest = b.to_vec();
    for column in 0..matrix.n {
        for slot in matrix.colptr[column]..matrix.colptr[column + 1] {
            let (row, value) = (matrix.rowval[slot], matrix.nzval[slot]);
            rest[row] -= value * x[column];
            if row != column {
                rest[column] -= value * x[row];
            }
        }
    }
    rest
}

/// Position of node `k` of `n`: node 0 comes after all others.
fn node(n: usize, k: usize) -> usize {
    STAGE * (if k == 0 { n - 1 } else { k - 1 })
}

/// Position of the multipliers of interval `k`.
fn multiplier(k: usize) -> usize {
    STAGE * k + NZ
}

/// Visits every entry of the upper triangle, always in the same order.
fn walk(n: usize, blocks: Option<&Blocks<'_>>, visit: &mut impl FnMut(usize, usize, f64)) {
    let mut put = |row: usize, column: usize, value: f64| {
        visit(row.min(column), row.max(column), value);
    };
    for k in 0..n {
        let at = node(n, k);
        for j in 0..NZ {
            for i in 0..=j {
                let more = blocks.map_or(0.0, |b| if i == j { b.primal } else { 0.0 });
                put(at + i, at + j, blocks.map_or(0.0, |b| b.nodes[k][(i, j)] + more));
            }
        }
        let after = node(n, if k + 1 == n { 0 } else { k + 1 });
        for j in 0..NZ {
            for i in 0..NZ {
                put(at + i, after + j, blocks.map_or(0.0, |b| b.mixed[k][(i, j)]));
            }
        }
        let below = multiplier(k);
        for (side, place) in [at, after].into_iter().enumerate() {
            for j in 0..NZ {
                for i in 0..NS {
                    let value = blocks.map_or(0.0, |b| b.defects[k][side][(i, j)]);
                    put(below + i, place + j, value);
                }
            }
        }
        for i in 0..NS {
            put(below + i, below + i, blocks.map_or(0.0, |b| -b.dual));
        }
    }
}
