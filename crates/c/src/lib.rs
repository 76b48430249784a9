//! lariat for C and C++: `lariat_wire`'s reader for control loops and its writer of frames, behind
//! a plain header.
//!
//! `lariat.h` tells users everything they need; it is generated from this crate's comments. Every
//! function that C calls accepts NULL pointers, catches panics, and leaves a message for
//! `lariat_error`.

// Names follow C's conventions, because they appear unchanged in the header.
#![allow(non_camel_case_types)]
#![allow(
    clippy::missing_safety_doc,
    reason = "the requirements on C callers are the same for all functions and are at the top of lariat.h"
)]

mod centerline;
mod error;
mod message;
mod reader;
mod rope;
mod shape;
mod space;
mod writer;

pub use centerline::*;
pub use error::*;
pub use message::*;
pub use reader::*;
pub use rope::*;
pub use shape::*;
pub use space::*;
pub use writer::*;
