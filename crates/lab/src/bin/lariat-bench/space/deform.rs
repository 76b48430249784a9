//! `lariat-bench space --deform DIR`: ropes that a motion capture saw move, drawn frame by frame before a colour and a depth camera, and
//! followed through extraction, depth and fit.
//!
//! The data are those of DEFORM (Chen et al., 2024): for each of five ropes of a metre, sequences of 500 frames at 100 Hz in which two robots
//! swing it, as 12 or 13 markers in metres, z up. The rope is the centripetal Catmull-Rom spline through the markers of a frame. Its
//! cameras stand still, level, and turned about the vertical so that the whole sequence is the shallowest to them, as near as all of it is in the picture;
//! behind it is a wall.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use super::{ASIDE, Args, Beside, FOCAL_PX, SIZE, beside_axis, far, header, pickle, settings};
use crate::accuracy::spline;
use crate::time;
use anyhow::{Context, Result, ensure};
use lariat_chain::pipeline::{Companion, FrameExtractor, FrameView, SpaceFitter};
use lariat_drawn::space::{DepthSensor, Eye, LiftedRope, Painter, depth};
use lariat_lab::{Samples, Table};
use lariat_wire::{Centerlines, Curve, Descriptor3, Descriptors3, Place, Shape, Status};

/// From one frame to the next.
const PERIOD_NS: u64 = 10_000_000;
/// Points of the spline between two markers.
const FINER: usize = 20;
/// The share of the picture, to each side of its middle, in which the rope stays.
const INNER: f64 = 0.45;
/// How far behind the rope the wall is, mm.
const WALL_MM: f64 = 150.0;
/// Turns of the camera that are tried.
const TURNS: u32 = 36;
/// A frame is bad whose points are farther from the axis than this, as a mean, mm.
const BAD_MM: f64 = 5.0;

/// Measures and prints the table: a row for each kind of rope.
///
/// # Errors
/// The folder holds no such data, or something else.
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

/// The folders of the kinds of rope, in order.
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

/// A kind's sequences: those to evaluate by first, in the order of their names.
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

/// The markers of each frame, mm, z up.
fn read(path: &Path) -> Result<Vec<Vec<[f64; 3]>>> {
    let frames = pickle::read(&fs::read(path)?)?;
    let frames: Result<Vec<_>> = frames.list()?.iter().map(markers).collect();
    let frames = frames?;
    ensure!(!frames.is_empty(), "it has no frames");
    Ok(frames)
}

/// A frame's markers; it is a list of all x, one of all y, and one of all z, in metres.
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

/// Where the cameras stand: the ropes' frame with x to their right, y up and the wall at z = 0.
struct Stage {
    turn: [f64; 2],
    origin: [f64; 3],
    eyes: [Eye; 2],
}

impl Stage {
    fn of(frames: &[Vec<[f64; 3]>]) -> Self {
        let markers = || frames.iter().flatten();
        let spans = |turn: [f64; 2]| {
            [0, 1, 2].map(|k| {
                let along = || markers().map(|&p| turned(turn, p)[k]);
                [
                    along().fold(f64::MAX, f64::min),
                    along().fold(f64::MIN, f64::max),
                ]
            })
        };
        let depth = |turn: [f64; 2]| {
            let [near, far] = spans(turn)[2];
            far - near
        };
        let turns = (0..TURNS).map(|k| {
            let (sin, cos) = f64::from(k * 180 / TURNS).to_radians().sin_cos();
            [cos, sin]
        });
        let turn = turns.min_by(|&a, &b| depth(a).total_cmp(&depth(b)));
        let turn = turn.unwrap_or([1.0, 0.0]);
        let [x, y, z] = spans(turn);
        let origin = [0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1]), z[0] - WALL_MM];
        let near_enough = markers().map(|&marker| {
            let at = turned(turn, marker);
            let asks = |k: usize| (at[k] - origin[k]).abs() * FOCAL_PX / (INNER * SIZE[k] as f64);
            at[2] - origin[2] + asks(0).max(asks(1))
        });
        let distance_mm = near_enough.fold(0.0, f64::max);
        let color = Eye::above(FOCAL_PX, SIZE, distance_mm, 0.0, 0.0);
        Self {
            turn,
            origin,
            eyes: [color, color.beside(ASIDE, 425.0, SIZE)],
        }
    }

    /// The rope of a frame's markers.
    fn rope(&self, markers: &[[f64; 3]], radius_mm: f64) -> LiftedRope {
        let knots: Vec<[f64; 3]> = (markers.iter())
            .map(|&marker| {
                let at = turned(self.turn, marker);
                [0, 1, 2].map(|k| at[k] - self.origin[k])
            })
            .collect();
        let last = knots.len() - 1;
        let mirrored = |at: [f64; 3], p: [f64; 3]| [0, 1, 2].map(|k| 2.0 * at[k] - p[k]);
        let mut line = Vec::with_capacity(FINER * last + 1);
        for i in 0..last {
            let before = match i {
                0 => mirrored(knots[0], knots[1]),
                _ => knots[i - 1],
            };
            let after = match knots.get(i + 2) {
                Some(&after) => after,
                None => mirrored(knots[last], knots[last - 1]),
            };
            let around = [before, knots[i], knots[i + 1], after];
            line.extend((0..FINER).map(|k| spline::between(around, far, k as f64 / FINER as f64)));
        }
        line.push(knots[last]);
        LiftedRope::along(&line, radius_mm)
    }
}

/// A point in axes that are turned about the vertical: to the right, up, and to the one who looks.
fn turned([cos, sin]: [f64; 2], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [cos * x + sin * y, z, sin * x - cos * y]
}

/// Follows the rope through a sequence.
fn follow(frames: &[Vec<[f64; 3]>], seed: u64, args: &Args, tally: &mut Tally) -> Result<()> {
    let stage = Stage::of(frames);
    let [color, beside] = stage.eyes;
    let sensor = DepthSensor::STEREO;
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
        let units = depth(&rope, &beside, &sensor, seed << 32 | k as u64);
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
            let curves: Vec<time::SeenPoints> = curves
                .map(|(curve, hidden)| (curve.points(), &hidden[..]))
                .collect();
            time::draw(&picture, SIZE, (&truth, &curves), &path)?;
        }
    }
    Ok(())
}

/// How far the centerlines' points are from the axis in the picture.
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

/// What was found in all frames.
#[derive(Default)]
struct Tally {
    sequences: u64,
    frames: u64,
    seen: u64,
    /// Frames without a rope in space, by the reason.
    missing: BTreeMap<String, u64>,
    points: Samples,
    ends: Samples,
    curve: Samples,
    bad: u64,
    renamed: u64,
    turned: u64,
    us: Samples,
}

impl Tally {
    /// Takes in a frame's answer. `before`: the rope's number in the last frame that had one, and whether it begins where the truth does.
    /// Says what is wrong.
    fn judge(
        &mut self,
        curves: &[Descriptor3],
        truth: &[[f64; 3]],
        before: &mut Option<(u32, bool)>,
    ) -> Option<String> {
        self.frames += 1;
        let (one, shape) = match only(curves) {
            Ok(found) => found,
            Err(reason) => {
                *self.missing.entry(reason.clone()).or_default() += 1;
                return Some(reason);
            }
        };
        self.seen += 1;
        let points: Vec<[f64; 3]> = one.points().iter().map(|p| p.map(f64::from)).collect();
        let off: Vec<f64> = points.iter().map(|&p| beside_axis(p, truth)).collect();
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        let mut tips = [points[0], points[points.len() - 1]];
        let [first, last] = [truth[0], truth[truth.len() - 1]];
        let is_forward =
            far(tips[0], first) + far(tips[1], last) < far(tips[0], last) + far(tips[1], first);
        if !is_forward {
            tips.reverse();
        }
        let ends = [far(tips[0], first), far(tips[1], last)];
        off.iter().for_each(|&mm| self.points.push(mm));
        ends.iter().for_each(|&mm| self.ends.push(mm));
        shape
            .points::<120>()
            .iter()
            .for_each(|&p| self.curve.push(beside_axis(p, truth)));
        let [was_renamed, was_turned] = match before.replace((one.track, is_forward)) {
            Some((track, way)) => [track != one.track, way != is_forward],
            None => [false; 2],
        };
        let is_bad = mean > BAD_MM;
        self.bad += u64::from(is_bad);
        self.renamed += u64::from(was_renamed);
        self.turned += u64::from(was_turned);
        let wrong = [
            is_bad.then(|| {
                format!(
                    "points are {mean:.1} mm from the axis, ends {:.0} and {:.0}",
                    ends[0], ends[1]
                )
            }),
            was_renamed.then(|| "renamed".to_owned()),
            was_turned.then(|| "turned".to_owned()),
        ];
        let wrong: Vec<String> = wrong.into_iter().flatten().collect();
        (!wrong.is_empty()).then(|| wrong.join(", "))
    }

    fn wrong(&self) -> u64 {
        self.frames - self.seen + self.bad + self.renamed + self.turned
    }

    fn take(&mut self, other: Self) {
        self.sequences += other.sequences;
        self.frames += other.frames;
        self.seen += other.seen;
        for (reason, count) in other.missing {
            *self.missing.entry(reason).or_default() += count;
        }
        self.points.take(other.points);
        self.ends.take(other.ends);
        self.curve.take(other.curve);
        self.bad += other.bad;
        self.renamed += other.renamed;
        self.turned += other.turned;
        self.us.take(other.us);
    }

    fn missing(&self) -> String {
        let reasons = self
            .missing
            .iter()
            .map(|(reason, count)| format!("{count} {reason}"));
        match self.missing.is_empty() {
            true => "none".to_owned(),
            false => reasons.collect::<Vec<_>>().join(", "),
        }
    }

    fn row(&self, name: &str) -> [String; 15] {
        let mm = |mm: f64| format!("{mm:.2}");
        [
            name.to_owned(),
            self.sequences.to_string(),
            self.frames.to_string(),
            self.seen.to_string(),
            mm(self.points.mean()),
            mm(self.points.percentile(0.95)),
            mm(self.points.percentile(1.0)),
            mm(self.ends.mean()),
            mm(self.ends.percentile(0.95)),
            mm(self.curve.mean()),
            mm(self.curve.percentile(0.95)),
            self.bad.to_string(),
            self.renamed.to_string(),
            self.turned.to_string(),
            format!("{:.0}", self.us.median()),
        ]
    }
}

/// The one rope of a frame; or why there is none.
fn only(curves: &[Descriptor3]) -> Result<(&Descriptor3, Shape<'_, 3>), String> {
    let known = |one: &&Descriptor3| one.place() == Some(Place::Known);
    let mut found = curves.iter().filter(known);
    match (found.next(), found.next()) {
        (Some(one), None) => match Shape::in_space(one) {
            Ok(shape) => Ok((one, shape)),
            Err(cause) => Err(cause.to_string()),
        },
        (Some(_), Some(_)) => Err("several".to_owned()),
        (None, _) => match curves {
            [] => Err("none".to_owned()),
            [one, ..] if one.status() == Some(Status::Lost) => Err("lost".to_owned()),
            [one, ..] => Err(one.place().map_or("unknown", Place::name).to_owned()),
        },
    }
}
