//! What each clue weighs: made by `cargo run --release -p lariat-lab -- calibrate-confidence`, which says how true the
//! confidence is on pictures that it was not fitted to: expected calibration error 0.035 of one's own masks (these are of an earlier run), 0.029 of the
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
    0.000, // surely seen by the network
];
/// Where the network did.
#[rustfmt::skip]
pub(super) const NETWORK: [f32; CLUES] = [
    -12.727, // constant
    5.111, // edges on both sides
    -2.722, // an edge on a side at least
    7.262, // contrast in levels
    3.016, // contrast over texture
    -8.276, // edges where the width says
    -1.502, // unevenness of the width
    -1.559, // unlikeness of colour along the curve
    1.315, // unlikeness of the two sides
    4.740, // unlikeness of the ground along the curve
    -2.244, // like the ground in less light
    10.027, // length in widths
    -6.983, // thinness
    1.100, // bends
    -5.000, // straight through the picture
    -4.259, // ends that go on
    -0.272, // hidden share
    -2.336, // seen in part
    -3.183, // its own doubt
    -0.071, // the mask's notice
    -1.666, // a stretch without edges
    -0.369, // nothing against it
    -6.684, // an arc of a circle
    3.637, // surely seen by the network
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
    0.000, // surely seen by the network
];
