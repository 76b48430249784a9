//! Cameras, by the kernel's Video4Linux2 interface.

mod sys;
