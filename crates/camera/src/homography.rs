//! The homography of pairs of points: where each pixel of a plane's picture lies on the plane.
//!
//! Eight unknowns, two equations a pair (Hartley and Zisserman, *Multiple View Geometry*, 4.1), in coordinates of mean 0 and
//! mean distance √2 (Hartley 1997), in which the third homogeneous coordinate at the middle of the points can be taken for 1: a
//! camera sees them all on one side of the plane's horizon. With four pairs that is exact. With more, it is the start of
//! Levenberg–Marquardt for the least sum of squared distances on the plane, which is what `cv2.findHomography` gives.

use crate::projective::{self, Matrix};
use crate::solve::{SIZE, solve};
use thiserror::Error;

/// A point as it is seen and where it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// In the picture, px.
    pub pixel: [f64; 2],
    /// On the plane, mm.
    pub plane_mm: [f64; 2],
}

/// Why pairs of points make no homography.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum HomographyError {
    /// Fewer than four pairs.
    #[error("{0} points do not determine a plane's perspective: give four, or better more")]
    TooFew(usize),
    /// More pairs than are taken.
    #[error("{0} points are too many: give at most {MOST}")]
    TooMany(usize),
    /// A coordinate that is not finite.
    #[error("point {0} is not a position: give finite numbers of pixels and millimetres")]
    NotAPoint(usize),
    /// Three of four points in a line.
    #[error(
        "points {}, {} and {} lie in one line {place}: choose four of which no three do, such as the corners of a sheet of \
         paper", .points[0], .points[1], .points[2]
    )]
    InLine {
        /// Which, from 1.
        points: [usize; 3],
        /// `in the picture` or `on the plane`.
        place: &'static str,
    },
    /// All points, but at most one, in a line, or several in one place.
    #[error("the points lie in one line, but for at most one: spread them over the table")]
    Degenerate,
    /// The points' order is turned, or the like.
    #[error(
        "no camera sees the points so: some would lie beyond the horizon of the others. Look whether two of them, or x and y, \
         have changed places"
    )]
    BothSides,
}

/// Pairs at most: a chess board has hundreds.
const MOST: usize = 10_000;
/// Three points whose triangle is lower than this share of its longest side count as in a line: a click that is a pixel
/// off would turn it.
const FLAT: f64 = 0.01;
/// Steps of Levenberg–Marquardt at most.
const STEPS: usize = 100;

/// The homography from pixels to the plane, with a positive third coordinate at all points.
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
    // Points of the plane in one line make a map onto that line.
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

/// A shift and a scale.
struct Normal {
    middle: [f64; 2],
    scale: f64,
}

impl Normal {
    /// Such that the points have mean 0 and mean distance √2; `None` if they all lie in one place.
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

/// The first eight numbers of the matrix whose last is 1.
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

/// The solution of the linear equations: exact for four pairs, else the least squares of their residuals.
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

/// The sum of squared distances on the plane; infinite if a point is not before the horizon.
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

/// Levenberg–Marquardt from `h` to the least squared distances. The sum of squares tells two places apart to the root of a
/// rounding error only, so the last steps, undamped, go by their own length: each is shorter than the one before.
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

/// One damped step of Gauss and Newton.
fn step(h: &[f64; SIZE], pairs: &[Pair], damping: f64) -> Option<[f64; SIZE]> {
    let (mut a, mut b) = ([[0.0; SIZE]; SIZE], [0.0; SIZE]);
    for pair in pairs {
        let place = projective::map(&matrix(h), pair.pixel)?;
        let depth = h[6] * pair.pixel[0] + h[7] * pair.pixel[1] + 1.0;
        let at = Pair {
            plane_mm: place.point,
            ..*pair
        };
        // An equation by the depth is the derivative of the distance on the plane.
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
