//! Making an instance, which both versions do alike.

use std::ffi::{c_char, c_void};
use std::path::PathBuf;
use std::ptr::null_mut;

use super::floating::FloatingPoint;
use super::logger::{Callback, Logger};
use super::pointer;
use crate::description::Version;
use crate::instance::Instance;
use crate::log::{Filter, LogMessage};
use crate::model::FmuModel;
use crate::registry;
use crate::status::{CallError, FmiStatus};

/// What both versions do to make an instance; null if anything is wrong.
///
/// # Safety
/// Strings end with a zero byte.
pub(super) unsafe fn make<M: FmuModel>(
    version: Version,
    name: *const c_char,
    token: *const c_char,
    callback: Callback,
    environment: *mut c_void,
    logging: bool,
    folder: impl FnOnce() -> Result<Option<PathBuf>, CallError>,
) -> *mut c_void {
    let floating = FloatingPoint::ours();
    let mut shown = String::from("?");
    let made = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
        // SAFETY: the caller's promise.
        let name = unsafe { pointer::text("instance name", name) }?;
        shown = name.to_owned();
        // SAFETY: the caller's promise.
        let token = unsafe { pointer::text("token", token) }?;
        let expected = M::description().token();
        if name.is_empty() {
            return Err(CallError::Refused("the instance name is empty".to_owned()));
        }
        if token != expected {
            return Err(CallError::Refused(format!(
                "token '{token}' does not match this library's '{expected}': \
                 the model description belongs to another build"
            )));
        }
        Ok(Instance::<M>::new(version, folder()?, Filter::new(logging)))
    }));
    let logger = Logger::new(callback, environment, &shown);
    let fault = match made {
        Ok(Ok(instance)) => {
            return std::ptr::without_provenance_mut(registry::insert(instance, logger));
        }
        Ok(Err(fault)) => fault.to_string(),
        Err(payload) => crate::instance::panic_text(&*payload),
    };
    let message = LogMessage { status: FmiStatus::Error, text: format!("instantiate: {fault}") };
    floating.callers(|| logger.send(&message));
    null_mut()
}

/// A text that may be null or empty.
///
/// # Safety
/// The string ends with a zero byte.
pub(super) unsafe fn optional_text<'a>(
    what: &str,
    text: *const c_char,
) -> Result<Option<&'a str>, CallError> {
    if text.is_null() {
        return Ok(None);
    }
    // SAFETY: the caller's promise.
    let text = unsafe { pointer::text(what, text) }?;
    Ok((!text.is_empty()).then_some(text))
}

/// The folder of a `file:` URI (RFC 8089); hosts that pass a plain path get what they mean.
pub(super) fn folder_of(uri: &str) -> Option<PathBuf> {
    let Some(rest) = uri.strip_prefix("file:") else {
        return Some(PathBuf::from(uri));
    };
    let path = rest.strip_prefix("//").map_or(rest, |r| r.strip_prefix("localhost").unwrap_or(r));
    let mut bytes = Vec::new();
    let mut left = path.bytes();
    while let Some(byte) = left.next() {
        if byte == b'%' {
            let digits = [left.next()?, left.next()?];
            bytes.push(u8::from_str_radix(std::str::from_utf8(&digits).ok()?, 16).ok()?);
        } else {
            bytes.push(byte);
        }
    }
    let path = String::from_utf8(bytes).ok()?;
    // "/C:/x" is how a drive letter appears in a URI.
    let drive = path.len() > 2 && path.as_bytes()[0] == b'/' && path.as_bytes()[2] == b':';
    Some(PathBuf::from(if drive { &path[1..] } else { &path }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resource_uris_become_folders() {
        let cases = [
            ("file:///a/b%20c/resources", "/a/b c/resources"),
            ("file:/a/resources", "/a/resources"),
            ("file://localhost/a", "/a"),
            ("file:///C:/x/resources", "C:/x/resources"),
            ("/plain/path", "/plain/path"),
        ];
        for (uri, path) in cases {
            assert_eq!(folder_of(uri), Some(PathBuf::from(path)), "{uri}");
        }
        assert_eq!(folder_of("file:///broken%2"), None);
    }
}
