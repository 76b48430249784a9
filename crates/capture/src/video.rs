//! Y4M video files: raw planes behind a line of text.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use lariat_wire::SourceKind;
use y4m::Colorspace;

use crate::ahead::{Ahead, Decode, Layout, Plan, Step};
use crate::open::FileOptions;
use crate::range::Frames;
use crate::source::SourceError;
use crate::yuv::Chroma;

/// Wider or higher is more likely a broken head than a camera.
const LARGEST_SIDE: u64 = 16384;
/// A head is no longer, in bytes.
const HEAD_BYTES: u64 = 1024;

/// Opens a Y4M video.
pub(crate) fn open_video(path: &Path, options: &FileOptions) -> Result<Ahead, SourceError> {
    let file = std::fs::metadata(path).map_err(|error| SourceError::Unreadable {
        path: path.to_owned(),
        error,
    })?;
    if !file.is_file() {
        // A pipe can be read neither twice nor ahead of its writer.
        return Err(SourceError::Video {
            path: path.to_owned(),
            what: "it is not a regular file".to_owned(),
        });
    }
    let (stream, native_fps) = Stream::open(path)?;
    let frames = options.range.frames(native_fps.or(options.fps))?;
    let frame_bytes = stream.frame_bytes();
    let plan = Plan {
        kind: SourceKind::Video,
        largest_frame_bytes: stream.layout.bytes(),
        native_fps,
        looped: options.looped,
        has_truth: false,
        total_bytes: frames.of(file.len() / frame_bytes) * frame_bytes,
        warnings: Vec::new(),
        news: frames.news(),
    };
    let video = Video {
        path: path.to_owned(),
        stream,
        frames,
        at: 0,
    };
    Ahead::start(video, plan)
}

struct Video {
    path: PathBuf,
    stream: Stream,
    frames: Frames,
    /// The frame that was passed last, in this pass: 0 before the first.
    at: u64,
}

/// A file that is being read.
struct Stream {
    decoder: y4m::Decoder<Shared>,
    /// What the decoder reads.
    input: Arc<Mutex<Input>>,
    chroma: Chroma,
    layout: Layout,
}

impl Stream {
    /// The stream at its first frame, and the frame rate it asks for.
    fn open(path: &Path) -> Result<(Self, Option<f64>), SourceError> {
        let unreadable = |error| SourceError::Unreadable {
            path: path.to_owned(),
            error,
        };
        let unfit = |what: &str| SourceError::Video {
            path: path.to_owned(),
            what: what.to_owned(),
        };
        let mut head = Vec::new();
        let file = File::open(path).map_err(unreadable)?;
        let read = file.take(HEAD_BYTES).read_to_end(&mut head);
        read.map_err(unreadable)?;
        check_head(&head).map_err(unfit)?;

        let input = Arc::new(Mutex::new(Input {
            reader: BufReader::new(File::open(path).map_err(unreadable)?),
            taken: 0,
            line: Vec::new(),
        }));
        let decoder =
            y4m::Decoder::new(Shared(Arc::clone(&input))).map_err(|error| match error {
                y4m::Error::UnknownColorspace => unfit(CHROMA_NEEDED),
                _ => unfit("its first line is not that of a Y4M video"),
            })?;
        let chroma = chroma_of(&decoder).ok_or_else(|| unfit(CHROMA_NEEDED))?;
        // Sizes in range: the head was looked at.
        let (width, height) = (decoder.get_width() as u32, decoder.get_height() as u32);
        let rate = decoder.get_framerate();
        let native_fps = (rate.num > 0 && rate.den > 0).then(|| rate.num as f64 / rate.den as f64);
        let stream = Self {
            decoder,
            input,
            chroma,
            layout: chroma.layout(width, height),
        };
        Ok((stream, native_fps))
    }

    /// Bytes of a frame's planes in the file.
    fn frame_bytes(&self) -> u64 {
        let (width, height) = (self.decoder.get_width(), self.decoder.get_height());
        self.chroma.plane_bytes(width, height) as u64
    }

    /// Passes over so many frames without reading their pixels; `false` if they are not all there. It then stands where the
    /// first begins that is not, for the decoder to say what is wrong with it.
    fn pass(&mut self, count: u64, at: &mut u64) -> io::Result<bool> {
        let frame_bytes = self.frame_bytes();
        let mut input = lock(&self.input);
        for _ in 0..count {
            if !input.pass_frame(frame_bytes)? {
                return Ok(false);
            }
            *at += 1;
        }
        Ok(true)
    }
}

const CHROMA_NEEDED: &str = "its pixels are none of 8-bit 4:2:0, 4:2:2, 4:4:4 and mono \
     (convert it with `ffmpeg -i IN -pix_fmt yuv420p OUT.y4m`)";

fn chroma_of(decoder: &y4m::Decoder<Shared>) -> Option<Chroma> {
    let mut words = decoder.get_raw_params().split(|&c| c == b' ');
    let full_range = words.any(|word| word == b"XCOLORRANGE=FULL");
    Some(match decoder.get_colorspace() {
        Colorspace::Cmono => Chroma::Mono,
        Colorspace::C420 | Colorspace::C420jpeg | Colorspace::C420paldv | Colorspace::C420mpeg2 => {
            Chroma::Half
        }
        Colorspace::C422 => Chroma::HalfWidth,
        Colorspace::C444 => Chroma::Full { full_range },
        _ => return None,
    })
}

/// Looks at a file's first line before the decoder makes room for what it says.
fn check_head(head: &[u8]) -> Result<(), &'static str> {
    if head.is_empty() {
        return Err("the file is empty");
    }
    if !head.starts_with(b"YUV4MPEG2 ") {
        return Err("it does not begin with `YUV4MPEG2`, as a Y4M video does");
    }
    let Some(end) = head.iter().position(|&c| c == b'\n') else {
        return Err("its first line does not end");
    };
    for (name, problem) in [
        (b'W', "its first line says no width from 1 to 16384"),
        (b'H', "its first line says no height from 1 to 16384"),
    ] {
        // The last of several counts, as it does for the decoder.
        let mut words = head[..end].split(|&c| c == b' ');
        let word = words.rfind(|word| word.first() == Some(&name));
        let digits = word.and_then(|word| std::str::from_utf8(&word[1..]).ok());
        let side = digits.and_then(|digits| digits.parse::<u64>().ok());
        if !side.is_some_and(|side| (1..=LARGEST_SIDE).contains(&side)) {
            return Err(problem);
        }
    }
    Ok(())
}

impl Video {
    /// Goes back to the beginning. At first the stream stands where it was opened.
    fn reopen(&mut self) -> Result<(), SourceError> {
        let (stream, _) = Stream::open(&self.path)?;
        if stream.layout != self.stream.layout {
            return Err(SourceError::Video {
                path: self.path.clone(),
                what: "the file was replaced by one of another size while it was shown".to_owned(),
            });
        }
        (self.stream, self.at) = (stream, 0);
        Ok(())
    }

    /// How many frames lie before the next one that is shown.
    fn between(&self) -> u64 {
        match self.at {
            0 => self.frames.first - 1,
            _ => self.frames.every - 1,
        }
    }
}

impl Decode for Video {
    fn rewind(&mut self) -> Result<(), SourceError> {
        match self.at {
            0 => Ok(()),
            _ => self.reopen(),
        }
    }

    fn decode(&mut self, pixels: &mut [u8]) -> Step {
        let between = self.between();
        if self.at.saturating_add(between) >= self.frames.last {
            return Step::End(None);
        }
        let path = self.path.display();
        let unreadable =
            |error: io::Error| Step::End(Some(format!("{path} cannot be read on: {error}")));
        let is_reached = match self.stream.pass(between, &mut self.at) {
            Ok(is_reached) => is_reached,
            Err(error) => return unreadable(error),
        };
        let Stream {
            decoder,
            input,
            chroma,
            layout,
        } = &mut self.stream;
        let taken = || lock(input).taken;
        let before = taken();
        let reason = match decoder.read_frame() {
            Ok(frame) if is_reached => {
                let planes = [
                    frame.get_y_plane(),
                    frame.get_u_plane(),
                    frame.get_v_plane(),
                ];
                // The room was made for this layout.
                chroma.write(layout, planes, &mut pixels[..layout.bytes()]);
                self.at += 1;
                return Step::Decoded(*layout);
            }
            Err(y4m::Error::EOF) if taken() == before && self.at > 0 => {
                return Step::End(None);
            }
            Err(y4m::Error::EOF) if taken() == before => format!("{path} holds no frame"),
            // One that is there now was not a moment ago: it is being written.
            Ok(_) | Err(y4m::Error::EOF) => format!("{path} is cut off in frame {}", self.at + 1),
            Err(y4m::Error::IoError(error)) => return unreadable(error),
            Err(_) => format!("{path} is damaged after frame {}", self.at),
        };
        // Where the next frame would begin is not known.
        Step::End(Some(reason))
    }

    fn nothing(&self) -> SourceError {
        SourceError::BehindEnd {
            first: self.frames.first,
            count: self.at,
        }
    }
}

/// A file as its decoder reads it, and past it: the decoder cannot skip a frame.
struct Input {
    reader: BufReader<File>,
    /// Bytes from the beginning of the file: the decoder calls every end the same, and only by this a clean one is told from
    /// a frame cut off.
    taken: u64,
    /// The line that was passed last.
    line: Vec<u8>,
}

impl Input {
    /// Passes over a frame's line and its pixels. `false`, and nothing is passed, if there is no line that begins one, or not
    /// all of its pixels.
    fn pass_frame(&mut self, frame_bytes: u64) -> io::Result<bool> {
        let begin = self.taken;
        let line = &mut self.line;
        line.clear();
        let mut head = (&mut self.reader).take(HEAD_BYTES);
        let line_bytes = head.read_until(b'\n', line)? as u64;
        let end = begin + line_bytes + frame_bytes;
        let is_frame =
            line.ends_with(b"\n") && (line[..] == b"FRAME\n"[..] || line.starts_with(b"FRAME "));
        let is_whole = is_frame && end <= self.reader.get_ref().metadata()?.len();
        // Sizes are checked: a frame has less than 2³² bytes.
        let step = if is_whole {
            frame_bytes as i64
        } else {
            -(line_bytes as i64)
        };
        self.reader.seek_relative(step)?;
        self.taken = if is_whole { end } else { begin };
        Ok(is_whole)
    }
}

/// Nobody who holds it panics; and if: a position is whole in any case.
fn lock(input: &Mutex<Input>) -> MutexGuard<'_, Input> {
    input.lock().unwrap_or_else(PoisonError::into_inner)
}

struct Shared(Arc<Mutex<Input>>);

impl Read for Shared {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let mut input = lock(&self.0);
        let count = input.reader.read(into)?;
        input.taken += count as u64;
        Ok(count)
    }
}
