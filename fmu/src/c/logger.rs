//! The host's log function, of either version.

use std::ffi::{CString, c_char, c_void};

use crate::log::LogMessage;

/// `fmi2CallbackLogger`: variadic, the message is a format.
// SAFETY: called as the standard says, with strings that live through the call.
pub type Logger2 = unsafe extern "C" fn(
    environment: *mut c_void,
    instance_name: *const c_char,
    status: i32,
    category: *const c_char,
    message: *const c_char,
    ...
);

/// `fmi3LogMessageCallback`.
// SAFETY: as above.
pub type Logger3 = unsafe extern "C" fn(
    environment: *mut c_void,
    status: i32,
    category: *const c_char,
    message: *const c_char,
);

/// Which function to call.
#[derive(Clone, Copy)]
pub(crate) enum Callback {
    None,
    Fmi2(Logger2),
    Fmi3(Logger3),
}

/// The host's log function with what it wants to be called with.
pub(crate) struct Logger {
    callback: Callback,
    environment: *mut c_void,
    instance_name: CString,
}

// SAFETY: the environment pointer is never dereferenced here, only handed back; both standards
// let the importer call an instance from any thread, so its log function must bear that too.
unsafe impl Send for Logger {}
// SAFETY: as above.
unsafe impl Sync for Logger {}

impl Logger {
    pub(crate) fn new(callback: Callback, environment: *mut c_void, instance_name: &str) -> Self {
        Self { callback, environment, instance_name: c_text(instance_name) }
    }

    pub(crate) fn send(&self, message: &LogMessage) {
        let (category, text) = (c_text(message.status.category()), c_text(&message.text));
        let (category, text) = (category.as_ptr(), text.as_ptr());
        let (environment, status) = (self.environment, message.status as i32);
        match self.callback {
            Callback::None => {}
            // SAFETY: the host vouches for its function; all strings outlive the call, and the
            // message is an argument, never the format, so a `%` in it means nothing.
            Callback::Fmi2(log) => unsafe {
                log(
                    environment,
                    self.instance_name.as_ptr(),
                    status,
                    category,
                    c"%s".as_ptr(),
                    text,
                );
            },
            // SAFETY: the host vouches for its function; all strings outlive the call.
            Callback::Fmi3(log) => unsafe { log(environment, status, category, text) },
        }
    }
}

/// A C string; a zero byte inside ends it.
fn c_text(text: &str) -> CString {
    let bytes: Vec<u8> = text.bytes().take_while(|b| *b != 0).collect();
    CString::new(bytes).unwrap_or_default()
}
