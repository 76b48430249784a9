//! Extract and fit without shared memory: the pipeline, applied to recorded messages.

use anyhow::{Context, Result};
use lariat_chain::pipeline::{CurveFitter, FrameExtractor, FrameView};
use lariat_chain::recorded::{Decoder, Gathered};
use lariat_chain::settings::Settings;
use lariat_extract::Mask;
use lariat_wire::{Centerlines, Descriptors, FrameHeader, Trace};
use std::time::{Duration, Instant};

/// Both stages.
pub(super) struct Stages {
    settings: Settings,
    extractor: FrameExtractor,
    curves: CurveFitter,
    pub(super) centerlines: Box<Centerlines>,
    pub(super) descriptors: Box<Descriptors>,
    pub(super) extract_time: Duration,
    pub(super) fit_time: Duration,
}

/// A decoded frame, with everything that extraction needs.
pub(super) struct Prepared<'a> {
    header: FrameHeader,
    bytes: &'a [u8],
    mask: Option<(FrameHeader, &'a [u8])>,
}

/// Decodes a frame, and its mask if there is one.
///
/// # Errors
/// Returns an error if the pixels were not recorded or cannot be read.
pub(super) fn prepare<'a>(
    gathered: &'a Gathered,
    decoders: &'a mut [Decoder; 2],
) -> Result<Prepared<'a>> {
    let frame = gathered.frame().context("its frame was not recorded")?;
    let [of_frame, of_mask] = decoders;
    let (header, bytes) = if frame.header.is_blank() {
        (frame.header, &[][..])
    } else {
        of_frame.decode(&frame.header, frame.pixels, &frame.bytes)?
    };
    let mask = match gathered.mask() {
        Some(mask) => Some(of_mask.decode(&mask.header, mask.pixels, &mask.bytes)?),
        None => None,
    };
    Ok(Prepared {
        header,
        bytes,
        mask,
    })
}

#[cfg(test)]
impl<'a> Prepared<'a> {
    /// Makes a frame that does not come from a recording.
    pub(super) fn new(
        header: FrameHeader,
        bytes: &'a [u8],
        mask: Option<(FrameHeader, &'a [u8])>,
    ) -> Self {
        Self {
            header,
            bytes,
            mask,
        }
    }
}

impl Prepared<'_> {
    /// Returns whether the frame has a mask.
    pub(super) fn has_mask(&self) -> bool {
        self.mask.is_some()
    }

    /// Returns whether the frame has no image.
    pub(super) fn is_blank(&self) -> bool {
        self.header.is_blank()
    }
}

impl Stages {
    /// Makes both stages as the chain does.
    pub(super) fn new(settings: &Settings) -> Result<Self> {
        Ok(Self {
            extractor: FrameExtractor::prepared(settings)?,
            curves: CurveFitter::new(settings)?,
            settings: settings.clone(),
            centerlines: Box::new(Centerlines::EMPTY),
            descriptors: Box::new(Descriptors::EMPTY),
            extract_time: Duration::ZERO,
            fit_time: Duration::ZERO,
        })
    }

    /// Returns whether extraction needs external masks.
    pub(super) fn needs_masks(&self) -> bool {
        self.settings.extract.mask == Mask::External
    }

    /// Restarts extract with these settings.
    pub(super) fn restart_extract(&mut self, settings: &Settings) -> Result<()> {
        self.settings.extract = settings.extract.clone();
        self.extractor = FrameExtractor::prepared(settings)?;
        Ok(())
    }

    /// Replaces extract as a restart within a chain does: it continues after the last message of
    /// its predecessor.
    pub(super) fn replace_extract(&mut self, settings: &Settings) -> Result<()> {
        let past = self.extractor.past();
        self.restart_extract(settings)?;
        self.extractor.go_on_after(past, &self.centerlines);
        Ok(())
    }

    /// Changes the settings of extract while it runs.
    pub(super) fn change_extract(&mut self, settings: &Settings) -> Result<()> {
        if self.settings.extract != settings.extract {
            let mut changed = FrameExtractor::prepared(settings)?;
            changed.go_on_from(&self.extractor);
            self.extractor = changed;
            self.settings.extract = settings.extract.clone();
        }
        Ok(())
    }

    /// Restarts fit with these settings.
    pub(super) fn restart_fit(&mut self, settings: &Settings) -> Result<()> {
        self.settings.fit = settings.fit.clone();
        self.settings.camera = settings.camera.clone();
        self.curves = CurveFitter::new(settings)?;
        Ok(())
    }

    /// Changes the settings of fit while it runs.
    pub(super) fn change_fit(&mut self, settings: &Settings) -> Result<()> {
        let before = (&self.settings.fit, &self.settings.camera);
        if before != (&settings.fit, &settings.camera) {
            self.restart_fit(settings)?;
        }
        Ok(())
    }

    /// Extracts the ropes of a frame. The result is in `centerlines`, with this trace.
    pub(super) fn extract(&mut self, frame: &Prepared, trace: Trace) {
        let begin = Instant::now();
        let mask = frame.mask.as_ref().filter(|_| self.needs_masks());
        let mask = mask.map(|(header, bytes)| FrameView::new(header, bytes));
        self.centerlines.trace = trace;
        let view = FrameView::new(&frame.header, frame.bytes);
        self.extractor.answer(view, mask, &mut self.centerlines);
        self.extract_time = begin.elapsed();
    }

    /// Fits these centerlines. The result is in `descriptors`, with this trace.
    pub(super) fn fit(&mut self, seen: &Centerlines, trace: Trace) {
        let begin = Instant::now();
        self.descriptors.trace = trace;
        self.curves.answer(seen, &mut self.descriptors);
        self.fit_time = begin.elapsed();
    }

    /// Fits the centerlines that were extracted last.
    pub(super) fn fit_seen(&mut self, trace: Trace) {
        let begin = Instant::now();
        self.descriptors.trace = trace;
        self.curves.answer(&self.centerlines, &mut self.descriptors);
        self.fit_time = begin.elapsed();
    }
}
