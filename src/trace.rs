//! `lariat trace`: pictures in, the ropes' shapes out. The same extraction and fit as in the chain, without
//! shared memory.

mod canvas;
mod masks;
mod overlay;
mod report;

use crate::descriptor_json::{Descriptor, thousandths};
use crate::doubts;
use crate::fit_lines::is_closed;
use crate::inputs;
use crate::picture::Picture;
use crate::settings::{Settings, ShapeArgs};
use crate::trace::masks::Masks;
use crate::trace::overlay::Overlays;
use crate::trace::report::{
    CrossingReport, CurveReport, Format, NoticeReport, Report, StrandReport, Table, Timing,
};
use anyhow::{Context, Result, bail};
use clap::Args;
use lariat_extract::{Crossing, CrossingSequence, Extractor, Mask, Scene, Step};
use lariat_fit::Fitter;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// The shapes of the ropes in pictures
#[derive(Debug, Args)]
pub(crate) struct TraceArgs {
    /// PNG or JPEG pictures, or folders of them
    #[arg(required = true, value_name = "IMAGE")]
    images: Vec<PathBuf>,
    /// What to print: a table for people, or a JSON object a line
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,
    /// Write a PNG of each picture with curve, points and control polygon drawn over it into this folder
    #[arg(long, value_name = "DIR")]
    overlay: Option<PathBuf>,
    /// Take the pictures for one moving scene: ropes keep their number and direction
    #[arg(long)]
    video: bool,
    /// Take each picture's mask from this folder: a PNG of the picture's name and size, white for rope
    #[arg(long, value_name = "DIR")]
    mask: Option<PathBuf>,
    #[command(flatten)]
    shape: ShapeArgs,
}

/// Runs `lariat trace`.
///
/// # Errors
/// Settings that make no sense, output that cannot be written. A picture that cannot be read is reported and the
/// next one taken; the exit code tells of it.
pub(crate) fn run(args: TraceArgs) -> Result<ExitCode> {
    let settings = Settings::resolve(&args.shape.clone().into())?;
    let mut tracer = Tracer::new(&settings, &args)?;
    let mut exit = ExitCode::SUCCESS;
    let mut complain = |why: anyhow::Error| {
        eprintln!("lariat: {why:#}");
        exit = ExitCode::FAILURE;
    };

    let (images, missing) = inputs::pictures(&args.images);
    missing.into_iter().for_each(&mut complain);
    let mut overlays = match &args.overlay {
        Some(folder) => Some(Overlays::new(folder, &images)?),
        None => None,
    };
    let mut table = Table::new(&images);
    let mut output = io::BufWriter::new(io::stdout().lock());
    for image in &images {
        let (picture, report) = match tracer.trace(image) {
            Ok(traced) => traced,
            Err(why) => {
                complain(why);
                continue;
            }
        };
        let printed = match args.format {
            Format::Jsonl => report.write_json(&mut output),
            Format::Table => table.write(&report, &mut output),
        };
        for notice in &report.notices {
            eprintln!("lariat: {}: {}", image.display(), notice.text);
        }
        // Each picture's result is out before the next is begun.
        if is_closed(printed.and_then(|()| output.flush()))? {
            break;
        }
        if let Some(overlays) = &mut overlays
            && let Err(why) = overlays.write(image, picture, &report)
        {
            complain(why);
        }
    }
    Ok(exit)
}

/// The pipeline, made once.
struct Tracer {
    extractor: Extractor,
    open: Fitter,
    closed: Fitter,
    is_video: bool,
    masks: Option<Masks>,
    points: Vec<[f64; 2]>,
}

impl Tracer {
    fn new(settings: &Settings, args: &TraceArgs) -> Result<Self> {
        if settings.extract.mask == Mask::External && args.mask.is_none() {
            bail!("the settings say mask = \"external\": name the masks' folder with --mask DIR");
        }
        Ok(Self {
            extractor: Extractor::new(settings.extract.options())?,
            open: Fitter::new(settings.fit.options(settings.extract.points, false))?,
            closed: Fitter::new(settings.fit.options(settings.extract.points, true))?,
            is_video: args.video,
            masks: args.mask.as_deref().map(Masks::new).transpose()?,
            points: Vec::new(),
        })
    }

    /// The ropes in the picture at `path`.
    fn trace(&mut self, path: &Path) -> Result<(Picture, Report)> {
        let begin = Instant::now();
        let picture = Picture::load(path)?;
        let image = picture
            .image()
            .with_context(|| path.display().to_string())?;
        let mask = match &self.masks {
            Some(masks) => Some(masks.of(path)?),
            None => None,
        };
        let mut timing = Timing {
            decode: since(begin),
            ..Timing::default()
        };

        if !self.is_video {
            self.extractor.reset();
        }
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
                self.extractor
                    .extract_masked_observed(&image, &mask, &mut watch)
                    .with_context(about)?
            }
        };

        last = Instant::now();
        let mut descriptors = Vec::with_capacity(scene.curves.len());
        for curve in scene.curves {
            self.points.clear();
            self.points
                .extend(curve.points.iter().map(|p| p.map(f64::from)));
            let fitter = if curve.closed {
                &mut self.closed
            } else {
                &mut self.open
            };
            descriptors.push(Descriptor::of(fitter.fit(&self.points)?).rounded());
        }
        timing.fit = since(last);
        timing.total = since(begin);
        let report = report(path, &picture, &scene, descriptors, timing.rounded());
        Ok((picture, report))
    }
}

fn report(
    path: &Path,
    picture: &Picture,
    scene: &Scene,
    descriptors: Vec<Descriptor>,
    timing_us: Timing,
) -> Report {
    let curves = descriptors.into_iter().enumerate();
    let crossings = scene.crossings.iter();
    Report {
        image: path.display().to_string(),
        width: picture.width(),
        height: picture.height(),
        curves: curves
            .map(|(index, descriptor)| curve_report(scene, index, descriptor))
            .collect(),
        crossings: crossings
            .map(|crossing| crossing_report(scene, crossing))
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

fn curve_report(scene: &Scene, index: usize, descriptor: Descriptor) -> CurveReport {
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
            .map(|p| p.map(|c| rounded(&c)))
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

fn crossing_report(scene: &Scene, crossing: &Crossing) -> CrossingReport {
    let strand = |curve: usize, rho: f32| StrandReport {
        track: scene.curves[curve].track,
        // To a tenth of a pixel of a rope of a thousand.
        rho: (f64::from(rho) * 1e4).round() / 1e4,
    };
    CrossingReport {
        at: crossing.at.map(|c| thousandths(c.into())),
        over: strand(crossing.over, crossing.over_rho),
        under: strand(crossing.under, crossing.under_rho),
        confidence: thousandths(crossing.confidence.into()),
    }
}

/// Microseconds since `begin`.
fn since(begin: Instant) -> f64 {
    begin.elapsed().as_secs_f64() * 1e6
}
