//! The pipeline on pictures, with the time of each step.

use crate::descriptor_json::{Descriptor, Measure, Quality};
use crate::trace::frames::{Input, Shown};
use crate::trace::masks::{MaskOf, Masks};
use crate::trace::report::{NoticeReport, Report, Timing};
use anyhow::{Context, Result};
use lariat_camera::Mapping;
use lariat_chain::exit::wrong_use;
use lariat_chain::pipeline::{CurveFitter, FrameExtractor, Part, Schedule};
use lariat_chain::settings::{self, Settings};
use lariat_extract::{Image, Mask, Scene, Step};
use lariat_wire::{Centerlines, Unit};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Time between pictures without a given frame rate, ns.
const FRAME_NS: u64 = 1_000_000_000 / 30;

/// The pipeline, which is made once.
pub(super) struct Tracer {
    extractor: FrameExtractor,
    curves: CurveFitter,
    settings: settings::Fit,
    masks: Option<Masks>,
    /// True if a picture continues the one before.
    is_one_scene: bool,
    /// Exposure times of the pictures.
    schedule: Schedule,
    exposed_ns: u64,
    centerlines: Box<Centerlines>,
}

impl Tracer {
    /// Makes the pipeline. `masks`: folder of external masks, if any.
    ///
    /// # Errors
    /// Returns an error if settings are invalid, or if files that they name cannot be read.
    pub(super) fn new(settings: &Settings, masks: Option<&Path>) -> Result<Self> {
        if settings.extract.mask == Mask::External && masks.is_none() {
            wrong_use!(
                "the settings say mask = \"external\": name the masks' folder with --masks DIR"
            );
        }
        Ok(Self {
            extractor: FrameExtractor::new(&settings.extract)?,
            curves: CurveFitter::new(settings)?,
            settings: settings.fit.clone(),
            masks: masks
                .map(|folder| Masks::new(folder, settings.extract.mask_level.is_none()))
                .transpose()?,
            is_one_scene: false,
            schedule: Schedule::new(&settings.capture, true)?,
            exposed_ns: 0,
            centerlines: Box::new(Centerlines::EMPTY),
        })
    }

    /// Unit of the descriptors.
    pub(super) fn unit(&self) -> Unit {
        self.curves.unit()
    }

    /// Mapping from pixels to the descriptors' points, for the size of the last picture.
    pub(super) fn mapping(&self) -> Option<&Mapping> {
        self.curves.mapping()
    }

    /// Path of the mask for the picture at `path`, if masks are external.
    pub(super) fn mask_of(&self, path: &Path) -> Option<PathBuf> {
        self.masks.as_ref()?.name(path)
    }

    /// Begins with the pictures of this input. `is_video`: picture files, too, are one scene.
    pub(super) fn begin(&mut self, input: &mut Input, is_video: bool) {
        let schedule = input.take_schedule();
        self.is_one_scene = is_video || schedule.is_some();
        if let Some(schedule) = schedule {
            self.schedule = schedule;
            self.forget();
        }
    }

    /// Forgets the scene, because another one follows.
    fn forget(&mut self) {
        self.extractor.forget();
        self.curves.forget();
    }

    /// Traces the ropes in a picture. `begin`: start time of the work on it.
    ///
    /// # Errors
    /// Returns an error if the picture or its mask cannot be read, or a rope cannot be fitted.
    pub(super) fn trace(&mut self, shown: &Shown, begin: Instant) -> Result<Report> {
        let about = || shown.name.display().to_string();
        let picture = &shown.picture;
        let whole = picture.image().with_context(about)?;
        let part = self.extractor.part(whole).with_context(about)?;
        let size = [picture.width(), picture.height()];
        self.curves.turn_to(size).with_context(about)?;
        let mask = match &self.masks {
            Some(masks) => Some(masks.of(&shown.name, size)?),
            None => None,
        };
        let mut timing = Timing {
            decode: since(begin),
            ..Timing::default()
        };
        if !self.is_one_scene {
            self.forget();
        }
        let ready_ns = self.exposed_ns + FRAME_NS;
        self.exposed_ns = (self.schedule).due_ns(ready_ns, shown.exposed_ns, shown.after_ns);
        self.centerlines.trace.exposed_ns = self.exposed_ns;

        let (extractor, seen) = (&mut self.extractor, &mut *self.centerlines);
        let scene = match &mask {
            None => extract(extractor, &part, None, seen, &mut timing),
            Some(mask) => {
                let image = mask.image()?;
                extract(extractor, &part, Some(image), seen, &mut timing)
                    .with_context(|| mask.path.display().to_string())
            }
        }?;
        let fitting = Instant::now();
        let (descriptors, coarse) =
            describe(&mut self.curves, &self.settings, seen).with_context(about)?;
        timing.fit = since(fitting);
        timing.total = since(begin);
        let notice = scene.notice;
        let mut report = Report::of(shown, &scene, part.origin(), descriptors, timing.rounded());
        report.notices.extend(notice.map(|notice| NoticeReport {
            kind: notice.name(),
            text: self.extractor.sentence(notice),
        }));
        report.notices.extend(coarse);
        if let Some(mask) = mask {
            report
                .notices
                .extend(about_mask(&mask, report.curves.is_empty()));
        }
        Ok(report)
    }
}

/// Extracts a picture's centerlines, and times the steps.
fn extract<'a>(
    extractor: &'a mut FrameExtractor,
    part: &Part,
    mask: Option<Image>,
    message: &mut Centerlines,
    timing: &mut Timing,
) -> Result<Scene<'a>> {
    let exposed_ns = message.trace.exposed_ns;
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
    extractor.extract(part, mask, exposed_ns, &mut watch, message)
}

/// Returns the descriptors of all curves, and notices about those that do not fit their points.
fn describe(
    curves: &mut CurveFitter,
    settings: &settings::Fit,
    seen: &Centerlines,
) -> Result<(Vec<Descriptor>, Vec<NoticeReport>)> {
    let unit = curves.unit().name();
    let mut described = lariat_wire::Descriptor::EMPTY;
    let mut descriptors = Vec::with_capacity(seen.curves().len());
    let mut coarse = Vec::new();
    for curve in seen.curves() {
        let judged = curves.describe(curve, seen.trace.exposed_ns, &mut described)?;
        let fit = curves.last_fit(curve);
        let quality = Quality::of(fit, judged.is_good, described.width);
        if !judged.is_good {
            let Quality {
                rms_widths,
                worst_widths,
                ..
            } = quality;
            let said = settings.coarse(rms_widths, worst_widths, fit.control_points.len());
            coarse.push(NoticeReport {
                kind: "coarse-curve",
                text: format!("rope {}: {said}", curve.track),
            });
        }
        let mut descriptor = Descriptor::of(fit);
        descriptor.control_points = described.control_points().to_vec();
        descriptor.quality = Some(quality);
        let length = described.length;
        descriptor.measure = Some(Measure { unit, length });
        descriptors.push(descriptor.rounded());
    }
    Ok((descriptors, coarse))
}

/// Start of the upper half of levels, where a network considers a pixel likelier rope than not.
const LIKELY: u8 = 128;

/// Notices about a mask: how it was interpreted, and why it shows no rope.
fn about_mask(mask: &MaskOf, is_empty: bool) -> impl Iterator<Item = NoticeReport> + use<> {
    let brightest = mask.brightest();
    let faint = (is_empty && (1..LIKELY).contains(&brightest)).then(|| {
        format!(
            "its brightest level is {brightest} of 255, and no rope stands out in it (mask_level sets the level of rope)"
        )
    });
    let about = mask.path.display().to_string();
    let said = mask.news.iter().cloned().chain(faint);
    let said: Vec<_> = said.map(|said| format!("{about}: {said}")).collect();
    said.into_iter()
        .map(|text| NoticeReport { kind: "mask", text })
}

/// Microseconds since `begin`.
fn since(begin: Instant) -> f64 {
    begin.elapsed().as_secs_f64() * 1e6
}
