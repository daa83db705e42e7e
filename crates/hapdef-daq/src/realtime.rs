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

/// Runs `work` without the real-time priority that this thread was given: threads inherit it, and one that searches
/// would hold up what has it for a reason.
pub fn without_realtime<T>(priority: Option<u8>, work: impl FnOnce() -> T) -> T {
    let Some(priority) = priority else {
        return work();
    };
    leave_realtime();
    let done = work();
    // Who was refused it before is refused again, and was told.
    let _ = enter_realtime(priority);
    done
}

#[cfg(all(feature = "realtime", target_os = "linux"))]
fn leave_realtime() {
    use thread_priority::{
        NormalThreadSchedulePolicy, ThreadPriority, ThreadPriorityOsValue, ThreadSchedulePolicy,
        set_thread_priority_and_policy, thread_native_id,
    };
    let normal = ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Other);
    let nice = ThreadPriority::Os(ThreadPriorityOsValue::default());
    // A niceness that may not be set stays; the policy is normal then, too.
    let _ = set_thread_priority_and_policy(thread_native_id(), nice, normal);
}

#[cfg(not(all(feature = "realtime", target_os = "linux")))]
fn leave_realtime() {}

/// Says that this build can't.
///
/// # Errors
/// Always.
#[cfg(not(all(feature = "realtime", target_os = "linux")))]
pub fn enter_realtime(_priority: u8) -> Result<(), String> {
    Err("this build has no real-time priority: build on Linux with feature `realtime`".to_owned())
}
