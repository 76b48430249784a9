//! Occluders: objects that differ from the table and are not ropes, such as a gripper, a hand, or a
//! tool at a rope.
//!
//! An occluder shows as a place where the mask is far wider than the ropes, in a color of its own.
//! From there, its whole area is filled by color. If the ropes' width is known, the occluder's rim,
//! which gets less light, is added by width. The occluder is removed from the mask, so that no
//! curve runs into it or around it. Hidden parts of a rope are bridged later.
//!
//! Two kinds of wide places stay in the mask. Strands close to each other have the rope's color, or
//! many colors. A thick rope among thin ones is long.

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

/// Quantile of the skeleton's half-widths that is the ropes' usual half-width.
const USUAL: f32 = 0.35;
/// Minimum half-width of an occluder, if the ropes' width is not known: factor of the ropes'
/// half-width, plus pixels.
const WIDE: (f32, f32) = (2.6, 2.0);
/// Same if it is known: more than two strands side by side.
const WIDE_KNOWN: (f32, f32) = (2.2, 1.0);
/// Factor for an occluder of the ropes' own color. Strands are never that wide together.
const WIDE_ALIKE: f32 = 5.0;
/// Maximum color difference at which an occluder has the ropes' color, in levels.
const ALIKE: f32 = 28.0;
/// Minimum share of an occluder's middle that has its color. Strands on top of each other, with
/// shade between them, reach a third. Only if the ropes' width is not known.
const ONE_COLOR: f32 = 0.6;
/// Maximum area of an occluder, in squares of its own width. A rope's area is larger. Only if the
/// ropes' width is not known.
const SQUARES: f32 = 5.0;
/// Maximum distance of an occluder's pixel from the occluder's color, as a share of its distance
/// from the rope's color.
const NEARER: f32 = 0.6;
/// Number of pixels around an occluder that are neither it nor the table.
const RIM: usize = 2;
/// Maximum number of occluders in one image.
const MOST: usize = 6;

/// Buffers and result of the step.
#[derive(Debug, Default)]
pub(crate) struct Occluder {
    halves: Vec<f32>,
    channel: Vec<f32>,
    /// Colors of one row.
    colors: Vec<u32>,
    alike: BitPlane,
    thing: BitPlane,
    grown: BitPlane,
    morphology: Morphology,
    opened: Strips,
    /// Places where the mask is far wider than the ropes.
    wide: BitPlane,
    /// Pixels of all occluders.
    pub(crate) plane: BitPlane,
    /// True if there is any occluder.
    found: bool,
}

impl Occluder {
    /// Returns whether an occluder is within `reach_px` of a place.
    pub(crate) fn is_near(&self, [x, y]: [f32; 2], reach_px: f32) -> bool {
        let reach = reach_px as i32;
        let (x, y) = (x as i32, y as i32);
        let offsets = || (-reach..=reach).step_by((reach as usize / 4).max(1));
        offsets().any(|dy| offsets().any(|dx| self.plane.get(x + dx, y + dy)))
    }

    /// Allocates buffers for images of this size.
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

    /// Returns whether there is any occluder.
    pub(crate) fn any(&self) -> bool {
        self.found
    }

    /// Finds occluders, starting from the widest places. Returns whether there are any.
    ///
    /// If the prior knows the ropes' width, width and color decide. If not, an occluder must also
    /// have one color and a limited area. An occluder of the ropes' own color then stays in the
    /// mask if its half-width is at least `widest_half_px`, as it may have fingers.
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

    /// Median color of the skeleton where it is about as wide as a rope.
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

    /// Adds the occluder around `seed` to the plane. Returns false if it is not an occluder.
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
            // Color does not separate it from the ropes, so everything inside the widest place is
            // taken.
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
        // If the ropes' width is not known, a wide place next to the occluder may be a thicker
        // rope.
        if known {
            let planes = (&mut self.thing, &mut self.wide);
            spread(planes, 0..mask.height(), f32::INFINITY, |_, _| {});
        }
        or(&mut self.plane, &self.thing);
        // The seed is done, even if its own pixel was not taken.
        self.plane.fill(seed.y, seed.x, seed.x + 1, true);
        true
    }
}

/// Returns whether no place is far wider than the ropes usually are. This holds if at most the
/// share `USUAL` of the places is far narrower than the widest one.
fn is_even(skeleton: &Skeleton, widest_px: f32) -> bool {
    let pixels = &skeleton.pixels;
    // A thousandth more than necessary, for rounding.
    let near_px = 1.001 * (widest_px - WIDE.1).max(0.0) / WIDE.0;
    let narrow = pixels.iter().filter(|p| p.half_px < near_px).count();
    narrow <= ((pixels.len().max(1) - 1) as f32 * USUAL) as usize
}

/// Clears the area along a rope. If an arm is next to a rope, both together are as wide in the mask
/// as an occluder.
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

/// Middle of a wide place.
struct Seed {
    x: usize,
    y: usize,
    half_px: f32,
}

impl Seed {
    /// Mean color around the seed.
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

    /// Rows within `share` of the half-width, in an image of this height.
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

/// Keeps the bits of a row whose pixels are near the occluder's own color: at most `share` times as
/// far from it as from the rope's.
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

/// Grows `plane` by one pixel in all directions, within `limits`.
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
