//! The chain: its processes, their launcher, their settings, and code shared by lariat's commands.
//!
//! `ARCHITECTURE.md` shows how the parts work together.
//!
//! - [`settings`]: every setting once, from flags, `lariat.toml` and defaults
//! - [`pipeline`]: from a frame to the shapes in it, without transport, clock or waiting
//! - [`stages`]: the processes around the pipeline
//! - [`launcher`]: `lariat run`, which starts the stages, watches them and stops them in order
//! - [`control`]: requests to a running chain
//! - [`notify`]: reports to a service manager
//! - [`stop`]: signals, as a descriptor for `poll`
//! - [`itself`]: starts this program again, from the running executable
//! - [`output`], [`run_files`]: files that are complete or absent
//! - [`bounded`], [`inputs`], [`picture`]: the files and pictures that a user named
//! - [`load`]: how busy the machine is
//! - [`recorded`]: recordings, frame by frame
//! - [`canvas`]: lines drawn over pictures
//! - [`calibrated`], [`plane_file`], [`measured_plane`], [`places`]: camera and plane, and the way
//!   back to the image
//! - [`layout`], [`confidence`], [`messages`], [`doubts`], [`exit`]: text on a terminal, and exit
//!   codes
//!
//! # Known limitations
//!
//! - Linux only: the launcher needs `/proc`, memfd and parent-death signals.
//! - The interface may change with any release.

/// Prints a line on standard error. The macro of the standard library would panic if nobody reads
/// standard error any more.
#[macro_export]
macro_rules! eprintln {
    ($($text:tt)*) => {{
        $crate::messages::say(&format!($($text)*));
    }};
}

/// Prints text on standard error like [`eprintln`], but without a line end.
#[macro_export]
macro_rules! eprint {
    ($($text:tt)*) => {{
        let _ = std::io::Write::write_fmt(&mut std::io::stderr(), format_args!($($text)*));
    }};
}

pub mod bounded;
pub mod calibrated;
pub mod canvas;
pub mod confidence;
pub mod control;
pub mod doubts;
pub mod exit;
pub mod inputs;
pub mod itself;
pub mod launcher;
pub mod layout;
pub mod load;
pub mod measured_plane;
pub mod messages;
pub mod notify;
pub mod output;
#[cfg(test)]
mod outside;
pub mod picture;
pub mod pipeline;
pub mod places;
pub mod plane_file;
pub mod recorded;
pub mod run_files;
pub mod settings;
pub mod stages;
pub mod stop;
