#![allow(unsafe_code)] // Two system calls that rustix does not have.
//! Short slices: a thread that asks for less of a core at a time has it sooner when it wakes, without any privilege.
//!
//! A kernel of 6.12 or later (EEVDF) lets a thread that wakes run before one whose slice is longer, and keeps nobody on a core beyond its own slice. The
//! usual slice is 1.4 ms on two cores and 2.8 on eight, which is what a thread otherwise waits for whatever program has its core. Older kernels go on as they do.

/// The shortest there is.
const SLICE_NS: u64 = 100_000;

/// Asks for short slices of a core for the calling thread, for a control loop that may not have realtime priority: when a message wakes it, it need
/// not wait for the end of another program's slice. Any user may; it needs Linux 6.12, and changes nothing on older ones.
///
/// Its share of a busy core stays, in shorter pieces, and so do its niceness and the slices of other threads; threads that it starts later have short
/// ones too. A thread of realtime priority is left alone. No reader does this by itself: a thread belongs to its program, which may do more in it
/// than read.
pub fn take_short_slices() {
    if let Some(mut attributes) = attributes()
        && attributes.sched_policy == libc::SCHED_OTHER as u32
    {
        attributes.sched_runtime = SLICE_NS;
        // SAFETY: the kernel only reads it, as far as its `size`, which the kernel itself has written. Not to be had is no fault.
        unsafe { libc::syscall(libc::SYS_sched_setattr, 0, &raw const attributes, 0) };
    }
}

/// How the calling thread is scheduled.
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
    // SAFETY: of this thread (0), the kernel writes at most `size` bytes to what is as large and lives here.
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
            // Kernels that have no slices to be asked for say 0.
            if before > 0 {
                assert_eq!(of_thread(), SLICE_NS);
            }
        })
        .join()
        .expect("it holds");
        assert_eq!(of_thread(), before);
    }
}
