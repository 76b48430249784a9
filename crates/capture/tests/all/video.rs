//! Y4M videos as frames: their layouts, how they end, and which are refused.

use std::fs;
use std::path::Path;

use lariat_capture::{FileOptions, Frame, FrameSource, RenderOptions, Source, SourceError, open};
use lariat_message::{PixelFormat, SourceKind};
use tempfile::TempDir;

use crate::pictures::next_pixels;

type Opened = Result<Box<dyn FrameSource>, SourceError>;

/// The bytes of a video file: its header, then its frames.
fn video(line: &str, frames: &[&[u8]]) -> Vec<u8> {
    let mut bytes = format!("YUV4MPEG2 {line}\n").into_bytes();
    for frame in frames {
        bytes.extend_from_slice(b"FRAME\n");
        bytes.extend_from_slice(frame);
    }
    bytes
}

fn open_path(path: &Path, looped: bool) -> Opened {
    let options = FileOptions {
        looped,
        ..FileOptions::default()
    };
    open(&Source::named(&[path], options, RenderOptions::default()))
}

/// Opens a video with these bytes. Dropping the folder removes the file.
fn open_bytes(bytes: &[u8], looped: bool) -> (Opened, TempDir) {
    let folder = TempDir::new().expect("the system has a folder for temporary files");
    let path = folder.path().join("video.y4m");
    fs::write(&path, bytes).unwrap();
    (open_path(&path, looped), folder)
}

fn refusal(bytes: &[u8]) -> String {
    open_bytes(bytes, false)
        .0
        .err()
        .expect("it is refused")
        .to_string()
}

#[test]
fn every_420_is_nv12_at_the_files_own_pace() {
    for chroma in ["", " C420", " C420jpeg", " C420mpeg2", " C420paldv"] {
        let line = format!("W4 H2 F30000:1001{chroma} XCOLORRANGE=FULL");
        let frame = [1, 2, 3, 4, 5, 6, 7, 8, 50, 51, 60, 61];
        let (opened, _folder) = open_bytes(&video(&line, &[&frame]), false);
        let mut source = opened.unwrap();
        assert_eq!(source.kind(), SourceKind::Video);
        assert_eq!(source.native_fps(), Some(30000.0 / 1001.0));
        let (frame, pixels) = next_pixels(&mut *source).unwrap();
        let expected = Frame {
            sequence: 1,
            width: 4,
            height: 2,
            stride: 4,
            format: PixelFormat::Nv12,
            exposed_ns: None,
            slot: None,
        };
        assert_eq!(frame, expected);
        assert_eq!(pixels, [1, 2, 3, 4, 5, 6, 7, 8, 50, 60, 51, 61]);
        assert_eq!(source.next().unwrap(), None);
        assert_eq!(source.take_warning(), None);
    }
}

#[test]
fn odd_sizes_have_room_for_the_odd_row_and_column_of_colour() {
    let frame: Vec<u8> = (0..15 + 6 + 6).collect();
    let (opened, _folder) = open_bytes(
        &video("W5 H3 F25:1 C420 XCOLORRANGE=FULL", &[&frame]),
        false,
    );
    let (frame, pixels) = next_pixels(&mut *opened.unwrap()).unwrap();
    assert_eq!((frame.width, frame.height, frame.stride), (5, 3, 6));
    let expected = [
        [0, 1, 2, 3, 4, 4],
        [5, 6, 7, 8, 9, 9],
        [10, 11, 12, 13, 14, 14],
        [15, 21, 16, 22, 17, 23],
        [18, 24, 19, 25, 20, 26],
    ];
    assert_eq!(pixels, expected.concat());
}

#[test]
fn mono_422_and_444_become_formats_that_travel() {
    let (opened, _folder) = open_bytes(&video("W3 H1 F25:1 Cmono", &[&[1, 2, 3]]), false);
    let (frame, pixels) = next_pixels(&mut *opened.unwrap()).unwrap();
    assert_eq!((frame.format, pixels), (PixelFormat::Gray8, vec![1, 2, 3]));

    let (opened, _folder) = open_bytes(
        &video("W2 H1 F25:1 C422 XCOLORRANGE=FULL", &[&[1, 2, 50, 60]]),
        false,
    );
    let (frame, pixels) = next_pixels(&mut *opened.unwrap()).unwrap();
    assert_eq!(
        (frame.format, pixels),
        (PixelFormat::Yuyv, vec![1, 50, 2, 60])
    );

    let frame = [16, 235, 128, 128, 128, 128];
    let (opened, _folder) = open_bytes(&video("W2 H1 F25:1 C444", &[&frame]), false);
    let (frame, pixels) = next_pixels(&mut *opened.unwrap()).unwrap();
    assert_eq!(frame.format, PixelFormat::Rgb8);
    assert_eq!(pixels, [0, 0, 0, 255, 255, 255]);

    let frame = [16, 235, 128, 128, 128, 128];
    let line = "W2 H1 F25:1 C444 XCOLORRANGE=FULL";
    let (opened, _folder) = open_bytes(&video(line, &[&frame]), false);
    let (_, pixels) = next_pixels(&mut *opened.unwrap()).unwrap();
    assert_eq!(pixels, [16, 16, 16, 235, 235, 235]);
}

#[test]
fn a_loop_counts_on_also_when_the_file_is_too_large_to_keep() {
    let small = video("W2 H1 F25:1 Cmono", &[&[1, 1], &[2, 2], &[3, 3]]);
    let frames: Vec<Vec<u8>> = (1..=3).map(|i| vec![i; 6000 * 4000]).collect();
    let frames: Vec<&[u8]> = frames.iter().map(Vec::as_slice).collect();
    let large = video("W6000 H4000 F25:1 Cmono", &frames);
    for bytes in [small, large] {
        let (opened, _folder) = open_bytes(&bytes, true);
        let mut source = opened.unwrap();
        for sequence in 1..=8 {
            let (frame, pixels) = next_pixels(&mut *source).unwrap();
            assert_eq!(frame.sequence, sequence);
            assert_eq!(u64::from(pixels[1]), (sequence - 1) % 3 + 1);
        }
    }
}

#[test]
fn a_cut_or_damaged_end_is_said_after_the_whole_frames() {
    let whole = video("W2 H2 F25:1 Cmono", &[&[1; 4], &[2; 4]]);
    let cut_in_pixels = [&whole[..], b"FRAME\n\x03"].concat();
    let cut_in_words = [&whole[..], b"FRA"].concat();
    let damaged = [&whole[..], b"GARBAGE\n\x03\x03\x03\x03"].concat();
    for (bytes, part) in [
        (cut_in_pixels, "cut off in frame 3"),
        (cut_in_words, "cut off in frame 3"),
        (damaged, "damaged after frame 2"),
    ] {
        for looped in [false, true] {
            let (opened, _folder) = open_bytes(&bytes, looped);
            let mut source = opened.unwrap();
            let sequences: Vec<u64> = std::iter::from_fn(|| next_pixels(&mut *source))
                .take(4)
                .map(|(frame, _)| frame.sequence)
                .collect();
            assert_eq!(sequences.len(), if looped { 4 } else { 2 });
            let said: Vec<String> = std::iter::from_fn(|| source.take_warning()).collect();
            assert_eq!(said.len(), 1, "{said:?}");
            assert!(said[0].contains(part), "{said:?}");
        }
    }
}

#[test]
fn what_cannot_be_shown_is_refused_with_what_would_be_right() {
    let good = video("W4 H2 F30:1 C420", &[&[0; 12]]);
    let refused: [(Vec<u8>, &str); 12] = [
        (Vec::new(), "the file is empty"),
        (b"RIFF....AVI ".to_vec(), "does not begin with `YUV4MPEG2`"),
        (b"YUV4MPEG2 W4 H2".to_vec(), "does not end"),
        (good[..20].to_vec(), "does not end"),
        (good[..good.len() - 1].to_vec(), "cut off in frame 1"),
        (video("W4 H2 F30:1 C420", &[]), "holds no frame"),
        (video("H2 F30:1", &[&[0; 12]]), "no width"),
        (video("W4 H0 F30:1", &[&[0; 12]]), "no height"),
        (
            video("W99999999999999 H99999999999999 F30:1", &[]),
            "no width",
        ),
        (video("W4 H2 F30:1 C440", &[&[0; 24]]), "none of 4:2:0"),
        (video("W4 H2 F30:1 C410", &[&[0; 12]]), "none of 4:2:0"),
        (video("W4 H2 Fast", &[&[0; 12]]), "first line is not that"),
    ];
    for (bytes, part) in refused {
        let said = refusal(&bytes);
        assert!(said.contains(part), "{said}");
        assert!(said.contains("video.y4m"), "{said}");
    }
}

#[test]
fn a_rate_of_nothing_is_no_rate() {
    for line in ["W2 H1 F0:0 Cmono", "W2 H1 F25:0 Cmono"] {
        let (opened, _folder) = open_bytes(&video(line, &[&[1, 2]]), false);
        assert_eq!(opened.unwrap().native_fps(), None);
    }
}

#[test]
fn a_missing_video_and_a_video_among_others_are_refused() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("missing.y4m");
    let said = open_path(&path, false).err().unwrap().to_string();
    assert!(
        said.contains("cannot read") && said.contains("missing.y4m"),
        "{said}"
    );
    let named = Source::named(
        &[&*path, Path::new("a.png")],
        FileOptions::default(),
        RenderOptions::default(),
    );
    let said = open(&named).err().unwrap().to_string();
    assert!(said.contains("shown alone"), "{said}");
}
