//! All tests of the public interface in one binary, which is built and linked once.

#[path = "../any_curve/mod.rs"]
mod any_curve;

mod allocation;
mod choice;
mod curve_measure;
mod curve_shape;
mod curves;
mod dense;
mod families;
mod filter;
mod numpy_lstsq;
mod propagation;
mod properties;
mod rational;
mod splines;
mod spread;
