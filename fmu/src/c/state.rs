//! FMU states over C; the same seven functions in both versions.

use std::ffi::c_void;

use super::{call, pointer};
use crate::description::Version;
use crate::model::FmuModel;
use crate::status::CallError;

/// `GetFMUState`.
///
/// # Safety
/// `state` is null or can be read and written.
pub unsafe fn get<M: FmuModel>(
    handle: *mut c_void,
    version: Version,
    name: &str,
    state: *mut *mut c_void,
) -> i32 {
    call::<M>(handle, version, name, |instance| {
        // SAFETY: the caller's promise.
        let state = unsafe { pointer::out("state", state) }?;
        *state = std::ptr::without_provenance_mut(instance.get_state(name, state.addr())?);
        Ok(())
    })
}

/// `SetFMUState`.
pub fn set<M: FmuModel>(
    handle: *mut c_void,
    version: Version,
    name: &str,
    state: *mut c_void,
) -> i32 {
    call::<M>(handle, version, name, |instance| instance.set_state(name, state.addr()))
}

/// `FreeFMUState`: the handle becomes null, null is ignored.
///
/// # Safety
/// `state` is null or can be read and written.
pub unsafe fn free<M: FmuModel>(
    handle: *mut c_void,
    version: Version,
    name: &str,
    state: *mut *mut c_void,
) -> i32 {
    call::<M>(handle, version, name, |instance| {
        if state.is_null() {
            return Ok(());
        }
        // SAFETY: the caller's promise.
        let state = unsafe { pointer::out("state", state) }?;
        instance.free_state(name, state.addr())?;
        *state = std::ptr::null_mut();
        Ok(())
    })
}

/// `SerializedFMUStateSize`.
///
/// # Safety
/// `size` is null or can be written to.
pub unsafe fn serialized_size<M: FmuModel>(
    handle: *mut c_void,
    version: Version,
    name: &str,
    state: *mut c_void,
    size: *mut usize,
) -> i32 {
    call::<M>(handle, version, name, |instance| {
        // SAFETY: the caller's promise.
        let size = unsafe { pointer::out("size", size) }?;
        *size = instance.serialize(name, state.addr())?.len();
        Ok(())
    })
}

/// `SerializeFMUState`.
///
/// # Safety
/// `bytes` points to `size` writable bytes.
pub unsafe fn serialize<M: FmuModel>(
    handle: *mut c_void,
    version: Version,
    name: &str,
    state: *mut c_void,
    bytes: *mut u8,
    size: usize,
) -> i32 {
    call::<M>(handle, version, name, |instance| {
        let saved = instance.serialize(name, state.addr())?;
        if size < saved.len() {
            return Err(CallError::Refused(format!(
                "{name}: the state takes {} bytes, the buffer has {size}",
                saved.len()
            )));
        }
        // SAFETY: the caller's promise; only as much as is needed is touched.
        let bytes = unsafe { pointer::bytes_mut("bytes", bytes, saved.len()) }?;
        bytes.copy_from_slice(&saved);
        Ok(())
    })
}

/// `DeSerializeFMUState`.
///
/// # Safety
/// `bytes` points to `size` readable bytes; `state` is null or can be read and written.
pub unsafe fn deserialize<M: FmuModel>(
    handle: *mut c_void,
    version: Version,
    name: &str,
    bytes: *const u8,
    size: usize,
    state: *mut *mut c_void,
) -> i32 {
    call::<M>(handle, version, name, |instance| {
        // SAFETY: the caller's promise.
        let bytes = unsafe { pointer::bytes("bytes", bytes, size) }?;
        // SAFETY: the caller's promise.
        let state = unsafe { pointer::out("state", state) }?;
        let made = instance.deserialize(name, bytes, state.addr())?;
        *state = std::ptr::without_provenance_mut(made);
        Ok(())
    })
}
