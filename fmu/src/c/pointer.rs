//! Raw arguments to Rust values, or a refusal.

use std::ffi::{CStr, c_char};

use crate::status::CallError;

/// No table here comes near this; a larger count is a mistake, and reading that far would be one
/// too.
const MOST: usize = 1 << 20;

/// A shared slice of `n` elements; null is fine for none.
///
/// # Safety
/// A pointer that is not null must point to `n` readable elements that live for `'a`.
pub(crate) unsafe fn slice<'a, T>(
    what: &str,
    pointer: *const T,
    n: usize,
) -> Result<&'a [T], CallError> {
    check(what, pointer, n)?;
    if n == 0 {
        return Ok(&[]);
    }
    // SAFETY: not null, aligned, of sane length; the rest is the caller's promise.
    Ok(unsafe { std::slice::from_raw_parts(pointer, n) })
}

/// A mutable slice of `n` elements; null is fine for none.
///
/// # Safety
/// A pointer that is not null must point to `n` writable elements used by nobody else.
pub(crate) unsafe fn slice_mut<'a, T>(
    what: &str,
    pointer: *mut T,
    n: usize,
) -> Result<&'a mut [T], CallError> {
    check(what, pointer, n)?;
    if n == 0 {
        return Ok(&mut []);
    }
    // SAFETY: not null, aligned, of sane length; the rest is the caller's promise.
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer, n) })
}

/// One place to write a result to.
///
/// # Safety
/// As for [`slice_mut`] with one element.
pub(crate) unsafe fn out<'a, T>(what: &str, pointer: *mut T) -> Result<&'a mut T, CallError> {
    // SAFETY: the caller's promise is the same.
    match unsafe { slice_mut(what, pointer, 1) }? {
        [one] => Ok(one),
        _ => Err(CallError::Refused(format!("{what}: no place to write to"))),
    }
}

/// A text; null is refused, and so is what is not UTF-8.
///
/// # Safety
/// A pointer that is not null must point to a string that ends with a zero byte.
pub(crate) unsafe fn text<'a>(what: &str, pointer: *const c_char) -> Result<&'a str, CallError> {
    check(what, pointer, 1)?;
    // SAFETY: not null; the end is the caller's promise.
    let text = unsafe { CStr::from_ptr(pointer) };
    text.to_str().map_err(|e| CallError::Refused(format!("{what} is not UTF-8: {e}")))
}

/// Texts; each is checked.
///
/// # Safety
/// As for [`slice`] and [`text`].
pub(crate) unsafe fn texts<'a>(
    what: &str,
    pointer: *const *const c_char,
    n: usize,
) -> Result<Vec<&'a str>, CallError> {
    // SAFETY: the caller's promise is the same.
    let pointers = unsafe { slice(what, pointer, n) }?;
    // SAFETY: the caller's promise is the same.
    pointers.iter().map(|p| unsafe { text(what, *p) }).collect()
}

/// The bytes of a saved state, which may be many more than any table has variables.
///
/// # Safety
/// As for [`slice`].
pub(crate) unsafe fn bytes<'a>(
    what: &str,
    from: *const u8,
    n: usize,
) -> Result<&'a [u8], CallError> {
    check_bytes(what, from, n)?;
    // SAFETY: not null, below half the address space; the rest is the caller's promise.
    Ok(unsafe { std::slice::from_raw_parts(from, n) })
}

/// As [`bytes`], to write to.
///
/// # Safety
/// As for [`slice_mut`].
pub(crate) unsafe fn bytes_mut<'a>(
    what: &str,
    to: *mut u8,
    n: usize,
) -> Result<&'a mut [u8], CallError> {
    check_bytes(what, to, n)?;
    // SAFETY: not null, below half the address space; the rest is the caller's promise.
    Ok(unsafe { std::slice::from_raw_parts_mut(to, n) })
}

fn check_bytes(what: &str, pointer: *const u8, n: usize) -> Result<(), CallError> {
    if pointer.is_null() || isize::try_from(n).is_err() {
        return Err(CallError::Refused(format!("{what}: a null pointer, or {n} bytes")));
    }
    Ok(())
}

fn check<T>(what: &str, pointer: *const T, n: usize) -> Result<(), CallError> {
    if n > MOST {
        return Err(CallError::Refused(format!(
            "{what}: {n} elements; at most {MOST} are accepted"
        )));
    }
    if n > 0 && pointer.is_null() {
        return Err(CallError::Refused(format!("{what}: a null pointer for {n} element(s)")));
    }
    if n > 0 && !pointer.is_aligned() {
        return Err(CallError::Refused(format!("{what}: a misaligned pointer")));
    }
    Ok(())
}
