//! A signal ends a wait early, so that whoever waits can look whether to stop.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use lariat_capture::{Wait, wait_until};
use lariat_wire::now_ns;
use rustix::process::{Signal, getpid, kill_process};

fn main() {
    let stop = Arc::new(AtomicBool::new(false));
    signal_hook::flag::register(signal_hook::consts::SIGUSR1, Arc::clone(&stop))
        .expect("the signal may be caught");
    let is_over = Arc::new(AtomicBool::new(false));
    let sender = thread::spawn({
        let is_over = Arc::clone(&is_over);
        move || {
            // Again and again: the first may come before the wait begins.
            while !is_over.load(Ordering::Relaxed) {
                kill_process(getpid(), Signal::USR1).expect("a process may signal itself");
                thread::sleep(Duration::from_millis(5));
            }
        }
    });
    let an_hour_ns = 3600 * 1_000_000_000;
    assert_eq!(wait_until(now_ns() + an_hour_ns), Wait::Interrupted);
    assert!(stop.load(Ordering::Relaxed));
    is_over.store(true, Ordering::Relaxed);
    sender.join().expect("it ends");
}
