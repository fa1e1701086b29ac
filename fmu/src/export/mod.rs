//! From a model to a shared library.

mod fmi2;
mod fmi3;

/// Exports the FMI 2.0 and FMI 3.0 co-simulation interfaces of a [`FmuModel`](crate::FmuModel).
///
/// Use it once, in a `cdylib` crate. The C names are fixed by the standards, so a crate that
/// uses it must not be linked into another that does.
#[macro_export]
macro_rules! export_fmu {
    ($model:ty) => {
        /// The C functions importers look for.
        #[allow(unsafe_code, non_snake_case, missing_docs, unused_variables)]
        #[allow(clippy::missing_safety_doc, clippy::too_many_arguments, unreachable_pub)]
        pub mod fmi_exports {
            use ::std::ffi::{c_char, c_void};

            use super::*;
            use $crate::Version::{Fmi2, Fmi3};
            use $crate::c::{fmi2, fmi3, state};

            $crate::export_fmi2!($model);
            $crate::export_fmi3!($model);
        }
    };
}

/// Writes functions with C names; the argument types are those of the standards' headers.
#[doc(hidden)]
#[macro_export]
macro_rules! c_functions {
    ($($name:ident($($arg:ident: $ty:ty),* $(,)?) -> $ret:ty = $body:expr;)*) => {
        $(
            // SAFETY: the names are the standards', each stands once in a library of one model.
            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn $name($($arg: $ty),*) -> $ret {
                // SAFETY: the host's promise, as written in the standard, is passed on as it is.
                #[allow(unused_unsafe)]
                unsafe { $body }
            }
        )*
    };
}
