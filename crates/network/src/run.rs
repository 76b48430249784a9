//! Runs a picture through the layers.
//!
//! Each layer computes all its rows before the next begins. There are two exceptions, whose outputs
//! are large and used immediately. The first layer's rows are kept in a ring of four, and the
//! second layer reads them there. The last two layers compute one row at a time, which becomes rows
//! of the maps. The memory in use is therefore little more than the two skips and fits in the
//! second-level cache.

use lariat_portable::{Convolution, ConvolutionKernels, Plane};

use crate::layers::{LAYERS, Place};
use crate::network::Network;
use crate::output;
use crate::size::{Maps, Picture};
use crate::workspace::{GREY, Workspace};

/// Rows of a ring: a window's three rows and one more.
const RING: usize = 4;

/// A run of a network.
pub(crate) struct Run<'a, F> {
    network: &'a Network,
    kernels: ConvolutionKernels,
    done: F,
}

impl<'a, F: FnMut(&'static str)> Run<'a, F> {
    /// Creates a run that calls `done` after each step.
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

    /// Runs the layers from the picture to 1/4 scale.
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
            // The first window takes three new rows, each later one takes two.
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

    /// Expands a row of the picture to the layout that the first layer reads.
    fn widen(&self, picture: Picture, y: usize, out: &mut [u8]) {
        let mut filled = 0;
        if y < picture.height {
            let row = &picture.rgb[y * picture.stride..][..3 * picture.width];
            self.kernels.widen(row, out);
            filled = 4 * picture.width;
        }
        out[filled..].fill(GREY);
    }

    /// Runs the layers from 1/4 to 1/16 scale.
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

    /// Runs the layers from 1/16 scale to the maps.
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

    /// Computes all rows of a layer.
    fn whole(&mut self, place: Place, from: &Plane, residual: Option<&Plane>, to: &mut Plane) {
        for y in 0..to.height() {
            let residual = residual.map(|plane| plane.row(y));
            self.row(place, from, y, residual, to.row_mut(y));
        }
        self.done(place);
    }

    /// Computes a row of a layer with windows of three rows.
    fn row(&self, place: Place, from: &Plane, y: usize, residual: Option<&[u8]>, to: &mut [u8]) {
        let layer = self.layer(place);
        let (shape, reach) = (layer.shape(), layer.reach());
        let top = (y * shape.stride) as isize - reach as isize;
        let windows = [0, 1, 2].map(|k| from.windows(top + (k * shape.dilation) as isize, reach));
        layer.row(self.kernels, &windows, residual, to);
    }

    /// Computes a 1×1 layer and adds each pixel to a 2×2 block of `to`.
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

    /// Writes four rows of both maps, fewer at the picture's end.
    fn maps(&self, picture: Picture, top: usize, signed: &mut [u8], maps: &mut Maps) {
        self.kernels.look_up(&self.network.probabilities, signed);
        for row in 0..(picture.height - top).min(4) {
            let range = (top + row) * maps.stride..(top + row) * maps.stride + picture.width;
            output::spread(signed, 4 * row, &mut maps.rope[range.clone()]);
            output::spread(signed, 16 + 4 * row, &mut maps.seam[range]);
        }
    }
}

/// Returns the three rows from `top` out of a ring that holds the newest rows. Rows from `height`
/// on are the border.
fn ring(rows: &Plane, top: usize, height: usize) -> [&[u8]; 3] {
    [top, top + 1, top + 2].map(|y| {
        let place = if y < height { (y % RING) as isize } else { -1 };
        rows.windows(place, 0)
    })
}
