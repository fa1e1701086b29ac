//! Either model as an importer sees it, in either version of FMI: one call for each thing a host does.
#![allow(clippy::unwrap_used, clippy::panic, unsafe_code, dead_code)]

use std::ffi::{CStr, CString, c_char, c_void};
use std::marker::PhantomData;
use std::ptr::{null, null_mut};

use fmu_core::c::{fmi2, fmi3, state};
use fmu_core::{FmuModel, VariableType, Version};

pub(crate) const VERSIONS: [Version; 2] = [Version::Fmi2, Version::Fmi3];

/// The Frenet state, as outputs of the car and inputs of the controller.
pub(crate) const STATE: [&str; 6] =
    ["vehicle.v_x", "vehicle.v_y", "vehicle.omega_z", "vehicle.e_psi", "vehicle.s", "vehicle.e_y"];
pub(crate) const COMMAND: [&str; 2] = ["cmd.a", "cmd.delta"];

/// What is set before initialisation.
#[derive(Clone, Copy)]
pub(crate) enum Set<'a> {
    Number(&'a str, f64),
    Text(&'a str, &'a str),
    Switch(&'a str),
}

/// One instance.
pub(crate) struct Slave<M: FmuModel> {
    handle: *mut c_void,
    version: Version,
    /// Messages of an FMI 3.0 instance; a Rust program cannot be the logger of FMI 2.0, which takes
    /// any number of arguments.
    log: *mut Vec<String>,
    model: PhantomData<M>,
}

// SAFETY: the environment is the instance's own log, the message ends with a zero byte.
unsafe extern "C" fn keep(
    environment: *mut c_void,
    _: i32,
    _: *const c_char,
    message: *const c_char,
) {
    // SAFETY: as above.
    let (log, text) = unsafe { (&mut *environment.cast::<Vec<String>>(), CStr::from_ptr(message)) };
    log.push(text.to_str().unwrap().to_owned());
}

impl<M: FmuModel> Slave<M> {
    /// Instantiated, nothing set.
    pub(crate) fn instantiate(version: Version) -> Self {
        let token = CString::new(M::description().token()).unwrap();
        let log = Box::into_raw(Box::<Vec<String>>::default());
        // SAFETY: strings end with a zero byte; the log lives as long as the instance.
        let handle = unsafe {
            match version {
                Version::Fmi2 => {
                    let callbacks = fmi2::Callbacks {
                        logger: None,
                        allocate_memory: None,
                        free_memory: None,
                        step_finished: None,
                        environment: null_mut(),
                    };
                    fmi2::instantiate::<M>(c"m".as_ptr(), 1, token.as_ptr(), null(), &callbacks, 0)
                }
                Version::Fmi3 => fmi3::instantiate::<M>(
                    c"m".as_ptr(),
                    token.as_ptr(),
                    null(),
                    true,
                    false,
                    log.cast(),
                    Some(keep),
                ),
            }
        };
        assert!(!handle.is_null());
        Self { handle, version, log, model: PhantomData }
    }

    /// Initialised with these values.
    pub(crate) fn with(version: Version, values: &[Set<'_>]) -> Self {
        let slave = Self::instantiate(version);
        for value in values {
            let status = match *value {
                Set::Number(name, number) => slave.try_set(name, number),
                Set::Text(name, text) => slave.set_text(name, text),
                Set::Switch(name) => slave.try_set(name, 1.0),
            };
            assert_eq!(status, 0, "{:?}", slave.log());
        }
        assert_eq!(slave.initialise(), 0, "{:?}", slave.log());
        slave
    }

    /// The status with which initialisation ends.
    pub(crate) fn initialise(&self) -> i32 {
        let (i, version) = (self.handle, self.version);
        let entered = match version {
            Version::Fmi2 => fmi2::enter_initialization_mode::<M>(i),
            Version::Fmi3 => fmi3::enter_initialization_mode::<M>(i, 0.0, 0, 0.0),
        };
        assert_eq!(entered, 0);
        fmi2::exit_initialization_mode::<M>(i, version, "exit")
    }

    fn place(name: &str) -> (u32, VariableType) {
        let variables = M::description().table.variables();
        let at = variables.iter().position(|v| v.name == name);
        let at = at.unwrap_or_else(|| panic!("no variable '{name}'"));
        (at as u32, variables[at].kind)
    }

    /// Sets a number or truth value; the status.
    pub(crate) fn try_set(&self, name: &str, value: f64) -> i32 {
        let (i, (place, kind)) = (self.handle, Self::place(name));
        // SAFETY: one reference, one value.
        unsafe {
            match (self.version, kind) {
                (Version::Fmi2, VariableType::Real) => {
                    fmi2::set::<M, f64>(i, "set", &place, 1, &value)
                }
                (Version::Fmi2, VariableType::Integer) => {
                    fmi2::set::<M, i32>(i, "set", &place, 1, &(value as i32))
                }
                (Version::Fmi2, _) => fmi2::set_boolean::<M>(i, &place, 1, &(value as i32)),
                (Version::Fmi3, VariableType::Real) => {
                    fmi3::set::<M, f64>(i, "set", &place, 1, &value, 1)
                }
                (Version::Fmi3, VariableType::Integer) => {
                    fmi3::set::<M, i32>(i, "set", &place, 1, &(value as i32), 1)
                }
                (Version::Fmi3, _) => fmi3::set_boolean::<M>(i, &place, 1, &(value as u8), 1),
            }
        }
    }

    pub(crate) fn set(&self, name: &str, value: f64) {
        assert_eq!(self.try_set(name, value), 0, "{name} = {value}: {:?}", self.log());
    }

    pub(crate) fn set_text(&self, name: &str, text: &str) -> i32 {
        let (i, version, place) = (self.handle, self.version, Self::place(name).0);
        let text = CString::new(text).unwrap();
        // SAFETY: one reference, one text.
        unsafe { fmi2::set_string::<M>(i, version, "set", &place, 1, &text.as_ptr()) }
    }

    /// A real variable.
    pub(crate) fn get(&self, name: &str) -> f64 {
        let (i, place, mut value) = (self.handle, Self::place(name).0, f64::NAN);
        // SAFETY: one reference, one value.
        let status = unsafe {
            match self.version {
                Version::Fmi2 => fmi2::get::<M, f64>(i, "get", &place, 1, &mut value),
                Version::Fmi3 => fmi3::get::<M, f64>(i, "get", &place, 1, &mut value, 1),
            }
        };
        assert_eq!(status, 0, "{name}: {:?}", self.log());
        value
    }

    pub(crate) fn all<const N: usize>(&self, names: [&str; N]) -> [f64; N] {
        names.map(|name| self.get(name))
    }

    pub(crate) fn set_all<const N: usize>(&self, names: [&str; N], values: [f64; N]) {
        names.iter().zip(values).for_each(|(name, value)| self.set(name, value));
    }

    /// One communication step; the status.
    pub(crate) fn step(&self, begin: f64, size: f64) -> i32 {
        let i = self.handle;
        let ([mut event, mut end, mut early], mut last) = ([0; 3], 0.0);
        let report = fmi3::StepReport {
            event_handling_needed: &mut event,
            terminate_simulation: &mut end,
            early_return: &mut early,
            last_successful_time: &mut last,
        };
        match self.version {
            Version::Fmi2 => fmi2::do_step::<M>(i, begin, size),
            // SAFETY: the places are ours.
            Version::Fmi3 => unsafe { fmi3::do_step::<M>(i, begin, size, report) },
        }
    }

    /// The state now, to go back to.
    pub(crate) fn saved(&self) -> *mut c_void {
        let mut saved = null_mut();
        // SAFETY: the place is ours.
        let status = unsafe { state::get::<M>(self.handle, self.version, "state", &mut saved) };
        assert_eq!(status, 0);
        saved
    }

    pub(crate) fn restore(&self, saved: *mut c_void) {
        assert_eq!(
            state::set::<M>(self.handle, self.version, "state", saved),
            0,
            "{:?}",
            self.log()
        );
    }

    /// The state as bytes.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let (i, version, saved, mut size) = (self.handle, self.version, self.saved(), 0);
        // SAFETY: the places are ours.
        unsafe {
            assert_eq!(state::serialized_size::<M>(i, version, "size", saved, &mut size), 0);
            let mut bytes = vec![0; size];
            let done = state::serialize::<M>(i, version, "bytes", saved, bytes.as_mut_ptr(), size);
            assert_eq!(done, 0);
            bytes
        }
    }

    /// The status with which it goes back to a state from bytes.
    pub(crate) fn revive(&self, bytes: &[u8]) -> i32 {
        let (i, version, mut saved) = (self.handle, self.version, null_mut());
        let (at, size) = (bytes.as_ptr(), bytes.len());
        // SAFETY: the places are ours.
        let made = unsafe { state::deserialize::<M>(i, version, "bytes", at, size, &mut saved) };
        made.max(state::set::<M>(i, version, "state", saved))
    }

    /// The messages so far, of an FMI 3.0 instance.
    pub(crate) fn log(&self) -> Vec<String> {
        // SAFETY: the log lives as long as the instance, and no call is under way.
        unsafe { (*self.log).clone() }
    }
}

impl<M: FmuModel> Drop for Slave<M> {
    fn drop(&mut self) {
        fmi2::free_instance(self.handle);
        // SAFETY: made from a box, and nothing writes to it any more.
        drop(unsafe { Box::from_raw(self.log) });
    }
}
