//! The strip below the film: the error up to the current time, on a logarithmic axis.

use image::{Rgb, RgbImage, imageops};
use lariat_chain::canvas::Canvas;

use super::dashes::dashes;
use super::{ARROW, WHITE};
use crate::servo::judge::REACHED_PX;

const HEIGHT_PX: u32 = 50;
const MARGIN_PX: f64 = 5.0;
/// Minimum range of the error axis.
const LEAST_PX: [f64; 2] = [1.0, 20.0];
const SOFT: [u8; 3] = [150, 150, 150];
const LINE: [u8; 3] = [0, 114, 178];

/// The axes, which are the same for all pictures.
#[derive(Debug)]
pub(super) struct Strip<'a> {
    /// Time and error.
    errors: &'a [[f64; 2]],
    /// First and last time.
    times_s: [f64; 2],
    /// Logarithms of the least and the greatest error.
    logs: [f64; 2],
}

impl<'a> Strip<'a> {
    pub(super) fn new(errors: &'a [[f64; 2]]) -> Self {
        let known = || {
            errors
                .iter()
                .map(|e| e[1])
                .filter(|px| *px > 0.0 && px.is_finite())
        };
        // A tenth of a pixel counts as no error.
        let low = known().fold(LEAST_PX[0], f64::min).max(0.1);
        let high = known().fold(LEAST_PX[1], f64::max);
        let time = |error: Option<&[f64; 2]>| error.map_or(0.0, |e| e[0]);
        Self {
            errors,
            times_s: [time(errors.first()), time(errors.last())],
            logs: [libm::log10(low), libm::log10(high)],
        }
    }

    /// Returns a picture with its strip at a time.
    pub(super) fn below(&self, picture: &RgbImage, at_s: f64) -> RgbImage {
        let (width, top) = picture.dimensions();
        let mut whole = RgbImage::from_pixel(width, top + HEIGHT_PX, Rgb(WHITE));
        imageops::replace(&mut whole, picture, 0, 0);
        let mut canvas = Canvas::on(whole);
        let place = |error: &[f64; 2]| self.place(error, width, top);
        let [first_s, last_s] = self.times_s;

        let level = [first_s, last_s].map(|t| place(&[t, REACHED_PX]));
        for dash in dashes(&level, [4.0, 3.0]) {
            canvas.line(&dash, 1.0);
        }
        // A tick each second.
        let foot = f64::from(top + HEIGHT_PX - 1);
        for second in 0..=((last_s - first_s).clamp(0.0, 1000.0) as u32) {
            let [x, _] = place(&[first_s + f64::from(second), 1.0]);
            canvas.line(&[[x, foot - 2.5], [x, foot + 1.0]], 1.0);
        }
        canvas.ink(SOFT, 1.0);

        let till_now = self.errors.partition_point(|e| e[0] <= at_s);
        let points: Vec<[f64; 2]> = self.errors[..till_now].iter().map(place).collect();
        canvas.line(&points, 1.6);
        canvas.ink(LINE, 1.0);
        if let Some(&now) = points.last() {
            canvas.dots(&[now], 5.2);
            canvas.ink(ARROW, 1.0);
        }
        canvas.picture
    }

    /// Returns the position of an error, clamped to the strip.
    fn place(&self, &[at_s, error_px]: &[f64; 2], width: u32, top: u32) -> [f64; 2] {
        let [first_s, last_s] = self.times_s;
        let [low, high] = self.logs;
        let along = (at_s - first_s) / (last_s - first_s).max(1e-9);
        let up = (libm::log10(error_px.max(1e-9)) - low) / (high - low);
        let room = [width, HEIGHT_PX].map(|px| f64::from(px) - 1.0 - 2.0 * MARGIN_PX);
        [
            MARGIN_PX + room[0] * along.clamp(0.0, 1.0),
            f64::from(top) + MARGIN_PX + room[1] * (1.0 - up.clamp(0.0, 1.0)),
        ]
    }
}
