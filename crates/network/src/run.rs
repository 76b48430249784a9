//! The way of a picture through the layers.
//!
//! Each layer makes all its rows before the next begins, with two exceptions, where what is made is large and used at once:
//! the first layer's rows live in a ring of four, from which the second makes its own, and those of the last two are made one
//! by one and become rows of the maps. So what is kept is little more than the two skips, and stays in the second cache.

use lariat_portable::{Convolution, ConvolutionKernels, Plane};

use crate::layers::{LAYERS, Place};
use crate::network::Network;
use crate::output;
use crate::size::{Maps, Picture};
use crate::workspace::{GREY, Workspace};

/// Rows of a ring: as many as a window has, and one.
const RING: usize = 4;

/// A run.
pub(crate) struct Run<'a, F> {
    network: &'a Network,
    kernels: ConvolutionKernels,
    done: F,
}

impl<'a, F: FnMut(&'static str)> Run<'a, F> {
    /// `done` is told of each piece of work.
    pub(crate) fn new(network: &'a Network, kernels: ConvolutionKernels, done: F) -> Self {
        Self {
            network,
            kernels,
            done,
        }
    }

    fn layer(&self, place: Place) -> &'a Convolution {
        &self.network.convolutions[place as usize]
    }

    fn done(&mut self, place: Place) {
        (self.done)(LAYERS[place as usize].name);
    }

    /// From the picture to 1/4.
    pub(crate) fn down(&mut self, workspace: &mut Workspace, picture: Picture) {
        let Workspace {
            picture: rows,
            half,
            quarter,
            ..
        } = workspace;
        let (stem, d1) = (self.layer(Place::Stem), self.layer(Place::D1));
        let halves = 2 * quarter.height();
        for y in 0..quarter.height() {
            // The first window takes three rows, each after it two new ones.
            let new = if y == 0 { 0 } else { 2 * y + 1 }..(2 * y + 3).min(halves);
            for made in new {
                let new = if made == 0 { 0 } else { 2 * made + 1 }..(2 * made + 3).min(2 * halves);
                for row in new {
                    self.widen(picture, row, rows.row_mut(row % RING));
                }
                (self.done)("picture");
                let windows = ring(rows, 2 * made, 2 * halves);
                stem.row(self.kernels, &windows, None, half.row_mut(made % RING));
                self.done(Place::Stem);
            }
            let windows = ring(half, 2 * y, halves);
            d1.row(self.kernels, &windows, None, quarter.row_mut(y));
            self.done(Place::D1);
        }
    }

    /// A row of the picture as the first layer reads it.
    fn widen(&self, picture: Picture, y: usize, out: &mut [u8]) {
        let mut filled = 0;
        if y < picture.height {
            let row = &picture.rgb[y * picture.stride..][..3 * picture.width];
            self.kernels.widen(row, out);
            filled = 4 * picture.width;
        }
        out[filled..].fill(GREY);
    }

    /// From 1/4 to 1/16.
    pub(crate) fn deep(&mut self, workspace: &mut Workspace) {
        let [a, b, c] = &mut workspace.eighth;
        self.whole(Place::D2, &workspace.quarter, None, a);
        self.whole(Place::E2a, a, None, b);
        self.whole(Place::E2b, b, Some(a), c);
        let [k, l, m] = &mut workspace.sixteenth;
        self.whole(Place::D3, c, None, k);
        self.whole(Place::E3a, k, None, l);
        self.whole(Place::E3b, l, Some(k), m);
        self.whole(Place::E3c, m, None, l);
        self.whole(Place::E3d, l, Some(m), k);
    }

    /// From 1/16 to the maps.
    pub(crate) fn up(&mut self, workspace: &mut Workspace, picture: Picture, mut maps: Maps) {
        let Workspace {
            quarter,
            eighth: [a, _, c],
            sixteenth: [k, ..],
            last,
            signed,
            ..
        } = workspace;
        self.add_upsampled::<48>(Place::U2, k, signed, c);
        self.whole(Place::F2, c, None, a);
        self.add_upsampled::<32>(Place::U1, a, signed, quarter);
        for y in 0..picture.height.div_ceil(4) {
            self.row(Place::F1, quarter, y, None, last.row_mut(0));
            self.done(Place::F1);
            let windows = last.windows(0, 0);
            let out = self.layer(Place::Out);
            out.row(self.kernels, &[windows], None, signed);
            self.done(Place::Out);
            self.maps(picture, 4 * y, signed, &mut maps);
            (self.done)("maps");
        }
    }

    /// All rows of a layer.
    fn whole(&mut self, place: Place, from: &Plane, residual: Option<&Plane>, to: &mut Plane) {
        for y in 0..to.height() {
            let residual = residual.map(|plane| plane.row(y));
            self.row(place, from, y, residual, to.row_mut(y));
        }
        self.done(place);
    }

    /// A row of a layer with windows of three rows.
    fn row(&self, place: Place, from: &Plane, y: usize, residual: Option<&[u8]>, to: &mut [u8]) {
        let layer = self.layer(place);
        let (shape, reach) = (layer.shape(), layer.reach());
        let top = (y * shape.stride) as isize - reach as isize;
        let windows = [0, 1, 2].map(|k| from.windows(top + (k * shape.dilation) as isize, reach));
        layer.row(self.kernels, &windows, residual, to);
    }

    /// A layer of single pixels, each of which is added to four of `to`.
    fn add_upsampled<const CHANNELS: usize>(
        &mut self,
        place: Place,
        from: &Plane,
        signed: &mut [u8],
        to: &mut Plane,
    ) {
        let layer = self.layer(place);
        let signed = &mut signed[..from.width() * CHANNELS];
        for y in 0..from.height() {
            layer.row(self.kernels, &[from.windows(y as isize, 0)], None, signed);
            self.done(place);
            for y in [2 * y, 2 * y + 1] {
                output::add_twice::<CHANNELS>(signed, to.row_mut(y));
            }
            (self.done)("skips");
        }
    }

    /// Four rows of both maps, or as many as the picture still has.
    fn maps(&self, picture: Picture, top: usize, signed: &mut [u8], maps: &mut Maps) {
        self.kernels.look_up(&self.network.probabilities, signed);
        for row in 0..(picture.height - top).min(4) {
            let range = (top + row) * maps.stride..(top + row) * maps.stride + picture.width;
            output::spread(signed, 4 * row, &mut maps.rope[range.clone()]);
            output::spread(signed, 16 + 4 * row, &mut maps.seam[range]);
        }
    }
}

/// The three rows from `top` on of which the newest lie in a ring; those from `height` on are the border.
fn ring(rows: &Plane, top: usize, height: usize) -> [&[u8]; 3] {
    [top, top + 1, top + 2].map(|y| {
        let place = if y < height { (y % RING) as isize } else { -1 };
        rows.windows(place, 0)
    })
}
