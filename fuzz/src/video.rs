//! A video file from a fuzzer's bytes, and a part of it to play. Invariant: a part has the same
//! frames as the whole.

use std::num::NonZeroU64;

use arbitrary::{Arbitrary, Unstructured};
use lariat_capture::{FileOptions, Position, Range, RenderOptions, Source};

use crate::shown::{ScratchFile, Shown, show};

/// First bytes of a real video.
const MAGIC: &[u8] = b"YUV4MPEG2 ";
/// Maximum number of frames that are read.
const MOST: usize = 64;

/// A file with a mostly valid header.
#[derive(Arbitrary, Debug)]
struct Made {
    width: u8,
    height: u8,
    colors: Colors,
    words: Vec<Word>,
    frames: Vec<Frame>,
    changes: Vec<(u16, u8)>,
    length: Option<u16>,
}

#[derive(Arbitrary, Debug)]
enum Colors {
    None,
    Mono,
    C420,
    C422,
    C444,
    Other(u8),
}

#[derive(Arbitrary, Debug)]
enum Word {
    Rate(u8, u8),
    FullRange,
    Any(Vec<u8>),
}

#[derive(Arbitrary, Debug)]
struct Frame {
    /// Text after `FRAME`.
    word: Option<Vec<u8>>,
    fill: u8,
    /// Number of missing or extra bytes.
    off_by: Option<i8>,
}

/// Part of the video to play.
#[derive(Arbitrary, Debug)]
struct Part {
    from: u8,
    to: Option<u8>,
    every: u8,
}

/// Plays a file made from any bytes, and a part of it; a real file is played as it is.
pub fn run(data: &[u8]) {
    let (file, part) = match data.split_first_chunk::<3>() {
        Some((part, file)) if file.starts_with(MAGIC) => {
            let [from, to, every] = *part;
            (
                file.to_vec(),
                Part {
                    from,
                    to: Some(to),
                    every,
                },
            )
        }
        _ => {
            let mut any = Unstructured::new(data);
            let Ok((made, part)) = <(Made, Part)>::arbitrary(&mut any) else {
                return;
            };
            (made.bytes(), part)
        }
    };
    // Frames of one pixel are a few bytes; frames of 16384 × 16384 are too large for thousands of
    // runs.
    if has_large_sides(&file) {
        return;
    }
    let scratch = ScratchFile::new("y4m", &file);
    let open = |range| {
        let options = FileOptions {
            range,
            ..FileOptions::default()
        };
        show(
            &Source::named(&[scratch.path()], options, RenderOptions::default()),
            MOST,
        )
    };
    let Some(whole) = open(Range::default()) else {
        return;
    };
    assert!(
        whole.len() <= file.len() / 6,
        "each frame has a line of its own"
    );
    let (first, every) = (u64::from(part.from).max(1), u64::from(part.every).max(1));
    let last = part.to.map_or(u64::MAX, u64::from);
    let range = Range {
        from: Some(Position::Frame(first)),
        to: Some(Position::Frame(last)),
        every: NonZeroU64::new(every).expect("at least 1"),
    };
    let shown = open(range).unwrap_or_default();
    let wanted = whole
        .iter()
        .filter(|frame| {
            (first..=last).contains(&frame.sequence) && (frame.sequence - first) % every == 0
        })
        .map(|frame| Shown {
            sequence: (frame.sequence - first) / every + 1,
            ..frame.clone()
        });
    // Fewer frames of the whole may have been read.
    for (expected, found) in wanted.zip(&shown) {
        assert_eq!(&expected, found);
    }
    if whole.len() < MOST {
        let count = whole
            .iter()
            .filter(|frame| (first..=last).contains(&frame.sequence));
        let count = count
            .filter(|frame| (frame.sequence - first) % every == 0)
            .count();
        assert_eq!(shown.len(), count);
    }
}

fn has_large_sides(file: &[u8]) -> bool {
    let head = file.split(|&c| c == b'\n').next().unwrap_or_default();
    head.split(|&c| c == b' ').any(|word| {
        let is_side = matches!(word.first(), Some(b'W' | b'H'));
        is_side && word[1..].iter().filter(|c| c.is_ascii_digit()).count() > 3
    })
}

impl Made {
    fn bytes(&self) -> Vec<u8> {
        let (width, height) = (usize::from(self.width), usize::from(self.height));
        let mut file = MAGIC.to_vec();
        file.extend(format!("W{width} H{height}").bytes());
        for word in &self.words {
            file.push(b' ');
            match word {
                Word::Rate(frames, seconds) => file.extend(format!("F{frames}:{seconds}").bytes()),
                Word::FullRange => file.extend(b"XCOLORRANGE=FULL"),
                Word::Any(bytes) => file.extend(bytes),
            }
        }
        let half = width.div_ceil(2);
        let (name, bytes) = match self.colors {
            Colors::None => (
                String::new(),
                width * height + 2 * half * height.div_ceil(2),
            ),
            Colors::Mono => (" Cmono".into(), width * height),
            Colors::C420 => (
                " C420jpeg".into(),
                width * height + 2 * half * height.div_ceil(2),
            ),
            Colors::C422 => (" C422".into(), width * height + 2 * half * height),
            Colors::C444 => (" C444".into(), 3 * width * height),
            Colors::Other(which) => (format!(" C4{which}"), width * height),
        };
        file.extend(name.bytes());
        file.push(b'\n');
        for frame in self.frames.iter().take(MOST + 2) {
            file.extend(b"FRAME");
            if let Some(word) = &frame.word {
                file.push(b' ');
                file.extend(word);
            }
            file.push(b'\n');
            let count = bytes.saturating_add_signed(frame.off_by.unwrap_or(0).into());
            file.resize(file.len() + count, frame.fill);
        }
        let length = file.len();
        for &(at, byte) in &self.changes {
            file[usize::from(at) % length] = byte;
        }
        if let Some(most) = self.length {
            file.truncate(most.into());
        }
        file
    }
}
