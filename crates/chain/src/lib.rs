//! The chain: its four processes, what starts them, their settings, and what every command of lariat shares.
//!
//! | room | what |
//! |---|---|
//! | [`settings`] | every setting once: flags, `lariat.toml`, defaults |
//! | [`pipeline`] | from a frame to the shapes in it, without transport, clock or waiting |
//! | [`stages`] | the processes around it: what each reads, computes and sends |
//! | [`launcher`] | `lariat run`: starts the stages, watches them, stops them in order |
//! | [`control`] | what a running chain can be asked for, and how |
//! | [`notify`] | what a service manager is told |
//! | [`stop`] | signals and the end of `--duration`, as something to `poll` |
//! | [`output`], [`run_files`] | files written whole or not at all |
//! | [`inputs`], [`picture`] | the pictures that a user named |
//! | [`load`] | how busy the machine is |
//! | [`recorded`] | recordings, frame by frame |
//! | [`canvas`] | lines drawn over pictures |
//! | [`calibrated`], [`plane_file`], [`measured_plane`] | camera and plane as files have them; a plane from points |
//! | [`layout`], [`confidence`], [`messages`], [`doubts`], [`exit`] | what is said on a terminal, by which process, and the exit code |

/// Says a line on standard error. The standard library's own would end the process where nobody reads it, in the middle of its work.
#[macro_export]
macro_rules! eprintln {
    ($($text:tt)*) => {{
        $crate::messages::say(&format!($($text)*));
    }};
}

/// Likewise, without the line's end.
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
