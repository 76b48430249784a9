//! Computes the centerlines of the ropes in a frame.

use crate::bounded;
use crate::doubts::Doubts;
use crate::settings::{self, Settings};
use anyhow::{Context, Result};
use lariat_extract::{
    Curve, Extractor, Image, Network, Notice, PixelFormat, Region, Scene, Status, Step, mask_levels,
};
use lariat_wire::{Centerlines, Crossing, FrameHeader, MAX_CROSSINGS, MAX_CURVES, MAX_POINTS};

use std::path::Path;
use std::sync::Arc;

use super::Warned;

/// A frame or its mask, in shared memory or in a recording.
#[derive(Debug, Clone, Copy)]
pub struct FrameView<'a> {
    header: &'a FrameHeader,
    bytes: &'a [u8],
}

impl<'a> FrameView<'a> {
    /// Creates a view of the bytes that the header describes. A blank frame has no bytes.
    pub fn new(header: &'a FrameHeader, bytes: &'a [u8]) -> Self {
        Self { header, bytes }
    }

    /// Returns the header.
    pub fn header(self) -> &'a FrameHeader {
        self.header
    }

    /// Returns the bytes.
    pub fn bytes(self) -> &'a [u8] {
        self.bytes
    }

    /// Returns the frame as input for the extractor.
    ///
    /// # Errors
    /// Returns an error if the pixel format is unknown, or if there are fewer bytes than the header
    /// says.
    pub fn image(self) -> Result<Image<'a>> {
        let Self { header, bytes } = self;
        let Some(format) = header.format() else {
            anyhow::bail!(
                "frames come in pixel format {}, which this release does not know: use the same release for all stages",
                header.pixel_format
            )
        };
        let [width, height, stride] =
            [header.width, header.height, header.stride].map(|length| length as usize);
        Ok(Image::new(
            bytes,
            width,
            height,
            stride,
            pixel_format(format),
        )?)
    }
}

/// The part of a frame that is processed.
#[derive(Debug, Clone, Copy)]
pub struct Part<'a> {
    whole: Image<'a>,
    region: Region,
    image: Image<'a>,
}

impl<'a> Part<'a> {
    /// Cuts a region out of a frame.
    ///
    /// # Errors
    /// Returns an error if the region does not overlap the frame.
    fn of(whole: Image<'a>, region: Option<Region>) -> Result<Self> {
        let all = Region {
            x: 0,
            y: 0,
            width: whole.width(),
            height: whole.height(),
        };
        let asked = region.unwrap_or(all);
        let view = asked
            .within(&whole)
            .and_then(|region| Some((region, whole.region(region)?)));
        let Some((region, image)) = view else {
            anyhow::bail!(
                "the region begins at {}, {} and the image has {}×{} pixels: nothing of it is left (roi = [x, y, width, height])",
                asked.x,
                asked.y,
                all.width,
                all.height
            )
        };
        Ok(Self {
            whole,
            region,
            image,
        })
    }

    /// Returns the position of the part in the frame.
    pub fn origin(&self) -> [usize; 2] {
        [self.region.x, self.region.y]
    }

    /// Returns the same part of the frame's mask. If the whole frame is processed, the mask is
    /// returned unchanged and the extractor reports its errors.
    ///
    /// # Errors
    /// Returns an error if the mask and the frame differ in size.
    fn of_mask<'m>(&self, mask: Image<'m>) -> Result<Image<'m>> {
        let (width, height) = (self.whole.width(), self.whole.height());
        if (self.region.width, self.region.height) == (width, height) {
            return Ok(mask);
        }
        let fits = (mask.width(), mask.height()) == (width, height);
        fits.then(|| mask.region(self.region)).flatten().ok_or_else(|| {
            anyhow::anyhow!(
                "the mask is {}×{} pixels: it must have its image's size, {width}×{height}, also where only a region of it is read",
                mask.width(),
                mask.height()
            )
        })
    }
}

/// State that a successor needs in addition to the last message.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Past {
    /// Exposure time of the last frame.
    pub exposed_ns: u64,
    /// Width and height of the last image, in pixels.
    pub size: [u32; 2],
    /// Number of track numbers that were assigned.
    pub tracks: u32,
}

/// Extracts the centerlines of successive frames.
pub struct FrameExtractor {
    extractor: Extractor,
    /// Exposure time of the last frame.
    exposed_ns: u64,
    /// Width and height of the last image.
    size: [u32; 2],
    /// The part of the frames that is processed, if not all.
    region: Option<Region>,
    /// Origin of the processed part in the last frame.
    origin: [usize; 2],
    /// Size for which the extractor's buffers were allocated in advance.
    prepared: Option<[usize; 2]>,
    unreadable: Warned,
    doubts: Doubts,
    /// True if the level of each mask is chosen from its own histogram.
    chooses_level: bool,
    relabelled: Warned,
}

/// Size limit for a file of weights. A network takes a few hundred kilobytes.
const LARGEST_WEIGHTS: u64 = 64 << 20;

/// Reads a network from a file.
fn network(file: &Path) -> Result<Arc<Network>> {
    let bytes = bounded::read(file, LARGEST_WEIGHTS)
        .with_context(|| format!("cannot read {}", file.display()))?;
    let network = Network::from_bytes(&bytes).with_context(|| file.display().to_string())?;
    Ok(Arc::new(network))
}

impl FrameExtractor {
    /// Creates an extractor that allocates its buffers when frames need them.
    ///
    /// # Errors
    /// Returns an error if options are invalid.
    pub fn new(settings: &settings::Extract) -> Result<Self> {
        let mut extractor = Extractor::new(settings.options())?;
        if let Some(file) = &settings.network {
            extractor = extractor.with_network(network(file)?)?;
        }
        Ok(Self {
            extractor,
            exposed_ns: 0,
            size: [0; 2],
            region: settings.roi,
            origin: [0; 2],
            prepared: None,
            unreadable: Warned::default(),
            doubts: Doubts::default(),
            chooses_level: settings.mask_level.is_none(),
            relabelled: Warned::default(),
        })
    }

    /// Creates an extractor whose buffers are allocated for the most likely frame size, so that no
    /// frame waits for them. Buffers for another size are allocated with its first frame.
    ///
    /// # Errors
    /// Fails like [`new`](Self::new).
    pub fn prepared(settings: &Settings) -> Result<Self> {
        let mut made = Self::new(&settings.extract)?;
        let mut size = settings.capture.likely_size().map(|side| side as usize);
        if let Some(region) = made.region {
            size[0] = region.width.min(size[0].saturating_sub(region.x)).max(1);
            size[1] = region.height.min(size[1].saturating_sub(region.y)).max(1);
        }
        made.prepare(size);
        Ok(made)
    }

    fn prepare(&mut self, size: [usize; 2]) {
        if self.prepared.replace(size) != Some(size) {
            self.extractor.prepare(size[0], size[1]);
        }
    }

    /// Continues from another extractor of this chain: ropes keep their numbers and directions.
    pub fn go_on_from(&mut self, other: &Self) {
        let curves: Vec<Curve> = other.extractor.scene().curves.to_vec();
        self.resume(other.past(), curves, other.origin);
    }

    /// Returns the state that a successor needs in addition to the last message.
    pub fn past(&self) -> Past {
        Past {
            exposed_ns: self.exposed_ns,
            size: self.size,
            tracks: self.extractor.tracks(),
        }
    }

    /// Continues from the state and the last message of a predecessor.
    pub fn go_on_after(&mut self, past: Past, last: &Centerlines) {
        let curves = last.curves().iter().map(curve_of).collect();
        self.resume(past, curves, [0; 2]);
    }

    /// Continues from curves that are measured from `origin` in the image.
    fn resume(&mut self, past: Past, mut curves: Vec<Curve>, origin: [usize; 2]) {
        let [width, height] = past.size.map(|side| side as usize);
        if width == 0 || height == 0 {
            // The predecessor had not received an image yet.
            return;
        }
        let all = Region {
            x: 0,
            y: 0,
            width,
            height,
        };
        let region = self.region.unwrap_or(all);
        let end = [
            (region.x, region.width, width),
            (region.y, region.height, height),
        ];
        let size = end.map(|(from, length, whole)| length.min(whole.saturating_sub(from)));
        let begin = [region.x, region.y];
        let moved: [f32; 2] = std::array::from_fn(|c| origin[c] as f32 - begin[c] as f32);
        for point in curves.iter_mut().flat_map(|curve| &mut curve.points) {
            *point = std::array::from_fn(|c| point[c] + moved[c]);
        }
        self.prepare(size);
        (self.origin, self.size, self.exposed_ns) = (begin, past.size, past.exposed_ns);
        self.extractor
            .resume(size, past.exposed_ns, &curves, past.tracks);
    }

    /// Returns the text of a notice, including the command that helps.
    pub fn sentence(&self, notice: Notice) -> String {
        self.extractor.sentence(notice)
    }

    /// Resets the extractor, because the next frame shows another scene.
    pub fn forget(&mut self) {
        self.extractor.reset();
    }

    /// Returns the part of a frame that is processed.
    ///
    /// # Errors
    /// Returns an error if that part is empty.
    pub fn part<'a>(&self, whole: Image<'a>) -> Result<Part<'a>> {
        Part::of(whole, self.region)
    }

    /// Extracts the next frame of the scene into a message. `exposed_ns` is the exposure time on
    /// any clock. The message's trace is left unchanged. `after` is called at the end of each step.
    ///
    /// # Errors
    /// Returns an error if the mask does not fit the frame.
    pub fn extract(
        &mut self,
        part: &Part,
        mask: Option<Image>,
        exposed_ns: u64,
        after: &mut dyn FnMut(Step),
        message: &mut Centerlines,
    ) -> Result<Scene<'_>> {
        let mask = mask.map(|mask| part.of_mask(mask)).transpose()?;
        self.origin = part.origin();
        self.exposed_ns = exposed_ns;
        self.size = [part.whole.width(), part.whole.height()].map(|side| side as u32);
        [message.width, message.height] = self.size;
        self.extractor.at(exposed_ns);
        let scene = match mask {
            None => self.extractor.extract_observed(&part.image, after),
            Some(mask) => self
                .extractor
                .extract_masked_observed(&part.image, &mask, after)?,
        };
        fill(message, &scene, self.origin);
        Ok(scene)
    }

    /// Extracts a frame for a stage, which must answer every frame. An unreadable frame yields no
    /// curves; a blank frame yields what is known without an image. Warns of unreadable frames and
    /// of doubtful results.
    pub fn answer(&mut self, frame: FrameView, mask: Option<FrameView>, message: &mut Centerlines) {
        let header = frame.header;
        (message.width, message.height) = (header.width, header.height);
        if header.is_blank() {
            self.exposed_ns = header.trace.exposed_ns;
            self.extractor.at(self.exposed_ns);
            return fill(message, &self.extractor.blank(), self.origin);
        }
        if let Err(cause) = self.try_to_answer(frame, mask, message) {
            self.unreadable.once(&cause);
            (message.count, message.crossing_count) = (0, 0);
        }
    }

    fn try_to_answer(
        &mut self,
        frame: FrameView,
        mask: Option<FrameView>,
        message: &mut Centerlines,
    ) -> Result<()> {
        let part = self.part(frame.image()?)?;
        let mask = mask.map(FrameView::image).transpose()?;
        let read = match &mask {
            Some(mask) if self.chooses_level => mask_levels(mask)?,
            _ => None,
        };
        let mask = match &read {
            Some(read) => Some(read.image()?),
            None => mask,
        };
        if let Some(notice) = read.as_ref().and_then(|read| read.notice.as_ref()) {
            self.relabelled.once(&anyhow::anyhow!(notice.clone()));
        }
        self.prepare([part.image.width(), part.image.height()]);
        let exposed_ns = frame.header.trace.exposed_ns;
        let scene = self.extract(&part, mask, exposed_ns, &mut |_| {}, message)?;
        let notice = scene.notice;
        if let Some(notice) = self.doubts.next(notice) {
            tracing::warn!("{}", self.sentence(notice));
        }
        Ok(())
    }
}

/// Converts a message's curve to the extractor's type.
fn curve_of(curve: &lariat_wire::Curve) -> Curve {
    let mut to = Curve::default();
    to.track = curve.track;
    to.status = match curve.status() {
        Some(lariat_wire::Status::Ok) => Status::Ok,
        Some(lariat_wire::Status::Partial) => Status::Partial,
        Some(lariat_wire::Status::Doubtful) => Status::Doubtful,
        Some(lariat_wire::Status::Lost) | None => Status::Lost,
    };
    to.closed = curve.closed != 0;
    to.border = [0, 1].map(|end| curve.border >> end & 1 == 1);
    to.points = curve.points().to_vec();
    to.widths_px = curve.widths_px().to_vec();
    to.hidden = (0..to.points.len()).map(|k| curve.is_hidden(k)).collect();
    to.width_px = curve.width_px;
    to.length_px = curve.length_px;
    to.confidence = curve.confidence;
    to.age_ns = curve.age_ns;
    to
}

/// Converts a pixel format to the extractor's type.
pub fn pixel_format(format: lariat_wire::PixelFormat) -> PixelFormat {
    use lariat_wire::PixelFormat as Wire;
    match format {
        Wire::Gray8 => PixelFormat::Gray8,
        Wire::Rgb8 => PixelFormat::Rgb8,
        Wire::Bgr8 => PixelFormat::Bgr8,
        Wire::Yuyv => PixelFormat::Yuyv,
        Wire::Uyvy => PixelFormat::Uyvy,
        Wire::Nv12 => PixelFormat::Nv12,
        Wire::Bgra8 => PixelFormat::Bgra8,
        Wire::Gray16 => PixelFormat::Gray16,
        Wire::BayerRggb8 => PixelFormat::BayerRggb8,
        Wire::BayerBggr8 => PixelFormat::BayerBggr8,
        Wire::BayerGrbg8 => PixelFormat::BayerGrbg8,
        Wire::BayerGbrg8 => PixelFormat::BayerGbrg8,
    }
}

/// Writes the scene into a message. `origin` is the position of the processed part in the frame.
fn fill(message: &mut Centerlines, scene: &Scene, origin: [usize; 2]) {
    let origin = origin.map(|c| c as f32);
    let moved = |p: [f32; 2]| [p[0] + origin[0], p[1] + origin[1]];
    let curves = scene.curves.len().min(MAX_CURVES);
    message.count = curves as u32;
    for (to, from) in message.curves.iter_mut().zip(scene.curves) {
        let points = from.points.len().min(MAX_POINTS);
        to.track = from.track;
        to.status = match from.status {
            Status::Ok => lariat_wire::Status::Ok,
            Status::Partial => lariat_wire::Status::Partial,
            Status::Lost => lariat_wire::Status::Lost,
            Status::Doubtful => lariat_wire::Status::Doubtful,
        } as u32;
        to.closed = from.closed.into();
        to.border = u32::from(from.border[0]) | u32::from(from.border[1]) << 1;
        to.count = points as u32;
        to.width_px = from.width_px;
        to.length_px = from.length_px;
        to.confidence = from.confidence;
        to.age_ns = from.age_ns;
        to.set_hidden(from.hidden.iter().copied());
        for (to, from) in to.points[..points].iter_mut().zip(&from.points) {
            *to = moved(*from);
        }
        to.widths_px[..points].copy_from_slice(&from.widths_px[..points]);
    }
    // A crossing may refer to a curve that did not fit.
    let known =
        |crossing: &&lariat_extract::Crossing| crossing.over < curves && crossing.under < curves;
    let crossings = scene.crossings.iter().filter(known).take(MAX_CROSSINGS);
    let mut count = 0;
    for (to, from) in message.crossings.iter_mut().zip(crossings) {
        *to = Crossing {
            at: moved(from.at),
            over: from.over as u32,
            under: from.under as u32,
            over_rho: from.over_rho,
            under_rho: from.under_rho,
            confidence: from.confidence,
            reserved: 0,
        };
        count += 1;
    }
    message.crossing_count = count;
}

#[cfg(test)]
mod tests {
    use super::*;
    use lariat_extract::Mask;

    #[test]
    fn a_process_that_writes_numbers_has_its_rope_seen() {
        let (width, height) = (320, 240);
        let header = FrameHeader {
            width,
            height,
            stride: width,
            pixel_format: lariat_wire::PixelFormat::Gray8 as u32,
            ..FrameHeader::default()
        };
        let picture = vec![210; (width * height) as usize];
        let settings = settings::Extract {
            mask: Mask::External,
            ..settings::Extract::default()
        };
        for (label, ropes) in [(0, 0), (1, 1), (7, 1), (255, 1)] {
            let mut mask = vec![0; picture.len()];
            for row in mask.chunks_exact_mut(width as usize).skip(100).take(12) {
                row[40..280].fill(label);
            }
            let mut extractor = FrameExtractor::new(&settings).unwrap();
            let mut message = Box::new(Centerlines::EMPTY);
            let [frame, mask] = [&picture, &mask].map(|bytes| FrameView::new(&header, bytes));
            extractor.answer(frame, Some(mask), &mut message);
            assert_eq!(message.count, ropes, "{label}");
        }
    }
}
