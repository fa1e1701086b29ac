//! A host that traps on division by zero must not find one: the entry points mask traps, so the flags tell.
#![cfg(target_arch = "x86_64")]
#![allow(clippy::unwrap_used, unsafe_code)]

use std::sync::Arc;

use controller::{Config, Controller, Preset};
use vehicle_model::{CarParams, Plant, PlantParams, State, Track};

/// Flag of a division by zero in MXCSR.
const DIVISION: u32 = 1 << 2;
/// MXCSR as the processor begins: no flags, all traps masked.
const CLEAR: u32 = 0x1f80;

/// Whether a division by zero was made since the last call; clears the flags.
fn divided_by_zero() -> bool {
    let (mut state, clear) = (0_u32, CLEAR);
    // SAFETY: stores the SSE control register to `state` and loads its initial value.
    unsafe {
        std::arch::asm!("stmxcsr [{}]", in(reg) &raw mut state);
        std::arch::asm!("ldmxcsr [{}]", in(reg) &raw const clear);
    }
    state & DIVISION != 0
}

#[test]
fn initialisation_divides_nothing_by_zero() {
    divided_by_zero();
    let zero = std::hint::black_box(0.0_f64);
    std::hint::black_box(1.0 / zero);
    assert!(divided_by_zero(), "the flag is seen");
    for name in CarParams::builtin_names() {
        let car = CarParams::builtin(name).unwrap();
        let track = Arc::new(
            Track::builtin(if car.wheelbase() < 0.5 { "l" } else { "road_course" }).unwrap(),
        );
        divided_by_zero();
        let config = Config::derived(Preset::Race, &car, &track);
        assert!(!divided_by_zero(), "settings of {name}");
        Controller::new(config, car.clone(), Arc::clone(&track)).unwrap();
        assert!(!divided_by_zero(), "controller of {name}");
        let start = State { v_x: 1.2, ..State::default() };
        Plant::new(PlantParams::new(car), track, start).unwrap();
        assert!(!divided_by_zero(), "plant of {name}");
    }
}
