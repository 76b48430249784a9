//! Frames from a pipe, usually standard input: a Y4M video, or consecutive raw frames.
//!
//! A pipe is live: unless a pace is requested, a frame's exposure time is when its last byte
//! arrived. The pipe is read while the caller waits for a frame, so that a stalled writer does not
//! prevent a stop. It is read no faster than frames are requested.

use std::fs::File;
use std::io::{self, IsTerminal, Read};
use std::os::fd::AsFd;

use lariat_message::{PixelFormat, SourceKind, now_ns};
use rustix::event::PollFlags;

use crate::ahead::Layout;
use crate::bits::{Bits, largest};
use crate::foreign::{Foreign, Way};
use crate::raw::RawFormat;
use crate::source::{Frame, FrameSource, Next, SourceError};
use crate::until::{Until, Woken};
use crate::y4m::{FRAME, Head, LARGEST_SIDE, LINE_BYTES, MAGIC, begins_frame};

/// How to read a pipe.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PipeOptions {
    /// Size and format of raw frames; `None` expects a Y4M video.
    pub raw: Option<RawFrames>,
    /// True if the caller sets the pace; otherwise frames are shown when they arrive.
    pub paced: bool,
}

/// Raw frames without headers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RawFrames {
    /// Width and height, in pixels.
    pub size: [u32; 2],
    /// Pixel format; rows are not padded.
    pub format: RawFormat,
}

impl RawFrames {
    fn check(self) -> Result<(), SourceError> {
        let ([width, height], format) = (self.size, self.format);
        let refuse = |what: String| SourceError::Pipe { what };
        let sides = 1..=LARGEST_SIDE as u32;
        if !(sides.contains(&width) && sides.contains(&height)) {
            return Err(refuse(format!(
                "{width}x{height} is not a valid frame size: sides are from 1 to {LARGEST_SIDE}"
            )));
        }
        if !format.fits(self.size) {
            return Err(refuse(format!(
                "pixels of {} share their color in pairs or fours, and {width}x{height} has some left over: send even sizes",
                format.name()
            )));
        }
        Ok(())
    }

    fn layout(self) -> Layout {
        self.format.layout(self.size)
    }

    fn bytes(self) -> usize {
        self.format.frame_bytes(self.size)
    }

    /// Guesses another common size, or another format, in which this many bytes are whole frames.
    fn likely(self, total: usize) -> Option<String> {
        // Sizes from 320×240 to 4K that cameras and encoders use.
        const USUAL: [[u32; 2]; 14] = [
            [320, 240],
            [424, 240],
            [640, 360],
            [640, 400],
            [640, 480],
            [800, 600],
            [848, 480],
            [960, 540],
            [1024, 768],
            [1280, 720],
            [1280, 800],
            [1280, 960],
            [1920, 1080],
            [3840, 2160],
        ];
        let [width, height] = self.size;
        let area = |[width, height]: [u32; 2]| u64::from(width) * u64::from(height);
        let is_whole = |other: &Self| {
            other.format.fits(other.size) && total > 0 && total.is_multiple_of(other.bytes())
        };
        let sizes = USUAL.into_iter().chain([[height, width]]);
        let sizes = sizes.map(|size| Self { size, ..self }).filter(is_whole);
        let nearest = sizes.min_by_key(|other| area(other.size).abs_diff(area(self.size)));
        if let Some(Self { size: [w, h], .. }) = nearest {
            return Some(format!("{w}x{h} {}", self.format.name()));
        }
        // Prefers the fewest frames, then the first format. One frame with two bytes per pixel thus
        // does not count as two frames with one byte per pixel.
        let formats = RawFormat::names().filter_map(RawFormat::from_name);
        let formats = formats.map(|format| Self { format, ..self });
        let other = formats
            .filter(is_whole)
            .min_by_key(|other| total / other.bytes())?;
        Some(format!("{width}x{height} {}", other.format.name()))
    }
}

/// The part of the stream being read.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Part {
    /// The header of a video.
    Head,
    /// The line before a frame.
    Line(Head),
    /// A frame's planes.
    Planes(Head),
    /// A raw frame.
    Raw(RawFrames),
}

/// A pipe being read.
pub(crate) struct Piped {
    pipe: File,
    paced: bool,
    part: Part,
    /// Bytes of the current part: `have` of them were read, and `need` complete it.
    bytes: Vec<u8>,
    have: usize,
    need: usize,
    sequence: u64,
    has_ended: bool,
    /// Number of bits in the samples of 16-bit raw frames.
    bits: Bits,
    news: Option<String>,
}

impl Piped {
    /// Opens standard input.
    pub(crate) fn standard_input(options: &PipeOptions) -> Result<Self, SourceError> {
        let input = io::stdin();
        let refuse = |what: &dyn std::fmt::Display| SourceError::Pipe {
            what: what.to_string(),
        };
        if input.is_terminal() {
            return Err(refuse(
                &"it is a terminal: send frames into it (ffmpeg -i IN -f yuv4mpegpipe - | lariat …)",
            ));
        }
        let own = input.as_fd().try_clone_to_owned();
        let own = own.map_err(|error| refuse(&error))?;
        Self::new(own.into(), options)
    }

    pub(crate) fn new(pipe: File, options: &PipeOptions) -> Result<Self, SourceError> {
        let (part, need) = match options.raw {
            None => (Part::Head, MAGIC.len()),
            Some(raw) => {
                raw.check()?;
                (Part::Raw(raw), raw.bytes())
            }
        };
        Ok(Self {
            pipe,
            paced: options.paced,
            part,
            bytes: Vec::new(),
            have: 0,
            need,
            sequence: 0,
            has_ended: false,
            bits: Bits::default(),
            news: None,
        })
    }

    fn goes_on_with(&mut self, part: Part, need: usize) {
        (self.part, self.have, self.need) = (part, 0, need);
    }

    /// Waits for data and reads it. Returns `None` if the wait was interrupted, otherwise whether
    /// there was more data.
    fn read(&mut self, until: &Until) -> io::Result<Option<bool>> {
        let event = Some((self.pipe.as_fd(), PollFlags::IN));
        if until.wait(event, None) == Woken::Interrupted {
            return Ok(None);
        }
        if self.bytes.len() < self.need {
            self.bytes.resize(self.need, 0);
        }
        match self.pipe.read(&mut self.bytes[self.have..self.need]) {
            Ok(count) => {
                self.have += count;
                Ok(Some(count > 0))
            }
            Err(error)
                if matches!(
                    error.kind(),
                    io::ErrorKind::Interrupted | io::ErrorKind::WouldBlock
                ) =>
            {
                Ok(Some(true))
            }
            Err(error) => Err(error),
        }
    }

    /// Handles a complete part. Returns its layout if it is a frame.
    fn take(&mut self) -> Result<Option<Layout>, SourceError> {
        let there = &self.bytes[..self.have];
        let refuse = |what: &str| SourceError::Pipe {
            what: what.to_owned(),
        };
        match self.part {
            Part::Raw(raw) => return Ok(Some(raw.layout())),
            Part::Planes(head) => return Ok(Some(head.layout)),
            Part::Head => {
                if !there.starts_with(MAGIC) {
                    return Err(refuse(&stranger(there)));
                }
                if there.ends_with(b"\n") || self.have >= LINE_BYTES {
                    let head = Head::of(there).map_err(refuse)?;
                    self.goes_on_with(Part::Line(head), FRAME.len());
                } else {
                    self.need += 1;
                }
            }
            Part::Line(head) => {
                if begins_frame(there) {
                    self.goes_on_with(Part::Planes(head), head.plane_bytes());
                } else if there.starts_with(b"FRAME ") && self.have < LINE_BYTES {
                    self.need += 1;
                } else {
                    let frame = self.sequence + 1;
                    return Err(SourceError::Pipe {
                        what: format!(
                            "frame {frame} does not begin with `FRAME`: bytes before it are missing, or too many"
                        ),
                    });
                }
            }
        }
        Ok(None)
    }

    /// Handles the end of the stream.
    fn end(&mut self) -> Result<Next, SourceError> {
        self.has_ended = true;
        let is_between = match self.part {
            Part::Raw(_) | Part::Line(_) => self.have == 0,
            Part::Head | Part::Planes(_) => false,
        };
        if is_between && self.sequence > 0 {
            return Ok(Next::End);
        }
        let frame = self.sequence + 1;
        let what = match self.part {
            _ if is_between => "it ended before the first frame".to_owned(),
            Part::Head if self.have == 0 => "it ended before anything came".to_owned(),
            Part::Head => "it ended in the first line of its Y4M video".to_owned(),
            Part::Raw(raw) => {
                let total = raw.bytes().saturating_mul(self.sequence as usize) + self.have;
                let likely = raw
                    .likely(total)
                    .map(|what| format!(": all {total} bytes would be whole frames of {what}"));
                format!(
                    "it ended in frame {frame}, after {} of {} bytes: the writer stopped within a frame, or its frames are not {}x{} {}{}",
                    self.have,
                    raw.bytes(),
                    raw.size[0],
                    raw.size[1],
                    raw.format.name(),
                    likely.unwrap_or_default()
                )
            }
            Part::Line(_) | Part::Planes(_) => {
                format!("it ended in the middle of frame {frame}: the writer broke off")
            }
        };
        Err(SourceError::Pipe { what })
    }
}

impl FrameSource for Piped {
    fn kind(&self) -> SourceKind {
        SourceKind::Video
    }

    fn largest_frame_bytes(&self) -> usize {
        match self.part {
            Part::Head => 0,
            Part::Line(head) | Part::Planes(head) => head.layout.bytes(),
            Part::Raw(raw) => raw.layout().bytes(),
        }
    }

    fn advance(&mut self, until: &Until) -> Result<Next, SourceError> {
        if self.has_ended {
            return Ok(Next::End);
        }
        // The last part was a frame, which has been shown.
        if self.have == self.need {
            match self.part {
                Part::Planes(head) => self.goes_on_with(Part::Line(head), FRAME.len()),
                part => self.goes_on_with(part, self.need),
            }
        }
        loop {
            if self.have == self.need {
                let taken = self.take();
                self.has_ended = taken.is_err();
                if let Some(layout) = taken? {
                    self.sequence += 1;
                    let exposed_ns = (!self.paced).then(now_ns);
                    return Ok(Next::Frame(Frame {
                        exposed_ns,
                        ..layout.frame(self.sequence)
                    }));
                }
                continue;
            }
            match self.read(until) {
                Ok(None) => return Ok(Next::Nothing),
                Ok(Some(true)) => {}
                Ok(Some(false)) => return self.end(),
                Err(error) => {
                    self.has_ended = true;
                    return Err(SourceError::Pipe {
                        what: error.to_string(),
                    });
                }
            }
        }
    }

    fn write(&mut self, pixels: &mut [u8]) {
        let frame = &mut self.bytes[..self.have];
        match self.part {
            Part::Planes(head) if pixels.len() == head.layout.bytes() => {
                head.write(frame, pixels);
            }
            Part::Raw(raw) if pixels.len() == raw.layout().bytes() => {
                let layout = raw.layout();
                raw.format.write(&layout, frame, pixels);
                if layout.format == PixelFormat::Gray16 {
                    let said = self.bits.see(largest(pixels));
                    self.news = self.news.take().or(said);
                    self.bits.widen_all(pixels);
                }
            }
            _ => {
                let count = pixels.len().min(frame.len());
                pixels[..count].copy_from_slice(&frame[..count]);
            }
        }
    }

    fn take_news(&mut self) -> Option<String> {
        self.news.take()
    }
}

/// A sentence about a stream with these first bytes that is not a video, and what to do.
fn stranger(begin: &[u8]) -> String {
    let picture = [
        (&b"\x89PNG"[..], "a PNG picture"),
        (b"\xff\xd8\xff", "a JPEG picture, or a stream of them"),
    ];
    let picture = picture
        .into_iter()
        .find(|(mark, _)| begin.starts_with(mark));
    let what = match Foreign::of(begin) {
        Some(Foreign {
            what,
            way: Way::Recording,
        }) => return format!("it is {what}: name its file with --source"),
        Some(Foreign { what, .. }) => Some(what),
        None if begin.starts_with(b"RIFF") => Some("a RIFF file, such as an AVI video"),
        None => picture.map(|(_, what)| what),
    };
    match what {
        Some(what) => format!(
            "it is {what}, not a Y4M video: let ffmpeg unpack it first \
             (… | ffmpeg -i - -f yuv4mpegpipe -pix_fmt yuv420p - | lariat …)"
        ),
        None => "it is no Y4M video: send one (ffmpeg -i IN -f yuv4mpegpipe -pix_fmt yuv420p - | lariat …), or say what its \
                 frames are with --size and --pixel-format"
            .to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;
    use std::os::fd::OwnedFd;

    use super::*;

    /// Creates a pipe. Also returns the end to write into.
    fn pipe(raw: Option<RawFrames>, paced: bool) -> (Piped, File) {
        let (out, into) = rustix::pipe::pipe().expect("a pipe");
        let [out, into] = [out, into].map(|end: OwnedFd| File::from(end));
        let options = PipeOptions { raw, paced };
        (Piped::new(out, &options).expect("frames"), into)
    }

    fn pixels(piped: &mut Piped, frame: &Frame) -> Vec<u8> {
        let mut pixels = vec![0xA5; frame.bytes()];
        piped.write(&mut pixels);
        pixels
    }

    /// The error for these bytes, after `frames` whole frames.
    fn refusal(raw: Option<RawFrames>, bytes: &[u8], frames: u64) -> String {
        let (mut piped, mut into) = pipe(raw, false);
        into.write_all(bytes).unwrap();
        drop(into);
        for sequence in 1..=frames {
            assert_eq!(piped.next().unwrap().unwrap().sequence, sequence);
        }
        let said = piped.next().unwrap_err().to_string();
        assert_eq!(piped.next().unwrap(), None, "an error is an end");
        said
    }

    fn raw(size: [u32; 2], format: &str) -> RawFrames {
        let format = RawFormat::from_name(format).expect("a format");
        RawFrames { size, format }
    }

    fn two() -> RawFrames {
        raw([2, 1], "rgb8")
    }

    #[test]
    fn frames_come_out_as_they_are_put_in_however_they_are_cut() {
        let video = b"YUV4MPEG2 W4 H2 F25:1 C420 XCOLORRANGE=FULL\nFRAME\nabcdefghuUvVFRAME Ip\nABCDEFGHuUvV";
        for step in [1, 5, video.len()] {
            let (mut piped, mut into) = pipe(None, false);
            let writer = std::thread::spawn(move || {
                video
                    .chunks(step)
                    .for_each(|part| into.write_all(part).unwrap());
            });
            for luma in [b"abcdefgh", b"ABCDEFGH"] {
                let frame = piped.next().unwrap().unwrap();
                assert_eq!((frame.width, frame.height), (4, 2));
                assert_eq!(frame.format, PixelFormat::Nv12);
                assert!(frame.exposed_ns.is_some() && frame.bytes() == piped.largest_frame_bytes());
                assert_eq!(pixels(&mut piped, &frame), [&luma[..], b"uvUV"].concat());
            }
            assert_eq!(piped.next().unwrap(), None);
            writer.join().unwrap();
        }
        let (mut piped, mut into) = pipe(Some(two()), true);
        into.write_all(b"rgbRGB").unwrap();
        drop(into);
        let frame = piped.next().unwrap().unwrap();
        assert_eq!((frame.exposed_ns, frame.stride), (None, 6));
        assert_eq!(pixels(&mut piped, &frame), b"rgbRGB");
        assert_eq!(piped.next().unwrap(), None);
    }

    #[test]
    fn a_writer_that_stands_still_is_not_waited_for_longer_than_wanted() {
        let (mut piped, mut into) = pipe(Some(two()), false);
        let (mut stop_in, stop) = std::os::unix::net::UnixStream::pair().unwrap();
        let until = Until::new(None, stop.as_fd());
        into.write_all(b"rgbR").unwrap();
        stop_in.write_all(&[1]).unwrap();
        assert_eq!(piped.advance(&until).unwrap(), Next::Nothing);
        into.write_all(b"GB").unwrap();
        assert_eq!(piped.next().unwrap().unwrap().sequence, 1);
    }

    #[test]
    fn what_breaks_off_is_said() {
        let head = "YUV4MPEG2 W2 H1 Cmono\n";
        for (text, frames, part) in [
            ("", 0, "before anything came"),
            ("YUV4MPEG2 W2", 0, "in the first line"),
            (head, 0, "before the first frame"),
            (
                &format!("{head}FRAME\nabFRA"),
                1,
                "in the middle of frame 2",
            ),
            (
                &format!("{head}FRAME\nabFRAME\nc"),
                1,
                "in the middle of frame 2",
            ),
            (
                &format!("{head}FRAME\nabcFRAME\n"),
                1,
                "frame 2 does not begin",
            ),
            ("YUV4MPEG2 W2 H1 C440\n", 0, "none of 4:2:0"),
        ] {
            let said = refusal(None, text.as_bytes(), frames);
            assert!(
                said.contains("standard input") && said.contains(part),
                "{said}"
            );
        }
        let said = refusal(Some(two()), b"rgbRGBrgb", 1);
        assert!(said.contains("frame 2, after 3 of 6 bytes"), "{said}");
    }

    #[test]
    fn what_is_no_video_is_named_with_the_way_to_make_it_one() {
        for (begin, name) in [
            (&b"\x1a\x45\xdf\xa3\x01\x00\x00\x00\x00\x00"[..], "Matroska"),
            (b"\x00\x00\x00\x20ftypisom", "MP4"),
            (b"RIFF1234AVI ", "AVI"),
            (b"\xff\xd8\xff\xe0\x00\x10JFIF", "JPEG"),
            (b"hello, world", "--pixel-format"),
        ] {
            let said = refusal(None, begin, 0);
            assert!(said.contains(name) && said.contains("ffmpeg"), "{said}");
        }
    }

    #[test]
    fn frames_of_another_size_than_said_are_named() {
        for (said, format, given, likely) in [
            ([640, 480], "rgb8", 5 * 320 * 240 * 3, "320x240 rgb8"),
            ([640, 480], "rgb8", 1280 * 720 * 3 + 640 * 480 * 3, ""),
            ([1024, 768], "yuyv", 1280 * 720 * 2, "1280x720 yuyv"),
            ([640, 480], "rgb8", 640 * 480 * 2, "640x480 yuyv"),
            ([480, 642], "gray8", 642 * 480 / 2 * 3, "480x642 nv12"),
        ] {
            let frames = raw(said, format);
            let whole = (given / frames.bytes()) as u64;
            let (mut piped, mut into) = pipe(Some(frames), false);
            let writer = std::thread::spawn(move || into.write_all(&vec![0; given]));
            for _ in 0..whole {
                assert!(piped.next().unwrap().is_some());
            }
            match piped.next() {
                Ok(end) => assert!(end.is_none() && likely.is_empty(), "{said:?} {format}"),
                Err(error) => {
                    let said = error.to_string();
                    assert!(said.contains(likely) && said.contains("after"), "{said}");
                }
            }
            writer.join().unwrap().unwrap();
        }
    }

    #[test]
    fn numbers_of_12_bits_become_16_and_that_is_told() {
        let (mut piped, mut into) = pipe(Some(raw([2, 1], "gray16")), false);
        into.write_all(&[4095u16.to_ne_bytes(), 0u16.to_ne_bytes()].concat())
            .unwrap();
        let frame = piped.next().unwrap().unwrap();
        assert_eq!(pixels(&mut piped, &frame), [255, 255, 0, 0]);
        assert!(
            piped
                .take_news()
                .is_some_and(|news| news.contains("12 bits"))
        );
    }

    #[test]
    fn frames_of_no_size_and_half_a_pair_are_refused() {
        for (size, format) in [
            ([0, 1], "gray8"),
            ([99_999, 1], "gray8"),
            ([3, 2], "yuyv"),
            ([2, 3], "nv12"),
            ([2, 3], "i420"),
        ] {
            let raw = Some(raw(size, format));
            let (out, _into) = rustix::pipe::pipe().expect("a pipe");
            let opened = Piped::new(out.into(), &PipeOptions { raw, paced: false });
            assert!(opened.is_err(), "{size:?} {format:?}");
        }
    }
}
