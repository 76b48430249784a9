//! Robustness, which the paper claims but does not show: noise, missing points, outliers, light.

mod light;
mod missing;
mod noise;
mod outliers;

pub(crate) use light::Lights;
pub(crate) use missing::Missing;
pub(crate) use noise::Noise;
pub(crate) use outliers::Outliers;

use lariat_plot::Spread;

/// Returns the median at each step of a sweep.
fn medians(spreads: &[Spread]) -> Vec<f64> {
    spreads.iter().map(|spread| spread.median).collect()
}
