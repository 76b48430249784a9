//! Figures of rivals that were not measured in this run.

/// What mBEST took for a photograph of its own data set (672×896, centerlines only), by set, in milliseconds: medians,
/// measured elsewhere, on a core that reads 640×480 RGB in 11 µs.
pub const MBEST_MS: [(&str, f64); 2] = [("S1", 18.5), ("S2", 20.5)];

/// What steps of the image libraries took for a frame of 640×480 on that core on that day, in milliseconds: by them this
/// machine can be compared with that one.
pub const STEPS_MS: [(&str, f64); 4] = [
    ("OpenCV HSV + inRange", 0.491),
    ("OpenCV connected components", 1.835),
    ("OpenCV distance transform", 0.378),
    ("scikit-image thinning", 3.437),
];
