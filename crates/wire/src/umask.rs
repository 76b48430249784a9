#![allow(unsafe_code)] // A listener may go to another thread, which the transport's own counters do not know.
//! The process's umask, kept from the transport.
//!
//! iceoryx2 0.10 gives the socket of a new listener its rights by the process's umask: it sets 0177, binds, and sets again what was there.
//! (Nothing else of it touches the umask.) What another thread makes in that moment has wrong rights, a program that it starts keeps
//! 0177, and of two threads that make listeners at once, each in a domain, one may leave it to the process for good. So a listener is made
//! in a thread that shares no umask with the others, which the kernel grants to whoever asks. Where a sandbox forbids that, as containers
//! do, one thread at a time makes one: the umask comes back, but until then, for microseconds, it is everybody's. So it is if a program
//! uses iceoryx2 itself beside lariat, which knows none of this.

use std::panic;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use iceoryx2::port::listener::{Listener, ListenerCreateError};
use iceoryx2::prelude::ipc;
use iceoryx2::service::port_factory::event::PortFactory;
use rustix::thread::{UnshareFlags, unshare_unsafe};

use crate::door::Held;

type Made = Result<Listener<ipc::Service>, ListenerCreateError>;

/// Makes a listener.
pub(crate) fn listener(service: &Arc<Held<PortFactory<ipc::Service>>>) -> Made {
    let apart = {
        let service = service.clone();
        move || {
            // SAFETY: the thread goes on sharing its descriptors. What it no longer shares are umask and folders.
            let _ = unsafe { unshare_unsafe(UnshareFlags::FS) };
            Sent(one_at_a_time(&service))
        }
    };
    // No `thread::scope`: it would leave this thread's handle behind, which valgrind finds in programs in C.
    match thread::Builder::new().spawn(apart) {
        Ok(thread) => match thread.join() {
            Ok(made) => made.0,
            Err(cause) => panic::resume_unwind(cause),
        },
        // No more threads may be had.
        Err(_) => one_at_a_time(service),
    }
}

fn one_at_a_time(service: &PortFactory<ipc::Service>) -> Made {
    static MAKING: Mutex<()> = Mutex::new(());
    let _making = MAKING.lock().unwrap_or_else(PoisonError::into_inner);
    service.listener_builder().create()
}

/// Given by the thread that made it to the one that asked.
struct Sent(Made);

// SAFETY: what keeps a listener from being `Send` is a counted reference without atomics, of which it has the only one. Its service is
// counted with atomics; the transport keeps nothing by thread.
unsafe impl Send for Sent {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Domain, ready};
    use rustix::fs::Mode;
    use rustix::process::umask;
    use std::process::Command;

    #[test]
    fn in_a_sandbox_threads_that_make_listeners_leave_the_umask_as_it_was() {
        // In a process of its own: other tests are to keep their umask.
        let maker = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "umask::tests::maker", "--include-ignored"])
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&maker.stdout);
        assert!(maker.status.success(), "{said}");
    }

    #[test]
    #[ignore = "it is started by the test before"]
    fn maker() {
        forbid_unshare();
        let own = Mode::from_raw_mode(0o027);
        umask(own);
        let name = format!("m{}-umask", std::process::id());
        let domain = Domain::named(&name).unwrap();
        let service = ready::open(&domain, "lariat/left/descriptors", 24).unwrap();
        let service = Arc::new(service);
        thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| (0..100).for_each(|_| drop(listener(&service).unwrap())));
            }
        });
        drop((service, domain));
        let _ = std::fs::remove_dir_all(format!("/tmp/lariat-{name}"));
        assert_eq!(umask(own), own);
    }

    /// From now on this thread, and those that it starts, may not leave what they share.
    fn forbid_unshare() {
        use libc::{BPF_ABS, BPF_JEQ, BPF_JMP, BPF_K, BPF_LD, BPF_RET, BPF_W};
        let step = |code: u32, jf, k| libc::sock_filter {
            code: code as u16,
            jt: 0,
            jf,
            k,
        };
        let refused = libc::SECCOMP_RET_ERRNO | libc::EPERM as u32;
        let mut steps = [
            // What a filter is given begins with the call's number.
            step(BPF_LD | BPF_W | BPF_ABS, 0, 0),
            step(BPF_JMP | BPF_JEQ | BPF_K, 1, libc::SYS_unshare as u32),
            step(BPF_RET | BPF_K, 0, refused),
            step(BPF_RET | BPF_K, 0, libc::SECCOMP_RET_ALLOW),
        ];
        let filter = libc::sock_fprog {
            len: steps.len() as u16,
            filter: steps.as_mut_ptr(),
        };
        // SAFETY: the kernel copies the filter, which forbids one call.
        unsafe {
            assert_eq!(libc::prctl(libc::PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0), 0);
            let mode = libc::SECCOMP_MODE_FILTER;
            assert_eq!(libc::prctl(libc::PR_SET_SECCOMP, mode, &filter), 0);
            assert_eq!(libc::unshare(libc::CLONE_FS), -1);
        }
    }
}
