//! The FMI 2.0 co-simulation functions, generic over the model. `export_fmu!` gives them their
//! C names; meaning and arguments are those of the FMI 2.0.4 standard, chapters 2.1 and 4.2.

use std::ffi::{c_char, c_void};
use std::ptr::null_mut;

use super::instantiate::{folder_of, make, optional_text};
use super::logger::{Callback, Logger2};
use super::{call, pointer};
use crate::description::Version::{self, Fmi2};
use crate::instance::{Boolean2, Element};
use crate::log::Filter;
use crate::model::FmuModel;
use crate::status::CallError;

/// `fmi2CallbackFunctions`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Callbacks {
    /// Receives messages.
    pub logger: Option<Logger2>,
    /// Unused: memory is our own.
    // SAFETY: a member of the standard's structure; never called.
    pub allocate_memory: Option<unsafe extern "C" fn(usize, usize) -> *mut c_void>,
    /// Unused.
    // SAFETY: as above.
    pub free_memory: Option<unsafe extern "C" fn(*mut c_void)>,
    /// Unused: no step is pending after its call.
    // SAFETY: as above.
    pub step_finished: Option<unsafe extern "C" fn(*mut c_void, i32)>,
    /// Handed back to the logger.
    pub environment: *mut c_void,
}

/// `fmi2CoSimulation` of `fmi2Type`.
const CO_SIMULATION: i32 = 1;
/// Members of `fmi2StatusKind`.
const LAST_SUCCESSFUL_TIME: i32 = 2;
const TERMINATED: i32 = 3;

/// `fmi2Instantiate`.
///
/// # Safety
/// Strings end with a zero byte; `callbacks` is null or points to a `fmi2CallbackFunctions`.
pub unsafe fn instantiate<M: FmuModel>(
    name: *const c_char,
    kind: i32,
    token: *const c_char,
    resources: *const c_char,
    callbacks: *const Callbacks,
    logging: i32,
) -> *mut c_void {
    // SAFETY: null or valid by the caller's promise.
    let callbacks = unsafe { callbacks.as_ref() };
    let (log, environment) = callbacks.map_or((None, null_mut()), |c| (c.logger, c.environment));
    let callback = log.map_or(Callback::None, Callback::Fmi2);
    let check = || {
        if kind != CO_SIMULATION {
            return Err(CallError::Refused("this FMU is for co-simulation only".to_owned()));
        }
        // SAFETY: the caller's promise.
        let folder = match unsafe { optional_text("resource location", resources) }? {
            Some(uri) => folder_of(uri),
            None => None,
        };
        Ok(folder)
    };
    // SAFETY: the caller's promise.
    unsafe { make::<M>(Fmi2, name, token, callback, environment, logging != 0, check) }
}

/// `fmi2FreeInstance`.
pub fn free_instance(component: *mut c_void) {
    super::free(component);
}

/// `fmi2SetDebugLogging`.
///
/// # Safety
/// `categories` points to `n` strings.
pub unsafe fn set_debug_logging<M: FmuModel>(
    component: *mut c_void,
    version: Version,
    function: &str,
    on: bool,
    n: usize,
    categories: *const *const c_char,
) -> i32 {
    call::<M>(component, version, function, |instance| {
        // SAFETY: the caller's promise.
        let names = unsafe { pointer::texts("categories", categories, n) }?;
        instance.filter = Filter::choose(on, &names).map_err(CallError::Refused)?;
        Ok(())
    })
}

/// `fmi2SetupExperiment`.
pub fn setup_experiment<M: FmuModel>(
    component: *mut c_void,
    start: f64,
    stop_defined: i32,
    stop: f64,
) -> i32 {
    let name = "fmi2SetupExperiment";
    let stop = (stop_defined != 0).then_some(stop);
    call::<M>(component, Fmi2, name, |instance| instance.set_times(name, start, stop))
}

/// `fmi2EnterInitializationMode`.
pub fn enter_initialization_mode<M: FmuModel>(component: *mut c_void) -> i32 {
    let name = "fmi2EnterInitializationMode";
    call::<M>(component, Fmi2, name, |instance| instance.enter_initialization(name))
}

/// `ExitInitializationMode` of either version.
pub fn exit_initialization_mode<M: FmuModel>(
    component: *mut c_void,
    version: Version,
    name: &str,
) -> i32 {
    call::<M>(component, version, name, |instance| instance.exit_initialization(name))
}

/// `Terminate` of either version.
pub fn terminate<M: FmuModel>(component: *mut c_void, version: Version, name: &str) -> i32 {
    call::<M>(component, version, name, |instance| instance.terminate(name))
}

/// `Reset` of either version.
pub fn reset<M: FmuModel>(component: *mut c_void, version: Version, name: &str) -> i32 {
    call::<M>(component, version, name, |instance| instance.reset(name))
}

/// `fmi2GetReal` and `fmi2GetInteger`, by the type of `values`.
///
/// # Safety
/// `references` and `values` point to `n` elements each.
#[allow(private_bounds)]
pub unsafe fn get<M: FmuModel, T: Element>(
    component: *mut c_void,
    name: &str,
    references: *const u32,
    n: usize,
    values: *mut T,
) -> i32 {
    call::<M>(component, Fmi2, name, |instance| {
        // SAFETY: the caller's promise.
        let references = unsafe { pointer::slice("value references", references, n) }?;
        // SAFETY: the caller's promise.
        let values = unsafe { pointer::slice_mut("values", values, n) }?;
        instance.get(name, references, values)
    })
}

/// `fmi2GetBoolean`.
///
/// # Safety
/// As for [`get`].
pub unsafe fn get_boolean<M: FmuModel>(
    component: *mut c_void,
    references: *const u32,
    n: usize,
    values: *mut i32,
) -> i32 {
    // SAFETY: Boolean2 is a transparent i32; the rest is the caller's promise.
    unsafe { get::<M, _>(component, "fmi2GetBoolean", references, n, values.cast::<Boolean2>()) }
}

/// `GetString` of either version.
///
/// # Safety
/// As for [`get`].
pub unsafe fn get_string<M: FmuModel>(
    component: *mut c_void,
    version: Version,
    name: &str,
    references: *const u32,
    n: usize,
    values: *mut *const c_char,
) -> i32 {
    call::<M>(component, version, name, |instance| {
        // SAFETY: the caller's promise.
        let references = unsafe { pointer::slice("value references", references, n) }?;
        // SAFETY: the caller's promise.
        let values = unsafe { pointer::slice_mut("values", values, n) }?;
        instance.get_texts(name, references, values)
    })
}

/// `fmi2SetReal` and `fmi2SetInteger`, by the type of `values`.
///
/// # Safety
/// `references` and `values` point to `n` elements each.
#[allow(private_bounds)]
pub unsafe fn set<M: FmuModel, T: Element>(
    component: *mut c_void,
    name: &str,
    references: *const u32,
    n: usize,
    values: *const T,
) -> i32 {
    call::<M>(component, Fmi2, name, |instance| {
        // SAFETY: the caller's promise.
        let references = unsafe { pointer::slice("value references", references, n) }?;
        // SAFETY: the caller's promise.
        let values = unsafe { pointer::slice("values", values, n) }?;
        instance.set(name, references, values)
    })
}

/// `fmi2SetBoolean`.
///
/// # Safety
/// As for [`set`].
pub unsafe fn set_boolean<M: FmuModel>(
    component: *mut c_void,
    references: *const u32,
    n: usize,
    values: *const i32,
) -> i32 {
    // SAFETY: Boolean2 is a transparent i32; the rest is the caller's promise.
    unsafe { set::<M, _>(component, "fmi2SetBoolean", references, n, values.cast::<Boolean2>()) }
}

/// `SetString` of either version.
///
/// # Safety
/// As for [`set`]; every string ends with a zero byte.
pub unsafe fn set_string<M: FmuModel>(
    component: *mut c_void,
    version: Version,
    name: &str,
    references: *const u32,
    n: usize,
    values: *const *const c_char,
) -> i32 {
    call::<M>(component, version, name, |instance| {
        // SAFETY: the caller's promise.
        let references = unsafe { pointer::slice("value references", references, n) }?;
        // SAFETY: the caller's promise.
        let values = unsafe { pointer::texts("values", values, n) }?;
        let values: Vec<String> = values.into_iter().map(str::to_owned).collect();
        instance.set_texts(name, references, &values)
    })
}

/// `fmi2DoStep`.
pub fn do_step<M: FmuModel>(component: *mut c_void, begin: f64, size: f64) -> i32 {
    let name = "fmi2DoStep";
    call::<M>(component, Fmi2, name, |instance| instance.do_step(name, begin, size))
}

/// `fmi2GetRealStatus`: the time reached is always known.
///
/// # Safety
/// `value` is null or can be written to.
pub unsafe fn get_real_status<M: FmuModel>(
    component: *mut c_void,
    kind: i32,
    value: *mut f64,
) -> i32 {
    let name = "fmi2GetRealStatus";
    call::<M>(component, Fmi2, name, |instance| {
        // SAFETY: the caller's promise.
        let value = unsafe { pointer::out("value", value) }?;
        if kind != LAST_SUCCESSFUL_TIME {
            return Err(CallError::Discard(format!("{name}: no such status ({kind})")));
        }
        *value = instance.core.time;
        Ok(())
    })
}

/// `fmi2GetBooleanStatus`: the model never asks to end the simulation.
///
/// # Safety
/// `value` is null or can be written to.
pub unsafe fn get_boolean_status<M: FmuModel>(
    component: *mut c_void,
    kind: i32,
    value: *mut i32,
) -> i32 {
    let name = "fmi2GetBooleanStatus";
    call::<M>(component, Fmi2, name, |_| {
        // SAFETY: the caller's promise.
        let value = unsafe { pointer::out("value", value) }?;
        if kind != TERMINATED {
            return Err(CallError::Discard(format!("{name}: no such status ({kind})")));
        }
        *value = 0;
        Ok(())
    })
}

/// `fmi2GetStatus`, `fmi2GetIntegerStatus`, `fmi2GetStringStatus`: no step is ever pending, so
/// there is nothing to tell.
pub fn no_status<M: FmuModel>(component: *mut c_void, name: &str) -> i32 {
    call::<M>(component, Fmi2, name, |_| {
        Err(CallError::Discard(format!(
            "{name}: steps are never pending, so there is no such status"
        )))
    })
}
