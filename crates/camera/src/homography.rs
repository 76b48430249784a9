//! Computes the homography of pairs of points, which maps each pixel of a plane's image to its
//! place on the plane.
//!
//! There are eight unknowns and two equations per pair (Hartley and Zisserman, *Multiple View
//! Geometry*, 4.1). Coordinates are normalized to mean 0 and mean distance √2 (Hartley 1997). The
//! third homogeneous coordinate at the center of the points can then be 1: a camera sees all of
//! them on one side of the plane's horizon. Four pairs give an exact solution. With more, the
//! linear solution is the start of Levenberg–Marquardt, which minimizes the sum of squared
//! distances on the plane, as `cv2.findHomography` does.

use crate::projective::{self, Matrix};
use crate::solve::{SIZE, solve};
use thiserror::Error;

/// A point in the image and on the plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// Position in the image, px.
    pub pixel: [f64; 2],
    /// Position on the plane, mm.
    pub plane_mm: [f64; 2],
}

/// Why pairs of points do not determine a homography.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum HomographyError {
    /// Fewer than four pairs.
    #[error("{0} points do not determine a plane's perspective: give four, or better more")]
    TooFew(usize),
    /// More pairs than are accepted.
    #[error("{0} points are too many: give at most {MOST}")]
    TooMany(usize),
    /// A coordinate that is not finite.
    #[error("point {0} is not a position: give finite numbers of pixels and millimetres")]
    NotAPoint(usize),
    /// Three of four points are in a line.
    #[error(
        "points {}, {} and {} lie in one line {place}: choose four of which no three do, such as the corners of a sheet of \
         paper", .points[0], .points[1], .points[2]
    )]
    InLine {
        /// Their numbers, from 1.
        points: [usize; 3],
        /// `in the picture` or `on the plane`.
        place: &'static str,
    },
    /// All points except at most one are in a line, or several coincide.
    #[error("the points lie in one line, but for at most one: spread them over the table")]
    Degenerate,
    /// No camera can see the points like this, for example because their order is reversed.
    #[error(
        "no camera sees the points so: some would lie beyond the horizon of the others. Look whether two of them, or x and y, \
         have changed places"
    )]
    BothSides,
}

/// Maximum number of pairs; a chess board has hundreds.
const MOST: usize = 10_000;
/// Three points count as collinear if the height of their triangle is less than this share of its
/// longest side. An error of one pixel could flip such a triangle.
const FLAT: f64 = 0.01;
/// Maximum number of Levenberg–Marquardt steps.
const STEPS: usize = 100;

/// Computes the homography from pixels to the plane, with a positive third coordinate at all
/// points.
pub(crate) fn of_pairs(pairs: &[Pair]) -> Result<Matrix, HomographyError> {
    check(pairs)?;
    let from = Normal::of(pairs, |pair| pair.pixel).ok_or(HomographyError::Degenerate)?;
    let to = Normal::of(pairs, |pair| pair.plane_mm).ok_or(HomographyError::Degenerate)?;
    let pairs: Vec<Pair> = pairs
        .iter()
        .map(|pair| Pair {
            pixel: from.apply(pair.pixel),
            plane_mm: to.apply(pair.plane_mm),
        })
        .collect();
    let h = start(&pairs).ok_or(HomographyError::Degenerate)?;
    if !all_before(&h, &pairs) {
        return Err(HomographyError::BothSides);
    }
    let h = if pairs.len() > 4 {
        refine(h, &pairs)
    } else {
        h
    };
    let h = projective::product(
        &to.back(),
        &projective::product(&matrix(&h), &from.matrix()),
    );
    // If the points on the plane are in a line, the result maps onto that line.
    match projective::inverse(&h) {
        Some(_) => Ok(h),
        None => Err(HomographyError::Degenerate),
    }
}

fn check(pairs: &[Pair]) -> Result<(), HomographyError> {
    let count = pairs.len();
    if count < 4 {
        return Err(HomographyError::TooFew(count));
    }
    if count > MOST {
        return Err(HomographyError::TooMany(count));
    }
    let is_place = |pair: &Pair| (pair.pixel.iter().chain(&pair.plane_mm)).all(|c| c.abs() < 1e9);
    if let Some(index) = pairs.iter().position(|pair| !is_place(pair)) {
        return Err(HomographyError::NotAPoint(index + 1));
    }
    if count > 4 {
        return Ok(());
    }
    for [a, b, c] in [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]] {
        let seen = [a, b, c].map(|i| pairs[i].pixel);
        let lying = [a, b, c].map(|i| pairs[i].plane_mm);
        for (triangle, place) in [(seen, "in the picture"), (lying, "on the plane")] {
            if is_flat(triangle) {
                return Err(HomographyError::InLine {
                    points: [a + 1, b + 1, c + 1],
                    place,
                });
            }
        }
    }
    Ok(())
}

fn is_flat([a, b, c]: [[f64; 2]; 3]) -> bool {
    let side = |p: [f64; 2], q: [f64; 2]| [q[0] - p[0], q[1] - p[1]];
    let (u, v, w) = (side(a, b), side(a, c), side(b, c));
    let area = (u[0] * v[1] - u[1] * v[0]).abs();
    let longest = [u, v, w].into_iter().map(|s| s[0] * s[0] + s[1] * s[1]);
    area <= FLAT * longest.fold(0.0, f64::max)
}

/// Normalization by a shift and a scale.
struct Normal {
    middle: [f64; 2],
    scale: f64,
}

impl Normal {
    /// Normalizes the points to mean 0 and mean distance √2; `None` if all of them coincide.
    fn of(pairs: &[Pair], place: impl Fn(&Pair) -> [f64; 2]) -> Option<Self> {
        let count = pairs.len() as f64;
        let middle = [0, 1].map(|i| pairs.iter().map(|p| place(p)[i]).sum::<f64>() / count);
        let distances = pairs.iter().map(|p| {
            let [x, y] = place(p);
            libm::hypot(x - middle[0], y - middle[1])
        });
        let scale = std::f64::consts::SQRT_2 * count / distances.sum::<f64>();
        (scale.is_finite() && scale > 0.0).then_some(Self { middle, scale })
    }

    fn apply(&self, p: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| self.scale * (p[i] - self.middle[i]))
    }

    fn matrix(&self) -> Matrix {
        let Self { middle, scale } = self;
        [
            [*scale, 0.0, -scale * middle[0]],
            [0.0, *scale, -scale * middle[1]],
            [0.0, 0.0, 1.0],
        ]
    }

    fn back(&self) -> Matrix {
        let Self { middle, scale } = self;
        [
            [1.0 / scale, 0.0, middle[0]],
            [0.0, 1.0 / scale, middle[1]],
            [0.0, 0.0, 1.0],
        ]
    }
}

/// The matrix with these first eight numbers, whose last is 1.
fn matrix(h: &[f64; SIZE]) -> Matrix {
    [[h[0], h[1], h[2]], [h[3], h[4], h[5]], [h[6], h[7], 1.0]]
}

fn all_before(h: &[f64; SIZE], pairs: &[Pair]) -> bool {
    let depth = |pair: &Pair| h[6] * pair.pixel[0] + h[7] * pair.pixel[1] + 1.0;
    pairs.iter().all(|pair| depth(pair) > 1e-9)
}

/// The two equations of a pair, linear in the unknowns.
fn equations(pair: &Pair) -> [([f64; SIZE], f64); 2] {
    let ([x, y], [u, v]) = (pair.pixel, pair.plane_mm);
    [
        ([x, y, 1.0, 0.0, 0.0, 0.0, -u * x, -u * y], u),
        ([0.0, 0.0, 0.0, x, y, 1.0, -v * x, -v * y], v),
    ]
}

/// Solves the linear equations: exactly for four pairs, otherwise by least squares.
fn start(pairs: &[Pair]) -> Option<[f64; SIZE]> {
    let mut rows = pairs.iter().flat_map(equations);
    let (mut a, mut b) = ([[0.0; SIZE]; SIZE], [0.0; SIZE]);
    if pairs.len() == 4 {
        for (i, (row, right)) in rows.by_ref().enumerate().take(SIZE) {
            (a[i], b[i]) = (row, right);
        }
    } else {
        for (row, right) in rows {
            add_square(&mut a, &mut b, &row, right);
        }
    }
    solve(a, b)
}

/// Adds an equation to the normal equations.
fn add_square(a: &mut [[f64; SIZE]; SIZE], b: &mut [f64; SIZE], row: &[f64; SIZE], right: f64) {
    for i in 0..SIZE {
        for j in 0..SIZE {
            a[i][j] += row[i] * row[j];
        }
        b[i] += row[i] * right;
    }
}

/// Sum of squared distances on the plane; infinite if a point is not in front of the horizon.
fn cost(h: &[f64; SIZE], pairs: &[Pair]) -> f64 {
    let matrix = matrix(h);
    let squares = pairs.iter().map(|pair| {
        projective::map(&matrix, pair.pixel).map_or(f64::INFINITY, |place| {
            let [u, v] = [0, 1].map(|i| place.point[i] - pair.plane_mm[i]);
            u * u + v * v
        })
    });
    squares.sum()
}

/// Minimizes the squared distances by Levenberg–Marquardt from `h`. The sum of squares resolves
/// positions only to the square root of a rounding error. The last, undamped steps are therefore
/// judged by their length: each must be shorter than the one before.
fn refine(mut h: [f64; SIZE], pairs: &[Pair]) -> [f64; SIZE] {
    let mut now = cost(&h, pairs);
    let mut damping = 1e-6;
    for _ in 0..STEPS {
        let Some(next) = step(&h, pairs, damping) else {
            return h;
        };
        let then = cost(&next, pairs);
        let gained = now - then;
        if gained > 0.0 {
            (h, now) = (next, then);
            damping *= 0.1;
        } else {
            damping *= 10.0;
        }
        if gained.abs() <= 1e-14 * now || damping > 1e6 {
            break;
        }
    }
    let mut last = f64::INFINITY;
    for _ in 0..STEPS {
        let Some(next) = step(&h, pairs, 0.0) else {
            return h;
        };
        let moved = next.iter().zip(&h).map(|(a, b)| (a - b) * (a - b)).sum();
        let settled = moved >= last || !all_before(&next, pairs);
        if settled {
            break;
        }
        (h, last) = (next, moved);
    }
    h
}

/// One damped Gauss–Newton step.
fn step(h: &[f64; SIZE], pairs: &[Pair], damping: f64) -> Option<[f64; SIZE]> {
    let (mut a, mut b) = ([[0.0; SIZE]; SIZE], [0.0; SIZE]);
    for pair in pairs {
        let place = projective::map(&matrix(h), pair.pixel)?;
        let depth = h[6] * pair.pixel[0] + h[7] * pair.pixel[1] + 1.0;
        let at = Pair {
            plane_mm: place.point,
            ..*pair
        };
        // Dividing an equation by the depth gives the derivative of the distance on the plane.
        for (i, (row, _)) in equations(&at).into_iter().enumerate() {
            let row = row.map(|x| x / depth);
            add_square(&mut a, &mut b, &row, pair.plane_mm[i] - place.point[i]);
        }
    }
    for (i, row) in a.iter_mut().enumerate() {
        row[i] *= 1.0 + damping;
    }
    let step = solve(a, b)?;
    Some(std::array::from_fn(|i| h[i] + step[i]))
}
