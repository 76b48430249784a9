//! `lariat-bench 3d --deform DIR`: ropes that move as recorded by motion capture. They are drawn
//! frame by frame in front of a color and a depth camera, and processed by extraction, depth and
//! fit.
//!
//! The data are those of DEFORM (Chen et al., 2024). For each of five ropes of one meter, there are
//! sequences of 500 frames at 100 Hz in which two robots swing it. A frame holds 12 or 13 markers
//! in meters, z up. The rope is the centripetal Catmull-Rom spline through them.
//!
//! The cameras are static and level. They are turned about the vertical so that the sequence has
//! the smallest depth range, and placed as near as the picture allows. A wall is behind the rope.

mod stage;
mod tally;

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use super::{Args, Beside, SIZE, header, pickle, settings};
use crate::tracking;
use crate::{Samples, Table};
use anyhow::{Context, Result, ensure};
use lariat_chain::pipeline::{Companion, FrameExtractor, FrameView, SpaceFitter};
use lariat_drawn::space::{DepthPainter, DepthSensor, Painter};
use lariat_wire::{Centerlines, Curve, Descriptors3, Status};
use stage::Stage;
use tally::Tally;

/// Time between two frames.
const PERIOD_NS: u64 = 10_000_000;

/// Measures and prints the table, with a row for each kind of rope.
///
/// # Errors
/// The folder does not hold such data.
pub(super) fn run(args: &Args, folder: &Path) -> Result<()> {
    let mut table = Table::new(&[
        "rope",
        "sequences",
        "frames",
        "seen",
        "mean mm",
        "95 %",
        "worst",
        "ends: mean",
        "95 %",
        "curve: mean",
        "95 %",
        "bad",
        "renamed",
        "turned",
        "µs",
    ]);
    let mut all = Tally::default();
    for kind in kinds(folder)? {
        let name = kind.file_name().unwrap_or_default().to_string_lossy();
        if args.only.as_ref().is_some_and(|only| !name.contains(only)) {
            continue;
        }
        let mut tally = Tally::default();
        let (first, count) = (args.first_seed as usize, args.seeds as usize);
        for (seed, path) in files(&kind)?.iter().enumerate().skip(first).take(count) {
            let frames = read(path).with_context(|| path.display().to_string())?;
            tally.sequences += 1;
            let before = tally.wrong();
            (follow(&frames, seed as u64, args, &mut tally))
                .with_context(|| path.display().to_string())?;
            if args.verbose {
                println!(
                    "{}: {} of its frames are wrong",
                    path.display(),
                    tally.wrong() - before
                )?;
            }
        }
        table.push(tally.row(&name));
        all.take(tally);
    }
    ensure!(
        all.sequences > 0,
        "no sequence is left to be measured: look at --only and --first-seed"
    );
    table.push(all.row("all"));
    print!("{table}")?;
    println!("\nmissing frames: {}", all.missing())
}

/// Returns the folders of the kinds of rope, in order.
fn kinds(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut kinds = entries(folder)?;
    kinds.retain(|path| path.is_dir());
    ensure!(
        !kinds.is_empty(),
        "{} has no folders of ropes in it: name DEFORM's data_set",
        folder.display()
    );
    Ok(kinds)
}

/// Returns a kind's sequences: first those for evaluation, in the order of their names.
fn files(kind: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for part in ["eval", "train"] {
        files.extend(entries(&kind.join(part))?);
    }
    files.retain(|path| path.extension().is_some_and(|ending| ending == "pkl"));
    Ok(files)
}

fn entries(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = fs::read_dir(folder)
        .with_context(|| format!("cannot read the folder {}", folder.display()))?;
    let mut paths = entries
        .map(|entry| Ok(entry?.path()))
        .collect::<Result<Vec<_>>>()?;
    paths.sort();
    Ok(paths)
}

/// Reads the markers of each frame, mm, z up.
fn read(path: &Path) -> Result<Vec<Vec<[f64; 3]>>> {
    let frames = pickle::read(&fs::read(path)?)?;
    let frames: Result<Vec<_>> = frames.list()?.iter().map(markers).collect();
    let frames = frames?;
    ensure!(!frames.is_empty(), "it has no frames");
    Ok(frames)
}

/// Parses a frame's markers: a list of all x, one of all y, and one of all z, in meters.
fn markers(frame: &pickle::Value) -> Result<Vec<[f64; 3]>> {
    let axes = frame.list()?;
    ensure!(
        axes.len() == 3,
        "a frame has {} axes instead of 3",
        axes.len()
    );
    let mut markers = vec![[0.0; 3]; axes[0].list()?.len()];
    ensure!(markers.len() >= 2, "a frame has fewer than two markers");
    for (k, axis) in axes.iter().enumerate() {
        let axis = axis.list()?;
        ensure!(
            axis.len() == markers.len(),
            "a frame's axes have different numbers of markers"
        );
        for (marker, value) in markers.iter_mut().zip(axis) {
            marker[k] = 1000.0 * value.number()?;
        }
    }
    Ok(markers)
}

/// Tracks the rope through a sequence.
fn follow(frames: &[Vec<[f64; 3]>], seed: u64, args: &Args, tally: &mut Tally) -> Result<()> {
    let stage = Stage::of(frames);
    let [color, beside] = stage.eyes;
    let sensor = DepthSensor::STEREO;
    let mut depths = DepthPainter::new(&beside, &sensor);
    let folder = tempfile::tempdir().context("cannot make a temporary folder")?;
    let settings = settings(&stage.eyes, &Beside::Depth(sensor), folder.path())?;
    let mut extractor = FrameExtractor::new(&settings.extract)?;
    let mut fitter = SpaceFitter::new(&settings)?.context("there is a depth camera")?;
    let (mut seen, mut message) = (Box::new(Centerlines::EMPTY), Box::new(Descriptors3::EMPTY));
    let mut painter = Painter::new(seed);
    let mut before = None;
    for (k, markers) in frames.iter().enumerate().take(args.frames) {
        let rope = stage.rope(markers, 0.5 * args.width_mm);
        let picture = painter.picture(&rope, &color);
        let units = depths.image(&rope, seed << 32 | k as u64);
        let bytes: Vec<u8> = units.iter().flat_map(|unit| unit.to_ne_bytes()).collect();
        let mut header = header();
        header.trace.sequence = k as u64;
        header.trace.exposed_ns = (1 + k as u64) * PERIOD_NS;
        let depth_header = header.of_depth([header.width, header.height]);
        let depth_image = FrameView::new(&depth_header, &bytes);
        seen.trace = header.trace;
        extractor.answer(FrameView::new(&header, &picture), None, &mut seen);
        let began = Instant::now();
        fitter.answer(&seen, Some(Companion::Depth(depth_image)), &mut message);
        tally.us.push(began.elapsed().as_secs_f64() * 1e6);
        let truth: Vec<[f64; 3]> = rope.points.iter().map(|&p| color.see(p)).collect();
        let Some(wrong) = tally.judge(message.curves(), &truth, &mut before) else {
            continue;
        };
        let truth: Vec<[f64; 2]> = truth.iter().map(|&p| color.pixel(p)).collect();
        if args.verbose {
            println!("  frame {k}: {wrong}; {}", in_the_picture(&seen, &truth))?;
        }
        if let Some(folder) = &args.overlay {
            let path = folder.join(format!("{seed:04}-{k:03}.png"));
            let hidden = |curve: &Curve| -> Vec<bool> {
                let points = 0..curve.points().len();
                points.map(|i| curve.is_hidden(i)).collect()
            };
            let hidden: Vec<Vec<bool>> = seen.curves().iter().map(hidden).collect();
            let curves = seen.curves().iter().zip(&hidden);
            let curves: Vec<tracking::SeenPoints> = curves
                .map(|(curve, hidden)| (curve.points(), &hidden[..]))
                .collect();
            tracking::draw(&picture, SIZE, (&truth, &curves), &path)?;
        }
    }
    Ok(())
}

/// Describes the distance of the centerlines' points from the axis in the picture.
fn in_the_picture(seen: &Centerlines, truth: &[[f64; 2]]) -> String {
    let off = |&[x, y]: &[f32; 2]| {
        let from = truth
            .iter()
            .map(|t| (t[0] - f64::from(x)).hypot(t[1] - f64::from(y)));
        from.fold(f64::MAX, f64::min)
    };
    let curves = seen.curves().iter().map(|curve| {
        let off: Samples = curve.points().iter().map(off).collect();
        let status = curve.status().map_or("unknown", Status::name);
        let hidden = (0..curve.points().len())
            .filter(|&i| curve.is_hidden(i))
            .count();
        format!(
            "{status}, {hidden} hidden, {:.1} px from the axis, at most {:.1}",
            off.mean(),
            off.percentile(1.0)
        )
    });
    let curves: Vec<String> = curves.collect();
    format!("in the picture: {}", curves.join("; "))
}
