//! Properties of every rational fit.

mod covariance;
mod exact;
mod noisy;
mod sampling;
