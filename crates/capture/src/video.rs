//! Y4M video files: raw planes behind a line of text.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use lariat_wire::SourceKind;
use y4m::Colorspace;

use crate::ahead::{Ahead, Decode, Layout, Plan, Step};
use crate::source::SourceError;
use crate::yuv::Chroma;

/// Wider or higher is more likely a broken head than a camera.
const LARGEST_SIDE: u64 = 16384;
/// A head is no longer, in bytes.
const HEAD_BYTES: u64 = 1024;

/// Opens a Y4M video.
pub(crate) fn open_video(path: &Path, looped: bool) -> Result<Ahead, SourceError> {
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
    let plan = Plan {
        kind: SourceKind::Video,
        largest_frame_bytes: stream.layout.bytes(),
        native_fps,
        looped,
        total_bytes: file.len(),
        warnings: Vec::new(),
    };
    let video = Video {
        path: path.to_owned(),
        stream,
        shown: 0,
    };
    Ahead::start(video, plan)
}

struct Video {
    path: PathBuf,
    stream: Stream,
    /// Frames decoded in this pass.
    shown: u64,
}

/// A file that is being read.
struct Stream {
    decoder: y4m::Decoder<Counted>,
    /// Bytes that the decoder has taken: it calls every end the same, and only by this a clean one is told from a
    /// frame cut off.
    taken: Arc<AtomicU64>,
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

        let taken = Arc::new(AtomicU64::new(0));
        let reader = Counted {
            reader: BufReader::new(File::open(path).map_err(unreadable)?),
            taken: Arc::clone(&taken),
        };
        let decoder = y4m::Decoder::new(reader).map_err(|error| match error {
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
            taken,
            chroma,
            layout: chroma.layout(width, height),
        };
        Ok((stream, native_fps))
    }
}

const CHROMA_NEEDED: &str = "its pixels are none of 8-bit 4:2:0, 4:2:2, 4:4:4 and mono \
     (convert it with `ffmpeg -i IN -pix_fmt yuv420p OUT.y4m`)";

fn chroma_of(decoder: &y4m::Decoder<Counted>) -> Option<Chroma> {
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

impl Decode for Video {
    fn rewind(&mut self) -> Result<(), SourceError> {
        // At first the stream stands where it was opened.
        if self.shown > 0 {
            let (stream, _) = Stream::open(&self.path)?;
            if stream.layout != self.stream.layout {
                return Err(SourceError::Video {
                    path: self.path.clone(),
                    what: "the file was replaced by one of another size while it was shown"
                        .to_owned(),
                });
            }
            self.stream = stream;
        }
        self.shown = 0;
        Ok(())
    }

    fn decode(&mut self, pixels: &mut [u8]) -> Step {
        let Stream {
            decoder,
            taken,
            chroma,
            layout,
        } = &mut self.stream;
        let before = taken.load(Ordering::Relaxed);
        let path = self.path.display();
        let reason = match decoder.read_frame() {
            Ok(frame) => {
                let planes = [
                    frame.get_y_plane(),
                    frame.get_u_plane(),
                    frame.get_v_plane(),
                ];
                // The room was made for this layout.
                chroma.write(layout, planes, &mut pixels[..layout.bytes()]);
                self.shown += 1;
                return Step::Decoded(*layout);
            }
            Err(y4m::Error::EOF) if taken.load(Ordering::Relaxed) == before && self.shown > 0 => {
                return Step::End(None);
            }
            Err(y4m::Error::EOF) if taken.load(Ordering::Relaxed) == before => {
                format!("{path} holds no frame")
            }
            Err(y4m::Error::EOF) => format!("{path} is cut off in frame {}", self.shown + 1),
            Err(y4m::Error::IoError(error)) => format!("{path} cannot be read on: {error}"),
            Err(_) => format!("{path} is damaged after frame {}", self.shown),
        };
        // Where the next frame would begin is not known.
        Step::End(Some(reason))
    }
}

/// Counts what is read.
struct Counted {
    reader: BufReader<File>,
    taken: Arc<AtomicU64>,
}

impl Read for Counted {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let count = self.reader.read(into)?;
        self.taken.fetch_add(count as u64, Ordering::Relaxed);
        Ok(count)
    }
}
