//! What each clue weighs: made by `cargo run --release -p lariat-lab -- calibrate-confidence`, which says how true the
//! confidence is on pictures that it was not fitted to: expected calibration error 0.035 of one's own masks (these are of an earlier run), 0.040 of the
//! network's, 0.029 of those from elsewhere.

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
    -16.179, // constant
    5.088, // edges on both sides
    -3.454, // an edge on a side at least
    7.642, // contrast in levels
    2.276, // contrast over texture
    -7.334, // edges where the width says
    -2.076, // unevenness of the width
    -1.982, // unlikeness of colour along the curve
    1.261, // unlikeness of the two sides
    4.680, // unlikeness of the ground along the curve
    -2.273, // like the ground in less light
    10.635, // length in widths
    -6.805, // thinness
    1.129, // bends
    -5.111, // straight through the picture
    -4.385, // ends that go on
    -0.338, // hidden share
    -2.342, // seen in part
    -3.273, // its own doubt
    -0.085, // the mask's notice
    -1.790, // a stretch without edges
    -0.229, // nothing against it
    -6.689, // an arc of a circle
    6.681, // likely by the network
    1.573, // unlikely by the network in part
];
/// Where somebody else did.
#[rustfmt::skip]
pub(super) const ELSEWHERE: [f32; CLUES] = [
    -15.148, // constant
    2.450, // edges on both sides
    0.194, // an edge on a side at least
    3.477, // contrast in levels
    -3.080, // contrast over texture
    1.408, // edges where the width says
    -0.058, // unevenness of the width
    -3.193, // unlikeness of colour along the curve
    2.092, // unlikeness of the two sides
    1.832, // unlikeness of the ground along the curve
    -0.612, // like the ground in less light
    12.719, // length in widths
    -1.660, // thinness
    -1.018, // bends
    0.000, // straight through the picture
    -6.020, // ends that go on
    1.038, // hidden share
    -0.372, // seen in part
    0.000, // its own doubt
    0.000, // the mask's notice
    -1.273, // a stretch without edges
    1.630, // nothing against it
    -3.600, // an arc of a circle
    0.000, // likely by the network
    0.000, // unlikely by the network in part
];
