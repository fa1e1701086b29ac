//! A controller's state as bytes.

use std::ffi::{c_char, c_int};

use controller::ControllerState;

use crate::{Handle, explain, guarded};

const MAGIC: &[u8; 8] = b"LMPC-C 2";
/// Magic, identity, checksum.
const HEADER: usize = 20;

fn save(handle: &Handle) -> Option<Vec<u8>> {
    let payload = postcard::to_allocvec(&handle.controller.state()).ok()?;
    let mut bytes = MAGIC.to_vec();
    bytes.extend(handle.identity.to_le_bytes());
    bytes.extend(crc32fast::hash(&payload).to_le_bytes());
    bytes.extend(payload);
    Some(bytes)
}

fn load(handle: &mut Handle, bytes: &[u8]) -> Result<(), String> {
    let Some((head, payload)) = bytes.split_at_checked(HEADER) else {
        return Err(format!("{} bytes are too few for a saved controller", bytes.len()));
    };
    if &head[..8] != MAGIC {
        return Err("these bytes are not a saved controller of this version".to_owned());
    }
    if head[8..16] != handle.identity.to_le_bytes() {
        return Err("the bytes are of another configuration, car or track".to_owned());
    }
    if head[16..] != crc32fast::hash(payload).to_le_bytes() {
        return Err("the bytes are damaged: their checksum does not match".to_owned());
    }
    let state: ControllerState = postcard::from_bytes(payload).map_err(|e| e.to_string())?;
    handle.controller.resume(&state);
    Ok(())
}

// SAFETY: the name stands once in a program; the arguments are as in lmpc.h.
#[unsafe(no_mangle)]
unsafe extern "C" fn lmpc_save(handle: *const Handle, bytes: *mut u8, size: usize) -> usize {
    guarded(0, || {
        // SAFETY: the caller's promise.
        let Some(saved) = (unsafe { handle.as_ref() }).and_then(save) else { return 0 };
        if !bytes.is_null() && saved.len() <= size {
            // SAFETY: the caller's promise; both are that long and do not overlap.
            unsafe { std::ptr::copy_nonoverlapping(saved.as_ptr(), bytes, saved.len()) };
        }
        saved.len()
    })
}

// SAFETY: as above.
#[unsafe(no_mangle)]
unsafe extern "C" fn lmpc_load(
    handle: *mut Handle,
    bytes: *const u8,
    size: usize,
    error: *mut c_char,
    error_size: usize,
) -> c_int {
    let loaded = guarded(Err("internal error".to_owned()), || {
        // SAFETY: the caller's promise.
        let handle = unsafe { handle.as_mut() }.ok_or_else(|| "controller is NULL".to_owned())?;
        if bytes.is_null() {
            return Err("bytes is NULL".to_owned());
        }
        // SAFETY: the caller's promise.
        load(handle, unsafe { std::slice::from_raw_parts(bytes, size) })
    });
    // SAFETY: the caller's promise.
    unsafe { explain(error, error_size, loaded.as_ref().err().map_or("", String::as_str)) };
    c_int::from(loaded.is_err())
}
