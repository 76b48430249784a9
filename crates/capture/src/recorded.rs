//! Shows a recording: its frames at their own pace unless another is requested, with the truth if
//! it was recorded.
//!
//! Losses are reproduced: the frame numbers have the same gaps, and blank frames stay blank.

mod lookahead;
mod timing;

use std::path::{Path, PathBuf};

use lariat_message::{Centerlines, FrameHeader, PixelFormat, SourceKind};
use lariat_record::{Entry, Messages, Pixels, Place, Recording, Span};

use crate::ahead::{Ahead, Decode, Layout, Plan, Step};
use crate::bits::{Bits, largest};
use crate::color_range::ColorRange;
use crate::picture::PictureDecoder;
use crate::range::{Position, Range};
use crate::source::SourceError;
use lookahead::Lookahead;
use timing::Timing;

/// Which part of a recording to show.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordingOptions {
    /// The file.
    pub path: PathBuf,
    /// Topic whose images are shown. Needed only if the recording has images of several cameras.
    pub topic: Option<String>,
    /// Numbers count recorded frames, and times count from the beginning. Within the range, every
    /// n-th *moment* of the source is shown, so that a neighbor does not replace a lost frame.
    pub range: Range,
    /// True if the recording starts again after its last frame.
    pub looped: bool,
}

/// Opens a recording.
pub(crate) fn open_recording(options: &RecordingOptions) -> Result<Ahead, SourceError> {
    let path = &options.path;
    let unfit = |error: &dyn std::error::Error| SourceError::Recording {
        path: path.clone(),
        what: with_causes(error),
    };
    let recording = Recording::open_topic(path, options.topic.as_deref());
    let recording = recording.map_err(|error| unfit(&error))?;
    if let (None, [_, _, ..]) = (&options.topic, recording.cameras()) {
        return Err(SourceError::Recording {
            path: path.clone(),
            what: format!(
                "it has images of several cameras, on {}: choose one with --topic",
                recording.cameras().join(", ")
            ),
        });
    }
    let topics = recording.topics().map_err(|error| unfit(&error))?;
    let images = topics
        .iter()
        .filter(|topic| recording.images() == Some(&topic.name));
    let (mut largest, mut total_bytes) = (0, 0);
    for topic in images {
        largest = largest.max(topic.largest);
        total_bytes += topic.bytes;
    }
    if largest == 0 {
        return Err(SourceError::Recording {
            path: path.clone(),
            what: "it holds no image: record with them to see them again".to_owned(),
        });
    }
    let span = span_of(&options.range)?;
    let messages = recording.messages(span).map_err(|error| unfit(&error))?;
    let mut first = recording.messages(span).map_err(|error| unfit(&error))?;
    let Opening {
        kind,
        size,
        message_bytes,
    } = Opening::of(&mut first);
    let (largest, total_bytes) = match size {
        // The decoded size of a picture file is stored only in the file itself. Later pictures are
        // assumed to be no larger than the first.
        Size::Unpacked(bytes) => (bytes, u64::MAX),
        Size::Raw(bytes) if largest > message_bytes as u64 + BESIDE_BYTES => {
            (largest_of(&mut first).max(bytes), total_bytes)
        }
        Size::Raw(bytes) => {
            let largest = usize::try_from(largest).unwrap_or(usize::MAX);
            (largest.max(bytes), total_bytes)
        }
    };
    let has_truth = topics
        .iter()
        .any(|topic| topic.name.ends_with("/truth") && topic.messages > 0);
    let plan = Plan {
        kind,
        largest_frame_bytes: largest,
        native_fps: None,
        looped: options.looped,
        has_truth,
        total_bytes,
        warnings: recording.cut_off().map(str::to_owned).into_iter().collect(),
        news: None,
    };
    let recorded = Recorded {
        path: path.clone(),
        is_own: recording.about().version().is_some(),
        recording,
        span,
        every: options.range.every.get(),
        messages,
        is_fresh: true,
        reader: Reader::default(),
        lookahead: Lookahead::new(has_truth),
        timing: Timing::default(),
    };
    Ahead::start(recorded, plan)
}

/// Joins an error and its causes into one sentence.
fn with_causes(error: &dyn std::error::Error) -> String {
    let causes = std::iter::successors(Some(error), |error| error.source());
    let causes: Vec<_> = causes.map(ToString::to_string).collect();
    causes.join(": ")
}

fn span_of(range: &Range) -> Result<Span, SourceError> {
    // Only checks for an empty range. One end may be a number and the other a time.
    if let (Some(Position::Frame(_)), Some(Position::Frame(_))) = (range.from, range.to) {
        range.frames(None)?;
    }
    if let (Some(Position::Time(_)), Some(Position::Time(_))) = (range.from, range.to) {
        range.frames(Some(1e9))?;
    }
    let place = |position, behind| match position {
        Position::Frame(number) => Place::Frame(u64::saturating_add(number, behind)),
        Position::Time(time) => Place::After(time),
    };
    Ok(Span {
        from: range.from.map(|from| place(from, 0)),
        // The number is that of the last frame, and a span's end is one past it.
        to: range.to.map(|to| place(to, 1)),
    })
}

/// Maximum size of the data that can be between an image and the next message in the index: the
/// descriptions of topics and their schemas.
const BESIDE_BYTES: u64 = 64 << 10;

/// Facts from the first frame with an image.
struct Opening {
    kind: SourceKind,
    size: Size,
    /// Bytes of the message that holds the image.
    message_bytes: usize,
}

/// Bytes of the first image's pixels.
enum Size {
    Raw(usize),
    /// Size of a decoded picture file.
    Unpacked(usize),
}

impl Opening {
    fn of(messages: &mut Messages) -> Self {
        let (mut kind, mut message_bytes) = (SourceKind::Files, 0);
        let size = loop {
            let frame = match messages.next_frame() {
                Ok(None) => break Size::Raw(0),
                // Damage is reported later, when the frame's turn comes.
                Err(_) => continue,
                Ok(Some(frame)) => frame,
            };
            kind = SourceKind::from_code(frame.header.source).unwrap_or(SourceKind::Files);
            message_bytes = frame.message_bytes;
            match frame.pixels {
                Pixels::None => {}
                Pixels::Raw(bytes) => break Size::Raw(bytes.len()),
                Pixels::Png(file) | Pixels::Jpeg(file) | Pixels::Other(file) => {
                    let size = PictureDecoder::size(Path::new("a picture"), file);
                    break Size::Unpacked(size.unwrap_or(0));
                }
            }
        };
        Self {
            kind,
            size,
            message_bytes,
        }
    }
}

/// Returns the size of the largest image that follows, in bytes. All images are read, because a
/// large size in the index may be real or may come from a damaged index.
fn largest_of(messages: &mut Messages) -> usize {
    let mut largest = 0;
    loop {
        match messages.next_frame() {
            Ok(None) => return largest,
            Ok(Some(frame)) => {
                if let Pixels::Raw(bytes) = frame.pixels {
                    largest = largest.max(bytes.len());
                }
            }
            Err(_) => {}
        }
    }
}

/// A recording being read.
struct Recorded {
    path: PathBuf,
    recording: Recording,
    span: Span,
    every: u64,
    messages: Messages,
    /// True if nothing has been read since the last rewind.
    is_fresh: bool,
    /// True if lariat recorded it, so that its frames need no conversion.
    is_own: bool,
    reader: Reader,
    lookahead: Lookahead,
    timing: Timing,
}

/// Converts recorded frames to pixels.
#[derive(Default)]
struct Reader {
    pictures: PictureDecoder,
    foreign: ForeignFrames,
}

/// Converts other programs' raw frames to the full range that lariat uses.
#[derive(Debug, Default)]
pub struct ForeignFrames {
    /// Number of bits in 16-bit samples.
    bits: Bits,
    news: Option<String>,
}

impl ForeignFrames {
    /// Returns a conclusion about the samples, once.
    pub fn take_news(&mut self) -> Option<String> {
        self.news.take()
    }

    /// Converts one frame's pixels in place. YUV is in limited range, as camera drivers deliver it,
    /// and 16-bit samples may use fewer bits.
    pub fn normalize(&mut self, header: &FrameHeader, pixels: &mut [u8]) {
        let Some(format) = header.format() else {
            return;
        };
        ColorRange::Limited.expand_yuv(format, header.stride, header.height, pixels);
        if format == PixelFormat::Gray16 {
            self.news = self.news.take().or(self.bits.see(largest(pixels)));
            self.bits.widen_all(pixels);
        }
    }
}

/// Writes a recorded frame's pixels into `pixels`.
fn fill(
    header: &FrameHeader,
    recorded: Pixels,
    is_own: bool,
    reader: &mut Reader,
    pixels: &mut [u8],
) -> Result<Layout, String> {
    let sequence = header.trace.sequence;
    match recorded {
        Pixels::None if header.is_blank() => Ok(Layout {
            width: 0,
            height: 0,
            stride: 0,
            format: PixelFormat::Gray8,
        }),
        Pixels::None => Err("the images of some frames were not recorded".to_owned()),
        Pixels::Raw(bytes) => {
            let format = header.format();
            let (Some(format), Some(room)) = (format, pixels.get_mut(..bytes.len())) else {
                return Err(format!("frame {sequence} is larger than room was made for"));
            };
            room.copy_from_slice(bytes);
            let layout = Layout {
                width: header.width,
                height: header.height,
                stride: header.stride,
                format,
            };
            if !is_own {
                reader.foreign.normalize(header, room);
            }
            Ok(layout)
        }
        Pixels::Png(file) | Pixels::Jpeg(file) | Pixels::Other(file) => {
            let name = format!("the picture of frame {sequence}");
            reader.pictures.decode_file(Path::new(&name), file, pixels)
        }
    }
}

impl Decode for Recorded {
    fn rewind(&mut self) -> Result<(), SourceError> {
        if !std::mem::replace(&mut self.is_fresh, true) {
            self.messages =
                self.recording
                    .messages(self.span)
                    .map_err(|error| SourceError::Recording {
                        path: self.path.clone(),
                        what: with_causes(&error),
                    })?;
            self.lookahead.clear();
            self.timing.restart();
        }
        Ok(())
    }

    fn decode(&mut self, pixels: &mut [u8]) -> Step {
        self.is_fresh = false;
        let about = |what: &str| Step::Wrong(format!("{}: {what}", self.path.display()));
        if let Some(error) = self.lookahead.take_error() {
            return about(&with_causes(&error));
        }
        if let Some(news) = self.timing.take_news() {
            return Step::News(format!("{}: {news}", self.path.display()));
        }
        loop {
            let stashed = self.lookahead.next_frame();
            let (header, log_time_ns, recorded) = match &stashed {
                Some(stashed) => (stashed.header, stashed.log_time_ns, stashed.pixels()),
                None => match self.messages.next() {
                    Ok(None) => return Step::End(None),
                    Err(error) => return about(&with_causes(&error)),
                    Ok(Some(Entry::Frame(frame))) => {
                        (frame.header, frame.log_time_ns, frame.pixels)
                    }
                    Ok(Some(Entry::Truth(truth))) => {
                        self.lookahead.truth_came(truth);
                        continue;
                    }
                    Ok(Some(_)) => continue,
                },
            };
            let moment = self.timing.place(self.every, &header, log_time_ns);
            let (is_own, reader) = (self.is_own, &mut self.reader);
            let filled = moment.map(|_| fill(&header, recorded, is_own, reader, pixels));
            if let Some(stashed) = stashed {
                self.lookahead.keep_room(stashed);
            }
            match moment.zip(filled) {
                None => {}
                Some((_, Err(reason))) => return about(&reason),
                Some((moment, Ok(layout))) => {
                    self.lookahead.look_for_truth(&header, &mut self.messages);
                    return Step::Recorded(layout, moment);
                }
            }
        }
    }

    fn truth(&mut self, truth: &mut Centerlines) -> bool {
        self.lookahead.truth(truth)
    }

    fn take_news(&mut self) -> Option<String> {
        self.reader
            .foreign
            .take_news()
            .or_else(|| self.reader.pictures.take_news())
    }

    fn nothing(&self) -> SourceError {
        SourceError::Recording {
            path: self.path.clone(),
            what: "this part of the recording has no frame".to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a frame of 2 × 1 pixels as it is shown, and its notice.
    fn shown(is_own: bool, format: PixelFormat, bytes: &[u8]) -> (Vec<u8>, Option<String>) {
        let header = FrameHeader {
            width: 2,
            height: 1,
            stride: bytes.len() as u32,
            pixel_format: format as u32,
            ..FrameHeader::default()
        };
        let (mut reader, mut pixels) = (Reader::default(), vec![0; bytes.len()]);
        let filled = fill(
            &header,
            Pixels::Raw(bytes),
            is_own,
            &mut reader,
            &mut pixels,
        );
        filled.expect("it has room");
        (pixels, reader.foreign.news)
    }

    #[test]
    fn other_programs_frames_are_brought_into_full_range_and_ones_own_are_in_it() {
        let yuyv = [235, 128, 16, 240];
        let (pixels, _) = shown(false, PixelFormat::Yuyv, &yuyv);
        assert_eq!(pixels, [255, 128, 0, 255]);
        assert_eq!(shown(true, PixelFormat::Yuyv, &yuyv).0, yuyv);
        let gray = [4095u16, 0].map(u16::to_ne_bytes).concat();
        let (pixels, said) = shown(false, PixelFormat::Gray16, &gray);
        assert_eq!(pixels, [255, 255, 0, 0]);
        assert!(said.is_some_and(|said| said.contains("12 bits")));
        assert_eq!(shown(true, PixelFormat::Gray16, &gray), (gray, None));
    }
}
