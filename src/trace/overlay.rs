//! Pictures for judging a trace by eye: the curve, its points and its control polygon, drawn over
//! the picture.

use crate::descriptor_json::{Descriptor, Quality};
use crate::trace::frames::Shown;
use crate::trace::report::{CurveReport, Report};
use anyhow::{Context, Result};
use image::RgbImage;
use image::codecs::png::PngEncoder;
use lariat_camera::Mapping;
use lariat_chain::canvas::Canvas;
use lariat_chain::confidence;
use lariat_chain::output::{Existing, Output, OutputFolder};
use lariat_record::rope_color;
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// Color of a curve that a control loop should not use: it does not fit its points, or may not be a
/// rope.
const UNTRUSTED: [u8; 3] = [225, 0, 40];

const DARK: [u8; 3] = [20, 20, 20];
const LIGHT: [u8; 3] = [255, 255, 255];

/// Output folder of the overlays.
pub(super) struct Overlays {
    folder: OutputFolder,
    existing: Existing,
    taken: HashSet<String>,
    /// Input files, which an overlay must not replace.
    inputs: Vec<PathBuf>,
}

impl Overlays {
    /// Creates the folder.
    ///
    /// # Errors
    /// Returns an error if the folder cannot be created or written to, or if it has an overlay that
    /// must be kept.
    pub(super) fn new(
        folder: &Path,
        images: &[PathBuf],
        inputs: Vec<PathBuf>,
        existing: Existing,
    ) -> Result<Self> {
        let mut taken = HashSet::new();
        let names: Vec<String> = images.iter().map(|path| name(path, &mut taken)).collect();
        let names = names.iter().map(String::as_str);
        Ok(Self {
            folder: OutputFolder::new(folder, existing, names)?,
            existing,
            taken: HashSet::new(),
            inputs,
        })
    }

    /// Draws the result over the picture and writes it as a PNG of the same name.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written or would replace one of the pictures.
    pub(super) fn write(
        &mut self,
        shown: Shown,
        report: &Report,
        mapping: Option<&Mapping>,
    ) -> Result<()> {
        let target = self.folder.path().join(name(&shown.name, &mut self.taken));
        let output = Output::new(
            &target,
            self.existing,
            self.inputs.iter().map(PathBuf::as_path),
        )?;
        let mut png = Vec::new();
        draw(shown.picture.into_rgb(), report, mapping)
            .write_with_encoder(PngEncoder::new(&mut png))
            .with_context(|| format!("cannot encode {}", target.display()))?;
        output.write(&png)
    }
}

/// The picture's name with `.png`, and with a number if two pictures have the same name.
fn name(path: &Path, taken: &mut HashSet<String>) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let mut name = format!("{stem}.png");
    let mut number = 2;
    while !taken.insert(name.clone()) {
        name = format!("{stem}-{number}.png");
        number += 1;
    }
    name
}

fn draw(picture: RgbImage, report: &Report, mapping: Option<&Mapping>) -> RgbImage {
    // Lines are visible in a large picture and do not cover a small one.
    let line_px = (f64::from(picture.width().min(picture.height())) / 240.0).clamp(1.2, 12.0);
    let mut canvas = Canvas::on(picture);
    for (index, curve) in report.curves.iter().enumerate() {
        let is_coarse = matches!(
            curve.descriptor.quality,
            Some(Quality { fit: "coarse", .. })
        );
        let is_unsure = curve.status == "doubtful" || confidence::is_low(curve.confidence);
        let rgb = match is_coarse || is_unsure {
            true => UNTRUSTED,
            false => rope_color(index as u32),
        };
        draw_curve(&mut canvas, curve, rgb, line_px, mapping);
    }
    canvas.picture
}

/// Draws, from the bottom up: polygon, curve, points, control points, and a ring around the first
/// point. `mapping`: from pixels to the descriptor's points, if those are not in the picture.
fn draw_curve(
    canvas: &mut Canvas,
    curve: &CurveReport,
    rgb: [u8; 3],
    line_px: f64,
    mapping: Option<&Mapping>,
) {
    // The coefficients of a Fourier series are not positions.
    let control_points = match curve.descriptor.basis {
        "fourier" => &[],
        _ => &curve.descriptor.control_points[..],
    };
    let control_points = &seen(control_points, mapping)[..];
    let smooth = seen(&sampled(&curve.descriptor, curve.length_px), mapping);

    canvas
        .line(control_points, 0.5 * line_px + 1.0)
        .ink(DARK, 0.35);
    canvas.line(control_points, 0.5 * line_px).ink(rgb, 0.8);

    canvas.line(&smooth, line_px + 1.6).ink(DARK, 0.55);
    canvas.line(&smooth, line_px).ink(rgb, 1.0);

    canvas
        .dots(&curve.points, 1.2 * line_px + 1.4)
        .ink(DARK, 0.9);
    canvas.dots(&curve.points, 1.2 * line_px).ink(LIGHT, 1.0);

    canvas
        .dots(control_points, 2.6 * line_px + 1.6)
        .ink(DARK, 0.8);
    canvas.dots(control_points, 2.6 * line_px).ink(LIGHT, 1.0);
    canvas.dots(control_points, 1.4 * line_px).ink(rgb, 1.0);

    if let Some(&first) = curve.points.first() {
        canvas.dots(&[first], 4.2 * line_px).ink(DARK, 0.8);
        canvas.dots(&[first], 3.4 * line_px).ink(rgb, 1.0);
        canvas.dots(&[first], 1.4 * line_px).ink(LIGHT, 1.0);
    }
}

/// Maps points to the picture; omits those outside its view.
fn seen(points: &[[f64; 2]], mapping: Option<&Mapping>) -> Vec<[f64; 2]> {
    match mapping {
        None => points.to_vec(),
        Some(mapping) => points.iter().filter_map(|p| mapping.pixel(*p)).collect(),
    }
}

/// The curve as a polyline with segments of two pixels, but no more than a large picture needs.
fn sampled(descriptor: &Descriptor, length_px: f64) -> Vec<[f64; 2]> {
    let Some(curve) = descriptor.curve() else {
        return Vec::new();
    };
    let steps = (length_px / 2.0).clamp(64.0, 8192.0) as usize;
    (0..=steps)
        .map(|i| curve.point(i as f64 / steps as f64))
        .collect()
}
