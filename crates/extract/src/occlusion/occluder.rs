//! What stands out from the table and is no rope: a gripper, a hand, a tool that lies at a rope.
//!
//! It shows as a place where the mask is far wider than the ropes are, in a color of its own; from
//! there its whole area is taken by color, and of ropes that are known its rim, which is in less
//! light, by width. It is taken out of the mask, so that no curve runs into it or around it; what it
//! hides of a rope is bridged later. Strands that lie close beside each other are wide too, but have
//! the rope's color, or many, and a thick rope among thin ones is long.

use std::ops::Range;

use crate::bitmap::bits::{BitPlane, left_of, right_of};
use crate::bitmap::morphology::Morphology;
use crate::bitmap::spread::spread;
use crate::bitmap::strips::Strips;
use crate::image::{Image, color};
use crate::past::{Past, Rope};
use crate::skeleton::{Pixel, Skeleton};
use crate::statistics::{quantile, quantile_of_positive};
use crate::vec2;
use lariat_portable::{Arch, NullaryFnOnce};

/// The share of the skeleton that is narrower than the ropes usually are.
const USUAL: f32 = 0.35;
/// Times as wide as a rope, and pixels more, that a thing is which is no rope.
const WIDE: (f32, f32) = (2.6, 2.0);
/// The same where the ropes' width is known: more than two strands beside each other.
const WIDE_KNOWN: (f32, f32) = (2.2, 1.0);
/// Times as wide as a rope that a thing of the rope's own color is: no strands lie so close.
const WIDE_ALIKE: f32 = 5.0;
/// Levels of color within which a thing has the rope's own.
const ALIKE: f32 = 28.0;
/// The least share of a thing's middle that has its color: among strands that lie on each other, with shade between them, a third.
const ONE_COLOR: f32 = 0.6;
/// Squares of its own width that a thing covers at most; a rope covers more. Of a rope already known
/// the width is known, and nothing else is asked.
const SQUARES: f32 = 5.0;
/// A pixel is the thing's when its color is nearer to the thing's than this share of its distance to
/// the rope's.
const NEARER: f32 = 0.6;
/// Pixels around a thing that are neither it nor the table.
const RIM: usize = 2;
/// The most things in one image.
const MOST: usize = 6;

/// Memory and result of the step.
#[derive(Debug, Default)]
pub(crate) struct Occluder {
    halves: Vec<f32>,
    channel: Vec<f32>,
    /// Those of a row.
    colors: Vec<u32>,
    alike: BitPlane,
    thing: BitPlane,
    grown: BitPlane,
    morphology: Morphology,
    opened: Strips,
    /// Where the mask is far wider than the ropes.
    wide: BitPlane,
    /// The pixels of all things.
    pub(crate) plane: BitPlane,
    /// Whether there is any.
    found: bool,
}

impl Occluder {
    /// Whether one of the things lies within `reach_px` of a place.
    pub(crate) fn is_near(&self, [x, y]: [f32; 2], reach_px: f32) -> bool {
        let reach = reach_px as i32;
        let (x, y) = (x as i32, y as i32);
        let offsets = || (-reach..=reach).step_by((reach as usize / 4).max(1));
        offsets().any(|dy| offsets().any(|dx| self.plane.get(x + dx, y + dy)))
    }

    /// Makes the buffers for images of this size.
    pub(crate) fn reserve(&mut self, width: usize, height: usize) {
        self.channel.reserve(self.halves.capacity());
        self.colors.reserve(width);
        for plane in [
            &mut self.alike,
            &mut self.thing,
            &mut self.grown,
            &mut self.wide,
            &mut self.plane,
        ] {
            plane.resize(width, height);
        }
        self.opened.take(&self.plane);
        self.morphology.reserve(&self.opened);
    }

    /// Whether there is any.
    pub(crate) fn any(&self) -> bool {
        self.found
    }

    /// Looks for things that are no rope, of which those of the past are known. Where none is known, what has the ropes' color and a
    /// larger half-width than `widest_half_px` is left where it is, as it may have fingers. Returns whether there are any.
    pub(crate) fn find(
        &mut self,
        image: &Image,
        skeleton: &Skeleton,
        (mask, strips): (&BitPlane, &Strips),
        (past, widest_half_px): (&Past, f32),
    ) -> bool {
        let known_half_px = past.widest_half_px();
        let size = [mask.width(), mask.height()];
        if self.found || size != [self.plane.width(), self.plane.height()] {
            self.plane.resize(size[0], size[1]);
            self.found = false;
        }
        let widest_px = skeleton
            .pixels
            .iter()
            .map(|p| p.half_px)
            .fold(0.0, f32::max);
        if known_half_px.is_none() && is_even(skeleton, widest_px) {
            return false;
        }
        self.halves.clear();
        self.halves
            .extend(skeleton.pixels.iter().map(|p| p.half_px));
        let usual_px = || quantile_of_positive(&mut self.halves, USUAL).max(0.5);
        let half_px = known_half_px.unwrap_or_else(usual_px);
        let wide = known_half_px.map_or(WIDE, |_| WIDE_KNOWN);
        let wide_px = wide.0 * half_px + wide.1;
        if widest_px <= wide_px {
            return false;
        }
        let rope = self.rope_color(image, skeleton, half_px);
        if known_half_px.is_some() {
            self.opened.copy_from(strips);
            (self.morphology).open(&mut self.opened, (2.0 * wide_px) as usize);
            self.wide.resize(size[0], size[1]);
            self.opened.put(&mut self.wide);
            (past.live()).for_each(|rope| clear_along(&mut self.wide, rope));
        }
        // Crossings of the ropes themselves are wide, too.
        let mut crossings = [[0.0f32; 3]; MOST];
        for k in 0..MOST {
            let free = |x: u16, y: u16| !self.plane.get(i32::from(x), i32::from(y));
            let is_crossing = |p: &Pixel| {
                let near = |&[x, y, px]: &[f32; 3]| vec2::distance(p.at(), [x, y]) <= px;
                crossings[..k].iter().any(near)
            };
            let widest = skeleton
                .pixels
                .iter()
                .filter(|p| p.half_px > wide_px && free(p.x, p.y) && !is_crossing(p))
                .max_by(|a, b| a.half_px.total_cmp(&b.half_px));
            let Some(widest) = widest else { break };
            let seed = Seed {
                x: usize::from(widest.x),
                y: usize::from(widest.y),
                half_px: widest.half_px,
            };
            let is_known = known_half_px.is_some();
            let widest_half_px = if is_known {
                f32::INFINITY
            } else {
                widest_half_px
            };
            let halves_px = half_px..widest_half_px;
            match self.take(image, mask, &seed, rope, halves_px, is_known) {
                true => self.found = true,
                false if is_known => {
                    crossings[k] = [f32::from(widest.x), f32::from(widest.y), widest.half_px];
                }
                false => break,
            }
        }
        self.found
    }

    /// The typical color of what is about as wide as a rope.
    fn rope_color(&mut self, image: &Image, skeleton: &Skeleton, half_px: f32) -> [f32; 3] {
        let narrow = |half: f32| half <= 1.5 * half_px + 1.0;
        let mut color = [0.0; 3];
        for (c, value) in color.iter_mut().enumerate() {
            self.channel.clear();
            let pixels = skeleton.pixels.iter().filter(|p| narrow(p.half_px));
            self.channel.extend(
                pixels.map(|p| {
                    f32::from(color::native(image, usize::from(p.x), usize::from(p.y))[c])
                }),
            );
            *value = quantile(&mut self.channel, 0.5);
        }
        color
    }

    /// Takes the thing around `seed` into the plane, if it is one.
    fn take(
        &mut self,
        image: &Image,
        mask: &BitPlane,
        seed: &Seed,
        rope: [f32; 3],
        halves_px: Range<f32>,
        known: bool,
    ) -> bool {
        let yuv = color::is_yuv(image.format());
        let own = seed.color(image);
        let most = SQUARES * (4.0 * seed.half_px * seed.half_px);
        self.thing.resize(mask.width(), mask.height());
        seed.fill(&mut self.thing, 0.8);
        if color::distance(own, rope, yuv) <= ALIKE {
            let least_px = WIDE_ALIKE * halves_px.start + WIDE.1;
            if seed.half_px <= least_px || seed.half_px >= halves_px.end {
                return false;
            }
            // Color tells nothing: all that is within the widest place.
            seed.fill(&mut self.thing, 1.1);
            self.alike.copy_from(mask);
        } else {
            let colors = &mut self.colors;
            colors.resize(image.width(), 0);
            let mut like = |share: f32, y: usize, alike: &mut BitPlane| {
                let words = alike.row_mut(y);
                words.copy_from_slice(mask.row(y));
                if words.iter().any(|&word| word != 0) {
                    color::along(image, y, colors);
                    Arch::new().dispatch(Nearer {
                        colors,
                        own,
                        rope,
                        share,
                        yuv,
                        words,
                    });
                }
            };
            self.alike.resize(mask.width(), mask.height());
            let rows = seed.rows(0.8, mask.height());
            rows.clone().for_each(|y| like(NEARER, y, &mut self.alike));
            let all = self.thing.count();
            and(&mut self.thing, &self.alike, rows.clone());
            if !known && (self.thing.count() as f32) < ONE_COLOR * all as f32 {
                return false;
            }
            let most = if known { f32::INFINITY } else { most };
            let like_thing = |y, alike: &mut BitPlane| like(NEARER, y, alike);
            let rows = spread((&mut self.thing, &mut self.alike), rows, most, like_thing);
            let rows = rows.start.saturating_sub(RIM)..(rows.end + RIM).min(mask.height());
            rows.for_each(|y| like(1.0, y, &mut self.alike));
        }
        if !known && self.thing.count() as f32 > most {
            return false;
        }
        for _ in 0..RIM {
            grow(&mut self.thing, &self.alike, &mut self.grown);
        }
        // Of ropes that are not known what is wide beside the thing may be a thicker one.
        if known {
            let planes = (&mut self.thing, &mut self.wide);
            spread(planes, 0..mask.height(), f32::INFINITY, |_, _| {});
        }
        or(&mut self.plane, &self.thing);
        // The seed is judged even where its very pixel was not taken.
        self.plane.fill(seed.y, seed.x, seed.x + 1, true);
        true
    }
}

/// Whether no place is far wider than the ropes usually are: so many are near the widest in width that the usual
/// width, whatever it is exactly, is.
fn is_even(skeleton: &Skeleton, widest_px: f32) -> bool {
    let pixels = &skeleton.pixels;
    // A thousandth more than it takes, for what rounding does.
    let near_px = 1.001 * (widest_px - WIDE.1).max(0.0) / WIDE.0;
    let narrow = pixels.iter().filter(|p| p.half_px < near_px).count();
    narrow <= ((pixels.len().max(1) - 1) as f32 * USUAL) as usize
}

/// Clears what lies along a rope: beside an arm the mask of both is as wide as a thing.
fn clear_along(plane: &mut BitPlane, rope: &Rope) {
    let steps = (2.0 * rope.length_px / rope.width_px) as usize;
    for step in 0..=steps {
        let [x, y] = rope.at(0.5 * rope.width_px * step as f32);
        let reach = |c: f32, most: usize| {
            let from = (c - 0.5 * rope.width_px).max(0.0) as usize;
            let to = (c + 0.5 * rope.width_px).max(0.0) as usize + 1;
            from.min(most)..to.min(most)
        };
        let columns = reach(x, plane.width());
        for row in reach(y, plane.height()) {
            plane.fill(row, columns.start, columns.end, false);
        }
    }
}

/// The middle of a wide place.
struct Seed {
    x: usize,
    y: usize,
    half_px: f32,
}

impl Seed {
    /// The mean color around it.
    fn color(&self, image: &Image) -> [f32; 3] {
        let reach = 0.6 * self.half_px;
        let (mut sum, mut count) = ([0.0; 3], 0.0f32);
        for j in -3i8..=3 {
            for i in -3i8..=3 {
                let offset = [f32::from(i), f32::from(j)].map(|o| o / 3.0 * reach);
                let at = [self.x as f32 + offset[0], self.y as f32 + offset[1]];
                let color = color::between(image, at);
                sum = std::array::from_fn(|c| sum[c] + color[c]);
                count += 1.0;
            }
        }
        sum.map(|s| s / count)
    }

    /// The rows within `share` of the half-width, of so many.
    fn rows(&self, share: f32, height: usize) -> Range<usize> {
        let reach = (share * self.half_px) as usize;
        self.y.saturating_sub(reach)..(self.y + reach + 1).min(height)
    }

    /// Sets the pixels within `share` of the half-width.
    fn fill(&self, plane: &mut BitPlane, share: f32) {
        let radius = share * self.half_px;
        for y in self.rows(share, plane.height()) {
            let dy = y as f32 - self.y as f32;
            let half = (radius * radius - dy * dy).max(0.0).sqrt() as usize;
            let to = (self.x + half + 1).min(plane.width());
            plane.fill(y, self.x.saturating_sub(half), to, true);
        }
    }
}

/// Leaves of a row's bits those of pixels that are nearer to the thing's own color than this share of their distance to the rope's.
struct Nearer<'a> {
    colors: &'a [u32],
    own: [f32; 3],
    rope: [f32; 3],
    share: f32,
    yuv: bool,
    words: &'a mut [u64],
}

impl NullaryFnOnce for Nearer<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (word, colors) in self.words.iter_mut().zip(self.colors.chunks(64)) {
            if *word == 0 {
                continue;
            }
            let mut is_nearer = [0u8; 64];
            for (is_nearer, &color) in is_nearer.iter_mut().zip(colors) {
                let pixel = [0, 8, 16].map(|c| (color >> c & 0xFF) as f32);
                let [own, rope] =
                    [self.own, self.rope].map(|of| color::distance(pixel, of, self.yuv));
                *is_nearer = u8::from(own < self.share * rope);
            }
            let bits = is_nearer.iter().rev();
            *word &= bits.fold(0, |bits, &is| bits << 1 | u64::from(is));
        }
    }
}

fn and(plane: &mut BitPlane, other: &BitPlane, rows: Range<usize>) {
    for y in rows {
        for (word, &o) in plane.row_mut(y).iter_mut().zip(other.row(y)) {
            *word &= o;
        }
    }
}

fn or(plane: &mut BitPlane, other: &BitPlane) {
    for y in 0..plane.height() {
        for (word, &o) in plane.row_mut(y).iter_mut().zip(other.row(y)) {
            *word |= o;
        }
    }
}

/// Grows `plane` within `limits` by one pixel to all sides.
fn grow(plane: &mut BitPlane, limits: &BitPlane, grown: &mut BitPlane) {
    grown.copy_from(plane);
    for y in 0..plane.height() {
        for i in 0..plane.words_per_row() {
            let wide = |row: &[u64]| row[i] | left_of(row, i) | right_of(row, i);
            let mut word = wide(plane.row(y));
            if y > 0 {
                word |= wide(plane.row(y - 1));
            }
            if y + 1 < plane.height() {
                word |= wide(plane.row(y + 1));
            }
            grown.row_mut(y)[i] |= word & limits.row(y)[i];
        }
    }
    std::mem::swap(plane, grown);
}
