//! Real-time rights: used where the system grants them, done without where not.

use nix::sys::mman::{MlockAllFlags, mlockall};
use thread_priority::{
    RealtimeThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy,
    set_thread_priority_and_policy, thread_native_id,
};

/// Priority of the control loop among FIFO threads. \[-\]
pub const LOOP_PRIORITY: u8 = 80;
/// Priority of the receiving thread: below the loop. \[-\]
pub const RECEIVE_PRIORITY: u8 = 70;

/// Gives the calling thread first-in-first-out priority.
///
/// # Errors
/// In words, with what would help.
pub fn prioritise(priority: u8) -> Result<(), String> {
    let refused = |why: String| {
        format!("no FIFO priority {priority} ({why}): needs CAP_SYS_NICE or `ulimit -r 80`")
    };
    let value = priority.try_into().map_err(|e| refused(format!("{e:?}")))?;
    let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    set_thread_priority_and_policy(thread_native_id(), ThreadPriority::Crossplatform(value), policy)
        .map_err(|e| refused(format!("{e:?}")))
}

/// Keeps all memory of the process in RAM, now and from now on.
///
/// # Errors
/// In words, with what would help.
pub fn lock_memory() -> Result<(), String> {
    mlockall(MlockAllFlags::MCL_CURRENT | MlockAllFlags::MCL_FUTURE)
        .map_err(|e| format!("memory is not locked ({e}): needs CAP_IPC_LOCK or `ulimit -l`"))
}
