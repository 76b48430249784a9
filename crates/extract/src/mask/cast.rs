//! The ropes' own cast shadow in the automatic mask, told from the ropes.
//!
//! A shadow has the table's color in less light, which a gray rope has too. But it is also a copy of the rope that casts
//! it, moved by one step that is the same for all of them: so the mask is parted by color, or by light where nothing in it
//! has another color, and the step is sought that carries the one part onto the other. A rope that runs parallel to
//! another keeps its distance and not the step: the two differ where the rope bends. Where it does not bend, nothing but
//! doubt is left.

use super::background::Background;
use super::shadow;
use crate::bitmap::bits::{BitPlane, left_of, right_of};
use crate::image::Image;
use crate::vec2::{self, Vec2};
use std::ops::Range;

/// Pixels of the mask that are looked at first, and, if as much of them may be shadow as is to be half sure, then.
const FIRST: usize = 64;
const GLANCE: usize = 400;
/// Shares of them that have the table's color, below which there is no shadow to speak of, and above which ropes must be
/// told from it by their light.
const SOME: f32 = 0.06;
/// The light of ropes and of shadow lie apart by so much, and so much of the light's variance is between the two: that of a
/// rope that is lit from one side spreads evenly, and has three quarters.
const APART: f32 = 0.15;
const PARTED: f32 = 0.85;
/// The least share of ropes, one in so many, that is inside of their edges.
const INSIDE: usize = 2;
/// Places of either part that are held against the other.
const PLACES: usize = 256;
/// The steps looked for, in widths of the rope.
const STEPS: (f32, f32) = (0.35, 5.0);
/// The least shares of the shadow that the step carries the ropes onto, and of the ropes that it carries onto less light.
const CARRIED: (f32, f32) = (0.8, 0.9);
/// If the step does not carry the ropes onto all of the shadow that is in the mask, then it must carry all of them onto less
/// light, and most of them onto that shadow: a rope that touches another has not both.
const MOST: f32 = 0.75;
const ALL: f32 = 0.95;
/// A rope's own dark side lies within so many widths, and the shares that are carried either way add up to less than this.
const NEAR: f32 = 1.6;
const BOTH_WAYS: f32 = 1.7;
/// One in so many of the ropes' places must be carried to where no rope lies, to tell.
const SEEN: i32 = 8;
/// A step that is a width off carries at most this share of it, or the step is not sure.
const SHARP: f32 = 0.75;
/// How far a shadow's soft edge reaches beyond the rope's, in widths.
const SOFT: f32 = 0.35;
/// One in so many places of a shadow is its darkest, and what has this share of that light is no shadow: a rope's dark side.
const DARKEST: usize = 10;
const DARKER: f32 = 0.85;

/// What of a mask is shadow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Cast {
    /// Nothing.
    #[default]
    None,
    /// What is set in the plane, or it is a rope parallel to another.
    Maybe,
    /// What is set in the plane.
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
    /// The pixels of the mask that are shadow, or may be.
    pub(crate) plane: BitPlane,
    pub(crate) cast: Cast,
}

impl Shadows {
    /// Makes the buffers for images of this size.
    pub(crate) fn reserve(&mut self, width: usize, height: usize) {
        self.lights.reserve(4 * GLANCE);
        self.bodies.reserve(4 * PLACES);
        self.pales.reserve(4 * PLACES);
        for plane in [&mut self.body, &mut self.spare, &mut self.plane] {
            plane.resize(width, height);
        }
    }

    /// Looks for the ropes' shadow in `mask`, in which `area` pixels are set.
    pub(crate) fn find(
        &mut self,
        image: &Image,
        background: &Background,
        (mask, area): (&BitPlane, usize),
    ) -> Cast {
        self.cast = Cast::None;
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
            // Their inside, unless they are too thin to have one.
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
                self.cast = if is_sharp { Cast::Sure } else { Cast::Maybe };
                break;
            }
        }
        self.cast
    }

    /// From which light on pixels of the table's color may be shadow: any, where ropes have other colors, and that above
    /// the light of dark ropes.
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

    /// Parts the mask into what has the table's color in at least this light, in `plane`, and the rest. The rope's own
    /// edge, which is mixed with the table, stays with the rope.
    fn part(&mut self, image: &Image, background: &Background, mask: &BitPlane, palest: f32) {
        // Nothing is surely the rope's.
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

    /// The step that carries the ropes onto their shadow, if there is one, and whether no other does. `is_dim` says where
    /// the picture is darker than the table.
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
            // On itself or another rope no shadow is seen.
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

    /// Leaves in the plane what the step carries the ropes onto, and the soft edge of it, but for what is darker.
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

/// How many places come from a body's pixels by 64 steps side by side: the digits of all 64 numbers, the lowest first.
#[derive(Default)]
struct Carried {
    digits: [u64; 16],
    /// The steps along x.
    steps: Range<i32>,
}

impl Carried {
    /// How many do by a step, which lies in the same row as those asked for before.
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

/// Eight directions, by sine and cosine.
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

/// Whether the picture has the table's color in clearly less light at a place. Beyond the picture it may.
fn is_dim(image: &Image, background: &Background, [x, y]: [i32; 2]) -> bool {
    if x < 0 || y < 0 || x as usize >= image.width() || y as usize >= image.height() {
        return true;
    }
    shadow::light_left(image, background, [x as usize, y as usize])
        .is_some_and(|light| light < 0.93)
}

/// Where sorted numbers part best in two: how many are in the lower part, the share of the variance that is between the
/// two, and how far their means are apart (Otsu, "A threshold selection method from gray-level histograms", 1979).
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

/// Calls `visit` with about `wanted` of the plane's `area` set pixels, or with all of them, spread evenly.
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

/// Some places of a plane.
fn gather(plane: &BitPlane, area: usize, places: &mut Vec<[i32; 2]>) {
    places.clear();
    for_each_some(plane, area, PLACES, |x, y| {
        places.push([x as i32, y as i32])
    });
}

/// The width of what is long, from its area and its outline: see `mask`.
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

/// The pixels whose neighbors by a side are all set.
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
