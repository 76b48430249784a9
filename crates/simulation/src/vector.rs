//! Points in the plane or in 3-D. Sums start with the first coordinate.

/// `a·b`
pub(crate) fn dot<const D: usize>(a: [f64; D], b: [f64; D]) -> f64 {
    let mut sum = a[0] * b[0];
    for axis in 1..D {
        sum += a[axis] * b[axis];
    }
    sum
}

/// `a − b`
pub(crate) fn minus<const D: usize>(a: [f64; D], b: [f64; D]) -> [f64; D] {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

/// `at += by · along`
pub(crate) fn push<const D: usize>(at: &mut [f64; D], by: f64, along: [f64; D]) {
    for axis in 0..D {
        at[axis] += by * along[axis];
    }
}

/// `a × b`
pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

pub(crate) fn length<const D: usize>(a: [f64; D]) -> f64 {
    dot(a, a).sqrt()
}

pub(crate) fn distance<const D: usize>(a: [f64; D], b: [f64; D]) -> f64 {
    length(minus(a, b))
}
