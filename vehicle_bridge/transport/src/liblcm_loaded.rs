//! liblcm's functions, taken from the shared library when the first of them is called.
//!
//! The `lcm` crate declares them; these are what the program links. So it starts on a computer
//! without liblcm and asks for it only when a URL needs it.
#![allow(unsafe_code, reason = "functions of C, for C")]

use std::ffi::{c_char, c_int, c_uint, c_void};
use std::io;
use std::sync::OnceLock;

use libloading::Library;

/// The name of its first and only interface.
const FILE: &str = "liblcm.so.1";

/// A C function with this name that calls liblcm's; without liblcm it returns `$absent`.
macro_rules! forward {
    ($($name:ident($($arg:ident: $type:ty),*) -> $result:ty, $absent:expr;)*) => {
        struct Functions {
            // SAFETY: types alone, as lcm.h declares them; each call has its own note.
            $($name: unsafe extern "C" fn($($type),*) -> $result,)*
            /// Unloading it would leave the functions behind.
            _library: Library,
        }

        impl Functions {
            fn load() -> Result<Self, libloading::Error> {
                // SAFETY: liblcm and what it needs run nothing at loading that asks for more.
                let library = unsafe { Library::new(FILE) }?;
                // SAFETY: the types are those of lcm.h.
                unsafe { Ok(Self { $($name: *library.get(stringify!($name).as_bytes())?,)* _library: library }) }
            }
        }

        $(
            // SAFETY: the name stands once, here; nothing else of liblcm is linked.
            #[unsafe(no_mangle)]
            unsafe extern "C" fn $name($($arg: $type),*) -> $result {
                match functions() {
                    // SAFETY: the caller's promise to lcm.h is passed on as it is.
                    Ok(all) => unsafe { (all.$name)($($arg),*) },
                    Err(_) => $absent,
                }
            }
        )*
    };
}

forward! {
    lcm_create(provider: *const c_char) -> *mut c_void, std::ptr::null_mut();
    lcm_destroy(lcm: *mut c_void) -> (), ();
    lcm_get_fileno(lcm: *mut c_void) -> c_int, -1;
    lcm_subscribe(lcm: *mut c_void, channel: *const c_char, handler: *mut c_void,
        user_data: *mut c_void) -> *mut c_void, std::ptr::null_mut();
    lcm_unsubscribe(lcm: *mut c_void, handler: *mut c_void) -> c_int, -1;
    lcm_publish(lcm: *mut c_void, channel: *const c_char, data: *const c_void,
        datalen: c_uint) -> c_int, -1;
    lcm_handle(lcm: *mut c_void) -> c_int, -1;
    lcm_handle_timeout(lcm: *mut c_void, timeout_millis: c_int) -> c_int, -1;
    lcm_subscription_set_queue_capacity(handler: *mut c_void, messages: c_int) -> c_int, -1;
}

fn functions() -> Result<&'static Functions, &'static str> {
    static LOADED: OnceLock<Result<Functions, String>> = OnceLock::new();
    let loaded = LOADED.get_or_init(|| Functions::load().map_err(|e| e.to_string()));
    loaded.as_ref().map_err(String::as_str)
}

/// Loads liblcm, if that was not done yet.
///
/// # Errors
/// What the system says if it cannot be loaded.
pub(crate) fn load() -> io::Result<()> {
    functions().map(|_| ()).map_err(|e| io::Error::new(io::ErrorKind::NotFound, e))
}
