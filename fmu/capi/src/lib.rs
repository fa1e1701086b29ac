//! The controller behind the C functions of `lmpc.h`, which says what each means.
//!
//! Nothing here reads a file or a clock. A panic never crosses into C: it becomes a failure.
#![allow(unsafe_code, reason = "functions of C, for C")]
#![allow(unreachable_pub, clippy::missing_safety_doc, reason = "the C header documents them")]

mod create;
mod saved;

use std::ffi::{c_char, c_int};
use std::panic::{AssertUnwindSafe, catch_unwind};

use controller::{Action, Command, Controller, Measurement, Pose};
use fmu_core::c::floating::FloatingPoint;
use vehicle_model::{GlobalState, Input, State};

/// A controller and what tells its saved states from those of others.
pub struct Handle {
    controller: Controller,
    identity: u64,
}

/// `lmpc_state`.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct CState {
    v_x: f64,
    v_y: f64,
    omega_z: f64,
    e_psi: f64,
    s: f64,
    e_y: f64,
}

/// `lmpc_global_state`.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct CGlobalState {
    v_x: f64,
    v_y: f64,
    omega_z: f64,
    x: f64,
    y: f64,
    psi: f64,
}

/// `lmpc_input`.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct CInput {
    a: f64,
    delta: f64,
}

/// `lmpc_command`.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct CCommand {
    input: CInput,
    action: i32,
    iterations: i32,
    lap: i32,
    lap_finished: i32,
    lap_valid: i32,
    lap_time: f64,
}

impl From<&Command> for CCommand {
    fn from(command: &Command) -> Self {
        let status = &command.status;
        let finished = status.finished.as_ref();
        Self {
            input: CInput { a: command.input.a, delta: command.input.delta },
            action: match status.action {
                Action::WarmUp => 0,
                Action::Learned => 1,
                Action::ShiftedPlan => 2,
                Action::Tracking => 3,
                Action::Braking => 4,
                Action::Recovering => 5,
            },
            iterations: i32::try_from(status.iterations).unwrap_or(i32::MAX),
            lap: i32::try_from(status.lap.get()).unwrap_or(i32::MAX),
            lap_finished: i32::from(finished.is_some()),
            lap_valid: i32::from(finished.is_some_and(|lap| lap.valid)),
            lap_time: finished.map_or(0.0, |lap| lap.lap_time),
        }
    }
}

/// Runs what a C function does in our floating-point state; a panic becomes `failed`.
fn guarded<T>(failed: T, body: impl FnOnce() -> T) -> T {
    let _floating = FloatingPoint::ours();
    catch_unwind(AssertUnwindSafe(body)).unwrap_or(failed)
}

/// Writes a reason where the caller wants it, cut to its room.
///
/// # Safety
/// `error` is null or has room for `size` bytes.
unsafe fn explain(error: *mut c_char, size: usize, reason: &str) {
    if error.is_null() || size == 0 {
        return;
    }
    let n = reason.len().min(size - 1);
    // SAFETY: the caller's promise; n is below size.
    unsafe {
        std::ptr::copy_nonoverlapping(reason.as_ptr(), error.cast::<u8>(), n);
        *error.add(n) = 0;
    }
}

/// One step with a pose of either frame.
///
/// # Safety
/// The pointers are null or point to what their types say.
unsafe fn step(
    handle: *mut Handle,
    time: f64,
    pose: Option<Pose>,
    applied: *const CInput,
    command: *mut CCommand,
) -> c_int {
    guarded(1, || {
        // SAFETY: the caller's promise.
        let (handle, applied, out) =
            unsafe { (handle.as_mut(), applied.as_ref(), command.as_mut()) };
        let (Some(handle), Some(pose), Some(out)) = (handle, pose, out) else { return 1 };
        let applied = applied.map(|u| Input { a: u.a, delta: u.delta });
        *out = CCommand::from(&handle.controller.step(&Measurement { time, pose, applied }));
        0
    })
}

// SAFETY: the name stands once in a program; the arguments are as in lmpc.h.
#[unsafe(no_mangle)]
unsafe extern "C" fn lmpc_period(handle: *const Handle) -> f64 {
    // SAFETY: the caller's promise.
    unsafe { handle.as_ref() }.map_or(0.0, |handle| handle.controller.config().horizon.period)
}

// SAFETY: as above.
#[unsafe(no_mangle)]
unsafe extern "C" fn lmpc_step(
    handle: *mut Handle,
    time: f64,
    state: *const CState,
    applied: *const CInput,
    command: *mut CCommand,
) -> c_int {
    // SAFETY: the caller's promise.
    let pose = unsafe { state.as_ref() }.map(|x| {
        let CState { v_x, v_y, omega_z, e_psi, s, e_y } = *x;
        Pose::Frenet(State { v_x, v_y, omega_z, e_psi, s, e_y })
    });
    // SAFETY: the caller's promise.
    unsafe { step(handle, time, pose, applied, command) }
}

// SAFETY: as above.
#[unsafe(no_mangle)]
unsafe extern "C" fn lmpc_step_global(
    handle: *mut Handle,
    time: f64,
    state: *const CGlobalState,
    applied: *const CInput,
    command: *mut CCommand,
) -> c_int {
    // SAFETY: the caller's promise.
    let pose = unsafe { state.as_ref() }.map(|at| {
        let CGlobalState { v_x, v_y, omega_z, x, y, psi } = *at;
        Pose::Global(GlobalState { x, y, psi, v_x, v_y, omega_z })
    });
    // SAFETY: the caller's promise.
    unsafe { step(handle, time, pose, applied, command) }
}

// SAFETY: as above.
#[unsafe(no_mangle)]
unsafe extern "C" fn lmpc_prepare(handle: *mut Handle) -> c_int {
    guarded(1, || {
        // SAFETY: the caller's promise.
        let Some(handle) = (unsafe { handle.as_mut() }) else { return 1 };
        handle.controller.prepare();
        0
    })
}

// SAFETY: as above; the pointer came from lmpc_create and is not used again.
#[unsafe(no_mangle)]
unsafe extern "C" fn lmpc_free(handle: *mut Handle) {
    guarded((), || {
        if !handle.is_null() {
            // SAFETY: made by Box::into_raw in lmpc_create.
            drop(unsafe { Box::from_raw(handle) });
        }
    });
}
