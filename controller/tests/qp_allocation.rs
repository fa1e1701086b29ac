//! The structured solver allocates at the first solve of a shape, never after.
#![allow(unsafe_code, clippy::unwrap_used)]

mod support;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use controller::config::{SolverConfig, SolverMethod};
use controller::fhocp::{FhocpSolver, Solution, Solver};
use support::random::random;

struct Counting;

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: every call goes to the system allocator as it came; counting does not allocate.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        // SAFETY: the caller's promises are passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's promises are passed on.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn no_allocation_after_the_first_solve_of_a_shape() {
    let config = SolverConfig {
        method: SolverMethod::Structured,
        fallback: true,
        tolerance: 1e-8,
        max_iterations: 100,
    };
    let mut solver = Solver::new(config);
    for parts in [0b11111, 0b00000] {
        let mut solution = Solution::new(12, 24);
        let problems: Vec<_> = (0..10).map(|seed| random(seed, 12, 24, parts)).collect();
        let before = COUNT.get();
        assert!(solver.solve(&problems[0], &mut solution).status.usable());
        let first = COUNT.get();
        assert!(first > before, "memory is laid out at the first solve");
        for problem in &problems {
            assert!(solver.solve(problem, &mut solution).status.usable());
        }
        assert_eq!(COUNT.get(), first);
    }
}
