//! Ropes where the network says that some are likely, on whatever ground: their edges, and what belongs together.
//!
//! A rope is a ribbon: two edges that keep their distance, of one color between them, on and on. So the picture is cut along
//! scan lines, rows and columns, where a rope is likely, into spans between two edges (`spans`); spans of neighboring lines that are alike in place,
//! width and color make chains, by dynamic programming (`chains`); what better chains have not taken, and what is not just
//! the ground or a shadow beside them, makes pieces (`pieces`); each is traced on at its ends, where one edge is enough and
//! a crossing is jumped (`trace`); pieces that go on from each other are grouped, and of a group it is weighed whether it is
//! a rope (`groups`); and what is rope is painted, each pixel by how much of the rope's color it has between the ground's
//! (`paint`), with what the network is sure of. The result is a mask like one from elsewhere, that all further steps take as theirs.

mod chains;
mod groups;
mod paint;
mod picture;
mod pieces;
mod spans;
mod trace;

use crate::image::Image;
use crate::image::gray::GrayPlane;
use crate::vec2::{self, Vec2};
use chains::Chainer;
use groups::Grouper;
use picture::Picture;
use pieces::{Fragment, Ground};

/// Brightness, and chroma counted double, so that distances are those of `image::color`.
type Color = [f32; 3];

/// Pixels from one scan line to the next.
const STEP: usize = 4;

/// A cut through a ribbon.
#[derive(Clone, Copy, Debug, Default)]
struct Rib {
    /// Its middle.
    at: Vec2,
    /// The ribbon's direction there.
    along: Vec2,
    width_px: f32,
    color: Color,
    /// The color beside it, along the normal and against it.
    sides: [Color; 2],
    /// How far its color is from that beside it, in its own spread and noise.
    quality: f32,
}

impl Rib {
    /// A place beside the middle, along the normal.
    fn aside(&self, by_px: f32) -> Vec2 {
        vec2::add(self.at, vec2::scale(vec2::normal(self.along), by_px))
    }
}

/// Memory of the search, and what was found.
#[derive(Debug, Default)]
pub(crate) struct Ribbons {
    picture: Picture,
    chainer: Chainer,
    ground: Ground,
    pieces: Vec<Fragment>,
    /// The ribs of all pieces, one after the other.
    ribs: Vec<Rib>,
    /// The same with those that were traced.
    traced: Vec<Rib>,
    grouper: Grouper,
}

impl Ribbons {
    /// Makes the buffers for images of this size.
    pub(crate) fn reserve(&mut self, width: usize, height: usize) {
        let [width, height] = self.picture.reserve(width, height);
        self.chainer.reserve(width, height);
        self.ground.reserve(width * height);
        self.pieces.reserve(pieces::MOST);
        self.ribs.reserve(pieces::MOST_RIBS);
        let ribs = pieces::MOST_RIBS + trace::MOST_TRACED;
        self.traced.reserve(ribs);
        self.grouper.reserve([width, height], pieces::MOST, ribs);
    }

    /// Looks for ropes in `image` where they are `likely` (255 for certain), and paints how much of each pixel is rope into `out`,
    /// all three of one size.
    pub(crate) fn find(&mut self, image: &Image, likely: &GrayPlane, out: &mut GrayPlane) {
        self.picture.take(image, likely);
        let Self {
            picture,
            chainer,
            ground,
            pieces,
            ribs,
            traced,
            grouper,
        } = self;
        chainer.run(picture);
        pieces::take(picture, chainer, ground, (pieces, ribs));
        trace::run(picture, ground, (pieces, ribs), traced);
        grouper.run(picture, ground, pieces, traced);
        paint::run(picture, grouper, (pieces, traced), likely, out);
    }
}

/// How far two colors are apart.
fn distance(a: Color, b: Color) -> f32 {
    squared_distance(a, b).sqrt()
}

#[inline(always)]
fn squared_distance(a: Color, b: Color) -> f32 {
    let [y, u, v] = minus(a, b);
    y * y + u * u + v * v
}

/// How unlike two colors are of what may lie in another light: brightness counts half.
#[inline(always)]
fn unlikeness(a: Color, b: Color) -> f32 {
    let [y, u, v] = minus(a, b);
    (0.25 * y * y + u * u + v * v).sqrt()
}

#[inline(always)]
fn minus(a: Color, b: Color) -> Color {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: Color, b: Color) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// From `a` to `b` by a share of the way.
#[inline(always)]
fn mix(a: Color, b: Color, share: f32) -> Color {
    let mixed = |c: usize| a[c] + share * (b[c] - a[c]);
    [mixed(0), mixed(1), mixed(2)]
}

/// Whether a color is another one in less light, or in as much.
fn is_shade(color: Color, of: Color, noise: f32) -> bool {
    let light = color[0] / of[0].max(1.0);
    if !(0.35..=1.06).contains(&light) {
        return false;
    }
    let (u, v) = (color[1] - light * of[1], color[2] - light * of[2]);
    (u * u + v * v).sqrt() < 10.0 + 1.4 * noise
}
