//! Recorded problems that the structured solver once did not solve. A problem that `lmpc race --dump-qp` or
//! `lmpc bench --dump-qp` wrote becomes a test when its file is put into `tests/data/qp`.
//!
//! - `barc_n10_second_order`: the whole second-order term made the iteration go round in circles.
#![allow(clippy::unwrap_used)] // a missing file must fail the test

use std::path::Path;

use controller::SolveStatus;
use hosting::problem_file;
use step_timing::compare;

/// Iterations that a problem may take.
const ITERATIONS: u32 = 20;

#[test]
fn recorded_problems_are_solved_to_the_optimum() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/qp");
    let compared = compare(&problem_file::read_all(&folder).unwrap());
    assert!(!compared.is_empty());
    for row in compared {
        assert_eq!(row.status, SolveStatus::Solved, "{row:?}");
        assert!(row.iterations <= ITERATIONS, "{row:?}");
        assert!(row.clarabel_status.usable(), "{row:?}");
        assert!(row.cost_difference < 1e-6, "{row:?}");
        assert!(row.u_0_difference < 1e-4, "{row:?}");
    }
}
