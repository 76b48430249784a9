//! `lariat servo`: a rope driven to a shape by what the camera sees.

mod film;
mod judge;
mod report;
