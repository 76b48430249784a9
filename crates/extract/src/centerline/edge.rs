//! The two edges of a rope in one of its cross-sections: where, from its middle outward, the difference falls below a
//! level. A few places about where the rope's width says that they lie are read at once, for both edges of many sections;
//! that is enough for nearly all. The rest is sought step by step.

use crate::image::gray::GrayPlane;
use crate::image::ray::{LANES, Lanes, Rays};
use crate::vec2::{self, Vec2};

/// The part of a half-width around the center where no edge is looked for: shine lies there.
const CORE: f32 = 0.35;
/// The least distance between places that are read: over a whole pixel a sharp edge is no straight line, and 0.01 px would
/// be lost.
const STEP_PX: f32 = 0.5;

/// The distances along −`normal` and +`normal` at which the difference falls below each level, those that are not
/// `known` (not a number), of a section that may leave the image. Where that ends before one edge, the other and the
/// rope's width tell.
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

/// Where an edge is sought first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Seek {
    /// Where the rope's width says that it is.
    Near,
    /// From the core on outward: at a tip, sections that run through its corners come out of the rope and in again.
    Inside,
}

impl Seek {
    /// How far from the section's center the search begins.
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

/// Places about each edge that are read at once, and how many of them lie before the first that is looked at: hardly
/// any edge lies farther off.
const BATCH: usize = 4;
const BEFORE: usize = 1;
/// Both edges' places.
pub(crate) const PLACES: usize = 2 * BATCH;

/// Distance between the places of a section that are read.
pub(crate) fn step_px(half_px: f32) -> f32 {
    (half_px / 12.0).max(STEP_PX)
}

/// The first place that is read at an edge.
fn first_px(half_px: f32) -> f32 {
    half_px - (BEFORE as f32 + 0.5) * step_px(half_px)
}

/// Where the values for [`near`] are read: from the inside outward, the −normal's first.
pub(crate) fn places(half_px: f32) -> [f32; PLACES] {
    std::array::from_fn(|k| {
        let out = first_px(half_px) + step_px(half_px) * (k % BATCH) as f32;
        if k < BATCH { -out } else { out }
    })
}

/// How far that is from the middle at most.
pub(crate) fn reach_px(half_px: f32) -> f32 {
    first_px(half_px) + step_px(half_px) * BATCH as f32
}

/// The distances of both edges in each lane, as [`edges`] seeks them near where the rope's width says that they are; not
/// a number where they lie farther off.
#[inline(always)]
pub(crate) fn near(values: &[Lanes; PLACES], levels: &[Lanes; 2], half_px: f32) -> [Lanes; 2] {
    let mut found = [[f32::NAN; LANES]; 2];
    let (left, right) = values.split_at(BATCH);
    for ((found, values), levels) in found.iter_mut().zip([left, right]).zip(levels) {
        for l in 0..LANES {
            let level = levels[l];
            let is_in = |k: usize| values[k][l] >= level;
            // From the start outward, or inward, whichever way the edge lies: the first step that crosses the level.
            let mut steps = f32::NAN;
            for k in (0..BATCH - 1).rev() {
                let (high, low) = (values[k][l], values[k + 1][l]);
                let is_next = is_in(k) & !is_in(k + 1);
                let is_sought = is_in(BEFORE) == (k >= BEFORE);
                let here = k as f32 + (high - level) / (high - low);
                steps = if is_next & is_sought { here } else { steps };
            }
            // Of ropes hardly wider than a pixel the first place lies within the core, where no edge is looked for.
            let in_core = (first_px(half_px) < CORE * half_px) & (steps < 1.0);
            let place = first_px(half_px) + step_px(half_px) * steps;
            found[l] = if in_core { f32::NAN } else { place };
        }
    }
    found
}

/// Places that are read at once where an edge is sought.
const SOUGHT: usize = 4;

/// Edges that are sought step by step, one in each lane.
#[derive(Debug, Default)]
pub(crate) struct Sought {
    /// From the middle of the rope across its edge.
    pub(crate) rays: Rays,
    pub(crate) levels: Lanes,
    /// Where the search begins, and where it ends.
    pub(crate) from_px: Lanes,
    pub(crate) reach_px: Lanes,
}

impl Sought {
    /// The edges' distances, as [`edge`] finds them along lines that stay within the plane a step farther than their
    /// reach; not a number where they are out of it.
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

/// Where the difference, which `read` tells for a distance as long as it lies in the image, falls below `level`: sought
/// from where the rope's width says that it does, inward or outward, whichever way it lies.
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

    /// A rope up and down at x = 40, of this half-width and blur, as bright as a cosine and some stripes make it.
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
        /// What is read at once, or in lanes, is what a step after the other finds.
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
                    // Places are told apart by 1/256 px.
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
