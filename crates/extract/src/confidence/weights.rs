//! What each clue weighs: made by `cargo run --release -p lariat-lab -- calibrate-confidence`, which says how true the
//! confidence is on pictures that it was not fitted to: expected calibration error 0.035 of one's own masks (these are of an earlier run), 0.030 of the
//! network's, 0.026 of those from elsewhere.

use super::CLUES;

/// Where the extractor made the mask.
#[rustfmt::skip]
pub(super) const OWN: [f32; CLUES] = [
    -6.553, // constant
    -0.429, // edges on both sides
    -2.853, // an edge on a side at least
    6.110, // contrast in levels
    -1.054, // contrast over texture
    -0.808, // edges where the width says
    -0.295, // unevenness of the width
    -1.828, // unlikeness of colour along the curve
    0.122, // unlikeness of the two sides
    0.377, // unlikeness of the ground along the curve
    -0.826, // like the ground in less light
    7.119, // length in widths
    -2.487, // thinness
    0.026, // bends
    -2.531, // straight through the picture
    -1.390, // ends that go on
    -0.141, // hidden share
    -2.437, // seen in part
    -1.803, // its own doubt
    -0.466, // the mask's notice
    -2.111, // a stretch without edges
    2.892, // nothing against it
    0.000, // an arc of a circle
    0.000, // likely by the network
    0.000, // unlikely by the network in part
];
/// Where the network did.
#[rustfmt::skip]
pub(super) const NETWORK: [f32; CLUES] = [
    -18.469, // constant
    4.523, // edges on both sides
    -5.063, // an edge on a side at least
    7.744, // contrast in levels
    1.623, // contrast over texture
    0.117, // edges where the width says
    -2.451, // unevenness of the width
    1.801, // unlikeness of colour along the curve
    1.602, // unlikeness of the two sides
    2.150, // unlikeness of the ground along the curve
    -1.780, // like the ground in less light
    11.989, // length in widths
    -4.081, // thinness
    1.260, // bends
    -5.394, // straight through the picture
    -4.297, // ends that go on
    -0.931, // hidden share
    -2.649, // seen in part
    -3.717, // its own doubt
    -0.036, // the mask's notice
    -4.143, // a stretch without edges
    -1.741, // nothing against it
    -6.979, // an arc of a circle
    4.459, // likely by the network
    -1.286, // unlikely by the network in part
];
/// Where somebody else did.
#[rustfmt::skip]
pub(super) const ELSEWHERE: [f32; CLUES] = [
    -15.281, // constant
    2.511, // edges on both sides
    0.170, // an edge on a side at least
    3.553, // contrast in levels
    -3.095, // contrast over texture
    1.327, // edges where the width says
    0.049, // unevenness of the width
    -3.160, // unlikeness of colour along the curve
    2.207, // unlikeness of the two sides
    1.589, // unlikeness of the ground along the curve
    -0.644, // like the ground in less light
    12.879, // length in widths
    -1.781, // thinness
    -1.045, // bends
    0.000, // straight through the picture
    -6.133, // ends that go on
    0.948, // hidden share
    -0.360, // seen in part
    0.000, // its own doubt
    0.000, // the mask's notice
    -1.150, // a stretch without edges
    1.638, // nothing against it
    -3.582, // an arc of a circle
    0.000, // likely by the network
    0.000, // unlikely by the network in part
];
