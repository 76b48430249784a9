//! Figures of rivals that are not measured by this program.

/// Median times of mBEST for a photograph of its own data set (672×896, centerlines only), by set,
/// in milliseconds. Measured on a core that reads 640×480 RGB in 11 µs.
pub const MBEST_MS: [(&str, f64); 2] = [("S1", 18.5), ("S2", 20.5)];

/// Times of the image libraries' steps for a frame of 640×480 on the same core and day, in
/// milliseconds. They allow this machine to be compared with that one.
pub const STEPS_MS: [(&str, f64); 4] = [
    ("OpenCV HSV + inRange", 0.491),
    ("OpenCV connected components", 1.835),
    ("OpenCV distance transform", 0.378),
    ("scikit-image thinning", 3.437),
];
