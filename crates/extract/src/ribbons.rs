//! Finds ropes where the network considers them likely, on any background, by their edges.
//!
//! A rope is a ribbon: two edges that keep their distance, with one color between them, over a long
//! stretch. The steps are:
//!
//! - `spans` cuts the picture along scan lines (rows and columns) where a rope is likely, into
//!   spans between two edges.
//! - `chains` joins spans of neighboring lines that are alike in place, width and color, by dynamic
//!   programming.
//! - `pieces` makes pieces of the chains, the best first, without the ground or a shadow next to
//!   them.
//! - `trace` extends each piece at its ends. One edge is enough there, and crossings are jumped.
//! - `groups` groups pieces that continue each other, and weighs whether a group is a rope.
//! - `paint` paints the ropes. Each pixel gets its share of the rope's color relative to the
//!   ground's. It also adds the pixels where the network is certain.
//!
//! The result is a mask like one from elsewhere, and all further steps use it as such.

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

/// Distance between scan lines, in pixels.
const STEP: usize = 4;

/// A cross-section of a ribbon.
#[derive(Clone, Copy, Debug, Default)]
struct Rib {
    /// Its middle.
    at: Vec2,
    /// Direction of the ribbon there.
    along: Vec2,
    width_px: f32,
    color: Color,
    /// Colors next to it, along the normal and against it.
    sides: [Color; 2],
    /// Distance of its color from those next to it, relative to its own spread and noise.
    quality: f32,
}

impl Rib {
    /// A place at a distance from the middle, along the normal.
    fn aside(&self, by_px: f32) -> Vec2 {
        vec2::add(self.at, vec2::scale(vec2::normal(self.along), by_px))
    }
}

/// Memory of the search, and its result.
#[derive(Debug, Default)]
pub(crate) struct Ribbons {
    picture: Picture,
    chainer: Chainer,
    ground: Ground,
    pieces: Vec<Fragment>,
    /// The ribs of all pieces, one piece after the other.
    ribs: Vec<Rib>,
    /// The ribs of all pieces, including those that were traced.
    traced: Vec<Rib>,
    grouper: Grouper,
}

impl Ribbons {
    /// Reserves the buffers for images of this size.
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

    /// Finds ropes in `image` where they are `likely` (255 for certain), and paints the share of
    /// rope in each pixel into `out`. All three have the same size.
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

/// Distance between two colors.
fn distance(a: Color, b: Color) -> f32 {
    squared_distance(a, b).sqrt()
}

#[inline(always)]
fn squared_distance(a: Color, b: Color) -> f32 {
    let [y, u, v] = minus(a, b);
    y * y + u * u + v * v
}

/// Difference between two colors that may be in different light: brightness counts half.
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

/// Interpolates from `a` to `b` by a share of the way.
#[inline(always)]
fn mix(a: Color, b: Color, share: f32) -> Color {
    let mixed = |c: usize| a[c] + share * (b[c] - a[c]);
    [mixed(0), mixed(1), mixed(2)]
}

/// Returns whether a color is another one in less light, or in the same.
fn is_shade(color: Color, of: Color, noise: f32) -> bool {
    let light = color[0] / of[0].max(1.0);
    if !(0.35..=1.06).contains(&light) {
        return false;
    }
    let (u, v) = (color[1] - light * of[1], color[2] - light * of[2]);
    (u * u + v * v).sqrt() < 10.0 + 1.4 * noise
}
