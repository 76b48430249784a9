//! Results drawn over the photographs, for visual inspection.
//!
//! - The photograph is darkened.
//! - White: the label's outline. Gray: the drawn edges.
//! - The curve is colored from red at the first tip to violet at the last, so a wrong connection
//!   shows as a jump in color. On the contact sheet the whole rope is colored, because only that is
//!   visible there.
//! - At a crossing, the strand on top is white over a black stretch of the lower one. A ring marks
//!   a crossing whose order is uncertain (confidence below a half).

use std::path::Path;

use anyhow::{Context, Result};
use image::codecs::png::PngEncoder;
use image::{RgbImage, imageops};
use lariat_extract::{Crossing, Curve};

use super::dataset::Pair;
use super::labels::Labels;
use super::measure::Measured;
use super::photo;
use super::spline::{self, Sample};
use super::whole_file;
use crate::enlarged::Enlarged;

/// Pixels of an overlay per pixel of the photograph, along each side.
const SCALE: u32 = 2;

const OUTLINE: [u8; 3] = [255, 255, 255];
const EDGE: [u8; 3] = [120, 120, 120];

/// Width of a picture on the contact sheet, in pixels.
const THUMBNAIL_PX: u32 = 224;
/// Pictures in a row of the contact sheet.
const COLUMNS: u32 = 10;

/// Writes `folder/NAME.png` for each image, and `folder/contact.png` with all of them in the same
/// order.
///
/// # Errors
/// A photograph cannot be read again, or the folder cannot be written to.
pub(super) fn write_set(folder: &Path, pairs: &[Pair], images: &[Measured]) -> Result<()> {
    let mut thumbnails = Vec::new();
    for (pair, measured) in pairs.iter().zip(images) {
        let photo = photo::load(&pair.image)?.into_rgb8();
        let overlay = overlay(&photo, &Labels::load(&pair.label)?, measured);
        thumbnails.push(thumbnail(&photo, measured));
        write(&folder.join(format!("{}.png", pair.name)), &overlay)?;
    }
    write(&folder.join("contact.png"), &sheet(&thumbnails))
}

fn write(path: &Path, picture: &RgbImage) -> Result<()> {
    let mut png = Vec::new();
    picture
        .write_with_encoder(PngEncoder::new(&mut png))
        .with_context(|| format!("cannot encode {}", path.display()))?;
    whole_file::write(path, &png)
}

/// Arranges the thumbnails in rows. Each cell is as high as the highest thumbnail.
fn sheet(thumbnails: &[RgbImage]) -> RgbImage {
    let cell = thumbnails.iter().map(RgbImage::height).max().unwrap_or(1);
    let count = thumbnails.len() as u32;
    let rows = count.div_ceil(COLUMNS).max(1);
    let mut sheet = RgbImage::new(THUMBNAIL_PX * count.clamp(1, COLUMNS), cell * rows);
    for (index, thumbnail) in (0..).zip(thumbnails) {
        let (x, y) = (index % COLUMNS * THUMBNAIL_PX, index / COLUMNS * cell);
        imageops::replace(&mut sheet, thumbnail, x.into(), y.into());
    }
    sheet
}

/// Returns a thumbnail of the photograph with curves as wide as their ropes.
fn thumbnail(photo: &RgbImage, measured: &Measured) -> RgbImage {
    let mut canvas = Enlarged::new(photo, SCALE);
    for curve in &measured.curves {
        for pair in spline::through(curve).windows(2) {
            let width_px = f64::from(2 * SCALE) * pair[0].half_px;
            canvas.line(&[pair[0].at, pair[1].at], width_px, hue(pair[0].rho));
        }
    }
    let picture = canvas.canvas.picture;
    let height = (picture.height() * THUMBNAIL_PX).div_ceil(picture.width());
    imageops::thumbnail(&picture, THUMBNAIL_PX, height)
}

fn overlay(photo: &RgbImage, label: &Labels, measured: &Measured) -> RgbImage {
    let mut canvas = Enlarged::new(photo, SCALE);
    canvas.darken(0.6);
    outline(&mut canvas.canvas.picture, label);
    let splines: Vec<_> = measured.curves.iter().map(spline::through).collect();
    for samples in &splines {
        edges(&mut canvas, samples);
    }
    for samples in &splines {
        for pair in samples.windows(2) {
            canvas.line(&[pair[0].at, pair[1].at], 2.0, hue(pair[0].rho));
        }
    }
    for crossing in &measured.crossings {
        mark(&mut canvas, crossing, &measured.curves, &splines);
    }
    canvas.canvas.picture
}

/// Draws the borders between the label's ropes and everything else, one canvas pixel wide, on the
/// ropes' side.
fn outline(picture: &mut RgbImage, label: &Labels) {
    let at = |x: u32, y: u32| label.at(i64::from(x / SCALE), i64::from(y / SCALE));
    for y in 0..picture.height() {
        for x in 0..picture.width() {
            let here = at(x, y);
            let around = [
                (x.wrapping_sub(1), y),
                (x + 1, y),
                (x, y.wrapping_sub(1)),
                (x, y + 1),
            ];
            if here != 0 && around.iter().any(|&(x, y)| at(x, y) != here) {
                picture.put_pixel(x, y, image::Rgb(OUTLINE));
            }
        }
    }
}

/// Draws both edges, half a width to the sides of the curve.
fn edges(canvas: &mut Enlarged, samples: &[Sample]) {
    for side in [-1.0, 1.0] {
        for pair in samples.windows(2) {
            let along = [0, 1].map(|i| pair[1].at[i] - pair[0].at[i]);
            let length = along[0].hypot(along[1]);
            if length > 0.0 {
                let normal = [-along[1] / length, along[0] / length];
                let edge = |s: &Sample| [0, 1].map(|i| s.at[i] + side * s.half_px * normal[i]);
                canvas.line(&[edge(&pair[0]), edge(&pair[1])], 1.0, EDGE);
            }
        }
    }
}

/// Draws the lower strand in black through the crossing, and the upper one in white over it.
fn mark(canvas: &mut Enlarged, crossing: &Crossing, curves: &[Curve], splines: &[Vec<Sample>]) {
    let strands = [
        (crossing.under, crossing.under_rho, [0, 0, 0]),
        (crossing.over, crossing.over_rho, [255, 255, 255]),
    ];
    for (index, rho, color) in strands {
        let (Some(curve), Some(samples)) = (curves.get(index), splines.get(index)) else {
            continue;
        };
        let reach = f64::from(0.8 * curve.width_px / curve.length_px.max(1.0));
        let near = |s: &Sample| (s.rho - f64::from(rho)).abs() <= reach;
        for pair in samples.windows(2).filter(|pair| near(&pair[0])) {
            canvas.line(&[pair[0].at, pair[1].at], 4.0, color);
        }
    }
    if crossing.confidence < 0.5 {
        let at = crossing.at.map(f64::from);
        let radius = curves
            .get(crossing.over)
            .map_or(8.0, |c| f64::from(c.width_px));
        let ring = (0..=120).map(|step| {
            let (sin, cos) = (f64::from(step) * std::f64::consts::TAU / 120.0).sin_cos();
            [at[0] + radius * cos, at[1] + radius * sin]
        });
        canvas.line(&ring.collect::<Vec<_>>(), 2.0, [255; 3]);
    }
}

/// Returns red, yellow, green, blue, violet: along a rope from its first tip (0) to its last (1).
pub(super) fn hue(rho: f64) -> [u8; 3] {
    let sixth = 5.0 * rho.clamp(0.0, 1.0);
    [5.0, 3.0, 1.0].map(|offset| {
        let k = (offset + sixth) % 6.0;
        (255.0 * (1.0 - k.min(4.0 - k).clamp(0.0, 1.0))) as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::drawing::tests::curve;
    use crate::accuracy::measure::{Bench, tests::picture};

    #[test]
    fn the_curve_is_coloured_along_the_rope_inside_its_outline() {
        let rope = curve(&[[30.0, 50.0], [120.0, 50.0], [210.0, 50.0]], 11.0);
        let (photo, label) = picture(&[rope]);
        let measured = Bench::new(lariat_extract::Method::Skeleton, crate::mask::Mask::Auto)
            .unwrap()
            .extract(&photo, &label)
            .unwrap();
        let drawn = overlay(&photo.into_rgb8(), &label, &measured);
        assert_eq!((drawn.width(), drawn.height()), (480, 320));
        let at = |x: u32, y: u32| drawn.get_pixel(SCALE * x, SCALE * y).0;
        assert!(at(40, 50)[0] > 200 && at(40, 50)[2] < 50);
        assert!(at(200, 50)[2] > 200 && at(200, 50)[1] < 50);
        // Along the rope the curve's own edges cover the label's outline. It is visible only at the
        // tips.
        assert!(drawn.pixels().any(|pixel| pixel.0 == OUTLINE));
        assert_eq!(at(100, 20), [126, 123, 120]);
    }

    #[test]
    fn the_contact_sheet_has_ten_in_a_row() {
        let thumbnails = vec![RgbImage::new(THUMBNAIL_PX, 30); 13];
        assert_eq!(sheet(&thumbnails).dimensions(), (10 * THUMBNAIL_PX, 60));
        assert_eq!(sheet(&thumbnails[..2]).dimensions(), (2 * THUMBNAIL_PX, 30));
    }

    #[test]
    fn the_colours_run_from_red_to_violet() {
        assert_eq!(hue(0.0), [255, 0, 0]);
        assert_eq!(hue(0.4), [0, 255, 0]);
        assert_eq!(hue(0.8), [0, 0, 255]);
        assert_eq!(hue(1.0), [255, 0, 255]);
    }
}
