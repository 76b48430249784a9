//! Y4M video files: a text header followed by raw planes.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use lariat_message::SourceKind;

use crate::ahead::{Ahead, Decode, Plan, Step};
use crate::open::FileOptions;
use crate::range::Frames;
use crate::source::SourceError;
use crate::y4m::{Head, LINE_BYTES, begins_frame};

/// Opens a Y4M video.
pub(crate) fn open_video(path: &Path, options: &FileOptions) -> Result<Ahead, SourceError> {
    let file = std::fs::metadata(path).map_err(|error| SourceError::Unreadable {
        path: path.to_owned(),
        error,
    })?;
    if !file.is_file() {
        // A pipe cannot be read twice, or ahead of its writer.
        return Err(SourceError::Video {
            path: path.to_owned(),
            what: "it is not a regular file (standard input is `--source -`)".to_owned(),
        });
    }
    let stream = Stream::open(path)?;
    let head = stream.head;
    let frames = options.range.frames(head.fps.or(options.fps))?;
    let frame_bytes = head.plane_bytes() as u64;
    let plan = Plan {
        kind: SourceKind::Video,
        largest_frame_bytes: head.layout.bytes(),
        native_fps: head.fps,
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

/// Frame rate of a Y4M video. `None` for other files, and for a video without a rate.
pub fn video_fps(path: &Path) -> Option<f64> {
    Stream::open(path).ok()?.head.fps
}

struct Video {
    path: PathBuf,
    stream: Stream,
    frames: Frames,
    /// Number of the last frame read or skipped in this pass, 0 before the first.
    at: u64,
}

/// A file being read.
struct Stream {
    reader: BufReader<File>,
    head: Head,
    /// The last line read.
    line: Vec<u8>,
    /// A frame's planes.
    planes: Vec<u8>,
}

/// Outcome of reading the next frame of a file.
enum Found {
    /// A frame, read or skipped.
    Frame,
    End,
    /// An incomplete frame.
    Part,
    /// Something else.
    Other,
}

impl Stream {
    /// Opens the stream at its first frame.
    fn open(path: &Path) -> Result<Self, SourceError> {
        let unreadable = |error| SourceError::Unreadable {
            path: path.to_owned(),
            error,
        };
        let mut reader = BufReader::new(File::open(path).map_err(unreadable)?);
        let mut line = Vec::new();
        let mut begin = (&mut reader).take(LINE_BYTES as u64);
        begin.read_until(b'\n', &mut line).map_err(unreadable)?;
        let head = Head::of(&line).map_err(|what| SourceError::Video {
            path: path.to_owned(),
            what: what.to_owned(),
        })?;
        Ok(Self {
            reader,
            head,
            line,
            planes: Vec::new(),
        })
    }

    /// Reads the next frame, or skips it without reading its pixels.
    fn next(&mut self, is_wanted: bool) -> io::Result<Found> {
        let line = &mut self.line;
        line.clear();
        let mut begin = (&mut self.reader).take(LINE_BYTES as u64);
        if begin.read_until(b'\n', line)? == 0 {
            return Ok(Found::End);
        }
        if !begins_frame(line) {
            let is_begun = !line.ends_with(b"\n") && line.len() < LINE_BYTES;
            let like = line.len().min(6);
            let is_frame = is_begun && line[..like] == b"FRAME "[..like];
            return Ok(if is_frame { Found::Part } else { Found::Other });
        }
        let bytes = self.head.plane_bytes();
        if is_wanted {
            self.planes.resize(bytes, 0);
            return match self.reader.read_exact(&mut self.planes) {
                Ok(()) => Ok(Found::Frame),
                Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(Found::Part),
                Err(error) => Err(error),
            };
        }
        let end = self.reader.get_ref().metadata()?.len();
        // Sizes are checked: a frame is shorter than 2³² bytes.
        self.reader.seek_relative(bytes as i64)?;
        let is_whole = io::Seek::stream_position(&mut self.reader)? <= end;
        Ok(if is_whole { Found::Frame } else { Found::Part })
    }
}

impl Video {
    /// Returns to the beginning.
    fn reopen(&mut self) -> Result<(), SourceError> {
        let stream = Stream::open(&self.path)?;
        if stream.head.layout != self.stream.head.layout {
            return Err(SourceError::Video {
                path: self.path.clone(),
                what: "the file was replaced by one of another size while it was shown".to_owned(),
            });
        }
        (self.stream, self.at) = (stream, 0);
        Ok(())
    }

    /// Number of frames to skip before the next one that is shown.
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
        for left in (0..=between).rev() {
            // After any other content, the start of the next frame is unknown.
            let reason = match self.stream.next(left == 0) {
                Ok(Found::Frame) => {
                    self.at += 1;
                    continue;
                }
                Ok(Found::End) if self.at > 0 => return Step::End(None),
                Ok(Found::End) => format!("{path} holds no frame"),
                Ok(Found::Part) => format!("{path} is cut off in frame {}", self.at + 1),
                Ok(Found::Other) => format!("{path} is damaged after frame {}", self.at),
                Err(error) => format!("{path} cannot be read on: {error}"),
            };
            return Step::End(Some(reason));
        }
        let Stream { head, planes, .. } = &mut self.stream;
        // The buffer was allocated for this layout.
        head.write(planes, &mut pixels[..head.layout.bytes()]);
        Step::Decoded(head.layout)
    }

    fn nothing(&self) -> SourceError {
        SourceError::BehindEnd {
            first: self.frames.first,
            count: self.at,
        }
    }
}
