//! The FMI 3.0 co-simulation functions, generic over the model. `export_fmu!` gives them their
//! C names; meaning and arguments are those of the FMI 3.0.2 standard, chapters 2.2 and 4.2.

use std::ffi::{c_char, c_void};
use std::path::PathBuf;
use std::ptr::null_mut;

use super::instantiate::{make, optional_text};
use super::logger::{Callback, Logger, Logger3};
use super::{call, fmi2, pointer};
use crate::description::Version::Fmi3;
use crate::instance::{Boolean3, Element};
use crate::log::LogMessage;
use crate::model::FmuModel;
use crate::status::{CallError, FmiStatus};

/// `fmi3InstantiateCoSimulation`.
///
/// # Safety
/// Strings end with a zero byte.
pub unsafe fn instantiate<M: FmuModel>(
    name: *const c_char,
    token: *const c_char,
    resources: *const c_char,
    logging: bool,
    event_mode: bool,
    environment: *mut c_void,
    log: Option<Logger3>,
) -> *mut c_void {
    let callback = log.map_or(Callback::None, Callback::Fmi3);
    let folder = || {
        if event_mode {
            return Err(CallError::Refused("this FMU has no event mode".to_owned()));
        }
        // SAFETY: the caller's promise.
        Ok(unsafe { optional_text("resource path", resources) }?.map(PathBuf::from))
    };
    // SAFETY: the caller's promise.
    unsafe { make::<M>(Fmi3, name, token, callback, environment, logging, folder) }
}

/// `fmi3InstantiateModelExchange` and `fmi3InstantiateScheduledExecution`: not offered.
pub fn instantiate_unsupported(
    environment: *mut c_void,
    log: Option<Logger3>,
    name: &str,
) -> *mut c_void {
    let text = format!("{name}: this FMU is for co-simulation only");
    let message = LogMessage { status: FmiStatus::Error, text };
    let send = || {
        Logger::new(log.map_or(Callback::None, Callback::Fmi3), environment, "").send(&message);
    };
    // Nothing above can panic short of a lack of memory; the guard is for that.
    let _ = std::panic::catch_unwind(std::panic::AssertUnwindSafe(send));
    null_mut()
}

/// `fmi3EnterInitializationMode`.
pub fn enter_initialization_mode<M: FmuModel>(
    instance: *mut c_void,
    start: f64,
    stop_defined: u8,
    stop: f64,
) -> i32 {
    let name = "fmi3EnterInitializationMode";
    let stop = (stop_defined != 0).then_some(stop);
    call::<M>(instance, Fmi3, name, |instance| {
        instance.set_times(name, start, stop)?;
        instance.enter_initialization(name)
    })
}

/// `fmi3GetFloat64` and `fmi3GetInt32`, by the type of `values`.
///
/// # Safety
/// `references` points to `n` elements, `values` to `m`.
#[allow(private_bounds)]
pub unsafe fn get<M: FmuModel, T: Element>(
    instance: *mut c_void,
    name: &str,
    references: *const u32,
    n: usize,
    values: *mut T,
    m: usize,
) -> i32 {
    call::<M>(instance, Fmi3, name, |instance| {
        same_count(name, n, m)?;
        // SAFETY: the caller's promise.
        let references = unsafe { pointer::slice("value references", references, n) }?;
        // SAFETY: the caller's promise.
        let values = unsafe { pointer::slice_mut("values", values, m) }?;
        instance.get(name, references, values)
    })
}

/// `fmi3GetBoolean`.
///
/// # Safety
/// As for [`get`].
pub unsafe fn get_boolean<M: FmuModel>(
    instance: *mut c_void,
    references: *const u32,
    n: usize,
    values: *mut u8,
    m: usize,
) -> i32 {
    let values = values.cast::<Boolean3>();
    // SAFETY: Boolean3 is a transparent byte; the rest is the caller's promise.
    unsafe { get::<M, _>(instance, "fmi3GetBoolean", references, n, values, m) }
}

/// `fmi3SetFloat64` and `fmi3SetInt32`, by the type of `values`.
///
/// # Safety
/// `references` points to `n` elements, `values` to `m`.
#[allow(private_bounds)]
pub unsafe fn set<M: FmuModel, T: Element>(
    instance: *mut c_void,
    name: &str,
    references: *const u32,
    n: usize,
    values: *const T,
    m: usize,
) -> i32 {
    call::<M>(instance, Fmi3, name, |instance| {
        same_count(name, n, m)?;
        // SAFETY: the caller's promise.
        let references = unsafe { pointer::slice("value references", references, n) }?;
        // SAFETY: the caller's promise.
        let values = unsafe { pointer::slice("values", values, m) }?;
        instance.set(name, references, values)
    })
}

/// `fmi3SetBoolean`.
///
/// # Safety
/// As for [`set`].
pub unsafe fn set_boolean<M: FmuModel>(
    instance: *mut c_void,
    references: *const u32,
    n: usize,
    values: *const u8,
    m: usize,
) -> i32 {
    let values = values.cast::<Boolean3>();
    // SAFETY: Boolean3 is a transparent byte; the rest is the caller's promise.
    unsafe { set::<M, _>(instance, "fmi3SetBoolean", references, n, values, m) }
}

/// `fmi3GetString` and `fmi3SetString` pass two counts; scalars need them equal.
///
/// # Errors
/// [`CallError::Refused`] naming both.
fn same_count(name: &str, n: usize, m: usize) -> Result<(), CallError> {
    if n == m {
        return Ok(());
    }
    Err(CallError::Refused(format!("{name}: {m} values for {n} scalar variables")))
}

/// `fmi3GetString`.
///
/// # Safety
/// As for [`get`].
pub unsafe fn get_string<M: FmuModel>(
    instance: *mut c_void,
    references: *const u32,
    n: usize,
    values: *mut *const c_char,
    m: usize,
) -> i32 {
    let name = "fmi3GetString";
    if n != m {
        return call::<M>(instance, Fmi3, name, |_| same_count(name, n, m));
    }
    // SAFETY: the caller's promise.
    unsafe { fmi2::get_string::<M>(instance, Fmi3, name, references, n, values) }
}

/// `fmi3SetString`.
///
/// # Safety
/// As for [`set`]; every string ends with a zero byte.
pub unsafe fn set_string<M: FmuModel>(
    instance: *mut c_void,
    references: *const u32,
    n: usize,
    values: *const *const c_char,
    m: usize,
) -> i32 {
    let name = "fmi3SetString";
    if n != m {
        return call::<M>(instance, Fmi3, name, |_| same_count(name, n, m));
    }
    // SAFETY: the caller's promise.
    unsafe { fmi2::set_string::<M>(instance, Fmi3, name, references, n, values) }
}

/// Getters and setters of types that no variable here has: fine for no variable, else refused.
pub fn no_such_type<M: FmuModel>(instance: *mut c_void, name: &str, n: usize) -> i32 {
    call::<M>(instance, Fmi3, name, |instance| {
        if instance.core.phase == crate::instance::Phase::Dead {
            instance.allow(name, &[])?;
        }
        if n == 0 {
            return Ok(());
        }
        Err(CallError::Refused(format!("{name}: this FMU has no variable of that type")))
    })
}

/// Counts of things this FMU has none of.
///
/// # Safety
/// `count` is null or can be written to.
pub unsafe fn none<M: FmuModel>(instance: *mut c_void, name: &str, count: *mut usize) -> i32 {
    call::<M>(instance, Fmi3, name, |_| {
        // SAFETY: the caller's promise.
        *unsafe { pointer::out("count", count) }? = 0;
        Ok(())
    })
}

/// Where `fmi3DoStep` reports to.
#[derive(Clone, Copy, Debug)]
pub struct StepReport {
    /// Never set: there is no event mode.
    pub event_handling_needed: *mut u8,
    /// Never set: the model does not end simulations.
    pub terminate_simulation: *mut u8,
    /// Never set: steps are taken whole or not at all.
    pub early_return: *mut u8,
    /// Time reached \[s\].
    pub last_successful_time: *mut f64,
}

/// `fmi3DoStep`.
///
/// # Safety
/// The report's pointers are null or can be written to.
pub unsafe fn do_step<M: FmuModel>(
    instance: *mut c_void,
    begin: f64,
    size: f64,
    report: StepReport,
) -> i32 {
    let name = "fmi3DoStep";
    call::<M>(instance, Fmi3, name, |instance| {
        let flags =
            [report.event_handling_needed, report.terminate_simulation, report.early_return];
        // SAFETY: the caller's promise.
        let time = unsafe { pointer::out("lastSuccessfulTime", report.last_successful_time) }?;
        for flag in flags {
            // SAFETY: the caller's promise.
            let _ = unsafe { pointer::out("a flag of fmi3DoStep", flag) }?;
        }
        let done = instance.do_step(name, begin, size);
        for flag in flags {
            // SAFETY: checked above.
            *unsafe { pointer::out("a flag of fmi3DoStep", flag) }? = 0;
        }
        *time = instance.core.time;
        done
    })
}
