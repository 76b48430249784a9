//! A recording in place of a rig. The page requests frames, and receives a summary of the
//! latencies.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use lariat_chain::calibrated::Calibrated;
use lariat_chain::places::Places;
use lariat_chain::recorded::{Decoder, Gather, Pixels, RecordedSettings};
use lariat_record::{Entry, Losses, Place, Recording, Span};
use lariat_wire::{Centerlines, Descriptors, Trace};

use crate::moment::{Image, Moment};
use crate::status::{Film as Told, Reporter};

/// Time limit for reading latencies, before the page is served.
const LOOKING: Duration = Duration::from_millis(500);
/// A frame at most this far ahead is reached frame by frame.
const NEAR: u64 = 30;

/// A recording that is shown.
#[derive(Debug)]
pub(crate) struct Film {
    path: PathBuf,
    topic: Option<String>,
    /// The summary for the page, as JSON.
    pub(crate) status: String,
}

impl Film {
    /// # Errors
    /// Fails if the recording cannot be read, or contains no frames.
    pub(crate) fn open(path: &Path, topic: Option<&str>) -> Result<Self> {
        let about = || path.display().to_string();
        let recording = Recording::open_topic(path, topic).with_context(about)?;
        let frames = recording.frames().with_context(about)?;
        anyhow::ensure!(frames > 0, "{} has no frames to be shown", path.display());
        let name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let traces = traces(&recording).with_context(about)?;
        Ok(Self {
            path: path.to_owned(),
            topic: topic.map(str::to_owned),
            status: Reporter::of_film(&Told { name, frames }, &traces),
        })
    }

    /// Opens a reader for one page.
    ///
    /// # Errors
    /// Fails if the recording cannot be read any more.
    pub(crate) fn playback(&self) -> Result<Playback> {
        let recording = Recording::open_topic(&self.path, self.topic.as_deref())?;
        let at = Gather::new(&recording, Span::default())?;
        // Without its settings, a recording is still shown, except for curves in millimeters.
        let settings = RecordedSettings::of(&recording).ok().flatten();
        Ok(Playback {
            recording,
            settings,
            places: Places::default(),
            at,
            next: 0,
            decoder: Decoder::default(),
        })
    }
}

/// Returns the traces of the first frames that have descriptors, as many as [`LOOKING`] allows.
fn traces(recording: &Recording) -> Result<Vec<Trace>> {
    let until = Instant::now() + LOOKING;
    let mut messages = recording.messages(Span::default())?;
    let mut traces = Vec::new();
    while Instant::now() < until
        && let Some(entry) = messages.next()?
    {
        if let Entry::Descriptors(shapes) = entry {
            traces.push(shapes.trace);
        }
    }
    Ok(traces)
}

/// Reads a recording frame by frame.
pub(crate) struct Playback {
    recording: Recording,
    settings: Option<RecordedSettings>,
    /// Mappings by the version of the settings.
    places: Places<u32>,
    at: Gather,
    /// Index of the frame that `at` gives next, from 0.
    next: u64,
    decoder: Decoder,
}

impl Playback {
    /// Returns the frame at an index, from 0; `None` after the last.
    ///
    /// # Errors
    /// Fails if the recording is damaged there.
    pub(crate) fn moment(&mut self, place: u64) -> Result<Option<Moment>> {
        if !(self.next..self.next + NEAR).contains(&place) {
            let span = Span {
                from: Some(Place::Frame(place.saturating_add(1))),
                to: None,
            };
            (self.at, self.next) = (Gather::new(&self.recording, span)?, place);
        }
        while self.next < place {
            self.next += 1;
            if self.at.next()?.is_none() {
                return Ok(None);
            }
        }
        self.next += 1;
        let Some(gathered) = self.at.next()? else {
            return Ok(None);
        };
        let mut descriptors = Box::new(Descriptors::EMPTY);
        let mut image = None;
        if let Some(frame) = gathered.frame() {
            descriptors.trace = frame.header.trace;
            if frame.pixels != Pixels::None {
                let decoded = self
                    .decoder
                    .decode(&frame.header, frame.pixels, &frame.bytes)?;
                let (header, bytes) = decoded;
                (descriptors.width, descriptors.height) = (header.width, header.height);
                image = Some(Image {
                    header,
                    bytes: bytes.to_vec(),
                });
            }
        }
        let centerlines = gathered.centerlines().map(|seen| {
            let mut copy = Box::new(Centerlines::EMPTY);
            copy.copy_meant(seen);
            copy
        });
        if let Some(shapes) = gathered.descriptors() {
            descriptors.copy_meant(shapes);
        }
        let version = descriptors.trace.settings;
        let places = self.places.of(&descriptors, version, |version| {
            let Some(first) = &self.settings else {
                return Ok(None);
            };
            let of_version = first.of_version(&self.recording, *version)?;
            let camera = of_version.map(|recorded| Calibrated::load(&recorded.settings.camera));
            camera.unwrap_or(Ok(None))
        });
        let number = place.saturating_add(1);
        let losses = Losses::default();
        let mut moment = Moment::new(number, image, centerlines, descriptors, losses);
        moment.places = places;
        Ok(Some(moment))
    }
}
