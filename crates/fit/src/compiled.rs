//! Curves in the plane and in space, compiled here, once, in a build for tests. Generic code is compiled by the crate that first
//! asks for it in a dimension, at that crate's level of optimization: without this list every program that fits compiles the
//! kernels anew, and the chain, which is not optimized for tests, fits by slow ones. In a release crates share no generic code.

use crate::{Filter, Fitter, RationalFitter, Resampler, SteadySize};

#[used]
static PLANE: fn() -> [*const (); 17] = all::<2>;

#[used]
static SPACE: fn() -> [*const (); 17] = all::<3>;

/// Never called: what it names is compiled.
fn all<const D: usize>() -> [*const (); 17] {
    [
        Fitter::<D>::in_dimensions as *const (),
        Fitter::<D>::fit as *const (),
        Fitter::<D>::fit_weighted as *const (),
        Fitter::<D>::control_points as *const (),
        Fitter::<D>::last_space as *const (),
        Fitter::<D>::propagate as *const (),
        Fitter::<D>::spread as *const (),
        Fitter::<D>::forget as *const (),
        SteadySize::fit::<D> as *const (),
        Resampler::<D>::in_dimensions as *const (),
        Resampler::<D>::resample as *const (),
        RationalFitter::<D>::new as *const (),
        RationalFitter::<D>::fit as *const (),
        RationalFitter::<D>::joint_covariance_factor as *const (),
        Filter::<D>::new as *const (),
        Filter::<D>::update as *const (),
        Filter::<D>::predict as *const (),
    ]
}
