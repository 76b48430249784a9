//! `lariat trace`: pictures in, the ropes' shapes out. The same extraction and fit as in the chain, without
//! shared memory.

mod canvas;
mod frames;
mod masks;
mod overlay;
mod report;

use crate::calibrated::Calibrated;
use crate::descriptor_json::{Descriptor, Measure, Quality, thousandths, unit_name};
use crate::doubts;
use crate::exit::wrong_use;
use crate::fit_lines::is_closed;
use crate::inputs;
use crate::output::Existing;
use crate::picture::Picture;
use crate::settings::{self, Flags, Settings};
use crate::stages::extract::{part, part_of_mask};
use crate::stages::fit::{Rope, RopeFitter};
use crate::trace::frames::Input;
use crate::trace::masks::Masks;
use crate::trace::overlay::Overlays;
use crate::trace::report::{
    CrossingReport, CurveReport, NoticeReport, Report, StrandReport, Table, Timing,
};
use anyhow::{Context, Result};
use clap::Args;
use lariat_camera::Mapping;
use lariat_extract::{Crossing, CrossingSequence, Extractor, Mask, Region, Scene, Step};
use lariat_fit::{Line, Resampler};
use lariat_wire::Unit;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// The shapes of the ropes in pictures
#[derive(Debug, Args)]
pub(crate) struct TraceArgs {
    /// Pictures, folders of them, Y4M videos, recordings, or `-`: a Y4M video or raw frames on standard input
    #[arg(required = true, value_name = "IMAGE")]
    images: Vec<PathBuf>,
    /// Print a JSON object for each picture, one a line
    #[arg(long)]
    json: bool,
    /// Write a PNG of each picture with curve, points and control polygon drawn over it into this folder
    #[arg(long, value_name = "DIR")]
    overlay: Option<PathBuf>,
    /// Overwrite overlays that are there already
    #[arg(long)]
    force: bool,
    /// Take the pictures for one moving scene: ropes keep their number and direction
    #[arg(long)]
    video: bool,
    /// Take each picture's mask from this folder: a PNG of the picture's name and size, white for rope
    #[arg(long, value_name = "DIR")]
    masks: Option<PathBuf>,
    #[command(flatten)]
    flags: Flags,
}

/// From picture to picture of a video, which has no times here, ns.
const FRAME_NS: u64 = 1_000_000_000 / 30;

/// What is asked of sources of frames alone.
const OF_FRAMES: [&str; 6] = [
    "--from",
    "--to",
    "--every",
    "--topic",
    "--size",
    "--pixel-format",
];

/// Runs `lariat trace`.
///
/// # Errors
/// Settings that make no sense, output that cannot be written. A picture that cannot be read is reported and the
/// next one taken; the exit code tells of it.
pub(crate) fn run(args: TraceArgs) -> Result<ExitCode> {
    let settings = Settings::resolve(&args.flags.without(&OF_FRAMES))?;
    let mut tracer = Tracer::new(&settings, &args)?;
    let mut exit = ExitCode::SUCCESS;
    let mut complain = |why: anyhow::Error| {
        eprintln!("lariat: {why:#}");
        exit = ExitCode::FAILURE;
    };

    let (images, missing) = inputs::pictures(&args.images);
    missing.into_iter().for_each(&mut complain);
    if let Some(flag) = OF_FRAMES.into_iter().find(|flag| args.flags.has(flag))
        && !images.iter().any(|image| frames::names_frames(image))
    {
        wrong_use!(
            "{flag} is for videos, recordings and standard input, and there are only pictures"
        );
    }
    let mut overlays = match &args.overlay {
        Some(folder) => {
            let existing = Existing::forced(args.force);
            let masks = images
                .iter()
                .filter_map(|image| Some(tracer.masks.as_ref()?.name(image)));
            let inputs = images.iter().cloned().chain(masks).collect();
            Some(Overlays::new(folder, &images, inputs, existing)?)
        }
        None => None,
    };
    // A frame's name ends in its number.
    let names = images
        .iter()
        .map(|image| match frames::names_frames(image) {
            true => image.join("12345"),
            false => image.clone(),
        });
    let names: Vec<PathBuf> = names.collect();
    let mut printer = Printer {
        json: args.json,
        table: Table::new(&names, unit_name(tracer.unit())),
        output: io::BufWriter::new(io::stdout().lock()),
    };
    let mut is_unread = false;
    for image in &images {
        let mut input = match Input::open(image, &args) {
            Ok(input) => input,
            Err(why) => {
                complain(why);
                continue;
            }
        };
        if input.is_one_scene() {
            tracer.extractor.reset();
            tracer.fitter.forget();
        }
        tracer.is_one_scene = args.video || input.is_one_scene();
        loop {
            let begin = Instant::now();
            let traced = match input.next(&mut complain) {
                Ok(None) => break,
                Ok(Some((name, picture))) => {
                    (tracer.trace(&name, &picture, begin)).map(|report| (name, picture, report))
                }
                Err(why) => Err(why),
            };
            let (name, picture, report) = match traced {
                Ok(traced) => traced,
                Err(why) => {
                    complain(why);
                    break;
                }
            };
            // Overlays are drawn also where nobody reads this.
            is_unread = printer.is_closed_after(&report)?;
            if is_unread && overlays.is_none() {
                return Ok(ExitCode::FAILURE);
            }
            if let Some(overlays) = &mut overlays
                && let Err(why) = overlays.write(&name, picture, &report, tracer.mapping.as_ref())
            {
                complain(why);
            }
        }
    }
    Ok(match is_unread {
        true => ExitCode::FAILURE,
        false => exit,
    })
}

/// What is printed, and where.
struct Printer {
    json: bool,
    table: Table,
    output: io::BufWriter<io::StdoutLock<'static>>,
}

impl Printer {
    /// Prints a report, so that each picture's result is out before the next is begun. Whether nobody reads on.
    ///
    /// # Errors
    /// It cannot be written.
    fn is_closed_after(&mut self, report: &Report) -> Result<bool> {
        let printed = match self.json {
            true => report.write_json(&mut self.output),
            false => self.table.write(report, &mut self.output),
        };
        for notice in &report.notices {
            eprintln!("lariat: {}: {}", report.image, notice.text);
        }
        is_closed(printed.and_then(|()| self.output.flush()))
    }
}

/// The pipeline, made once.
struct Tracer {
    extractor: Extractor,
    fitter: RopeFitter,
    settings: settings::Fit,
    /// How many pictures there were before.
    count: u64,
    /// Whether a picture goes on from the one before.
    is_one_scene: bool,
    masks: Option<Masks>,
    region: Option<Region>,
    calibrated: Option<Calibrated>,
    /// The way to where points lie, for the last picture's size.
    mapping: Option<Mapping>,
    line: Resampler,
    points: Vec<[f64; 2]>,
}

impl Tracer {
    fn new(settings: &Settings, args: &TraceArgs) -> Result<Self> {
        if settings.extract.mask == Mask::External && args.masks.is_none() {
            wrong_use!(
                "the settings say mask = \"external\": name the masks' folder with --masks DIR"
            );
        }
        Ok(Self {
            extractor: Extractor::new(settings.extract.options())?,
            fitter: RopeFitter::new(&settings.fit, settings.extract.points)?,
            settings: settings.fit.clone(),
            count: 0,
            is_one_scene: false,
            masks: args.masks.as_deref().map(Masks::new).transpose()?,
            region: settings.extract.roi,
            calibrated: Calibrated::load(&settings.camera)?,
            mapping: None,
            line: Resampler::new(),
            points: Vec::new(),
        })
    }

    /// What descriptors come in.
    fn unit(&self) -> Unit {
        self.calibrated
            .as_ref()
            .map_or(Unit::Pixel, Calibrated::unit)
    }

    /// The ropes in the picture at `path`, which was begun with at a moment.
    fn trace(&mut self, path: &Path, picture: &Picture, begin: Instant) -> Result<Report> {
        let about = || path.display().to_string();
        let whole = picture.image().with_context(about)?;
        let (region, image) = part(&whole, self.region).with_context(about)?;
        let size = [picture.width(), picture.height()];
        if let Some(calibrated) = &self.calibrated {
            self.mapping = Some(calibrated.mapping(size).with_context(about)?);
        }
        let mask = match &self.masks {
            Some(masks) => Some(masks.of(path)?),
            None => None,
        };
        let mut timing = Timing {
            decode: since(begin),
            ..Timing::default()
        };

        if !self.is_one_scene {
            self.extractor.reset();
            self.fitter.forget();
        }
        let seen_ns = self.count * FRAME_NS;
        self.count += 1;
        let mut last = Instant::now();
        let mut watch = |step| {
            let spent = match step {
                Step::Follow => &mut timing.follow,
                Step::Mask => &mut timing.mask,
                Step::Skeleton => &mut timing.skeleton,
                Step::Graph => &mut timing.graph,
                Step::Points => &mut timing.points,
            };
            *spent += since(last);
            last = Instant::now();
        };
        let scene = match &mask {
            None => self.extractor.extract_observed(&image, &mut watch),
            Some((name, mask)) => {
                let about = || name.display().to_string();
                let mask = mask.image().with_context(about)?;
                let mask = part_of_mask(mask, &whole, region).with_context(about)?;
                self.extractor
                    .extract_masked_observed(&image, &mask, &mut watch)
                    .with_context(about)?
            }
        };

        last = Instant::now();
        let unit = self
            .calibrated
            .as_ref()
            .map_or(Unit::Pixel, Calibrated::unit);
        let unit = unit_name(unit);
        let mut descriptors = Vec::with_capacity(scene.curves.len());
        let mut coarse = Vec::new();
        for curve in scene.curves {
            self.points.clear();
            for p in &curve.points {
                let [x, y] = p.map(f64::from);
                let pixel = [x + region.x as f64, y + region.y as f64];
                self.points.push(match &self.mapping {
                    None => pixel,
                    Some(mapping) => mapping.place(pixel).with_context(about)?.point,
                });
            }
            let mut length = f64::from(curve.length_px);
            let mut unit_per_px = 1.0;
            if self.mapping.is_some() {
                let even = self
                    .line
                    .resample(&self.points, curve.closed)
                    .with_context(about)?;
                self.points.copy_from_slice(even);
                unit_per_px = self.line.length() / length;
                length = self.line.length();
            }
            let width = f64::from(curve.width_px) * unit_per_px;
            let rope = Rope {
                track: curve.track,
                closed: curve.closed,
                width,
                unit_per_px,
                seen_ns: seen_ns.saturating_sub(curve.age_ns),
            };
            let line = Line {
                points: &self.points,
                weights: None,
                hidden: &curve.hidden,
            };
            let judged = self.fitter.fit(rope, &line)?;
            let fit = self.fitter.fitter(curve.closed).last();
            let mut descriptor = Descriptor::of(fit);
            descriptor.quality = Some(Quality::of(fit, judged.is_good, width));
            if !judged.is_good {
                let quality = Quality::of(fit, false, width);
                coarse.push(NoticeReport {
                    kind: "coarse-curve",
                    text: format!(
                        "rope {}: {}",
                        curve.track,
                        self.settings.coarse(
                            quality.rms_widths,
                            quality.worst_widths,
                            fit.control_points.len()
                        )
                    ),
                });
            }
            descriptor.measure = Some(Measure { unit, length });
            descriptors.push(descriptor.rounded());
        }
        timing.fit = since(last);
        timing.total = since(begin);
        let mut report = report(path, picture, &scene, region, descriptors, timing.rounded());
        report.notices.extend(coarse);
        Ok(report)
    }
}

fn report(
    path: &Path,
    picture: &Picture,
    scene: &Scene,
    region: Region,
    descriptors: Vec<Descriptor>,
    timing_us: Timing,
) -> Report {
    let curves = descriptors.into_iter().enumerate();
    let crossings = scene.crossings.iter();
    let origin = [region.x as f32, region.y as f32];
    Report {
        image: path.display().to_string(),
        width: picture.width(),
        height: picture.height(),
        curves: curves
            .map(|(index, descriptor)| curve_report(scene, origin, index, descriptor))
            .collect(),
        crossings: crossings
            .map(|crossing| crossing_report(scene, origin, crossing))
            .collect(),
        notices: (scene.notice.into_iter())
            .map(|notice| NoticeReport {
                kind: notice.name(),
                text: doubts::sentence(notice),
            })
            .collect(),
        timing_us,
    }
}

/// `origin` is where in the picture the extractor's own begins.
fn curve_report(
    scene: &Scene,
    origin: [f32; 2],
    index: usize,
    descriptor: Descriptor,
) -> CurveReport {
    let curve = &scene.curves[index];
    let sequence = CrossingSequence::of(scene, index);
    let rounded = |x: &f32| thousandths((*x).into());
    CurveReport {
        track: curve.track,
        status: report::status_name(curve.status),
        closed: curve.closed,
        border: curve.border,
        length_px: rounded(&curve.length_px),
        width_px: rounded(&curve.width_px),
        points: curve
            .points
            .iter()
            .map(|p| [0, 1].map(|axis| rounded(&(p[axis] + origin[axis]))))
            .collect(),
        widths_px: curve.widths_px.iter().map(rounded).collect(),
        hidden: (0..curve.points.len())
            .filter(|&i| curve.hidden.get(i) == Some(&true))
            .collect(),
        age_ms: curve.age_ns as f64 / 1e6,
        crossing_sequence: sequence.to_string(),
        pulls_straight: sequence.pulls_straight(),
        descriptor,
    }
}

fn crossing_report(scene: &Scene, origin: [f32; 2], crossing: &Crossing) -> CrossingReport {
    let strand = |curve: usize, rho: f32| StrandReport {
        track: scene.curves[curve].track,
        // To a tenth of a pixel of a rope of a thousand.
        rho: (f64::from(rho) * 1e4).round() / 1e4,
    };
    CrossingReport {
        at: [0, 1].map(|axis| thousandths((crossing.at[axis] + origin[axis]).into())),
        over: strand(crossing.over, crossing.over_rho),
        under: strand(crossing.under, crossing.under_rho),
        confidence: thousandths(crossing.confidence.into()),
    }
}

/// Microseconds since `begin`.
fn since(begin: Instant) -> f64 {
    begin.elapsed().as_secs_f64() * 1e6
}
