#![allow(unsafe_code)] // Listeners move between threads despite their non-atomic counters.
//! Protects the process's umask from the transport.
//!
//! iceoryx2 0.10 sets the permissions of a new listener's socket through the process's umask: it
//! sets 0177, binds, and restores the previous value. It uses the umask for nothing else. Files
//! that another thread creates in between get wrong permissions, and a child process started in
//! between keeps 0177. If two threads create listeners at once, each in its own domain, the process
//! may even keep 0177 permanently.
//!
//! A listener is therefore created in a thread that does not share its umask. Linux permits this to
//! any process, but sandboxes such as containers may forbid it. In that case, only one thread at a
//! time creates a listener. The umask is then always restored, but the whole process has the umask
//! 0177 for some microseconds. The same happens if a program uses iceoryx2 directly alongside
//! lariat.

use std::panic;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use iceoryx2::port::listener::{Listener, ListenerCreateError};
use iceoryx2::prelude::ipc;
use iceoryx2::service::port_factory::event::PortFactory;
use rustix::thread::{UnshareFlags, unshare_unsafe};

use crate::door::Held;

type Made = Result<Listener<ipc::Service>, ListenerCreateError>;

/// Creates a listener.
pub(crate) fn listener(service: &Arc<Held<PortFactory<ipc::Service>>>) -> Made {
    let apart = {
        let service = service.clone();
        move || {
            // SAFETY: the thread still shares its file descriptors; only the umask and the working
            // directory are separate.
            let _ = unsafe { unshare_unsafe(UnshareFlags::FS) };
            Sent(one_at_a_time(&service))
        }
    };
    // `thread::scope` would leave this thread's handle behind, which valgrind reports in C
    // programs.
    match thread::Builder::new().spawn(apart) {
        Ok(thread) => match thread.join() {
            Ok(made) => made.0,
            Err(cause) => panic::resume_unwind(cause),
        },
        // The thread limit is reached.
        Err(_) => one_at_a_time(service),
    }
}

fn one_at_a_time(service: &PortFactory<ipc::Service>) -> Made {
    static MAKING: Mutex<()> = Mutex::new(());
    let _making = MAKING.lock().unwrap_or_else(PoisonError::into_inner);
    service.listener_builder().create()
}

/// A listener on its way from the thread that created it to the caller.
struct Sent(Made);

// SAFETY: a listener is not `Send` because of one non-atomic reference count, and this is the only
// reference. Its service is counted atomically, and the transport keeps nothing per thread.
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
        // Runs in a separate process, so that other tests keep their umask.
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

    /// Forbids `unshare` for this thread and the threads that it starts.
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
            // The filter's input begins with the number of the system call.
            step(BPF_LD | BPF_W | BPF_ABS, 0, 0),
            step(BPF_JMP | BPF_JEQ | BPF_K, 1, libc::SYS_unshare as u32),
            step(BPF_RET | BPF_K, 0, refused),
            step(BPF_RET | BPF_K, 0, libc::SECCOMP_RET_ALLOW),
        ];
        let filter = libc::sock_fprog {
            len: steps.len() as u16,
            filter: steps.as_mut_ptr(),
        };
        // SAFETY: the kernel copies the filter, which forbids one system call.
        unsafe {
            assert_eq!(libc::prctl(libc::PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0), 0);
            let mode = libc::SECCOMP_MODE_FILTER;
            assert_eq!(libc::prctl(libc::PR_SET_SECCOMP, mode, &filter), 0);
            assert_eq!(libc::unshare(libc::CLONE_FS), -1);
        }
    }
}
