//! Where C begins: the guard around every exported function and the checks on raw pointers.
//!
//! The only `unsafe` of the FMUs is in this module and in what `export_fmu!` writes. What cannot
//! be checked from here is the caller's promise of every C interface: a pointer that is not null
//! points to as many elements as the caller says, and a string ends with a zero byte.
#![allow(unsafe_code)]

pub mod floating;
pub mod fmi2;
pub mod fmi3;
mod instantiate;
pub(crate) mod logger;
pub(crate) mod pointer;
pub mod state;

pub use logger::{Logger2, Logger3};

use std::ffi::c_void;
use std::panic::{AssertUnwindSafe, catch_unwind};

use self::floating::FloatingPoint;
use crate::description::Version;
use crate::instance::{Instance, Phase, panic_text};
use crate::log::LogMessage;
use crate::model::FmuModel;
use crate::registry;
use crate::status::{CallError, FmiStatus};

/// The guard: sets the host's floating-point state aside, finds the instance, runs the call,
/// catches panics, turns the result into a status and hands the messages to the host after the
/// instance is free again.
pub(crate) fn call<M: FmuModel>(
    handle: *mut c_void,
    version: Version,
    function: &str,
    body: impl FnOnce(&mut Instance<M>) -> Result<(), CallError>,
) -> i32 {
    let floating = FloatingPoint::ours();
    let guarded = || {
        let Some(entry) = registry::find::<M>(handle.addr()) else {
            return FmiStatus::Error;
        };
        let Ok(mut instance) = entry.instance.try_lock() else {
            // Locked by another thread's call, or poisoned by nothing: panics are caught below.
            let text = format!("{function}: the instance is busy with another call");
            let message = LogMessage { status: FmiStatus::Error, text };
            floating.callers(|| entry.logger.send(&message));
            return FmiStatus::Error;
        };
        let status = run(&mut instance, version, function, body);
        let messages = std::mem::take(&mut instance.log.messages);
        if messages.is_empty() {
            return status;
        }
        let filter = instance.filter.clone();
        drop(instance);
        for message in messages.iter().filter(|m| filter.passes(m.status)) {
            floating.callers(|| entry.logger.send(message));
        }
        status
    };
    catch_unwind(AssertUnwindSafe(guarded)).unwrap_or(FmiStatus::Fatal) as i32
}

fn run<M: FmuModel>(
    instance: &mut Instance<M>,
    version: Version,
    function: &str,
    body: impl FnOnce(&mut Instance<M>) -> Result<(), CallError>,
) -> FmiStatus {
    let result = if instance.version == version {
        catch_unwind(AssertUnwindSafe(|| body(instance))).unwrap_or_else(|payload| {
            let text = panic_text(&*payload);
            Err(CallError::Fatal(format!("{function}: internal error: {text}")))
        })
    } else {
        Err(CallError::Refused(format!("{function}: the instance is of another FMI version")))
    };
    match result {
        Ok(()) => instance.log.worst(),
        Err(fault) => {
            match fault {
                CallError::Failed(_) => instance.core.phase = Phase::Failed,
                CallError::Fatal(_) => instance.core.phase = Phase::Dead,
                CallError::Discard(_) | CallError::Refused(_) => {}
            }
            let status = fault.status();
            instance.log.messages.push(LogMessage { status, text: fault.to_string() });
            status
        }
    }
}

/// Frees an instance; unknown handles are ignored, as the standards ask for null.
pub(crate) fn free(handle: *mut c_void) {
    let _floating = FloatingPoint::ours();
    // A panic while dropping a model must not cross into C either.
    let _ = catch_unwind(AssertUnwindSafe(|| drop(registry::remove(handle.addr()))));
}

/// A call that this FMU does not offer, whatever its arguments.
pub fn unsupported<M: FmuModel>(handle: *mut c_void, version: Version, function: &str) -> i32 {
    call::<M>(handle, version, function, |_| {
        Err(CallError::Refused(format!("{function}: not offered by this FMU")))
    })
}
