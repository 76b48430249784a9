//! The work of the four stages without their connections, shared by the rivals and the chain.

use std::path::Path;

use anyhow::{Context, Result};
use lariat_capture::FrameSource;
use lariat_sink::{FinalCounts, Sink};
use lariat_wire::{Centerlines, Descriptors, FrameHeader, Trace, now_ns};

use lariat_chain::output::{Existing, OutputFolder};
use lariat_chain::pipeline::{CurveFitter, FrameExtractor, FrameView, Schedule, frame_header};
use lariat_chain::run_files::write_report;
use lariat_chain::settings::{Fps, Settings};
use lariat_chain::stages::arrangement::precise_timer;
use lariat_chain::stop::Stop;

/// Arguments of a rival.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct Task {
    /// Width of the picture in pixels
    #[arg(long)]
    width: u32,
    /// Height of the picture in pixels
    #[arg(long)]
    height: u32,
    /// Frames per second
    #[arg(long)]
    fps: f64,
    /// Duration of the run in seconds
    #[arg(long)]
    seconds: f64,
    /// Folder of the report
    #[arg(long)]
    out: std::path::PathBuf,
}

impl Task {
    /// Returns the task as command-line arguments.
    pub(super) fn words(size: [u32; 2], fps: f64, seconds: f64, out: &Path) -> Vec<String> {
        let mut words: Vec<String> = [
            ("--width", f64::from(size[0])),
            ("--height", f64::from(size[1])),
            ("--fps", fps),
            ("--seconds", seconds),
        ]
        .iter()
        .flat_map(|(name, value)| [(*name).to_owned(), value.to_string()])
        .collect();
        words.extend(["--out".to_owned(), out.display().to_string()]);
        words
    }

    /// Returns the chain's default settings with the task's values.
    pub(super) fn settings(&self) -> Settings {
        let mut settings = Settings::default();
        settings.capture.size = Some([self.width, self.height]);
        settings.capture.fps = Fps::PerSecond(self.fps);
        settings.run.duration = Some(std::time::Duration::from_secs_f64(self.seconds));
        settings.run.out = Some(self.out.clone());
        settings
    }
}

/// The first stage: the rendered rope. Each frame is drawn before it is due.
pub(super) struct CaptureStep {
    source: Box<dyn FrameSource>,
    schedule: Schedule,
    end_ns: Option<u64>,
    duration_ns: u64,
    captured: u64,
}

impl CaptureStep {
    pub(super) fn new(settings: &Settings) -> Result<Self> {
        precise_timer();
        Ok(Self {
            source: lariat_capture::open(&settings.source())?,
            schedule: Schedule::new(&settings.capture, false)?,
            end_ns: None,
            duration_ns: settings.run.duration_ns().unwrap_or(0),
            captured: 0,
        })
    }

    /// Returns the maximum number of bytes of a frame.
    pub(super) fn frame_bytes(&self) -> usize {
        self.source.largest_frame_bytes()
    }

    /// Writes the next frame's pixels, waits until the frame is due, and returns its header.
    /// Returns `None` when the time is over or a signal arrived.
    pub(super) fn next(&mut self, pixels: &mut [u8], stop: &Stop) -> Result<Option<FrameHeader>> {
        let Some(frame) = self.source.next()? else {
            return Ok(None);
        };
        self.source.write(pixels);
        let after_ns = self.source.due_after_ns();
        let due_ns = self.schedule.due_ns(now_ns(), frame.exposed_ns, after_ns);
        let end_ns = *self.end_ns.get_or_insert(due_ns + self.duration_ns);
        if due_ns >= end_ns || !stop.sleep_until(due_ns) {
            return Ok(None);
        }
        self.captured += 1;
        let trace = Trace {
            sequence: self.schedule.sequence(&frame),
            captured: self.captured,
            exposed_ns: due_ns,
            captured_ns: now_ns(),
            ..Trace::EMPTY
        };
        Ok(Some(frame_header(&frame, self.source.kind(), trace)))
    }
}

/// The second stage.
pub(super) struct ExtractStep {
    extractor: FrameExtractor,
    extracted: u64,
}

impl ExtractStep {
    pub(super) fn new(settings: &Settings) -> Result<Self> {
        Ok(Self {
            extractor: FrameExtractor::prepared(settings)?,
            extracted: 0,
        })
    }

    /// Extracts a frame that has just arrived into `message`.
    pub(super) fn look(&mut self, header: &FrameHeader, pixels: &[u8], message: &mut Centerlines) {
        message.trace = header.trace;
        message.trace.extract_started_ns = now_ns();
        self.extractor
            .answer(FrameView::new(header, pixels), None, message);
        self.extracted += 1;
        message.trace.extracted = self.extracted;
        message.trace.extracted_ns = now_ns();
    }
}

/// The third stage.
pub(super) struct FitStep {
    curves: CurveFitter,
    fitted: u64,
}

impl FitStep {
    pub(super) fn new(settings: &Settings) -> Result<Self> {
        Ok(Self {
            curves: CurveFitter::new(settings)?,
            fitted: 0,
        })
    }

    /// Fits centerlines that have just arrived, and writes their descriptors to `message`.
    pub(super) fn fit(&mut self, seen: &Centerlines, message: &mut Descriptors) {
        message.trace = seen.trace;
        message.trace.fit_started_ns = now_ns();
        self.curves.answer(seen, message);
        self.fitted += 1;
        message.trace.fitted = self.fitted;
        message.trace.fitted_ns = now_ns();
    }
}

/// The last stage: the chain's own sink.
pub(super) struct SinkStep {
    sink: Sink,
}

impl SinkStep {
    pub(super) fn new(settings: &Settings) -> Self {
        Self {
            sink: Sink::new(settings.sink_options(true)),
        }
    }

    pub(super) fn count(&mut self, message: &Descriptors) {
        self.sink.descriptors(message, now_ns());
    }

    /// Writes the report. `counts` are the final counts of the stages.
    pub(super) fn report(mut self, settings: &Settings, counts: FinalCounts) -> Result<()> {
        self.sink.finish(counts);
        let out = settings.run.out.as_ref().context("a rival has a folder")?;
        let folder = OutputFolder::new(out, Existing::Keep, [])?;
        write_report(&folder, &self.sink.report())
    }
}
