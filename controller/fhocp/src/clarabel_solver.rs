//! The FHOCP solved by Clarabel: one solver object per shape, values written in place.

use std::sync::Arc;

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT,
    SolverStatus, ZeroConeT,
};
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::layout::{Entries, Shape, state, walk};
use super::{Backend, Fhocp, FhocpSolver, Solution, SolveReport, SolveStatus, Termination};

/// Interior-point solver Clarabel behind the FHOCP's interface.
pub struct ClarabelSolver {
    termination: Termination,
    /// Whether linear solves are refined from the start, not only after a failure.
    refined: bool,
    built: Option<Built>,
}

/// The problem a solver was first laid out for. Clarabel keeps the equilibration of that problem,
/// so a solver that is to go on bit for bit must be laid out for the same one.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SolverSeed {
    shape: Shape,
    pattern: Arc<Pattern>,
}

/// Solver and value arrays of one shape.
struct Built {
    shape: Shape,
    pattern: Arc<Pattern>,
    solver: DefaultSolver<f64>,
    values: Values,
    /// Whether each linear solve is refined.
    refined: bool,
}

impl ClarabelSolver {
    /// A solver that ends so; memory is laid out at the first solve of each shape.
    #[must_use]
    pub fn new(termination: Termination) -> Self {
        Self { termination, refined: false, built: None }
    }

    /// The same with every linear solve refined, as Clarabel does by default: slower, for
    /// reference solutions to tight tolerances.
    #[must_use]
    pub fn reference(termination: Termination) -> Self {
        Self { refined: true, ..Self::new(termination) }
    }
}

impl ClarabelSolver {
    /// Lays out the memory for the shape of `problem`, if that is not the last one.
    pub(super) fn lay_out(&mut self, problem: &Fhocp) {
        let shape = Shape::of(problem);
        if self.built.as_ref().is_none_or(|built| built.shape != shape) {
            self.built = Built::new(problem, shape, self.termination);
        }
    }

    /// What the solver was laid out for, if it was.
    pub(super) fn seed(&self) -> Option<SolverSeed> {
        let built = self.built.as_ref()?;
        Some(SolverSeed { shape: built.shape, pattern: Arc::clone(&built.pattern) })
    }

    /// Lays the solver out as another one was.
    pub(super) fn restore(&mut self, seed: Option<&SolverSeed>) {
        let same = |b: &Built, s: &SolverSeed| b.shape == s.shape && b.pattern == s.pattern;
        let kept = matches!((&self.built, seed), (Some(b), Some(s)) if same(b, s));
        if !kept {
            self.built = seed.and_then(|s| {
                Built::from_pattern(Arc::clone(&s.pattern), s.shape, self.termination)
            });
        }
    }
}

impl FhocpSolver for ClarabelSolver {
    fn solve(&mut self, problem: &Fhocp, solution: &mut Solution) -> SolveReport {
        // A value that is not finite makes Clarabel report infeasibility: it never gets there.
        if !problem.is_finite() {
            return report(SolveStatus::Numerical, 0);
        }
        self.lay_out(problem);
        let Some(built) = &mut self.built else { return report(SolveStatus::Numerical, 0) };
        if !built.update(problem) {
            self.built = None;
            return report(SolveStatus::Numerical, 0);
        }
        // Refinement of each linear solve costs 40 % of the time and is rarely needed.
        let (mut status, mut iterations) = built.solve(self.refined, self.termination);
        if status != SolveStatus::Solved && !self.refined {
            let (again, more) = built.solve(true, self.termination);
            status = again;
            iterations += more;
        }
        if status.usable() {
            read(problem, &built.shape, &built.solver.solution.x, solution);
        }
        report(status, iterations)
    }
}

fn report(status: SolveStatus, iterations: u32) -> SolveReport {
    SolveReport { status, iterations, backend: Backend::Clarabel }
}

impl Built {
    fn new(problem: &Fhocp, shape: Shape, termination: Termination) -> Option<Self> {
        let mut pattern = Pattern::default();
        walk(problem, &shape, &mut pattern);
        Self::from_pattern(Arc::new(pattern), shape, termination)
    }

    fn from_pattern(pattern: Arc<Pattern>, shape: Shape, termination: Termination) -> Option<Self> {
        let (n, m) = (shape.variables(), pattern.b.len());
        let mut q = vec![0.0; n];
        for &(variable, value) in &pattern.q {
            q[variable] = value;
        }
        let (p, p_slots) = compress(n, n, &pattern.p);
        let (a, a_slots) = compress(m, n, &pattern.a);
        let cones = [ZeroConeT(shape.equalities()), NonnegativeConeT(m - shape.equalities())];
        let solver =
            DefaultSolver::new(&p, &q, &a, &pattern.b, &cones, settings(termination, false)?)
                .ok()?;
        let values = Values {
            p: p.nzval,
            q,
            a: a.nzval,
            b: pattern.b.clone(),
            p_slots,
            a_slots,
            at: [0; 3],
        };
        Some(Self { shape, pattern, solver, values, refined: false })
    }

    fn solve(&mut self, refined: bool, termination: Termination) -> (SolveStatus, u32) {
        if self.refined != refined
            && let Some(settings) = settings(termination, refined)
            && self.solver.update_settings(settings).is_ok()
        {
            self.refined = refined;
        }
        self.solver.solve();
        let result = &self.solver.solution;
        (status_of(result.status), result.iterations)
    }

    fn update(&mut self, problem: &Fhocp) -> bool {
        let values = &mut self.values;
        values.at = [0; 3];
        walk(problem, &self.shape, values);
        self.solver.update_P(&values.p).is_ok()
            && self.solver.update_q(&values.q).is_ok()
            && self.solver.update_A(&values.a).is_ok()
            && self.solver.update_b(&values.b).is_ok()
    }
}

fn settings(termination: Termination, refined: bool) -> Option<DefaultSettings<f64>> {
    DefaultSettingsBuilder::default()
        .verbose(false)
        // Presolve would forbid updating values in place.
        .presolve_enable(false)
        .iterative_refinement_enable(refined)
        .max_iter(termination.max_iterations)
        .tol_gap_abs(termination.tolerance)
        .tol_gap_rel(termination.tolerance)
        .tol_feas(termination.tolerance)
        .direct_solve_method("qdldl".to_owned())
        .build()
        .ok()
}

fn status_of(status: SolverStatus) -> SolveStatus {
    match status {
        SolverStatus::Solved => SolveStatus::Solved,
        SolverStatus::AlmostSolved => SolveStatus::AlmostSolved,
        SolverStatus::MaxIterations | SolverStatus::MaxTime | SolverStatus::CallbackTerminated => {
            SolveStatus::MaxIterations
        }
        SolverStatus::PrimalInfeasible
        | SolverStatus::DualInfeasible
        | SolverStatus::AlmostPrimalInfeasible
        | SolverStatus::AlmostDualInfeasible => SolveStatus::Infeasible,
        SolverStatus::NumericalError
        | SolverStatus::InsufficientProgress
        | SolverStatus::Unsolved => SolveStatus::Numerical,
    }
}

fn read(problem: &Fhocp, shape: &Shape, z: &[f64], solution: &mut Solution) {
    solution.x[0] = problem.x_0;
    for t in 0..shape.horizon {
        solution.x[t + 1] = state(shape, z, t + 1);
        let u = shape.u(t);
        solution.u[t] = Vector2::new(z[u], z[u + 1]);
    }
    let lambda = shape.lambda();
    solution.lambda.copy_from_slice(&z[lambda..lambda + shape.hull]);
}

/// Entries as triplets, for the first solve of a shape.
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
struct Pattern {
    p: Vec<(usize, usize, f64)>,
    q: Vec<(usize, f64)>,
    a: Vec<(usize, usize, f64)>,
    b: Vec<f64>,
}

impl Entries for Pattern {
    fn p(&mut self, row: usize, column: usize, value: f64) {
        self.p.push((row, column, value));
    }

    fn q(&mut self, variable: usize, value: f64) {
        self.q.push((variable, value));
    }

    fn a(&mut self, row: usize, column: usize, value: f64) {
        self.a.push((row, column, value));
    }

    fn b(&mut self, value: f64) {
        self.b.push(value);
    }
}

/// Value arrays of a known pattern; the i-th entry walked lands in slot i.
struct Values {
    p: Vec<f64>,
    q: Vec<f64>,
    a: Vec<f64>,
    b: Vec<f64>,
    p_slots: Vec<usize>,
    a_slots: Vec<usize>,
    /// Entries of P, A and b walked so far.
    at: [usize; 3],
}

impl Entries for Values {
    fn p(&mut self, _: usize, _: usize, value: f64) {
        self.p[self.p_slots[self.at[0]]] = value;
        self.at[0] += 1;
    }

    fn q(&mut self, variable: usize, value: f64) {
        self.q[variable] = value;
    }

    fn a(&mut self, _: usize, _: usize, value: f64) {
        self.a[self.a_slots[self.at[1]]] = value;
        self.at[1] += 1;
    }

    fn b(&mut self, value: f64) {
        self.b[self.at[2]] = value;
        self.at[2] += 1;
    }
}

/// Compressed columns of distinct triplets, zeros kept, and the slot of each triplet.
fn compress(
    rows: usize,
    columns: usize,
    triplets: &[(usize, usize, f64)],
) -> (CscMatrix<f64>, Vec<usize>) {
    let mut order: Vec<usize> = (0..triplets.len()).collect();
    order.sort_by_key(|&i| (triplets[i].1, triplets[i].0));
    let mut slots = vec![0; triplets.len()];
    let mut colptr = vec![0; columns + 1];
    let mut rowval = Vec::with_capacity(order.len());
    let mut nzval = Vec::with_capacity(order.len());
    for (slot, &i) in order.iter().enumerate() {
        let (row, column, value) = triplets[i];
        slots[i] = slot;
        colptr[column + 1] += 1;
        rowval.push(row);
        nzval.push(value);
    }
    for column in 0..columns {
        colptr[column + 1] += colptr[column];
    }
    (CscMatrix::new(rows, columns, colptr, rowval, nzval), slots)
}
