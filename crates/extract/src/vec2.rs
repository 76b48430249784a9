//! Arithmetic of positions and directions in the image plane.

pub(crate) type Vec2 = [f32; 2];

pub(crate) fn add(a: Vec2, b: Vec2) -> Vec2 {
    [a[0] + b[0], a[1] + b[1]]
}

pub(crate) fn sub(a: Vec2, b: Vec2) -> Vec2 {
    [a[0] - b[0], a[1] - b[1]]
}

pub(crate) fn scale(a: Vec2, k: f32) -> Vec2 {
    [a[0] * k, a[1] * k]
}

/// `a + k·b`.
pub(crate) fn along(a: Vec2, b: Vec2, k: f32) -> Vec2 {
    [a[0] + k * b[0], a[1] + k * b[1]]
}

pub(crate) fn dot(a: Vec2, b: Vec2) -> f32 {
    a[0] * b[0] + a[1] * b[1]
}

pub(crate) fn cross(a: Vec2, b: Vec2) -> f32 {
    a[0] * b[1] - a[1] * b[0]
}

pub(crate) fn norm(a: Vec2) -> f32 {
    dot(a, a).sqrt()
}

pub(crate) fn distance(a: Vec2, b: Vec2) -> f32 {
    norm(sub(a, b))
}

/// The direction of `a`, or `otherwise` if `a` is zero.
pub(crate) fn unit_or(a: Vec2, otherwise: Vec2) -> Vec2 {
    let length = norm(a);
    if length > 1e-6 {
        scale(a, 1.0 / length)
    } else {
        otherwise
    }
}

/// The vector turned by a quarter turn, from x toward y.
pub(crate) fn normal(a: Vec2) -> Vec2 {
    [-a[1], a[0]]
}

/// The angle from `a` to `b`, −π to π.
pub(crate) fn angle(a: Vec2, b: Vec2) -> f32 {
    libm::atan2f(cross(a, b), dot(a, b))
}
