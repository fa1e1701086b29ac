//! Tests alone: the FMUs of `make fmu` in the `fmi` crate.
