//! `lariat-bench 3d`: drawn ropes in front of a color camera and a depth camera, or two color
//! cameras, through extraction and fit, compared with the true axis.

mod deform;
mod pickle;

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::Table;
use anyhow::{Context, Result};
use lariat_chain::pipeline::{Companion, FrameExtractor, FrameView, SpaceFitter};
use lariat_chain::settings::{self, Settings};
use lariat_drawn::space::{DepthSensor, Eye, LiftOptions, LiftedRope, depth, picture};
use lariat_fit::{Fitter, Line};
use lariat_wire::{
    Basis, Centerlines, Descriptor3, Descriptors3, FitQuality, FrameHeader, PixelFormat, Place,
    Shape, Status,
};

/// What to measure.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Number of ropes of each row
    #[arg(long, value_name = "N", default_value_t = 24)]
    seeds: u64,
    /// Seed of the first rope
    #[arg(long, value_name = "N", default_value_t = 0)]
    first_seed: u64,
    /// Only rows whose name contains this text
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
    /// Write the drawing of the first of the rows to this folder instead of measuring: pictures of
    /// both cameras, both calibrations, true axes
    #[arg(long, value_name = "DIR")]
    write: Option<PathBuf>,
    /// Folder data_set of DEFORM's repository: measure ropes that move as in its motion capture
    /// instead of the drawn ones, one row per kind of rope
    #[arg(long, value_name = "DIR", conflicts_with = "write")]
    deform: Option<PathBuf>,
    /// Maximum number of frames of each of its sequences
    #[arg(long, value_name = "N", default_value_t = 500, requires = "deform")]
    frames: usize,
    /// Width at which its ropes are drawn, in mm
    #[arg(long, value_name = "MM", default_value_t = 8.0, value_parser = width, requires = "deform")]
    width_mm: f64,
    /// Print which of its frames are wrong
    #[arg(long, requires = "deform")]
    verbose: bool,
    /// Write the wrong frames, with centerline and truth drawn over them, to this folder
    #[arg(long, value_name = "DIR", requires = "deform")]
    overlay: Option<PathBuf>,
}

/// Parses a rope's width.
fn width(text: &str) -> Result<f64, String> {
    let width = text
        .parse()
        .ok()
        .filter(|width| (1.0..100.0).contains(width));
    width.ok_or_else(|| format!("'{text}' is not a rope width in mm: from 1 to 100"))
}

const SIZE: [usize; 2] = [848, 480];
/// Squared radius that contains 95 % of a standard normal distribution with three degrees of
/// freedom.
const CHI_SQUARED_95: f64 = 7.815;
/// Position of the depth camera relative to the color camera, mm.
const ASIDE: [f64; 3] = [-15.0, 0.0, 0.0];

/// Position of a second color camera, which is turned to look at the same point, mm.
const BASELINE: [f64; 3] = [100.0, 0.0, 0.0];
const FOCAL_PX: f64 = 610.0;

/// The scene of a row.
#[derive(Clone, Copy)]
struct Scene {
    distance_mm: f64,
    options: LiftOptions,
    beside: Beside,
}

/// The device next to the color camera.
#[derive(Clone, Copy)]
enum Beside {
    Depth(DepthSensor),
    Second,
}

const USUAL: Scene = Scene {
    distance_mm: 500.0,
    options: LiftOptions {
        length_mm: 600.0,
        radius_mm: 4.0,
        lift_mm: 80.0,
        crossings: 1,
    },
    beside: Beside::Depth(DepthSensor::STEREO),
};

fn rows() -> Vec<(String, Scene)> {
    let mut rows = of_ropes("", USUAL);
    let sensor = |change: &dyn Fn(&mut DepthSensor)| {
        let mut sensor = DepthSensor::STEREO;
        change(&mut sensor);
        Scene {
            beside: Beside::Depth(sensor),
            ..USUAL
        }
    };
    let sensors = [
        (
            "a third of the noise",
            sensor(&|sensor| sensor.noise_per_mm /= 3.0),
        ),
        (
            "twice the noise",
            sensor(&|sensor| sensor.noise_per_mm *= 2.0),
        ),
        (
            "noise shared by 3×3 pixels",
            sensor(&|sensor| sensor.grain_px = 3),
        ),
        ("a tenth of holes", sensor(&|sensor| sensor.holes = 0.1)),
    ];
    rows.extend(sensors.map(|(name, scene)| (name.to_owned(), scene)));
    let views = Scene {
        beside: Beside::Second,
        ..USUAL
    };
    rows.extend(of_ropes("two views, ", views));
    rows
}

/// Returns rows with several ropes and distances.
fn of_ropes(before: &str, usual: Scene) -> Vec<(String, Scene)> {
    let name = format!("{before}usual: 0.5 m, 8 mm, lift 80, 1 crossing");
    let mut rows = vec![(name, usual)];
    let mut add = |name: String, change: &dyn Fn(&mut Scene)| {
        let mut scene = usual;
        change(&mut scene);
        rows.push((format!("{before}{name}"), scene));
    };
    for crossings in [0, 2] {
        add(format!("{crossings} crossings"), &|scene| {
            scene.options.crossings = crossings;
        });
    }
    for lift_mm in [0.0, 160.0] {
        add(format!("lift {lift_mm} mm"), &|scene| {
            scene.options.lift_mm = lift_mm;
        });
    }
    for width_mm in [4.0, 6.0, 12.0] {
        add(format!("width {width_mm} mm"), &|scene| {
            scene.options.radius_mm = 0.5 * width_mm;
        });
    }
    for distance_mm in [350.0, 800.0] {
        add(format!("distance {distance_mm} mm"), &|scene| {
            scene.distance_mm = distance_mm;
            // The rope fills as much of the picture as before.
            scene.options.length_mm *= (distance_mm / 500.0_f64).min(1.0);
        });
    }
    add("distance 800 mm, 4 mm wide".to_owned(), &|scene| {
        (scene.distance_mm, scene.options.radius_mm) = (800.0, 2.0);
    });
    rows
}

/// Measures and prints the table.
///
/// # Errors
/// A temporary folder cannot be created, or such a rope cannot be drawn.
pub(crate) fn run(args: &Args) -> Result<()> {
    if let Some(folder) = &args.write {
        return write(args, folder);
    }
    if let Some(folder) = &args.deform {
        return deform::run(args, folder);
    }
    let mut table = Table::new(&[
        "scene",
        "ropes",
        "found",
        "thin",
        "coarse",
        "size",
        "mean mm",
        "95 %",
        "worst",
        "ends: worst",
        "curve: mean",
        "95 %",
        "in 95 %",
        "µs",
    ]);
    for (name, scene) in rows() {
        if args.only.as_ref().is_some_and(|only| !name.contains(only)) {
            continue;
        }
        let mut score = Score::default();
        for seed in args.first_seed..args.first_seed + args.seeds {
            measure(&scene, seed, &mut score).with_context(|| format!("{name}, seed {seed}"))?;
        }
        table.push(score.row(name, args.seeds));
    }
    print!("{table}")?;
    Ok(())
}

/// The output of the two cameras.
struct Shot {
    eyes: [Eye; 2],
    rope: LiftedRope,
    picture: Vec<u8>,
    beside: Image,
}

enum Image {
    Depth(Vec<u16>),
    Second(Vec<u8>),
}

impl Scene {
    /// Returns the color camera and the device next to it.
    fn eyes(&self, seed: u64) -> [Eye; 2] {
        let color = Eye::above(FOCAL_PX, SIZE, self.distance_mm, 15.0, 40.0 * seed as f64);
        let beside = match self.beside {
            Beside::Depth(_) => color.beside(ASIDE, 425.0, SIZE),
            Beside::Second => color.verging(BASELINE, self.distance_mm),
        };
        [color, beside]
    }

    fn draw(&self, seed: u64) -> Result<Shot> {
        let eyes @ [color, beside] = self.eyes(seed);
        let rope = LiftedRope::new(&self.options, &color, seed)?;
        Ok(Shot {
            picture: picture(&rope, &color, seed),
            beside: match &self.beside {
                Beside::Depth(sensor) => Image::Depth(depth(&rope, &beside, sensor, seed)),
                Beside::Second => Image::Second(picture(&rope, &beside, seed)),
            },
            eyes,
            rope,
        })
    }
}

fn write(args: &Args, folder: &Path) -> Result<()> {
    let name = args.only.as_deref().unwrap_or_default();
    let mut rows = rows().into_iter();
    let (_, scene) = (rows.find(|(row, _)| row.contains(name))).context("there is no such row")?;
    let beside = match scene.beside {
        Beside::Depth(_) => "depth",
        Beside::Second => "second",
    };
    let [pictures, besides] = ["color", beside].map(|name| folder.join(name));
    fs::create_dir_all(&pictures)?;
    fs::create_dir_all(&besides)?;
    settings(&scene.eyes(0), &scene.beside, folder)?;
    let [width, height] = SIZE.map(|side| side as u32);
    let save = |picture: Vec<u8>, path: PathBuf| {
        let picture = image::RgbImage::from_raw(width, height, picture);
        anyhow::Ok(picture.context("a picture")?.save(path)?)
    };
    let mut axes = Vec::new();
    for seed in args.first_seed..args.first_seed + args.seeds {
        let shot = scene.draw(seed)?;
        let name = format!("{seed:04}.png");
        save(shot.picture, pictures.join(&name))?;
        match shot.beside {
            Image::Second(picture) => save(picture, besides.join(&name))?,
            Image::Depth(units) => {
                let image =
                    image::ImageBuffer::<image::Luma<u16>, _>::from_raw(width, height, units);
                image.context("a depth image")?.save(besides.join(&name))?;
            }
        }
        let every = shot.rope.points.iter().step_by(20);
        axes.push(every.map(|&p| shot.eyes[0].see(p)).collect::<Vec<_>>());
    }
    fs::write(folder.join("axes.json"), serde_json::to_vec(&axes)?)?;
    Ok(())
}

#[derive(Default)]
struct Score {
    found: u64,
    thin: u64,
    coarse: u64,
    sizes: Vec<f64>,
    points: Vec<f64>,
    ends: Vec<f64>,
    curve: Vec<f64>,
    within: [u64; 2],
    us: Vec<f64>,
}

impl Score {
    fn row(mut self, name: String, ropes: u64) -> [String; 14] {
        let share = |of: &mut Vec<f64>, share: f64| {
            of.sort_by(f64::total_cmp);
            let last = of.len().saturating_sub(1);
            let at = of.get((share * last as f64).round() as usize);
            at.map_or_else(|| "-".to_owned(), |mm| format!("{mm:.2}"))
        };
        let mean = |of: &[f64]| match of.len() {
            0 => "-".to_owned(),
            n => format!("{:.2}", of.iter().sum::<f64>() / n as f64),
        };
        let [within, of] = self.within;
        [
            name,
            ropes.to_string(),
            self.found.to_string(),
            self.thin.to_string(),
            self.coarse.to_string(),
            share(&mut self.sizes, 0.5),
            mean(&self.points),
            share(&mut self.points, 0.95),
            share(&mut self.points, 1.0),
            share(&mut self.ends, 1.0),
            mean(&self.curve),
            share(&mut self.curve, 0.95),
            format!("{:.1} %", 100.0 * within as f64 / of.max(1) as f64),
            share(&mut self.us, 0.5),
        ]
    }
}

fn measure(scene: &Scene, seed: u64, score: &mut Score) -> Result<()> {
    let Shot {
        eyes: [color, _],
        rope,
        picture,
        beside,
    } = scene.draw(seed)?;
    let folder = tempfile::tempdir().context("cannot make a temporary folder")?;
    let settings = settings(&scene.eyes(seed), &scene.beside, folder.path())?;
    let mut fitter = SpaceFitter::new(&settings)?.context("there is another camera")?;
    let header = header();
    let extract = |picture: &[u8]| {
        let mut seen = Box::new(Centerlines::EMPTY);
        let mut extractor = FrameExtractor::new(&settings.extract)?;
        extractor.answer(FrameView::new(&header, picture), None, &mut seen);
        anyhow::Ok(seen)
    };
    let depth_header = header.of_depth([header.width, header.height]);
    let (bytes, second): (Vec<u8>, _) = match &beside {
        Image::Depth(units) => (
            units.iter().flat_map(|unit| unit.to_ne_bytes()).collect(),
            None,
        ),
        Image::Second(picture) => (Vec::new(), Some(extract(picture)?)),
    };
    let companion = match &second {
        None => Companion::Depth(FrameView::new(&depth_header, &bytes)),
        Some(second) => Companion::Second(second),
    };
    let (seen, mut message) = (extract(&picture)?, Box::new(Descriptors3::EMPTY));
    let truth: Vec<[f64; 3]> = rope.points.iter().map(|&p| color.see(p)).collect();
    for _ in 0..3 {
        let began = Instant::now();
        fitter.answer(&seen, Some(companion), &mut message);
        score.us.push(began.elapsed().as_secs_f64() * 1e6);
    }
    let one = match message.curves() {
        [one] if one.status() == Some(Status::Ok) => one,
        _ => return Ok(()),
    };
    score.thin += u64::from(one.place() == Some(Place::Thin));
    let Ok(shape) = Shape::in_space(one) else {
        return Ok(());
    };
    let points: Vec<[f64; 3]> = one.points().iter().map(|p| p.map(f64::from)).collect();
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return Ok(());
    };
    let truth = match far(*first, truth[0]) < far(*last, truth[0]) {
        true => truth,
        false => truth.into_iter().rev().collect(),
    };
    score.found += 1;
    score.coarse += u64::from(one.fit() == Some(FitQuality::Coarse));
    score.sizes.push(f64::from(one.count));
    score
        .points
        .extend(points.iter().map(|&p| beside_axis(p, &truth)));
    let ends = [far(*first, truth[0]), far(*last, truth[truth.len() - 1])];
    score.ends.extend(ends);
    let curve = shape.points::<120>();
    score
        .curve
        .extend(curve.iter().map(|&p| beside_axis(p, &truth)));
    judge_covariances(one, &truth, &settings.fit, score)
}

/// Counts the control points whose error is within their 95 % ellipsoid. Their truth is obtained by
/// fitting the true axis.
fn judge_covariances(
    one: &Descriptor3,
    truth: &[[f64; 3]],
    settings: &settings::Fit,
    score: &mut Score,
) -> Result<()> {
    let count = one.points().len();
    let even: Vec<[f64; 3]> = (0..count)
        .map(|k| truth[((truth.len() - 1) as f64 * k as f64 / (count - 1) as f64).round() as usize])
        .collect();
    let mut fitter = Fitter::<3>::in_dimensions(settings.options(count, false))?;
    let line = Line::of(&even);
    for size in 0..fitter.sizes() {
        let fit = fitter.fit_at(size, &line)?;
        let inner = one.degree as usize + 1;
        let is_same = fit.control_points.len() == one.control_points().len()
            && one.basis() == Some(Basis::BSpline)
            && fit.knots.get(inner..one.count as usize) == Some(one.inner_knots());
        if !is_same && one.basis() != Some(Basis::Bezier) {
            continue;
        }
        for ((p, q), c) in
            (one.control_points().iter().zip(&fit.control_points)).zip(one.covariances())
        {
            let off = [0, 1, 2].map(|k| p[k] - q[k]);
            score.within[0] += u64::from(squared_in(c, off) < CHI_SQUARED_95);
            score.within[1] += 1;
        }
        break;
    }
    Ok(())
}

/// Returns `xᵀ C⁻¹ x` for a symmetric matrix `[xx, xy, xz, yy, yz, zz]`.
fn squared_in(c: &[f64; 6], x: [f64; 3]) -> f64 {
    let [a, b, d, e, f, g] = *c;
    let adjoint = [
        [e * g - f * f, d * f - b * g, b * f - d * e],
        [d * f - b * g, a * g - d * d, b * d - a * f],
        [b * f - d * e, b * d - a * f, a * e - b * b],
    ];
    let determinant = a * adjoint[0][0] + b * adjoint[1][0] + d * adjoint[2][0];
    let dot = |row: [f64; 3]| row[0] * x[0] + row[1] * x[1] + row[2] * x[2];
    (0..3).map(|k| x[k] * dot(adjoint[k])).sum::<f64>() / determinant
}

/// Returns the header of the color camera's frames.
fn header() -> FrameHeader {
    let [width, height] = SIZE.map(|side| side as u32);
    FrameHeader {
        width,
        height,
        stride: 3 * width,
        pixel_format: PixelFormat::Rgb8 as u32,
        ..FrameHeader::default()
    }
}

/// Returns settings that name the two cameras' files in this folder.
fn settings([color, beside]: &[Eye; 2], of: &Beside, folder: &Path) -> Result<Settings> {
    let camera = |eye: &Eye| {
        let ([focal, _], [x, y], [width, height]) = (eye.focal_px, eye.center_px, eye.size);
        format!(
            "image_width: {width}\nimage_height: {height}\ncamera_matrix: [{focal}, 0, {x}, 0, {focal}, {y}, 0, 0, 1]\n\
             distortion_coefficients: [0, 0, 0, 0]\n"
        )
    };
    let (rotation, place) = beside.pose_in(color);
    let pose = format!(
        "rotation: {:?}\ntranslation_mm: {place:?}\nrange_mm: [200, 1500]\n",
        rotation.as_flattened()
    );
    let calibration = folder.join("camera.yaml");
    fs::write(&calibration, camera(color))?;
    let mut settings = Settings::default();
    settings.camera.calibration = Some(calibration);
    let text = camera(beside) + &pose;
    match of {
        Beside::Depth(sensor) => {
            let path = folder.join("depth.yaml");
            let noise_mm = sensor.noise_per_mm * 1e6;
            fs::write(&path, format!("{text}noise_mm_at_1m: {noise_mm}\n"))?;
            settings.camera.depth = Some(path);
        }
        Beside::Second => {
            let path = folder.join("second.yaml");
            fs::write(&path, text)?;
            settings.camera.second = Some(path);
        }
    }
    Ok(settings)
}

fn far(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

fn beside_axis(point: [f64; 3], axis: &[[f64; 3]]) -> f64 {
    axis.iter()
        .map(|&on| far(point, on))
        .fold(f64::MAX, f64::min)
}
