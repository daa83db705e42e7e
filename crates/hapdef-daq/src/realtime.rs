//! Real-time priority and locked memory, where the operating system grants them.

/// Gives the calling thread SCHED_FIFO priority and locks the memory that the process has, page by page as it is
/// touched: a page once read or written stays. What is only reserved, such as stacks and what an allocator holds
/// in store, costs nothing; locked at once it was a gigabyte.
///
/// # Errors
/// What was refused, and what to do about it.
#[cfg(all(feature = "realtime", target_os = "linux"))]
pub fn enter_realtime(priority: u8) -> Result<(), String> {
    use rustix::mm::{MlockAllFlags, mlockall};
    use thread_priority::{
        RealtimeThreadSchedulePolicy, ThreadPriority, ThreadPriorityValue, ThreadSchedulePolicy,
        set_thread_priority_and_policy, thread_native_id,
    };
    let value =
        ThreadPriorityValue::try_from(priority.clamp(1, 99)).map_err(|error| error.to_string())?;
    let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    set_thread_priority_and_policy(
        thread_native_id(),
        ThreadPriority::Crossplatform(value),
        policy,
    )
    .map_err(|error| {
        format!("SCHED_FIFO was refused ({error}): raise rtprio in /etc/security/limits.conf")
    })?;
    mlockall(MlockAllFlags::CURRENT | MlockAllFlags::ONFAULT).map_err(|error| {
        format!("locking memory was refused ({error}): raise memlock in /etc/security/limits.conf")
    })
}

/// Says that this build can't.
///
/// # Errors
/// Always.
#[cfg(not(all(feature = "realtime", target_os = "linux")))]
pub fn enter_realtime(_priority: u8) -> Result<(), String> {
    Err("this build has no real-time priority: build on Linux with feature `realtime`".to_owned())
}
