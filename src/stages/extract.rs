//! Extract as a process: frames in, centerlines out.

use lariat_extract::{Extractor, Image, PixelFormat, Region, Scene, Status};
use lariat_wire::{
    CENTERLINES, Centerlines, Crossing, FRAMES, FrameHeader, MAX_CROSSINGS, MAX_CURVES, MAX_POINTS,
    Writer, now_ns,
};

use super::external::External;
use super::masks::Masks;
use super::status::Sent;
use super::{Came, Inbox, Seat, Station};
use crate::doubts::{self, Doubts};
use crate::settings::Settings;

/// Extracts until a signal comes.
pub(crate) fn run(settings: &Settings, seat: Seat) -> anyhow::Result<()> {
    let mut station = Station::open(settings, "extract", seat)?;
    let mut eye = Eye::new(settings)?;
    let mut masks = Masks::open(settings, &station)?;
    let Station {
        domain,
        rig,
        delivery,
        ..
    } = &station;
    let mut frames = Inbox::open(&station, &FRAMES, |frame| frame.header().trace.captured)?;
    let centerlines = Writer::<Centerlines>::create(domain, rig, &CENTERLINES, delivery)?;
    let mut external = External::of(settings);
    let mut sent = Sent::default();
    station.ready()?;
    loop {
        let deadline = external.as_ref().and_then(External::deadline);
        let (frame, mut started_ns) = match frames.receive_by(&station.stop, deadline)? {
            Came::Message(frame, now_ns) => (frame, now_ns),
            Came::Nothing if external.as_mut().is_some_and(External::wait_on) => continue,
            Came::Nothing | Came::End => break,
        };
        let header = frame.header();
        if external
            .as_mut()
            .is_some_and(|external| !external.takes(&header.trace, &station.stop))
        {
            break;
        }
        let mask = match &mut masks {
            None => None,
            // Nobody makes a mask of nothing.
            Some(_) if header.is_blank() => None,
            Some(masks) => match masks.of(header, &station.stop)? {
                Some(mask) => {
                    // Waiting for it was no work.
                    started_ns = now_ns();
                    Some(mask)
                }
                // Its mask came too late: the frame is not sent on, and counted.
                None => continue,
            },
        };
        let mut slot = centerlines.slot()?;
        slot.trace = header.trace;
        slot.trace.extract_started_ns = started_ns;
        let seen = Seen::new(header, &frame);
        let mask = mask.map(|mask| Seen::new(mask.header(), mask));
        eye.look(seen, mask, &mut slot);
        // Read, the frame makes room for another.
        let sequence = header.trace.sequence;
        drop(frame);
        sent.count += 1;
        sent.last_sequence = sequence;
        slot.trace.extracted = sent.count;
        slot.trace.extracted_ns = now_ns();
        slot.send()?;
        if external.as_ref().is_some_and(External::has_all) {
            break;
        }
    }
    if let Some(masks) = masks {
        station.status.late(masks.late());
    }
    if let Some(external) = external {
        if !station.stop.asked() {
            station.status.done();
        }
        station.status.taken(external.taken());
    }
    station.status.sent(sent);
    Ok(())
}

/// A frame, or its mask, wherever it lies: in shared memory or in a recording.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Seen<'a> {
    header: &'a FrameHeader,
    bytes: &'a [u8],
}

impl<'a> Seen<'a> {
    /// `bytes` as the header describes them; none of a blank frame.
    pub(crate) fn new(header: &'a FrameHeader, bytes: &'a [u8]) -> Self {
        Self { header, bytes }
    }

    fn image(self) -> anyhow::Result<Image<'a>> {
        image(self.header, self.bytes)
    }
}

/// An extractor that answers every frame: all that extract does but to receive, to wait and to send.
pub(crate) struct Eye {
    extractor: Extractor,
    /// What of the frames is read, if not all.
    region: Option<Region>,
    /// Where in the last frame the extractor looked.
    origin: [usize; 2],
    /// What the extractor's buffers are made for.
    size: (usize, usize),
    unreadable: Warned,
    doubts: Doubts,
}

impl Eye {
    /// Prepares for the settings' likely size.
    pub(crate) fn new(settings: &Settings) -> anyhow::Result<Self> {
        let mut extractor = Extractor::new(settings.extract.options())?;
        // Most likely the size that is coming. Another is prepared for with its first frame.
        let mut size = settings.capture.likely_size().map(|side| side as usize);
        let region = settings.extract.roi;
        if let Some(region) = region {
            size[0] = region.width.min(size[0].saturating_sub(region.x)).max(1);
            size[1] = region.height.min(size[1].saturating_sub(region.y)).max(1);
        }
        extractor.prepare(size[0], size[1]);
        Ok(Self {
            extractor,
            region,
            origin: [0; 2],
            size: (size[0], size[1]),
            unreadable: Warned::default(),
            doubts: Doubts::default(),
        })
    }

    /// Fills in what is seen in a frame: nothing, if it cannot be read; what is known without, if there is no image in it.
    /// It is answered all the same: a stage never goes silent while frames come in. The message's trace is left as it is.
    pub(crate) fn look(&mut self, frame: Seen, mask: Option<Seen>, message: &mut Centerlines) {
        let header = frame.header;
        (message.width, message.height) = (header.width, header.height);
        if header.is_blank() {
            self.extractor.at(header.trace.exposed_ns);
            return fill(message, &self.extractor.blank(), self.origin);
        }
        if let Err(cause) = self.see(frame, mask, message) {
            self.unreadable.once(&cause);
            (message.count, message.crossing_count) = (0, 0);
        }
    }

    fn see(
        &mut self,
        frame: Seen,
        mask: Option<Seen>,
        message: &mut Centerlines,
    ) -> anyhow::Result<()> {
        let whole = frame.image()?;
        let (region, seen) = part(&whole, self.region)?;
        self.origin = [region.x, region.y];
        if self.size != (seen.width(), seen.height()) {
            self.size = (seen.width(), seen.height());
            self.extractor.prepare(self.size.0, self.size.1);
        }
        self.extractor.at(frame.header.trace.exposed_ns);
        let scene = match mask {
            None => self.extractor.extract(&seen),
            Some(mask) => {
                let mask = part_of_mask(mask.image()?, &whole, region)?;
                self.extractor.extract_masked(&seen, &mask)?
            }
        };
        fill(message, &scene, self.origin);
        if let Some(notice) = self.doubts.next(scene.notice) {
            tracing::warn!("{}", doubts::sentence(notice));
        }
        Ok(())
    }
}

/// The extractor's own name for a pixel format.
pub(crate) fn pixel_format(format: lariat_wire::PixelFormat) -> PixelFormat {
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

/// A frame as extraction sees it.
pub(crate) fn image<'a>(header: &FrameHeader, bytes: &'a [u8]) -> anyhow::Result<Image<'a>> {
    let format = match header.format() {
        Some(format) => pixel_format(format),
        None => anyhow::bail!(
            "frames come in pixel format {}, which this release does not know: use the same release for all stages",
            header.pixel_format
        ),
    };
    let (width, height, stride) = (
        header.width as usize,
        header.height as usize,
        header.stride as usize,
    );
    Ok(Image::new(bytes, width, height, stride, format)?)
}

/// The part of a frame that is read: which it is, and itself.
///
/// # Errors
/// Nothing of the frame lies in the region.
pub(crate) fn part<'a>(
    whole: &Image<'a>,
    region: Option<Region>,
) -> anyhow::Result<(Region, Image<'a>)> {
    let all = Region {
        x: 0,
        y: 0,
        width: whole.width(),
        height: whole.height(),
    };
    let asked = region.unwrap_or(all);
    let view = asked
        .within(whole)
        .and_then(|region| Some((region, whole.region(region)?)));
    view.ok_or_else(|| {
        anyhow::anyhow!(
            "the region begins at {}, {} and the image has {}×{} pixels: nothing of it is left (roi = [x, y, width, height])",
            asked.x,
            asked.y,
            all.width,
            all.height
        )
    })
}

/// The part of a frame's mask that is read. Without a region the mask is as it came: the extractor says what is wrong with it.
///
/// # Errors
/// Its size is not the frame's.
pub(crate) fn part_of_mask<'a>(
    mask: Image<'a>,
    whole: &Image,
    region: Region,
) -> anyhow::Result<Image<'a>> {
    let (width, height) = (whole.width(), whole.height());
    if (region.width, region.height) == (width, height) {
        return Ok(mask);
    }
    let fits = (mask.width(), mask.height()) == (width, height);
    fits.then(|| mask.region(region)).flatten().ok_or_else(|| {
        anyhow::anyhow!(
            "the mask is {}×{} pixels: it must have its image's size, {width}×{height}, also where only a region of it is read",
            mask.width(),
            mask.height()
        )
    })
}

/// Writes what was seen into a message; `origin` is where in the frame it was looked for.
pub(crate) fn fill(message: &mut Centerlines, scene: &Scene, origin: [usize; 2]) {
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
        to.reserved = 0;
        to.age_ns = from.age_ns;
        to.set_hidden(from.hidden.iter().copied());
        for (to, from) in to.points[..points].iter_mut().zip(&from.points) {
            *to = moved(*from);
        }
        to.widths_px[..points].copy_from_slice(&from.widths_px[..points]);
    }
    // A crossing may name a curve that had no room.
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

/// Says a thing the first time only: a fault of every frame would fill the screen.
#[derive(Default)]
pub(crate) struct Warned(bool);

impl Warned {
    /// Warns, once.
    pub(crate) fn once(&mut self, cause: &anyhow::Error) {
        if !std::mem::replace(&mut self.0, true) {
            tracing::warn!("{cause:#}");
        }
    }
}
