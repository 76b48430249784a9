//! Shape of a rope. Its heading on the table is a sum of a few waves, and its height a few lifts.
//! Where it crosses itself, one strand passes over the other.

use super::Eye;
use super::eye::dot;
use crate::rendered::portable::smoothstep;
use lariat_portable::SplitMix64;
use std::f64::consts::TAU;
use thiserror::Error;

/// Number of points of a true centerline.
const TRUE_POINTS: usize = 2000;
/// Number of points of a draft.
const DRAFT: usize = 600;
/// Maximum number of drafts.
const TRIES: usize = 20_000;
/// Minimum distance of strands that do not cross, in the picture, and minimum bend radius on the
/// table, both in diameters.
const APART: f64 = 2.5;
const TIGHTEST: f64 = 3.0;
/// Minimum crossing angle, and minimum distance of crossings from each other and from an end, in
/// diameters.
const FLATTEST_DEG: f64 = 35.0;
const CROSSINGS_APART: f64 = 5.0;

/// Requirements on a rope.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiftOptions {
    /// Length, mm.
    pub length_mm: f64,
    /// Radius, mm.
    pub radius_mm: f64,
    /// Height of the lift, mm above the rope's position on the table; 0 for a rope on the table.
    pub lift_mm: f64,
    /// Number of self-crossings in the picture.
    pub crossings: usize,
}

/// No rope was found that meets the requirements and is completely in the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error(
    "no such rope fits the picture: ask for a shorter one, fewer crossings, a lower lift, or a larger picture"
)]
pub struct NoSuchRope;

/// A rope in 3-D.
#[derive(Debug, Clone, PartialEq)]
pub struct LiftedRope {
    /// 2000 points of its centerline at equal steps of arc length, mm; the first and the last point
    /// are its ends.
    pub points: Vec<[f64; 3]>,
    /// Radius, mm.
    pub radius_mm: f64,
    /// Self-crossings in the picture that it was made for: normalized arc lengths of the upper and
    /// of the lower strand.
    pub crossings: Vec<[f64; 2]>,
}

impl LiftedRope {
    /// Makes the first rope of a seed that `eye` sees well: within the inner nine tenths of the
    /// picture, with strands apart and crossings steep.
    ///
    /// # Errors
    /// Returns an error if none of many drafts meets the requirements.
    pub fn new(options: &LiftOptions, eye: &Eye, seed: u64) -> Result<Self, NoSuchRope> {
        let mut random = SplitMix64::new(seed);
        (0..TRIES)
            .find_map(|_| Self::draft(options, eye, &mut random))
            .ok_or(NoSuchRope)
    }

    /// Makes a rope along these points, mm, resampled at equal steps.
    pub fn along(points: &[[f64; 3]], radius_mm: f64) -> Self {
        Self {
            points: at_equal_steps(points, TRUE_POINTS),
            radius_mm,
            crossings: Vec::new(),
        }
    }

    /// Returns the first and the last end.
    pub(super) fn ends(&self) -> [End; 2] {
        let [first, .., last] = &self.points[..] else {
            return [End::default(); 2];
        };
        let [second, before] = [self.points[1], self.points[self.points.len() - 2]];
        [End::of(*first, second), End::of(*last, before)]
    }

    fn draft(options: &LiftOptions, eye: &Eye, random: &mut SplitMix64) -> Option<Self> {
        let diameter = 2.0 * options.radius_mm;
        let ground = heading(options, random);
        if bends_tighter(&ground, TIGHTEST * diameter) {
            return None;
        }
        let mut points = lifted(&ground, options, random);
        if !is_inside(&points, eye) {
            return None;
        }
        let crossed = crossings(&points, eye, diameter)?;
        if crossed.len() != options.crossings {
            return None;
        }
        let mut order = Vec::new();
        for [early, late] in crossed {
            let (over, under) = if random.unit() < 0.5 {
                (early, late)
            } else {
                (late, early)
            };
            lay_over(&mut points, over, under, diameter);
            order.push([over, under]);
        }
        // A strand that passes over another one appears at a slightly different place.
        if crossings(&points, eye, diameter)?.len() != options.crossings || !is_inside(&points, eye)
        {
            return None;
        }
        let arcs = arcs(&points);
        let length = arcs[points.len() - 1];
        Some(Self {
            points: at_equal_steps(&points, TRUE_POINTS),
            radius_mm: options.radius_mm,
            crossings: order
                .iter()
                .map(|pair| pair.map(|i| arcs[i] / length))
                .collect(),
        })
    }
}

/// An end of a rope, cut off square.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct End {
    at: [f64; 3],
    /// Outward direction at the end, of length 1.
    pub(crate) outward: [f64; 3],
}

impl End {
    /// Makes an end from a point of a line and the point before it.
    pub(crate) fn of(at: [f64; 3], before: [f64; 3]) -> Self {
        let way = [0, 1, 2].map(|k| at[k] - before[k]);
        let length = dot(way, way).sqrt();
        Self {
            at,
            outward: way.map(|c| if length > 0.0 { c / length } else { 0.0 }),
        }
    }

    /// Transforms the end to a camera's frame.
    pub(crate) fn seen_by(&self, eye: &Eye) -> Self {
        Self {
            at: eye.see(self.at),
            outward: eye.rotation.map(|row| dot(row, self.outward)),
        }
    }

    /// Returns whether a ball around `center` reaches beyond the end.
    pub(crate) fn is_within(&self, radius: f64, center: [f64; 3]) -> bool {
        let way = [0, 1, 2].map(|k| center[k] - self.at[k]);
        dot(way, way) < radius * radius
    }

    /// Returns the depth at which a ray enters the part of a ball that remains after the cut.
    /// `near` and `far` are the depths at which the ray enters and leaves the whole ball. `None` if
    /// the ray misses the remaining part.
    pub(crate) fn cut(&self, ray: [f64; 3], [near, far]: [f64; 2]) -> Option<f64> {
        let beyond = |depth: f64| {
            let way = [0, 1, 2].map(|k| depth * ray[k] - self.at[k]);
            dot(way, self.outward)
        };
        match [beyond(near) > 0.0, beyond(far) > 0.0] {
            [false, _] => Some(near),
            [true, true] => None,
            [true, false] => Some(dot(self.at, self.outward) / dot(ray, self.outward)),
        }
    }
}

/// Makes a line on the table, with its middle at the origin.
fn heading(options: &LiftOptions, random: &mut SplitMix64) -> Vec<[f64; 2]> {
    let begin = random.uniform(0.0, TAU);
    let spin = random.uniform(-1.0, 1.0)
        * if options.crossings > 0 {
            2.5 * TAU
        } else {
            2.0
        };
    let waves = [1.0, 2.0, 3.0, 4.0].map(|k| {
        let most = if options.crossings > 0 { 3.0 } else { 1.6 };
        (k, random.uniform(-most, most) / k, random.uniform(0.0, TAU))
    });
    let step = options.length_mm / (DRAFT - 1) as f64;
    let mut at = [0.0; 2];
    let mut line = vec![at];
    for i in 1..DRAFT {
        let share = (i as f64 - 0.5) / (DRAFT - 1) as f64;
        let angle = begin
            + spin * share
            + waves
                .iter()
                .map(|&(k, high, phase)| high * libm::sin(TAU * k * share + phase))
                .sum::<f64>();
        let (sin, cos) = libm::sincos(angle);
        at = [at[0] + step * cos, at[1] + step * sin];
        line.push(at);
    }
    let middle = [0, 1].map(|axis| {
        let of_axis = || line.iter().map(|p| p[axis]);
        0.5 * (of_axis().fold(f64::MAX, f64::min) + of_axis().fold(f64::MIN, f64::max))
    });
    line.iter()
        .map(|p| [0, 1].map(|axis| p[axis] - middle[axis]))
        .collect()
}

/// Lifts the line off the table at one or two places, as grippers would.
fn lifted(ground: &[[f64; 2]], options: &LiftOptions, random: &mut SplitMix64) -> Vec<[f64; 3]> {
    let count = if options.lift_mm > 0.0 {
        1 + random.below(2)
    } else {
        0
    };
    let lifts: Vec<[f64; 3]> = (0..count)
        .map(|_| {
            let at = random.unit() * options.length_mm;
            let high = options.lift_mm * random.uniform(0.5, 1.0);
            // No steeper than about 50 degrees.
            [at, high, (1.3 * high).max(60.0) * random.uniform(1.0, 1.6)]
        })
        .collect();
    let step = options.length_mm / (DRAFT - 1) as f64;
    let height = |i: usize| {
        let lift = |&[at, high, reach]: &[f64; 3]| {
            high * smoothstep(1.0 - (i as f64 * step - at).abs() / reach)
        };
        options.radius_mm + lifts.iter().map(lift).fold(0.0, f64::max)
    };
    let lines = ground.iter().enumerate();
    lines.map(|(i, &[x, y])| [x, y, height(i)]).collect()
}

/// Lifts the strand at `over` onto the strand at `under`, unless it is already above that strand.
fn lay_over(points: &mut [[f64; 3]], over: usize, under: usize, diameter: f64) {
    let step = distance(points[over], points[(over + 1).min(points.len() - 1)]).max(1e-9);
    let missing = points[under][2] + diameter - points[over][2];
    let reach = 4.0 * diameter + 1.5 * missing.max(0.0);
    for (i, point) in points.iter_mut().enumerate() {
        let away = (i as f64 - over as f64).abs() * step;
        point[2] += missing.max(0.0) * smoothstep(1.0 - away / reach);
    }
}

/// Finds the self-crossings in the picture, with the earlier point first; `None` if a crossing is
/// flat or strands come too close.
fn crossings(points: &[[f64; 3]], eye: &Eye, diameter: f64) -> Option<Vec<[usize; 2]>> {
    let seen: Vec<[f64; 3]> = points.iter().map(|&p| eye.see(p)).collect();
    if seen.iter().any(|p| p[2] < 100.0) {
        return None;
    }
    let line: Vec<[f64; 2]> = seen.iter().map(|&p| eye.pixel(p)).collect();
    let wide = |i: usize| eye.focal_px[0] * diameter / seen[i][2];
    let arcs = arcs(points);
    let mut found: Vec<[usize; 2]> = Vec::new();
    for i in 0..line.len() - 1 {
        for j in i + 2..line.len() - 1 {
            if let Some(sine) = meet([line[i], line[i + 1]], [line[j], line[j + 1]]) {
                if sine < libm::sin(FLATTEST_DEG.to_radians()) {
                    return None;
                }
                found.push([i, j]);
            }
        }
    }
    let spots: Vec<f64> = found.iter().flatten().map(|&i| arcs[i]).collect();
    let last = arcs[points.len() - 1];
    for (k, &spot) in spots.iter().enumerate() {
        let to_others = spots[k + 1..].iter().map(|other| (other - spot).abs());
        let nearest = to_others
            .chain([spot, last - spot])
            .fold(f64::MAX, f64::min);
        if nearest < CROSSINGS_APART * diameter {
            return None;
        }
    }
    // Elsewhere the strands keep apart. Every fourth point is sufficient.
    let reach = CROSSINGS_APART * diameter;
    for i in (0..line.len()).step_by(4) {
        for j in (i + 4..line.len()).step_by(4) {
            let is_far_along = arcs[j] - arcs[i] > 2.0 * reach;
            let crosses = |&[a, b]: &[usize; 2]| {
                (arcs[i] - arcs[a]).abs() < reach && (arcs[j] - arcs[b]).abs() < reach
            };
            let off = [0, 1].map(|c| line[i][c] - line[j][c]);
            let least = APART * wide(i).max(wide(j));
            let is_near = off[0] * off[0] + off[1] * off[1] < least * least;
            if is_far_along && is_near && !found.iter().any(crosses) {
                return None;
            }
        }
    }
    Some(found)
}

/// Sine of the angle at which two segments intersect, if they do.
fn meet(a: [[f64; 2]; 2], b: [[f64; 2]; 2]) -> Option<f64> {
    let way = |s: [[f64; 2]; 2]| [s[1][0] - s[0][0], s[1][1] - s[0][1]];
    let cross = |p: [f64; 2], q: [f64; 2]| p[0] * q[1] - p[1] * q[0];
    let (u, v, w) = (way(a), way(b), [b[0][0] - a[0][0], b[0][1] - a[0][1]]);
    let whole = cross(u, v);
    let (s, t) = (cross(w, v) / whole, cross(w, u) / whole);
    let meets = (0.0..1.0).contains(&s) && (0.0..1.0).contains(&t);
    let length = |p: [f64; 2]| libm::hypot(p[0], p[1]);
    meets.then(|| whole.abs() / (length(u) * length(v)))
}

fn bends_tighter(line: &[[f64; 2]], radius: f64) -> bool {
    line.windows(3).step_by(2).any(|p| {
        let (a, b) = (
            [p[1][0] - p[0][0], p[1][1] - p[0][1]],
            [p[2][0] - p[1][0], p[2][1] - p[1][1]],
        );
        let step = libm::hypot(a[0], a[1]);
        let sine = (a[0] * b[1] - a[1] * b[0]) / (step * step);
        sine.abs() > step / radius
    })
}

/// Returns whether the points are within the inner nine tenths of the picture.
fn is_inside(points: &[[f64; 3]], eye: &Eye) -> bool {
    points.iter().step_by(5).all(|&p| {
        let at = eye.pixel(eye.see(p));
        (0..2).all(|k| {
            let side = eye.size[k] as f64;
            (0.05 * side..0.95 * side).contains(&at[k])
        })
    })
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    [0, 1, 2]
        .map(|k| (a[k] - b[k]) * (a[k] - b[k]))
        .iter()
        .sum::<f64>()
        .sqrt()
}

/// Arc length up to each point.
fn arcs(points: &[[f64; 3]]) -> Vec<f64> {
    let mut arcs = vec![0.0];
    for pair in points.windows(2) {
        arcs.push(arcs[arcs.len() - 1] + distance(pair[0], pair[1]));
    }
    arcs
}

fn at_equal_steps(points: &[[f64; 3]], count: usize) -> Vec<[f64; 3]> {
    let arcs = arcs(points);
    let length = arcs[points.len() - 1];
    let mut i = 0;
    (0..count)
        .map(|k| {
            let at = length * k as f64 / (count - 1) as f64;
            while i + 2 < points.len() && arcs[i + 1] < at {
                i += 1;
            }
            let share = ((at - arcs[i]) / (arcs[i + 1] - arcs[i])).clamp(0.0, 1.0);
            [0, 1, 2].map(|axis| points[i][axis] + share * (points[i + 1][axis] - points[i][axis]))
        })
        .collect()
}
