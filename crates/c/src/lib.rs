//! lariat for C and C++: `lariat_wire`'s reader for control loops, and its writer of frames, behind a plain header.
//!
//! What a user has to know stands in `lariat.h`, which is made of this crate's comments. Here: every function that C calls
//! takes pointers that may be NULL, catches what would unwind, and leaves a sentence for `lariat_error`.

// Names are C's: they stand in the header as they stand here.
#![allow(non_camel_case_types)]
#![allow(
    clippy::missing_safety_doc,
    reason = "what C has to vouch for is the same for all functions, and stands at the head of lariat.h"
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
