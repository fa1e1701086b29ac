//! Random calls over the C interface of both versions: any function, any order, any arguments a
//! C caller can be held to. Every call must return a status, and an *error* or *discard* must
//! leave every output as it was.
#![allow(clippy::unwrap_used, clippy::panic, unsafe_code)]

mod probe;

use std::collections::BTreeMap;
use std::ffi::{CString, c_char, c_void};
use std::ptr::{null, null_mut, without_provenance_mut};

use fmu_core::c::fmi2::Callbacks;
use fmu_core::{FmuModel, Version};
use probe::Probe;

fmu_core::export_fmu!(Probe);
use fmi_exports as c;

const CALLS_PER_VERSION: usize = 1_000_000;
const ERROR: i32 = 3;
/// Value references of the outputs, and one more than there are variables.
const OUTPUTS: [u32; 2] = [7, 8];
const VARIABLES: u64 = 9;

/// xorshift64* (Vigna 2016).
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }
    fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }
    fn one_in(&mut self, n: u64) -> bool {
        self.below(n) == 0
    }
    fn number(&mut self) -> f64 {
        let odd = [f64::NAN, f64::INFINITY, -1.0, 0.0, -0.0, 1e300, 5e-324, f64::MIN];
        match self.below(10) {
            0 => odd[self.below(odd.len() as u64) as usize],
            1 => f64::from_bits(self.next()),
            _ => self.below(1000) as f64 * 0.01,
        }
    }
}

unsafe extern "C" fn log3(
    env: *mut c_void,
    status: i32,
    category: *const c_char,
    text: *const c_char,
) {
    assert!(env.is_null() && (0..5).contains(&status) && !category.is_null() && !text.is_null());
}

/// What a caller holds.
struct World {
    version: Version,
    dice: Dice,
    instances: Vec<*mut c_void>,
    states: Vec<*mut c_void>,
    saved: Vec<Vec<u8>>,
    time: f64,
    counts: BTreeMap<i32, usize>,
}

impl World {
    fn pick(dice: &mut Dice, from: &[*mut c_void]) -> *mut c_void {
        match dice.below(40) {
            0 => null_mut(),
            1 => without_provenance_mut(dice.next() as usize),
            _ if from.is_empty() => null_mut(),
            _ => from[dice.below(from.len() as u64) as usize],
        }
    }

    fn instantiate(&mut self) -> *mut c_void {
        let good = CString::new(Probe::description().token()).unwrap();
        let token = if self.dice.one_in(8) { c"{no}".as_ptr() } else { good.as_ptr() };
        let name = if self.dice.one_in(10) { null() } else { c"name".as_ptr() };
        let logging = self.dice.below(2);
        // SAFETY: strings end with a zero byte; the callbacks are null or whole.
        unsafe {
            match self.version {
                Version::Fmi2 => {
                    let callbacks = Callbacks {
                        logger: None,
                        allocate_memory: None,
                        free_memory: None,
                        step_finished: None,
                        environment: null_mut(),
                    };
                    let kind = i32::from(!self.dice.one_in(10));
                    let uri = c"file:///nowhere%20at%20all".as_ptr();
                    let callbacks = if self.dice.one_in(5) { null() } else { &raw const callbacks };
                    c::fmi2Instantiate(name, kind, token, uri, callbacks, 0, logging as i32)
                }
                Version::Fmi3 => {
                    let event = u8::from(self.dice.one_in(10));
                    let log = Some(log3 as fmu_core::c::Logger3);
                    c::fmi3InstantiateCoSimulation(
                        name,
                        token,
                        null(),
                        0,
                        logging as u8,
                        event,
                        0,
                        null(),
                        0,
                        null_mut(),
                        log,
                        null_mut(),
                    )
                }
            }
        }
    }

    /// The outputs as bits, if the instance lets them be read.
    fn outputs(&self, instance: *mut c_void) -> Option<[u64; 2]> {
        let mut values = [0.0; 2];
        // SAFETY: two references, two values.
        let status = unsafe {
            match self.version {
                Version::Fmi2 => c::fmi2GetReal(instance, OUTPUTS.as_ptr(), 2, values.as_mut_ptr()),
                Version::Fmi3 => {
                    c::fmi3GetFloat64(instance, OUTPUTS.as_ptr(), 2, values.as_mut_ptr(), 2)
                }
            }
        };
        (status == 0).then(|| values.map(f64::to_bits))
    }

    fn call(&mut self) {
        let instance = Self::pick(&mut self.dice, &self.instances);
        if self.instances.len() < 3 || self.dice.one_in(2_000) {
            let made = self.instantiate();
            if !made.is_null() {
                self.instances.push(made);
                self.time = 0.0;
            }
            return;
        }
        if self.dice.one_in(500) {
            // SAFETY: any handle may be freed; unknown ones are ignored.
            unsafe {
                match self.version {
                    Version::Fmi2 => c::fmi2FreeInstance(instance),
                    Version::Fmi3 => c::fmi3FreeInstance(instance),
                }
            }
            // Mostly forget it, sometimes keep the dead handle and use it.
            if !self.dice.one_in(4) {
                self.instances.retain(|i| *i != instance);
            } else if self.instances.len() > 12 {
                self.instances.clear();
            }
            return;
        }
        // Reading first also settles what a lazily built model would show.
        let before = self.outputs(instance);
        let status = match self.version {
            Version::Fmi2 => self.call2(instance),
            Version::Fmi3 => self.call3(instance),
        };
        assert!((0..=4).contains(&status), "status {status}");
        if (2..=ERROR).contains(&status)
            && let Some(before) = before
        {
            assert_eq!(self.outputs(instance), Some(before), "outputs changed on {status}");
        }
        *self.counts.entry(status).or_default() += 1;
    }

    fn step_times(&mut self) -> (f64, f64) {
        let begin = if self.dice.one_in(8) { self.dice.number() } else { self.time };
        let size = if self.dice.one_in(6) { self.dice.number() } else { 0.05 };
        (begin, size)
    }

    fn references(&mut self) -> ([u32; 3], usize) {
        let mut one = || match self.dice.below(20) {
            0 => self.dice.next() as u32,
            _ => self.dice.below(VARIABLES + 1) as u32,
        };
        let references = [one(), one(), one()];
        (references, self.dice.below(4) as usize)
    }

    fn state_slot(&mut self) -> *mut c_void {
        if self.dice.one_in(3) { null_mut() } else { Self::pick(&mut self.dice, &self.states) }
    }

    fn keep_state(&mut self, status: i32, state: *mut c_void) -> i32 {
        if status == 0 && !self.states.contains(&state) {
            self.states.push(state);
        }
        if self.states.len() > 20 {
            self.states.remove(0);
        }
        status
    }

    fn damaged(&mut self) -> Vec<u8> {
        let n = self.saved.len() as u64;
        let mut bytes =
            if n == 0 { vec![7; 64] } else { self.saved[self.dice.below(n) as usize].clone() };
        match self.dice.below(4) {
            0 => {
                let at = self.dice.below(bytes.len() as u64) as usize;
                bytes[at] ^= 1 << self.dice.below(8);
            }
            1 => bytes.truncate(self.dice.below(bytes.len() as u64) as usize),
            _ => {}
        }
        bytes
    }
}

#[path = "fuzz/random2.rs"]
mod random2;
#[path = "fuzz/random3.rs"]
mod random3;

fn run(version: Version) {
    let mut world = World {
        version,
        dice: Dice(0x9e37_79b9_7f4a_7c15),
        instances: Vec::new(),
        states: Vec::new(),
        saved: Vec::new(),
        time: 0.0,
        counts: BTreeMap::new(),
    };
    // The model panics thousands of times; nobody wants to read that.
    std::panic::set_hook(Box::new(|_| {}));
    for _ in 0..CALLS_PER_VERSION {
        world.call();
    }
    let _ = std::panic::take_hook();
    // A fuzzer that never gets anywhere proves nothing: every status must have been seen, but
    // fatal, which only a broken core returns.
    let seen: Vec<i32> = world.counts.keys().copied().collect();
    assert_eq!(seen, [0, 1, 2, 3], "{:?}", world.counts);
    let good = world.counts[&0];
    assert!(good > CALLS_PER_VERSION / 10, "{:?}", world.counts);
}

#[test]
fn a_million_random_calls_of_fmi_2() {
    run(Version::Fmi2);
}

#[test]
fn a_million_random_calls_of_fmi_3() {
    run(Version::Fmi3);
}
