//! A place for messages: a domain and a rig for each caller.

use std::sync::atomic::{AtomicU32, Ordering};

use lariat_wire::{Domain, Rig};

/// A separate domain. If it is dropped after everything in it, nothing is left over.
pub(crate) struct Place {
    pub(crate) name: String,
    pub(crate) rig: Rig,
}

impl Place {
    pub(crate) fn new() -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        Self {
            name: format!("h{}-{number}", std::process::id()),
            rig: Rig::default(),
        }
    }

    pub(crate) fn domain(&self) -> Domain {
        Domain::named(&self.name).expect("a plain name, and shared memory")
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(format!("/tmp/lariat-{}", self.name));
    }
}
