//! Finds the ropes' own cast shadow in the automatic mask.
//!
//! A shadow has the table's color in less light, but so has a gray rope. A shadow is also a copy of
//! the rope that casts it, moved by one step that is the same for all ropes. The mask is therefore
//! split by color, or by light if nothing in it has another color. Then the step is sought that
//! carries one part onto the other.
//!
//! A rope parallel to another keeps its distance but not the step: the two differ where the rope
//! bends. Along a straight rope, the result stays in doubt.

use super::background::Background;
use super::shadow;
use crate::bitmap::bits::{BitPlane, left_of, right_of};
use crate::image::Image;
use crate::vec2::{self, Vec2};
use std::ops::Range;

/// Number of mask pixels in the first sample, and in the second. The second is taken if half the
/// needed share of the first may be shadow.
const FIRST: usize = 64;
const GLANCE: usize = 400;
/// Minimum share of these pixels that have the table's color, for a notable shadow. Also the
/// minimum share of other colors for telling ropes from shadow by color. With fewer, ropes and
/// shadow are separated by their light.
const SOME: f32 = 0.06;
/// Minimum difference between the light of ropes and that of shadow. Also the minimum share of the
/// light's variance that this difference explains. On a rope lit from one side, light is spread
/// evenly, for which this share is three quarters.
const APART: f32 = 0.15;
const PARTED: f32 = 0.85;
/// The ropes' interior is used if it contains at least one in this many of their pixels.
const INSIDE: usize = 2;
/// Number of places of each part that are compared with the other part.
const PLACES: usize = 256;
/// Minimum and maximum step of the search, in rope widths.
const STEPS: (f32, f32) = (0.35, 5.0);
/// Minimum share of the shadow that the step carries the ropes onto, and of the ropes that it
/// carries onto less light.
const CARRIED: (f32, f32) = (0.8, 0.9);
/// If the step does not carry the ropes onto `ALL` of the mask's shadow, it must carry `ALL` of
/// them onto less light and `MOST` of them onto that shadow. A rope that touches another does not
/// meet both conditions.
const MOST: f32 = 0.75;
const ALL: f32 = 0.95;
/// A step below this many widths leads to a rope's own dark side if the shares carried in both
/// directions sum to less than `BOTH_WAYS`.
const NEAR: f32 = 1.6;
const BOTH_WAYS: f32 = 1.7;
/// A step is judged only if it carries at least one in this many of the ropes' places off the
/// ropes.
const SEEN: i32 = 8;
/// Maximum share that a step one width away from the best may carry, relative to the share of the
/// best. Above it, the best step is in doubt.
const SHARP: f32 = 0.75;
/// Width of a shadow's soft edge beyond the rope's, in rope widths.
const SOFT: f32 = 0.35;
/// One in this many places of a shadow is its darkest. Pixels with less than `DARKER` of the light
/// there are a rope's dark side, not shadow.
const DARKEST: usize = 10;
const DARKER: f32 = 0.85;

/// The part of a mask that is shadow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Cast {
    /// No part.
    #[default]
    None,
    /// The pixels set in the plane, unless they are a rope parallel to another.
    Maybe,
    /// The pixels set in the plane.
    Sure,
}

/// Memory and result of the step.
#[derive(Debug, Default)]
pub(crate) struct Shadows {
    lights: Vec<f32>,
    body: BitPlane,
    spare: BitPlane,
    bodies: Vec<[i32; 2]>,
    pales: Vec<[i32; 2]>,
    /// Pixels of the mask that are or may be shadow.
    pub(crate) plane: BitPlane,
}

impl Shadows {
    /// Reserves the buffers for images of this size.
    pub(crate) fn reserve(&mut self, width: usize, height: usize) {
        self.lights.reserve(4 * GLANCE);
        self.bodies.reserve(4 * PLACES);
        self.pales.reserve(4 * PLACES);
        for plane in [&mut self.body, &mut self.spare, &mut self.plane] {
            plane.resize(width, height);
        }
    }

    /// Searches `mask`, in which `area` pixels are set, for the ropes' shadow.
    pub(crate) fn find(
        &mut self,
        image: &Image,
        background: &Background,
        (mask, area): (&BitPlane, usize),
    ) -> Cast {
        for palest in self
            .glance(image, background, mask, area)
            .into_iter()
            .flatten()
        {
            self.part(image, background, mask, palest);
            let pale_area = self.plane.count();
            let body_area = area - pale_area;
            if (pale_area.min(body_area) as f32) < SOME * area as f32 {
                continue;
            }
            shrink(&self.body, &mut self.spare);
            // Use the ropes' interior, unless they are too thin to have one.
            match self.spare.count() {
                inside if INSIDE * inside < body_area => {
                    gather(&self.body, body_area, &mut self.bodies)
                }
                inside => gather(&self.spare, inside, &mut self.bodies),
            }
            gather(&self.plane, pale_area, &mut self.pales);
            let width_px = width_px(&self.body, body_area);
            let is_dim = |at| is_dim(image, background, at);
            if let Some((step, is_sharp)) = self.step(width_px, is_dim) {
                self.keep_carried(image, background, step, width_px);
                return if is_sharp { Cast::Sure } else { Cast::Maybe };
            }
        }
        Cast::None
    }

    /// Minimum light at which pixels of the table's color may be shadow. The first value is for
    /// ropes of other colors and allows any light. The second is for dark ropes and is above their
    /// light.
    fn glance(
        &mut self,
        image: &Image,
        background: &Background,
        mask: &BitPlane,
        area: usize,
    ) -> [Option<f32>; 2] {
        let (mut all, mut others) = (0, 0);
        for (wanted, some) in [(FIRST, 0.5 * SOME), (GLANCE, SOME)] {
            self.lights.clear();
            others = 0;
            for_each_some(mask, area, wanted, |x, y| {
                match shadow::light_left(image, background, [x, y]) {
                    Some(light) if light < 1.0 => self.lights.push(light),
                    _ => others += 1,
                }
            });
            all = self.lights.len() + others;
            if (self.lights.len() as f32) < some * all as f32 {
                return [None; 2];
            }
        }
        self.lights.sort_unstable_by(f32::total_cmp);
        let (dark, parted, apart) = part_in_two(&self.lights);
        let has_others = others as f32 >= SOME * all as f32;
        let is_parted = parted >= PARTED && apart >= APART;
        [
            has_others.then_some(0.0),
            is_parted.then(|| 0.5 * (self.lights[dark - 1] + self.lights[dark])),
        ]
    }

    /// Splits the mask: `plane` gets what has the table's color in at least `palest` light, and
    /// `body` gets the rest. The rope's own edge, which is mixed with the table, stays with the
    /// rope.
    fn part(&mut self, image: &Image, background: &Background, mask: &BitPlane, palest: f32) {
        // The plane of pixels known to be rope is empty.
        self.spare.resize(mask.width(), mask.height());
        self.body.copy_from(mask);
        shadow::clear(image, background, palest, &mut self.body, &self.spare);
        self.plane.copy_from(mask);
        let words = self.plane.words_mut().iter_mut().zip(self.body.words());
        words.for_each(|(pale, body)| *pale &= !body);
        shrink(&self.plane, &mut self.spare);
        grow_within(&mut self.spare, &self.plane, &mut self.body);
        self.plane.copy_from(&self.spare);
        self.body.copy_from(mask);
        let words = self.body.words_mut().iter_mut().zip(self.plane.words());
        words.for_each(|(body, pale)| *body &= !pale);
    }

    /// Finds the step that carries the ropes onto their shadow, and whether it is the only one.
    /// `is_dim` tells where the picture is darker than the table.
    fn step(&self, width_px: f32, is_dim: impl Fn([i32; 2]) -> bool) -> Option<(Vec2, bool)> {
        let onto = |step: Vec2| {
            let by = whole(step);
            let carried = self
                .pales
                .iter()
                .filter(|at| self.body.get(at[0] - by[0], at[1] - by[1]));
            carried.count() as f32 / self.pales.len() as f32
        };
        let from = |step: Vec2| {
            let by = whole(step);
            let moved = self.bodies.iter().map(|at| [at[0] + by[0], at[1] + by[1]]);
            // A shadow on the rope itself or on another rope is not visible.
            let seen = moved.filter(|at| !self.body.get(at[0], at[1]));
            let (mut all, mut dim, mut pale) = (0, 0, 0);
            for at in seen {
                all += 1;
                dim += i32::from(is_dim(at));
                pale += i32::from(self.plane.get(at[0], at[1]));
            }
            if all == 0 || SEEN * all < self.bodies.len() as i32 {
                return (0.0, 0.0);
            }
            (dim as f32 / all as f32, pale as f32 / all as f32)
        };
        let reach_px = STEPS.1 * width_px;
        let hop_px = (width_px / 3.0).max(1.0);
        let hops = (reach_px / hop_px) as i32;
        let mut best = ([0.0; 2], 0.0);
        let mut seek = |middle: Vec2, hop_px: f32, hops: i32| {
            for j in -hops..=hops {
                let mut carried = Carried::default();
                for i in -hops..=hops {
                    let step = vec2::add(middle, [hop_px * i as f32, hop_px * j as f32]);
                    let far_px = vec2::norm(step);
                    if far_px < STEPS.0 * width_px || far_px > reach_px {
                        continue;
                    }
                    let count = carried.by(whole(step), &self.pales, &self.body);
                    let share = count as f32 / self.pales.len() as f32;
                    if share > best.1 {
                        best = (step, share);
                    }
                }
            }
            best
        };
        let (rough, _) = seek([0.0; 2], hop_px, hops);
        let (step, share) = seek(rough, (hop_px / 4.0).max(1.0), 4);
        if share < CARRIED.0 {
            return None;
        }
        let (dim, pale) = from(step);
        let is_another = share < ALL && (dim < ALL || pale < MOST);
        let is_own_side = vec2::norm(step) < NEAR * width_px && share + pale < BOTH_WAYS;
        if dim < CARRIED.1 || is_another || is_own_side {
            return None;
        }
        let around = (0..8).map(|k| {
            let (sin, cos) = AROUND[k];
            onto(vec2::add(step, [width_px * cos, width_px * sin]))
        });
        Some((step, around.fold(0.0, f32::max) <= SHARP * share))
    }

    /// Keeps only those pixels of the plane that the step carries the ropes or their soft edge
    /// onto. Also removes pixels darker than a shadow.
    fn keep_carried(&mut self, image: &Image, background: &Background, step: Vec2, width_px: f32) {
        let light =
            |x: usize, y: usize| shadow::light_left(image, background, [x, y]).unwrap_or(0.0);
        self.lights.clear();
        let places = self.pales.iter();
        self.lights
            .extend(places.map(|at| light(at[0] as usize, at[1] as usize)));
        let (_, darkest, _) =
            (self.lights).select_nth_unstable_by(self.pales.len() / DARKEST, f32::total_cmp);
        let darkest = DARKER * *darkest;
        let soft_px = (SOFT * width_px).max(1.5);
        let by: [[i32; 2]; 9] = std::array::from_fn(|k| {
            let (sin, cos) = if k < 8 { AROUND[k] } else { (0.0, 0.0) };
            whole(vec2::add(step, [soft_px * cos, soft_px * sin]))
        });
        self.spare.copy_from(&self.plane);
        let Self {
            spare, plane, body, ..
        } = self;
        for_each_some(spare, 1, 1, |x, y| {
            let carried = by
                .iter()
                .any(|by| body.get(x as i32 - by[0], y as i32 - by[1]));
            if !carried || light(x, y) < darkest {
                plane.fill(y, x, x + 1, false);
            }
        });
    }
}

/// Counts the places that come from a body's pixels, for 64 adjacent steps at once. `digits` holds
/// the binary digits of all 64 counts, the lowest first.
#[derive(Default)]
struct Carried {
    digits: [u64; 16],
    /// The steps along x.
    steps: Range<i32>,
}

impl Carried {
    /// The count for a step, which must be in the same row as those of earlier calls.
    fn by(&mut self, [x, y]: [i32; 2], places: &[[i32; 2]], body: &BitPlane) -> u32 {
        if !self.steps.contains(&x) {
            (self.digits, self.steps) = ([0; 16], x..x + 64);
            for at in places {
                // A longer step comes from farther left.
                let mut carry = body.bits_from(at[0] - x - 63, at[1] - y);
                for digit in &mut self.digits {
                    (*digit, carry) = (*digit ^ carry, *digit & carry);
                    if carry == 0 {
                        break;
                    }
                }
            }
        }
        let bit = 63 - (x - self.steps.start);
        let digits = self.digits.iter().rev();
        digits.fold(0, |number, digit| 2 * number + (digit >> bit & 1) as u32)
    }
}

/// Eight directions, as sine and cosine.
const AROUND: [(f32, f32); 8] = {
    const D: f32 = std::f32::consts::FRAC_1_SQRT_2;
    [
        (0.0, 1.0),
        (D, D),
        (1.0, 0.0),
        (D, -D),
        (0.0, -1.0),
        (-D, -D),
        (-1.0, 0.0),
        (-D, D),
    ]
};

fn whole(step: Vec2) -> [i32; 2] {
    step.map(|c| libm::roundf(c) as i32)
}

/// Returns whether the picture has the table's color in clearly less light at a place. True outside
/// the picture.
fn is_dim(image: &Image, background: &Background, [x, y]: [i32; 2]) -> bool {
    if x < 0 || y < 0 || x as usize >= image.width() || y as usize >= image.height() {
        return true;
    }
    shadow::light_left(image, background, [x as usize, y as usize])
        .is_some_and(|light| light < 0.93)
}

/// Splits sorted numbers into the two most distinct parts (Otsu, "A threshold selection method from
/// gray-level histograms", 1979). Returns the size of the lower part, the share of the variance
/// between the parts, and the distance of their means.
fn part_in_two(sorted: &[f32]) -> (usize, f32, f32) {
    let count = sorted.len() as f32;
    let sum: f32 = sorted.iter().sum();
    let mean = sum / count;
    let variance: f32 = sorted.iter().map(|x| (x - mean) * (x - mean)).sum::<f32>() / count;
    let (mut best, mut lower) = ((0, 0.0, 0.0), 0.0);
    for k in 1..sorted.len() {
        lower += sorted[k - 1];
        let share = k as f32 / count;
        let apart = (sum - lower) / (count - k as f32) - lower / k as f32;
        let between = share * (1.0 - share) * apart * apart;
        if between > best.1 {
            best = (k, between, apart);
        }
    }
    (best.0, best.1 / variance.max(1e-9), best.2)
}

/// Calls `visit` with about `wanted` of the plane's `area` set pixels, spread evenly, or with all
/// if there are fewer.
pub(super) fn for_each_some(
    plane: &BitPlane,
    area: usize,
    wanted: usize,
    mut visit: impl FnMut(usize, usize),
) {
    let stride = ((area / wanted) as f32).sqrt().floor().max(1.0) as usize;
    let every = (0..64)
        .step_by(stride)
        .fold(0, |bits, bit| bits | 1u64 << bit);
    for y in (0..plane.height()).step_by(stride) {
        for (i, &row_word) in plane.row(y).iter().enumerate() {
            if row_word == 0 {
                continue;
            }
            let first = (64 * i).next_multiple_of(stride) - 64 * i;
            let mut word = row_word & every.checked_shl(first as u32).unwrap_or(0);
            while word != 0 {
                visit(64 * i + word.trailing_zeros() as usize, y);
                word &= word - 1;
            }
        }
    }
}

/// Lists some places of a plane.
fn gather(plane: &BitPlane, area: usize, places: &mut Vec<[i32; 2]>) {
    places.clear();
    for_each_some(plane, area, PLACES, |x, y| {
        places.push([x as i32, y as i32])
    });
}

/// Width of a long shape in pixels, from its area and its outline; see `outline`.
fn width_px(plane: &BitPlane, area: usize) -> f32 {
    let mut sides = 0;
    for y in 0..plane.height() {
        let row = plane.row(y);
        for (i, &word) in row.iter().enumerate() {
            let above = if y > 0 { plane.row(y - 1)[i] } else { 0 };
            sides += 2 * ((word & !left_of(row, i)).count_ones() + (word & !above).count_ones());
        }
    }
    2.0 * area as f32 / (sides as f32 * std::f32::consts::FRAC_PI_4).max(1.0)
}

/// Sets `out` to the pixels whose four nearest neighbors are all set.
fn shrink(plane: &BitPlane, out: &mut BitPlane) {
    out.copy_from(plane);
    for y in 0..plane.height() {
        for i in 0..plane.words_per_row() {
            let row = plane.row(y);
            let above = if y > 0 { plane.row(y - 1)[i] } else { 0 };
            let below = if y + 1 < plane.height() {
                plane.row(y + 1)[i]
            } else {
                0
            };
            out.row_mut(y)[i] &= left_of(row, i) & right_of(row, i) & above & below;
        }
    }
}

/// Adds to `plane` the pixels of `limits` that touch it.
fn grow_within(plane: &mut BitPlane, limits: &BitPlane, spare: &mut BitPlane) {
    spare.copy_from(plane);
    for y in 0..plane.height() {
        for i in 0..plane.words_per_row() {
            let wide = |y: usize| {
                let row = spare.row(y);
                row[i] | left_of(row, i) | right_of(row, i)
            };
            let mut word = wide(y);
            word |= if y > 0 { wide(y - 1) } else { 0 };
            word |= if y + 1 < spare.height() {
                wide(y + 1)
            } else {
                0
            };
            plane.row_mut(y)[i] |= word & limits.row(y)[i];
        }
    }
}
