//! Finds the two edges of a rope in its cross-sections. An edge is where the difference falls below
//! a level, from the middle outward. The rope's width predicts the edges, and a few places around
//! them are read for many sections at once. This finds nearly all edges. The others are sought step
//! by step.

use crate::image::gray::GrayPlane;
use crate::image::ray::{LANES, Lanes, Rays};
use crate::vec2::{self, Vec2};

/// Part of a half-width around the center where no edge is sought: shine is there.
const CORE: f32 = 0.35;
/// Minimum distance between the places that are read. Over a whole pixel, a sharp edge is not
/// linear, and interpolation would be off by 0.01 px.
const STEP_PX: f32 = 0.5;

/// Finds the distances along −`normal` and +`normal` at which the difference falls below each
/// level. The section may leave the image. Only the distances that are still NaN in `known` are
/// sought. If the image ends before one edge, that edge follows from the other and the rope's
/// width.
pub(crate) fn edges(
    difference: &GrayPlane,
    (center, normal): (Vec2, Vec2),
    levels: [f32; 2],
    known: [f32; 2],
    seek: Seek,
    [half_px, reach_px]: [f32; 2],
) -> Option<[f32; 2]> {
    let mut found = known.map(Edge::At);
    for (k, side) in [-1.0, 1.0].into_iter().enumerate() {
        if known[k].is_nan() {
            let read = |far| {
                let place = vec2::along(center, normal, side * far);
                difference.holds(place).then(|| difference.sample(place))
            };
            found[k] = edge(read, levels[k], seek, half_px, reach_px);
        }
    }
    match found {
        [Edge::At(left), Edge::At(right)] => Some([left, right]),
        [Edge::At(left), Edge::OutOfImage] => Some([left, 2.0 * half_px - left]),
        [Edge::OutOfImage, Edge::At(right)] => Some([2.0 * half_px - right, right]),
        _ => None,
    }
}

/// Starting point of the search for an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Seek {
    /// At the place that the rope's width predicts.
    Near,
    /// From the core outward. At a tip, sections through its corners leave the rope and enter it
    /// again.
    Inside,
}

impl Seek {
    /// Distance from the section's center at which the search begins.
    #[inline(always)]
    pub(crate) fn start_px(self, half_px: f32) -> f32 {
        let core = CORE * half_px;
        match self {
            Seek::Near => (half_px - 0.5 * step_px(half_px)).max(core),
            Seek::Inside => core,
        }
    }
}

/// One edge of a section, at a distance from its center.
#[derive(Clone, Copy, Debug)]
enum Edge {
    At(f32),
    OutOfImage,
    OutOfReach,
}

/// Number of places read at once around each edge, and how many of them are before the one where
/// the search begins. Hardly any edge is farther away.
const BATCH: usize = 4;
const BEFORE: usize = 1;
/// Places around both edges.
pub(crate) const PLACES: usize = 2 * BATCH;

/// Distance between the places of a section that are read.
pub(crate) fn step_px(half_px: f32) -> f32 {
    (half_px / 12.0).max(STEP_PX)
}

/// Distance of the first place read at an edge.
fn first_px(half_px: f32) -> f32 {
    half_px - (BEFORE as f32 + 0.5) * step_px(half_px)
}

/// Places where the values for [`near`] are read: from the inside outward, on the −normal side
/// first.
pub(crate) fn places(half_px: f32) -> [f32; PLACES] {
    std::array::from_fn(|k| {
        let out = first_px(half_px) + step_px(half_px) * (k % BATCH) as f32;
        if k < BATCH { -out } else { out }
    })
}

/// Upper bound of the distance of these places from the middle.
pub(crate) fn reach_px(half_px: f32) -> f32 {
    first_px(half_px) + step_px(half_px) * BATCH as f32
}

/// The distances of both edges in each lane. Like [`edges`], but only near the places that the
/// rope's width predicts; NaN for edges farther away.
#[inline(always)]
pub(crate) fn near(values: &[Lanes; PLACES], levels: &[Lanes; 2], half_px: f32) -> [Lanes; 2] {
    let mut found = [[f32::NAN; LANES]; 2];
    let (left, right) = values.split_at(BATCH);
    for ((found, values), levels) in found.iter_mut().zip([left, right]).zip(levels) {
        for l in 0..LANES {
            let level = levels[l];
            let is_in = |k: usize| values[k][l] >= level;
            // Finds the first step that crosses the level, outward or inward from the start,
            // depending on where the edge is.
            let mut steps = f32::NAN;
            for k in (0..BATCH - 1).rev() {
                let (high, low) = (values[k][l], values[k + 1][l]);
                let is_next = is_in(k) & !is_in(k + 1);
                let is_sought = is_in(BEFORE) == (k >= BEFORE);
                let here = k as f32 + (high - level) / (high - low);
                steps = if is_next & is_sought { here } else { steps };
            }
            // If a rope is hardly wider than a pixel, the first place is within the core, where no
            // edge is sought.
            let in_core = (first_px(half_px) < CORE * half_px) & (steps < 1.0);
            let place = first_px(half_px) + step_px(half_px) * steps;
            found[l] = if in_core { f32::NAN } else { place };
        }
    }
    found
}

/// Number of places read at once in the stepwise search.
const SOUGHT: usize = 4;

/// Edges that are sought step by step, one in each lane.
#[derive(Debug, Default)]
pub(crate) struct Sought {
    /// Rays from the middle of the rope across its edge.
    pub(crate) rays: Rays,
    pub(crate) levels: Lanes,
    /// Distances where the search begins and ends.
    pub(crate) from_px: Lanes,
    pub(crate) reach_px: Lanes,
}

impl Sought {
    /// The edges' distances, as [`edge`] finds them; NaN for those out of reach. The lines must
    /// stay within the plane one step beyond their reach.
    #[inline(always)]
    pub(crate) fn find(&self, difference: &GrayPlane, half_px: f32) -> Lanes {
        let (core, step) = (CORE * half_px, step_px(half_px));
        let (mut at, mut values, mut found) = (self.from_px, [[0.0; LANES]; 1], [f32::NAN; LANES]);
        self.rays.read(difference, &[at], &mut values);
        let [mut here] = values;
        let (mut onward, mut inside, mut open) = ([step; LANES], [true; LANES], [true; LANES]);
        for l in 0..LANES {
            inside[l] = here[l] >= self.levels[l];
            onward[l] = if inside[l] { step } else { -step };
        }
        let mut is_open = true;
        while is_open {
            let (mut far, mut values) = ([[0.0; LANES]; SOUGHT], [[0.0; LANES]; SOUGHT]);
            for (k, far) in far.iter_mut().enumerate() {
                for l in 0..LANES {
                    let next = at[l] + onward[l] * (k + 1) as f32;
                    let next = if next > core { next } else { core };
                    let most = self.reach_px[l] + step;
                    far[l] = if next < most { next } else { most };
                }
            }
            self.rays.read(difference, &far, &mut values);
            for (far, values) in far.iter().zip(&values) {
                for l in 0..LANES {
                    let ends_out = inside[l] & (at[l] >= self.reach_px[l]);
                    let ends_in = !inside[l] & (at[l] <= core);
                    let crosses = (values[l] >= self.levels[l]) != inside[l];
                    let share = (here[l] - self.levels[l]) / (here[l] - values[l]);
                    let place = at[l] + (far[l] - at[l]) * share;
                    let place = if ends_in { core } else { place };
                    let place = if ends_out { f32::NAN } else { place };
                    let ends = ends_out | ends_in | crosses;
                    found[l] = if open[l] & ends { place } else { found[l] };
                    open[l] &= !ends;
                    (at[l], here[l]) = (far[l], values[l]);
                }
            }
            is_open = open.iter().fold(false, |any, &open| any | open);
        }
        found
    }
}

/// Finds where the difference falls below `level`. `read` gives the difference at a distance, or
/// nothing outside of the image. The search starts where the rope's width predicts the edge and
/// goes inward or outward, depending on where the edge is.
#[inline(always)]
fn edge(
    read: impl Fn(f32) -> Option<f32>,
    level: f32,
    seek: Seek,
    half_px: f32,
    reach_px: f32,
) -> Edge {
    let (core, step) = (CORE * half_px, step_px(half_px));
    let between = |(inner, high): (f32, f32), (outer, low): (f32, f32)| {
        inner + (outer - inner) * (high - level) / (high - low)
    };
    let start = seek.start_px(half_px);
    let (mut at, mut value) = (start, read(start));
    match value {
        Some(mut inside) if inside >= level => {
            while at < reach_px {
                let next = at + step;
                match read(next) {
                    None => return Edge::OutOfImage,
                    Some(low) if low < level => {
                        return Edge::At(between((at, inside), (next, low)));
                    }
                    Some(value) => (at, inside) = (next, value),
                }
            }
            Edge::OutOfReach
        }
        _ => {
            while at > core {
                let inner = (at - step).max(core);
                let found = read(inner);
                if let Some(high) = found.filter(|&high| high >= level) {
                    return value.map_or(Edge::OutOfImage, |low| {
                        Edge::At(between((inner, high), (at, low)))
                    });
                }
                (at, value) = (inner, found);
            }
            value.map_or(Edge::OutOfImage, |_| Edge::At(core))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::ray::Ray;
    use proptest::prelude::*;

    /// A vertical rope at x = 40 of this half-width and blur, with stripes of brightness by a sine.
    fn plane(half_px: f32, blur_px: f32, stripes: f32) -> GrayPlane {
        let mut plane = GrayPlane::default();
        plane.resize(80, 60);
        for y in 0..60 {
            for (x, byte) in plane.row_mut(y).iter_mut().enumerate() {
                let beyond = (x as f32 - 40.0).abs() - half_px;
                let rope = (0.5 - beyond / blur_px).clamp(0.0, 1.0);
                let stripe = 1.0 + stripes * (1.3 * x as f32 + 0.7 * y as f32).sin();
                *byte = (150.0 * rope * stripe) as u8;
            }
        }
        plane
    }

    /// A section through such a rope, and how its edges are sought.
    #[derive(Clone, Copy, Debug)]
    struct Case {
        half_px: f32,
        wrong: f32,
        blur_px: f32,
        stripes: f32,
        aside: f32,
        turn: f32,
        level: f32,
        seek: Seek,
    }

    impl Case {
        /// Asserts that reading in batches and in lanes finds the edges that the stepwise search
        /// finds.
        fn check(self) -> Result<(), TestCaseError> {
            let plane = plane(self.half_px, self.blur_px, self.stripes);
            let (center, normal) = (
                [40.0 + self.aside, 30.0],
                [self.turn.cos(), self.turn.sin()],
            );
            let (level, seek, half_px) = (self.level, self.seek, self.wrong * self.half_px);
            let reach_px = 1.6 * half_px + 3.0;
            let ray =
                Ray::new(&plane, center, normal, reach_px + step_px(half_px)).expect("well inside");
            let mut rays = Rays::default();
            rays.lay(3, center, [normal[1], -normal[0]]);
            rays.unify();
            let mut values = [[0.0; LANES]; PLACES];
            rays.read(
                &plane,
                &places(half_px).map(|far| [far; LANES]),
                &mut values,
            );
            let lanes = near(&values, &[[level; LANES]; 2], half_px);
            for (k, side) in [-1.0, 1.0].into_iter().enumerate() {
                let mut sought = Sought::default();
                sought
                    .rays
                    .lay(5, center, [side * normal[1], -side * normal[0]]);
                (sought.levels[5], sought.reach_px[5]) = (level, reach_px);
                sought.from_px[5] = seek.start_px(half_px);
                let along = sought.find(&plane, half_px)[5];
                let along = if along.is_nan() {
                    Edge::OutOfReach
                } else {
                    Edge::At(along)
                };
                let read = |far: f32| Some(ray.at_each([side * far])[0]);
                let stepwise = edge(read, level, seek, half_px, reach_px);
                match (stepwise, along) {
                    // Rays resolve places to 1/256 px.
                    (Edge::At(a), Edge::At(b)) => prop_assert!((a - b).abs() < 0.05, "{a} {b}"),
                    (Edge::OutOfReach, Edge::OutOfReach) => {}
                    (a, b) => prop_assert!(false, "{a:?} {b:?}"),
                }
                if let (Edge::At(a), Seek::Near, false) = (stepwise, seek, lanes[k][3].is_nan()) {
                    prop_assert!((a - lanes[k][3]).abs() < 0.05, "{a} {}", lanes[k][3]);
                }
            }
            Ok(())
        }
    }

    #[test]
    fn an_edge_near_the_core_of_a_thin_rope_is_sought_step_by_step() {
        let case = Case {
            half_px: 1.056_788_8,
            wrong: 0.980_769_9,
            blur_px: 1.487,
            stripes: 0.272_987_37,
            aside: -0.255_492_1,
            turn: 0.0,
            level: 105.220_18,
            seek: Seek::Near,
        };
        case.check().expect("none is found within the core");
    }

    proptest! {
        #[test]
        fn edges_lie_where_they_are_found_step_by_step(
            half_px in 1.0f32..9.0, wrong in 0.75f32..1.3, blur_px in 0.3f32..4.0, stripes in 0.0f32..0.4,
            aside in -2.0f32..2.0, turn in -0.6f32..0.6, level in 30.0f32..110.0, inside: bool,
        ) {
            let seek = if inside { Seek::Inside } else { Seek::Near };
            Case { half_px, wrong, blur_px, stripes, aside, turn, level, seek }.check()?;
        }
    }
}
