//! What must hold for every rational fit.

mod covariance;
mod exact;
mod noisy;
mod sampling;
