//! What each clue weighs: made by `cargo run --release -p lariat-lab -- calibrate-confidence`, which says how true the
//! confidence is on pictures that it was not fitted to: expected calibration error 0.045 and 0.025.

use super::CLUES;

/// Where the extractor made the mask.
#[rustfmt::skip]
pub(super) const OWN: [f32; CLUES] = [
    -4.444, // constant
    -0.351, // edges on both sides
    -3.286, // an edge on a side at least
    3.914, // contrast in levels
    0.307, // contrast over texture
    -1.101, // edges where the width says
    -0.818, // unevenness of the width
    -1.695, // unlikeness of colour along the curve
    -2.826, // unlikeness of the two sides
    -0.966, // unlikeness of the ground along the curve
    -0.611, // like the ground in less light
    5.557, // length in widths
    -2.538, // thinness
    1.770, // bends
    -0.503, // straight through the picture
    -1.340, // ends that go on
    -0.104, // hidden share
    -2.004, // seen in part
    -1.252, // its own doubt
    -0.018, // the mask's notice
    -1.536, // a stretch without edges
    3.599, // nothing against it
];
/// Where somebody else did.
#[rustfmt::skip]
pub(super) const ELSEWHERE: [f32; CLUES] = [
    -9.732, // constant
    2.071, // edges on both sides
    -0.586, // an edge on a side at least
    0.089, // contrast in levels
    -1.903, // contrast over texture
    0.795, // edges where the width says
    0.954, // unevenness of the width
    -2.921, // unlikeness of colour along the curve
    -0.448, // unlikeness of the two sides
    0.346, // unlikeness of the ground along the curve
    0.310, // like the ground in less light
    9.445, // length in widths
    -2.577, // thinness
    0.022, // bends
    0.000, // straight through the picture
    -5.652, // ends that go on
    -0.180, // hidden share
    -0.501, // seen in part
    0.000, // its own doubt
    0.000, // the mask's notice
    -0.442, // a stretch without edges
    3.015, // nothing against it
];
