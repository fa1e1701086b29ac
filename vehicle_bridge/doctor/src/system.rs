//! The system: clock, processor, real-time rights.

use std::fs;

use nix::sys::resource::{Resource, getrlimit};

use super::Finding;
use hosting::realtime;

const CLOCK: &str = "/sys/devices/system/clocksource/clocksource0/current_clocksource";
const GOVERNOR: &str = "/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor";
/// Clocks that are read without leaving the process.
const FAST_CLOCKS: [&str; 4] =
    ["tsc", "kvm-clock", "arch_sys_counter", "hyperv_clocksource_tsc_page"];
/// Memory a program of this project locks at most. \[B\]
const LOCKED: u64 = 512 << 20;

/// The kernel's clock source.
pub(super) fn clock() -> Finding {
    const SUBJECT: &str = "clock source";
    let fix = format!("echo tsc > {CLOCK} (or the kernel option clocksource=tsc)");
    match fs::read_to_string(CLOCK) {
        Ok(name) if FAST_CLOCKS.contains(&name.trim()) => Finding::ok(SUBJECT, name.trim()),
        Ok(name) => {
            let name = name.trim();
            Finding::warn(SUBJECT, format!("{name}: each time stamp is a system call"), fix)
        }
        Err(error) => Finding::warn(SUBJECT, format!("{CLOCK}: {error}"), fix),
    }
}

/// The frequency governor; a virtual machine has none.
pub(super) fn governor() -> Finding {
    const SUBJECT: &str = "CPU governor";
    match fs::read_to_string(GOVERNOR) {
        Ok(name) if name.trim() == "performance" => Finding::ok(SUBJECT, "performance"),
        Ok(name) => Finding::warn(
            SUBJECT,
            format!("{}: the clock changes under load", name.trim()),
            "cpupower frequency-set -g performance",
        ),
        Err(_) => Finding::ok(SUBJECT, "none: the processor's clock is not ours to change"),
    }
}

/// Whether a thread gets FIFO priority. Tried on a thread of its own, which then ends.
pub(super) fn priority() -> Finding {
    const SUBJECT: &str = "real-time priority";
    let tried = std::thread::spawn(|| realtime::prioritise(realtime::LOOP_PRIORITY)).join();
    let limit = getrlimit(Resource::RLIMIT_RTPRIO).map_or(0, |(soft, _)| soft);
    match tried {
        Ok(Ok(())) => Finding::ok(SUBJECT, format!("FIFO {} granted", realtime::LOOP_PRIORITY)),
        Ok(Err(why)) => Finding::warn(
            SUBJECT,
            format!("RLIMIT_RTPRIO {limit}: {why}"),
            "`@realtime - rtprio 95` in /etc/security/limits.d/, or setcap cap_sys_nice+ep lmpc",
        ),
        Err(_) => Finding::warn(SUBJECT, "the trying thread ended early", "try again"),
    }
}

/// How much memory may be locked.
pub(super) fn memory() -> Finding {
    const SUBJECT: &str = "locked memory";
    let fix = "`@realtime - memlock unlimited` in /etc/security/limits.d/";
    if nix::unistd::geteuid().is_root() {
        return Finding::ok(SUBJECT, "root: without limit");
    }
    match getrlimit(Resource::RLIMIT_MEMLOCK) {
        Ok((soft, _)) if soft >= LOCKED => Finding::ok(SUBJECT, format!("{soft} bytes allowed")),
        Ok((soft, _)) => {
            Finding::warn(SUBJECT, format!("{soft} bytes allowed, {LOCKED} wanted"), fix)
        }
        Err(error) => Finding::warn(SUBJECT, error.to_string(), fix),
    }
}
