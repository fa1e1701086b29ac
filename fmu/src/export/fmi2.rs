//! C names and signatures of FMI 2.0 co-simulation.

/// Exports the functions of FMI 2.0 co-simulation; see [`export_fmu!`](crate::export_fmu).
#[doc(hidden)]
#[macro_export]
macro_rules! export_fmi2 {
    ($m:ty) => {
        $crate::c_functions! {
            fmi2GetTypesPlatform() -> *const c_char = c"default".as_ptr();
            fmi2GetVersion() -> *const c_char = c"2.0".as_ptr();
            fmi2SetDebugLogging(c: *mut c_void, on: i32, n: usize,
                categories: *const *const c_char) -> i32 =
                fmi2::set_debug_logging::<$m>(
                    c, Fmi2, "fmi2SetDebugLogging", on != 0, n, categories);
            fmi2Instantiate(name: *const c_char, kind: i32, guid: *const c_char,
                resources: *const c_char, callbacks: *const fmi2::Callbacks, visible: i32,
                logging: i32) -> *mut c_void =
                fmi2::instantiate::<$m>(name, kind, guid, resources, callbacks, logging);
            fmi2FreeInstance(c: *mut c_void) -> () = fmi2::free_instance(c);
            fmi2SetupExperiment(c: *mut c_void, tolerance_defined: i32, tolerance: f64,
                start: f64, stop_defined: i32, stop: f64) -> i32 =
                fmi2::setup_experiment::<$m>(c, start, stop_defined, stop);
            fmi2EnterInitializationMode(c: *mut c_void) -> i32 =
                fmi2::enter_initialization_mode::<$m>(c);
            fmi2ExitInitializationMode(c: *mut c_void) -> i32 =
                fmi2::exit_initialization_mode::<$m>(c, Fmi2, "fmi2ExitInitializationMode");
            fmi2Terminate(c: *mut c_void) -> i32 =
                fmi2::terminate::<$m>(c, Fmi2, "fmi2Terminate");
            fmi2Reset(c: *mut c_void) -> i32 = fmi2::reset::<$m>(c, Fmi2, "fmi2Reset");

            fmi2GetReal(c: *mut c_void, vr: *const u32, n: usize, values: *mut f64) -> i32 =
                fmi2::get::<$m, f64>(c, "fmi2GetReal", vr, n, values);
            fmi2GetInteger(c: *mut c_void, vr: *const u32, n: usize, values: *mut i32) -> i32 =
                fmi2::get::<$m, i32>(c, "fmi2GetInteger", vr, n, values);
            fmi2GetBoolean(c: *mut c_void, vr: *const u32, n: usize, values: *mut i32) -> i32 =
                fmi2::get_boolean::<$m>(c, vr, n, values);
            fmi2GetString(c: *mut c_void, vr: *const u32, n: usize,
                values: *mut *const c_char) -> i32 =
                fmi2::get_string::<$m>(c, Fmi2, "fmi2GetString", vr, n, values);
            fmi2SetReal(c: *mut c_void, vr: *const u32, n: usize, values: *const f64) -> i32 =
                fmi2::set::<$m, f64>(c, "fmi2SetReal", vr, n, values);
            fmi2SetInteger(c: *mut c_void, vr: *const u32, n: usize, values: *const i32) -> i32 =
                fmi2::set::<$m, i32>(c, "fmi2SetInteger", vr, n, values);
            fmi2SetBoolean(c: *mut c_void, vr: *const u32, n: usize, values: *const i32) -> i32 =
                fmi2::set_boolean::<$m>(c, vr, n, values);
            fmi2SetString(c: *mut c_void, vr: *const u32, n: usize,
                values: *const *const c_char) -> i32 =
                fmi2::set_string::<$m>(c, Fmi2, "fmi2SetString", vr, n, values);

            fmi2GetFMUstate(c: *mut c_void, s: *mut *mut c_void) -> i32 =
                state::get::<$m>(c, Fmi2, "fmi2GetFMUstate", s);
            fmi2SetFMUstate(c: *mut c_void, s: *mut c_void) -> i32 =
                state::set::<$m>(c, Fmi2, "fmi2SetFMUstate", s);
            fmi2FreeFMUstate(c: *mut c_void, s: *mut *mut c_void) -> i32 =
                state::free::<$m>(c, Fmi2, "fmi2FreeFMUstate", s);
            fmi2SerializedFMUstateSize(c: *mut c_void, s: *mut c_void, size: *mut usize) -> i32 =
                state::serialized_size::<$m>(c, Fmi2, "fmi2SerializedFMUstateSize", s, size);
            fmi2SerializeFMUstate(c: *mut c_void, s: *mut c_void, bytes: *mut u8,
                size: usize) -> i32 =
                state::serialize::<$m>(c, Fmi2, "fmi2SerializeFMUstate", s, bytes, size);
            fmi2DeSerializeFMUstate(c: *mut c_void, bytes: *const u8, size: usize,
                s: *mut *mut c_void) -> i32 =
                state::deserialize::<$m>(c, Fmi2, "fmi2DeSerializeFMUstate", bytes, size, s);

            fmi2GetDirectionalDerivative(c: *mut c_void, unknowns: *const u32, n_unknowns: usize,
                knowns: *const u32, n_knowns: usize, d_known: *const f64,
                d_unknown: *mut f64) -> i32 =
                $crate::c::unsupported::<$m>(c, Fmi2, "fmi2GetDirectionalDerivative");
            fmi2SetRealInputDerivatives(c: *mut c_void, vr: *const u32, n: usize,
                orders: *const i32, values: *const f64) -> i32 =
                $crate::c::unsupported::<$m>(c, Fmi2, "fmi2SetRealInputDerivatives");
            fmi2GetRealOutputDerivatives(c: *mut c_void, vr: *const u32, n: usize,
                orders: *const i32, values: *mut f64) -> i32 =
                $crate::c::unsupported::<$m>(c, Fmi2, "fmi2GetRealOutputDerivatives");

            fmi2DoStep(c: *mut c_void, begin: f64, size: f64, keep: i32) -> i32 =
                fmi2::do_step::<$m>(c, begin, size);
            fmi2CancelStep(c: *mut c_void) -> i32 =
                $crate::c::unsupported::<$m>(c, Fmi2, "fmi2CancelStep");
            fmi2GetStatus(c: *mut c_void, kind: i32, value: *mut i32) -> i32 =
                fmi2::no_status::<$m>(c, "fmi2GetStatus");
            fmi2GetRealStatus(c: *mut c_void, kind: i32, value: *mut f64) -> i32 =
                fmi2::get_real_status::<$m>(c, kind, value);
            fmi2GetIntegerStatus(c: *mut c_void, kind: i32, value: *mut i32) -> i32 =
                fmi2::no_status::<$m>(c, "fmi2GetIntegerStatus");
            fmi2GetBooleanStatus(c: *mut c_void, kind: i32, value: *mut i32) -> i32 =
                fmi2::get_boolean_status::<$m>(c, kind, value);
            fmi2GetStringStatus(c: *mut c_void, kind: i32, value: *mut *const c_char) -> i32 =
                fmi2::no_status::<$m>(c, "fmi2GetStringStatus");
        }
    };
}
