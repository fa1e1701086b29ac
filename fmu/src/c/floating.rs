//! The host's floating-point state: set aside while our code runs, put back afterwards.
//!
//! A host may round upwards, trap on division by zero or flush small numbers to zero; other
//! numbers than tested would follow, or a signal. Rust itself assumes the default state.

/// The state every number here is computed in: rounding to nearest, no traps, no flushing to zero.
/// MXCSR: all exceptions masked, no flags.
#[cfg(target_arch = "x86_64")]
const OURS: u32 = 0x1f80;
/// FPCR: every bit off.
#[cfg(target_arch = "aarch64")]
const OURS: u64 = 0;

/// The caller's state, put back when this is dropped; with it the exception flags it had.
#[derive(Debug)]
pub struct FloatingPoint {
    #[cfg(target_arch = "x86_64")]
    callers: u32,
    #[cfg(target_arch = "aarch64")]
    callers: [u64; 2],
}

impl FloatingPoint {
    /// Switches to our state.
    #[must_use]
    pub fn ours() -> Self {
        let saved = Self::now();
        saved.replace();
        saved
    }

    /// Lets the host's code run in the host's state.
    pub fn callers<T>(&self, body: impl FnOnce() -> T) -> T {
        self.put_back();
        let result = body();
        self.replace();
        result
    }
}

impl Drop for FloatingPoint {
    fn drop(&mut self) {
        self.put_back();
    }
}

#[cfg(target_arch = "x86_64")]
impl FloatingPoint {
    fn now() -> Self {
        let mut callers = 0_u32;
        // SAFETY: stores the SSE control register into a local of its size; every x86-64 has SSE.
        unsafe { std::arch::asm!("stmxcsr [{}]", in(reg) &raw mut callers, options(nostack)) };
        Self { callers }
    }

    fn replace(&self) {
        load(OURS);
    }

    fn put_back(&self) {
        load(self.callers);
    }
}

#[cfg(target_arch = "x86_64")]
fn load(state: u32) {
    // SAFETY: the value is one the register held, or the architecture's default; a reserved bit,
    // which alone could fault, is never set.
    unsafe { std::arch::asm!("ldmxcsr [{}]", in(reg) &raw const state, options(nostack)) };
}

#[cfg(target_arch = "aarch64")]
impl FloatingPoint {
    fn now() -> Self {
        let (control, flags): (u64, u64);
        // SAFETY: reads two registers that every program may read.
        unsafe {
            std::arch::asm!("mrs {}, fpcr", "mrs {}, fpsr", out(reg) control, out(reg) flags);
        }
        Self { callers: [control, flags] }
    }

    fn replace(&self) {
        load([OURS, 0]);
    }

    fn put_back(&self) {
        load(self.callers);
    }
}

#[cfg(target_arch = "aarch64")]
fn load([control, flags]: [u64; 2]) {
    // SAFETY: the values are ones the registers held, or the default; every program may write them.
    unsafe { std::arch::asm!("msr fpcr, {}", "msr fpsr, {}", in(reg) control, in(reg) flags) };
}

/// Of other processors the host's state is taken as it is.
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
impl FloatingPoint {
    fn now() -> Self {
        Self {}
    }

    fn replace(&self) {}

    fn put_back(&self) {}
}
