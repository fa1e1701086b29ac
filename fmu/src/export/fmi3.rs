//! C names and signatures of FMI 3.0. The whole set must be present, so what co-simulation
//! without events does not need answers *error*.

/// Exports the functions of FMI 3.0; see [`export_fmu!`](crate::export_fmu).
#[doc(hidden)]
#[macro_export]
macro_rules! export_fmi3 {
    ($m:ty) => {
        $crate::export_fmi3_life!($m);
        $crate::export_fmi3_values!($m);
        $crate::export_fmi3_state!($m);
        $crate::export_fmi3_rest!($m);
    };
}

/// Version, instances, modes and steps.
#[doc(hidden)]
#[macro_export]
macro_rules! export_fmi3_life {
    ($m:ty) => {
        $crate::c_functions! {
            fmi3GetVersion() -> *const c_char = c"3.0".as_ptr();
            fmi3SetDebugLogging(i: *mut c_void, on: u8, n: usize,
                categories: *const *const c_char) -> i32 =
                fmi2::set_debug_logging::<$m>(
                    i, Fmi3, "fmi3SetDebugLogging", on != 0, n, categories);
            fmi3InstantiateModelExchange(name: *const c_char, token: *const c_char,
                resources: *const c_char, visible: u8, logging: u8, environment: *mut c_void,
                log: Option<$crate::c::Logger3>) -> *mut c_void =
                fmi3::instantiate_unsupported(environment, log, "fmi3InstantiateModelExchange");
            fmi3InstantiateCoSimulation(name: *const c_char, token: *const c_char,
                resources: *const c_char, visible: u8, logging: u8, event_mode: u8,
                early_return: u8, intermediate: *const u32, n_intermediate: usize,
                environment: *mut c_void, log: Option<$crate::c::Logger3>,
                update: *mut c_void) -> *mut c_void =
                fmi3::instantiate::<$m>(
                    name, token, resources, logging != 0, event_mode != 0, environment, log);
            fmi3InstantiateScheduledExecution(name: *const c_char, token: *const c_char,
                resources: *const c_char, visible: u8, logging: u8, environment: *mut c_void,
                log: Option<$crate::c::Logger3>, update: *mut c_void, lock: *mut c_void,
                unlock: *mut c_void) -> *mut c_void =
                fmi3::instantiate_unsupported(
                    environment, log, "fmi3InstantiateScheduledExecution");
            fmi3FreeInstance(i: *mut c_void) -> () = fmi2::free_instance(i);
            fmi3EnterInitializationMode(i: *mut c_void, tolerance_defined: u8, tolerance: f64,
                start: f64, stop_defined: u8, stop: f64) -> i32 =
                fmi3::enter_initialization_mode::<$m>(i, start, stop_defined, stop);
            fmi3ExitInitializationMode(i: *mut c_void) -> i32 =
                fmi2::exit_initialization_mode::<$m>(i, Fmi3, "fmi3ExitInitializationMode");
            fmi3Terminate(i: *mut c_void) -> i32 =
                fmi2::terminate::<$m>(i, Fmi3, "fmi3Terminate");
            fmi3Reset(i: *mut c_void) -> i32 = fmi2::reset::<$m>(i, Fmi3, "fmi3Reset");
            fmi3DoStep(i: *mut c_void, begin: f64, size: f64, keep: u8, event: *mut u8,
                terminate: *mut u8, early: *mut u8, last: *mut f64) -> i32 =
                fmi3::do_step::<$m>(i, begin, size, fmi3::StepReport {
                    event_handling_needed: event, terminate_simulation: terminate,
                    early_return: early, last_successful_time: last });
        }
    };
}

/// Getters and setters.
#[doc(hidden)]
#[macro_export]
macro_rules! export_fmi3_values {
    ($m:ty) => {
        $crate::c_functions! {
            fmi3GetFloat64(i: *mut c_void, vr: *const u32, n: usize, values: *mut f64,
                m: usize) -> i32 =
                fmi3::get::<$m, f64>(i, "fmi3GetFloat64", vr, n, values, m);
            fmi3SetFloat64(i: *mut c_void, vr: *const u32, n: usize, values: *const f64,
                m: usize) -> i32 =
                fmi3::set::<$m, f64>(i, "fmi3SetFloat64", vr, n, values, m);
            fmi3GetInt32(i: *mut c_void, vr: *const u32, n: usize, values: *mut i32,
                m: usize) -> i32 =
                fmi3::get::<$m, i32>(i, "fmi3GetInt32", vr, n, values, m);
            fmi3SetInt32(i: *mut c_void, vr: *const u32, n: usize, values: *const i32,
                m: usize) -> i32 =
                fmi3::set::<$m, i32>(i, "fmi3SetInt32", vr, n, values, m);
            fmi3GetBoolean(i: *mut c_void, vr: *const u32, n: usize, values: *mut u8,
                m: usize) -> i32 =
                fmi3::get_boolean::<$m>(i, vr, n, values, m);
            fmi3SetBoolean(i: *mut c_void, vr: *const u32, n: usize, values: *const u8,
                m: usize) -> i32 =
                fmi3::set_boolean::<$m>(i, vr, n, values, m);
            fmi3GetString(i: *mut c_void, vr: *const u32, n: usize, values: *mut *const c_char,
                m: usize) -> i32 =
                fmi3::get_string::<$m>(i, vr, n, values, m);
            fmi3SetString(i: *mut c_void, vr: *const u32, n: usize, values: *const *const c_char,
                m: usize) -> i32 =
                fmi3::set_string::<$m>(i, vr, n, values, m);
            fmi3GetFloat32(i: *mut c_void, vr: *const u32, n: usize, values: *mut f32,
                m: usize) -> i32 =
                fmi3::no_such_type::<$m>(i, "fmi3GetFloat32", n);
            fmi3SetFloat32(i: *mut c_void, vr: *const u32, n: usize, values: *const f32,
                m: usize) -> i32 =
                fmi3::no_such_type::<$m>(i, "fmi3SetFloat32", n);
            fmi3GetInt8(i: *mut c_void, vr: *const u32, n: usize, values: *mut i8,
                m: usize) -> i32 =
                fmi3::no_such_type::<$m>(i, "fmi3GetInt8", n);
            fmi3SetInt8(i: *mut c_void, vr: *const u32, n: usize, values: *const i8,
                m: usize) -> i32 =
                fmi3::no_such_type::<$m>(i, "fmi3SetInt8", n);
            fmi3GetUInt8(i: *mut c_void, vr: *const u32, n: usize, values: *mut u8,
                m: usize) -> i32 =
                fmi3::no_such_type::<$m>(i, "fmi3GetUInt8", n);
            fmi3SetUInt8(i: *mut c_void, vr: *const u32, n: usize, values: *const u8,
                m: usize) -> i32 =
                fmi3::no_such_type::<$m>(i, "fmi3SetUInt8", n);
            fmi3GetInt16(i: *mut c_void, vr: *const u32, n: usize, values: *mut i16,
                m: usize) -> i32 =
                fmi3::no_such_type::<$m>(i, "fmi3GetInt16", n);
            fmi3SetInt16(i: *mut c_void, vr: *const u32, n: usize, values: *const i16,
                m: usize) -> i32 =
                fmi3::no_such_type::<$m>(i, "fmi3SetInt16", n);
            fmi3GetUInt16(i: *mut c_void, vr: *const u32, n: usize, values: *mut u16,
                m: usize) -> i32 =
                fmi3::no_such_type::<$m>(i, "fmi3GetUInt16", n);
            fmi3SetUInt16(i: *mut c_void, vr: *const u32, n: usize, values: *const u16,
                m: usize) -> i32 =
                fmi3::no_such_type::<$m>(i, "fmi3SetUInt16", n);
            fmi3GetUInt32(i: *mut c_void, vr: *const u32, n: usize, values: *mut u32,
                m: usize) -> i32 =
                fmi3::no_such_type::<$m>(i, "fmi3GetUInt32", n);
            fmi3SetUInt32(i: *mut c_void, vr: *const u32, n: usize, values: *const u32,
                m: usize) -> i32 =
                fmi3::no_such_type::<$m>(i, "fmi3SetUInt32", n);
            fmi3GetInt64(i: *mut c_void, vr: *const u32, n: usize, values: *mut i64,
                m: usize) -> i32 =
                fmi3::no_such_type::<$m>(i, "fmi3GetInt64", n);
            fmi3SetInt64(i: *mut c_void, vr: *const u32, n: usize, values: *const i64,
                m: usize) -> i32 =
                fmi3::no_such_type::<$m>(i, "fmi3SetInt64", n);
            fmi3GetUInt64(i: *mut c_void, vr: *const u32, n: usize, values: *mut u64,
                m: usize) -> i32 =
                fmi3::no_such_type::<$m>(i, "fmi3GetUInt64", n);
            fmi3SetUInt64(i: *mut c_void, vr: *const u32, n: usize, values: *const u64,
                m: usize) -> i32 =
                fmi3::no_such_type::<$m>(i, "fmi3SetUInt64", n);
            fmi3GetBinary(i: *mut c_void, vr: *const u32, n: usize, sizes: *mut usize,
                values: *mut *const u8, m: usize) -> i32 =
                fmi3::no_such_type::<$m>(i, "fmi3GetBinary", n);
            fmi3SetBinary(i: *mut c_void, vr: *const u32, n: usize, sizes: *const usize,
                values: *const *const u8, m: usize) -> i32 =
                fmi3::no_such_type::<$m>(i, "fmi3SetBinary", n);
            fmi3GetClock(i: *mut c_void, vr: *const u32, n: usize, values: *mut u8) -> i32 =
                fmi3::no_such_type::<$m>(i, "fmi3GetClock", n);
            fmi3SetClock(i: *mut c_void, vr: *const u32, n: usize, values: *const u8) -> i32 =
                fmi3::no_such_type::<$m>(i, "fmi3SetClock", n);
        }
    };
}

/// FMU states.
#[doc(hidden)]
#[macro_export]
macro_rules! export_fmi3_state {
    ($m:ty) => {
        $crate::c_functions! {
            fmi3GetFMUState(i: *mut c_void, s: *mut *mut c_void) -> i32 =
                state::get::<$m>(i, Fmi3, "fmi3GetFMUState", s);
            fmi3SetFMUState(i: *mut c_void, s: *mut c_void) -> i32 =
                state::set::<$m>(i, Fmi3, "fmi3SetFMUState", s);
            fmi3FreeFMUState(i: *mut c_void, s: *mut *mut c_void) -> i32 =
                state::free::<$m>(i, Fmi3, "fmi3FreeFMUState", s);
            fmi3SerializedFMUStateSize(i: *mut c_void, s: *mut c_void, size: *mut usize) -> i32 =
                state::serialized_size::<$m>(i, Fmi3, "fmi3SerializedFMUStateSize", s, size);
            fmi3SerializeFMUState(i: *mut c_void, s: *mut c_void, bytes: *mut u8,
                size: usize) -> i32 =
                state::serialize::<$m>(i, Fmi3, "fmi3SerializeFMUState", s, bytes, size);
            fmi3DeserializeFMUState(i: *mut c_void, bytes: *const u8, size: usize,
                s: *mut *mut c_void) -> i32 =
                state::deserialize::<$m>(i, Fmi3, "fmi3DeserializeFMUState", bytes, size, s);
        }
    };
}

/// Everything co-simulation without events does not need.
#[doc(hidden)]
#[macro_export]
macro_rules! export_fmi3_rest {
    ($m:ty) => {
        $crate::c_functions! {
            fmi3GetNumberOfEventIndicators(i: *mut c_void, count: *mut usize) -> i32 =
                fmi3::none::<$m>(i, "fmi3GetNumberOfEventIndicators", count);
            fmi3GetNumberOfContinuousStates(i: *mut c_void, count: *mut usize) -> i32 =
                fmi3::none::<$m>(i, "fmi3GetNumberOfContinuousStates", count);
            fmi3GetNumberOfVariableDependencies(i: *mut c_void, vr: u32, count: *mut usize) -> i32 =
                $crate::c::unsupported::<$m>(i, Fmi3, "fmi3GetNumberOfVariableDependencies");
            fmi3GetVariableDependencies(i: *mut c_void, dependent: u32, elements: *mut usize,
                independents: *mut u32, their_elements: *mut usize, kinds: *mut i32, n: usize) -> i32 =
                $crate::c::unsupported::<$m>(i, Fmi3, "fmi3GetVariableDependencies");
            fmi3GetDirectionalDerivative(i: *mut c_void, unknowns: *const u32, n_unknowns: usize,
                knowns: *const u32, n_knowns: usize, seed: *const f64, n_seed: usize,
                sensitivity: *mut f64, n_sensitivity: usize) -> i32 =
                $crate::c::unsupported::<$m>(i, Fmi3, "fmi3GetDirectionalDerivative");
            fmi3GetAdjointDerivative(i: *mut c_void, unknowns: *const u32, n_unknowns: usize,
                knowns: *const u32, n_knowns: usize, seed: *const f64, n_seed: usize,
                sensitivity: *mut f64, n_sensitivity: usize) -> i32 =
                $crate::c::unsupported::<$m>(i, Fmi3, "fmi3GetAdjointDerivative");
            fmi3EnterEventMode(i: *mut c_void) -> i32 =
                $crate::c::unsupported::<$m>(i, Fmi3, "fmi3EnterEventMode");
            fmi3EnterConfigurationMode(i: *mut c_void) -> i32 =
                $crate::c::unsupported::<$m>(i, Fmi3, "fmi3EnterConfigurationMode");
            fmi3ExitConfigurationMode(i: *mut c_void) -> i32 =
                $crate::c::unsupported::<$m>(i, Fmi3, "fmi3ExitConfigurationMode");
            fmi3EvaluateDiscreteStates(i: *mut c_void) -> i32 =
                $crate::c::unsupported::<$m>(i, Fmi3, "fmi3EvaluateDiscreteStates");
            fmi3EnterContinuousTimeMode(i: *mut c_void) -> i32 =
                $crate::c::unsupported::<$m>(i, Fmi3, "fmi3EnterContinuousTimeMode");
            fmi3EnterStepMode(i: *mut c_void) -> i32 =
                $crate::c::unsupported::<$m>(i, Fmi3, "fmi3EnterStepMode");
            fmi3GetIntervalDecimal(i: *mut c_void, vr: *const u32, n: usize,
                intervals: *mut f64, qualifiers: *mut i32) -> i32 =
                $crate::c::unsupported::<$m>(i, Fmi3, "fmi3GetIntervalDecimal");
            fmi3GetIntervalFraction(i: *mut c_void, vr: *const u32, n: usize,
                counters: *mut u64, resolutions: *mut u64, qualifiers: *mut i32) -> i32 =
                $crate::c::unsupported::<$m>(i, Fmi3, "fmi3GetIntervalFraction");
            fmi3GetShiftDecimal(i: *mut c_void, vr: *const u32, n: usize, shifts: *mut f64) -> i32 =
                $crate::c::unsupported::<$m>(i, Fmi3, "fmi3GetShiftDecimal");
            fmi3GetShiftFraction(i: *mut c_void, vr: *const u32, n: usize,
                counters: *mut u64, resolutions: *mut u64) -> i32 =
                $crate::c::unsupported::<$m>(i, Fmi3, "fmi3GetShiftFraction");
            fmi3SetIntervalDecimal(i: *mut c_void, vr: *const u32, n: usize,
                intervals: *const f64) -> i32 =
                $crate::c::unsupported::<$m>(i, Fmi3, "fmi3SetIntervalDecimal");
            fmi3SetIntervalFraction(i: *mut c_void, vr: *const u32, n: usize,
                counters: *const u64, resolutions: *const u64) -> i32 =
                $crate::c::unsupported::<$m>(i, Fmi3, "fmi3SetIntervalFraction");
            fmi3SetShiftDecimal(i: *mut c_void, vr: *const u32, n: usize, shifts: *const f64) -> i32 =
                $crate::c::unsupported::<$m>(i, Fmi3, "fmi3SetShiftDecimal");
            fmi3SetShiftFraction(i: *mut c_void, vr: *const u32, n: usize,
                counters: *const u64, resolutions: *const u64) -> i32 =
                $crate::c::unsupported::<$m>(i, Fmi3, "fmi3SetShiftFraction");
            fmi3UpdateDiscreteStates(i: *mut c_void, again: *mut u8, terminate: *mut u8,
                nominals: *mut u8, states: *mut u8, next: *mut u8, time: *mut f64) -> i32 =
                $crate::c::unsupported::<$m>(i, Fmi3, "fmi3UpdateDiscreteStates");
            fmi3CompletedIntegratorStep(i: *mut c_void, keep: u8, event: *mut u8,
                terminate: *mut u8) -> i32 =
                $crate::c::unsupported::<$m>(i, Fmi3, "fmi3CompletedIntegratorStep");
            fmi3SetTime(i: *mut c_void, time: f64) -> i32 =
                $crate::c::unsupported::<$m>(i, Fmi3, "fmi3SetTime");
            fmi3SetContinuousStates(i: *mut c_void, x: *const f64, n: usize) -> i32 =
                $crate::c::unsupported::<$m>(i, Fmi3, "fmi3SetContinuousStates");
            fmi3GetContinuousStateDerivatives(i: *mut c_void, x: *mut f64, n: usize) -> i32 =
                $crate::c::unsupported::<$m>(i, Fmi3, "fmi3GetContinuousStateDerivatives");
            fmi3GetEventIndicators(i: *mut c_void, x: *mut f64, n: usize) -> i32 =
                $crate::c::unsupported::<$m>(i, Fmi3, "fmi3GetEventIndicators");
            fmi3GetContinuousStates(i: *mut c_void, x: *mut f64, n: usize) -> i32 =
                $crate::c::unsupported::<$m>(i, Fmi3, "fmi3GetContinuousStates");
            fmi3GetNominalsOfContinuousStates(i: *mut c_void, x: *mut f64, n: usize) -> i32 =
                $crate::c::unsupported::<$m>(i, Fmi3, "fmi3GetNominalsOfContinuousStates");
            fmi3GetOutputDerivatives(i: *mut c_void, vr: *const u32, n: usize,
                orders: *const i32, values: *mut f64, m: usize) -> i32 =
                $crate::c::unsupported::<$m>(i, Fmi3, "fmi3GetOutputDerivatives");
            fmi3ActivateModelPartition(i: *mut c_void, clock: u32, time: f64) -> i32 =
                $crate::c::unsupported::<$m>(i, Fmi3, "fmi3ActivateModelPartition");
        }
    };
}
