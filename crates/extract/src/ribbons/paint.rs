//! Paints ropes as a mask. Each pixel gets its share of the rope's color, relative to that of the
//! ground next to it.

use lariat_portable::{Arch, NullaryFnOnce};

use super::groups::Grouper;
use super::picture::Picture;
use super::pieces::Fragment;
use super::{Color, Rib, dot, minus, mix};
use crate::image::gray::GrayPlane;
use crate::vec2;

/// Distances from a rope's edge, in pixels. Farther inside than the first, every pixel is rope.
/// Farther outside than the second, none is.
const EDGE_PX: (f32, f32) = (1.5, 2.0);
/// Maximum length, in widths, by which a rope is continued beyond its last rib, as long as its
/// color continues.
const TIP_WIDTHS: f32 = 1.0;
/// Maximum distance of an end from what it runs into, in widths and in pixels.
const INTO: (f32, f32) = (1.5, 6.0);

/// Minimum probability, of 255, at which a pixel is rope even where no ribbon was found.
const SURE: u8 = 179;

/// Rule for painting a stretch between two ribs.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// All of it is rope, except its edges.
    Seen,
    /// Only pixels of the rope's color are rope.
    Tip,
    /// The stretch is considered rope, but is not visible.
    Hidden,
}

/// Paints all pieces that are rope, and the pixels where the network is certain.
pub(super) fn run(
    picture: &Picture,
    grouper: &Grouper,
    (pieces, ribs): (&[Fragment], &[Rib]),
    likely: &GrayPlane,
    out: &mut GrayPlane,
) {
    for y in 0..out.height() {
        out.row_mut(y).fill(0);
    }
    let mut brush = Brush { picture, out };
    for (number, piece) in pieces.iter().enumerate() {
        if !grouper.is_rope(number) {
            continue;
        }
        for pair in ribs[piece.from..piece.to].windows(2) {
            brush.stroke(&pair[0], &pair[1], Kind::Seen);
        }
    }
    for (i, end) in grouper.ends.iter().enumerate() {
        if !grouper.is_rope(end.piece) {
            continue;
        }
        let mut rib = ribs[end.rib];
        if vec2::dot(rib.along, end.along) < 0.0 {
            rib.sides.swap(0, 1);
        }
        rib.along = end.along;
        rib.width_px = pieces[end.piece].width_px;
        if let Some(other) = end.linked {
            let other = &grouper.ends[other];
            if i < end.linked.unwrap_or(0) {
                let mut to = ribs[other.rib];
                to.width_px = pieces[other.piece].width_px;
                brush.stroke(&rib, &to, Kind::Hidden);
            }
            continue;
        }
        let reach_px = (INTO.0 * rib.width_px).max(INTO.1);
        match brush.run_up_px(&rib, reach_px) {
            Some(px) => brush.stroke(&rib, &ahead(&rib, px), Kind::Hidden),
            None => brush.stroke(&rib, &ahead(&rib, TIP_WIDTHS * rib.width_px), Kind::Tip),
        }
    }
    for y in 0..out.height() {
        let (likely, out) = (likely.row(y), out.row_mut(y));
        Arch::new().dispatch(Surely { likely, out });
    }
}

/// Adds to a row the pixels where the network is certain.
struct Surely<'a> {
    likely: &'a [u8],
    out: &'a mut [u8],
}

impl NullaryFnOnce for Surely<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (out, &likely) in self.out.iter_mut().zip(self.likely) {
            *out = (*out).max(if likely >= SURE { likely } else { 0 });
        }
    }
}

/// The rib moved ahead by a distance.
fn ahead(rib: &Rib, px: f32) -> Rib {
    Rib {
        at: vec2::along(rib.at, rib.along, px),
        ..*rib
    }
}

struct Brush<'a> {
    picture: &'a Picture,
    out: &'a mut GrayPlane,
}

impl Brush<'_> {
    /// Distance from an end to another rope or the picture's border ahead of it, if within reach.
    fn run_up_px(&self, rib: &Rib, reach_px: f32) -> Option<f32> {
        let mut px = 3.0;
        while px < reach_px {
            let at = ahead(rib, px).at;
            let Some(_) = self.picture.between(vec2::along(at, rib.along, 1.0)) else {
                return Some(px + 3.0);
            };
            let [x, y] = at.map(|c| ((c + 0.5) * self.picture.scale as f32) as usize);
            if self.out.row(y.min(self.out.height() - 1))[x.min(self.out.width() - 1)] == 255 {
                return Some(px);
            }
            px += 1.0;
        }
        None
    }

    /// Paints the stretch from one rib to another.
    fn stroke(&mut self, from: &Rib, to: &Rib, kind: Kind) {
        let scale = self.picture.scale as f32;
        let reach_px = 0.5 * from.width_px.max(to.width_px) + EDGE_PX.1 + 1.0;
        let bound = |c: usize, most: usize| {
            let low = (from.at[c].min(to.at[c]) - reach_px + 0.5) * scale;
            let high = (from.at[c].max(to.at[c]) + reach_px + 0.5) * scale;
            low.max(0.0) as usize..(high.max(0.0) as usize + 1).min(most)
        };
        let way = vec2::sub(to.at, from.at);
        let length_px = vec2::norm(way).max(1e-3);
        let along = vec2::scale(way, 1.0 / length_px);
        let normal = vec2::normal(along);
        let columns = bound(0, self.out.width());
        for y in bound(1, self.out.height()) {
            let row = (y as f32 + 0.5) / scale - 0.5;
            // Paint only what is between the ribs and near them. A small margin over the tests
            // below allows for rounding.
            let down_px = row - from.at[1];
            let near = (f32::NEG_INFINITY, f32::INFINITY);
            let near = cut(near, (along, down_px), (-1.0, length_px + 1.0));
            let near = cut(near, (normal, down_px), (-reach_px, reach_px));
            let pixel = |px: f32| ((from.at[0] + px + 0.5) * scale - 0.5).max(0.0) as usize;
            let (first, last) = (pixel(near.0), pixel(near.1).saturating_add(2));
            let (first, last) = (columns.start.max(first), columns.end.min(last));
            let row_out = self.out.row_mut(y).iter_mut().enumerate();
            for (x, out) in row_out.take(last).skip(first) {
                // The pixel is rope already.
                if *out == 255 {
                    continue;
                }
                let at = [(x as f32 + 0.5) / scale - 0.5, row];
                let off = vec2::sub(at, from.at);
                let run_px = vec2::dot(off, along);
                // With a smaller limit, the outer side would be left open where ribs turn.
                if run_px < -0.75 || run_px > length_px + 0.75 {
                    continue;
                }
                let share = (run_px / length_px).clamp(0.0, 1.0);
                let side_px = vec2::dot(off, normal);
                let level = level(self.picture, (from, to, share), (at, side_px), kind);
                *out = (*out).max(level);
            }
        }
    }
}

/// Clips a stretch of a row to the places whose component along a direction is between two bounds.
/// The row is `down_px` below the origin.
fn cut(
    (low, high): (f32, f32),
    (along, down_px): (vec2::Vec2, f32),
    (from, to): (f32, f32),
) -> (f32, f32) {
    // The component hardly changes along the row.
    if along[0].abs() < 0.01 {
        return (low, high);
    }
    let [a, b] = [from, to].map(|bound| (bound - down_px * along[1]) / along[0]);
    (low.max(a.min(b)), high.min(a.max(b)))
}

/// Share of rope in a pixel, from 0 to 255.
fn level(
    picture: &Picture,
    (from, to, share): (&Rib, &Rib, f32),
    (at, side_px): (vec2::Vec2, f32),
    kind: Kind,
) -> u8 {
    let half_px = 0.5 * (from.width_px + share * (to.width_px - from.width_px));
    let inside_px = half_px - side_px.abs();
    if inside_px < -EDGE_PX.1 {
        return 0;
    }
    let is_core = inside_px > EDGE_PX.0.min(0.5 * half_px);
    if kind == Kind::Hidden {
        return if inside_px >= 0.0 { 255 } else { 0 };
    }
    if kind == Kind::Seen && is_core {
        return 255;
    }
    let k = usize::from(side_px < 0.0);
    let rope = mix(from.color, to.color, share);
    let ground = mix(from.sides[k], to.sides[k], share);
    let part = match picture.between(at) {
        Some(own) => part(own, ground, rope),
        None => 1.0,
    };
    // More than a pixel outside the edge, the rope's color may be that of another object.
    let most = (0.5 + 0.5 * (inside_px + EDGE_PX.1)).clamp(0.0, 1.0);
    (255.0 * part.min(most)) as u8
}

/// Position of a color on the way from the ground's color to the rope's, from 0 to 1.
fn part(own: Color, ground: Color, rope: Color) -> f32 {
    let way = minus(rope, ground);
    (dot(minus(own, ground), way) / dot(way, way).max(1.0)).clamp(0.0, 1.0)
}
