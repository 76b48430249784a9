#![allow(unsafe_code)] // Two system calls that rustix lacks.
//! Short time slices: a thread that requests shorter slices is scheduled sooner when it wakes,
//! without any privilege.
//!
//! Linux 6.12 and later (EEVDF) lets a waking thread preempt one with a longer slice, and takes the
//! core from each thread after its slice. The usual slice is 1.4 ms on two cores and 2.8 ms on
//! eight. Without short slices, a thread waits that long for another program on its core. Older
//! kernels are unaffected.

/// The shortest slice that the kernel grants.
const SLICE_NS: u64 = 100_000;

/// Requests short time slices for the calling thread, for a control loop without realtime priority.
/// When a message wakes the thread, it need not wait until another program's slice ends. This needs
/// no privilege. It requires Linux 6.12 and does nothing on older kernels.
///
/// The thread keeps its share of a busy core, in shorter pieces, and its niceness. Other threads
/// are unaffected, but threads that it starts later inherit the short slices. A thread of realtime
/// priority is left alone. Readers never call this themselves, because a thread belongs to its
/// program, which may use it for more than reading.
pub fn take_short_slices() {
    if let Some(mut attributes) = attributes()
        && attributes.sched_policy == libc::SCHED_OTHER as u32
    {
        attributes.sched_runtime = SLICE_NS;
        // SAFETY: the kernel only reads the struct, up to the `size` that it wrote itself. Failure
        // is harmless.
        unsafe { libc::syscall(libc::SYS_sched_setattr, 0, &raw const attributes, 0) };
    }
}

/// Scheduling attributes of the calling thread.
fn attributes() -> Option<libc::sched_attr> {
    let mut attributes = libc::sched_attr {
        size: 0,
        sched_policy: 0,
        sched_flags: 0,
        sched_nice: 0,
        sched_priority: 0,
        sched_runtime: 0,
        sched_deadline: 0,
        sched_period: 0,
    };
    let size = size_of_val(&attributes) as u32;
    // SAFETY: for this thread (0), the kernel writes at most `size` bytes into a struct of that
    // size.
    let read = unsafe { libc::syscall(libc::SYS_sched_getattr, 0, &raw mut attributes, size, 0) };
    (read == 0).then_some(attributes)
}

#[cfg(test)]
mod tests {
    use std::thread;

    use super::*;

    #[test]
    fn the_thread_that_asks_has_short_slices_and_keeps_its_niceness() {
        let of_thread = || attributes().expect("the kernel knows it").sched_runtime;
        let before = of_thread();
        thread::spawn(move || {
            let niceness = || rustix::process::getpriority_process(None).expect("it is this one");
            // The test itself may run with any niceness.
            let before_nice = niceness();
            rustix::process::nice(3).expect("anybody may");
            let nice = niceness();
            assert_eq!(nice, (before_nice + 3).min(19));
            take_short_slices();
            assert_eq!(niceness(), nice);
            // Kernels without adjustable slices report 0.
            if before > 0 {
                assert_eq!(of_thread(), SLICE_NS);
            }
        })
        .join()
        .expect("it holds");
        assert_eq!(of_thread(), before);
    }
}
