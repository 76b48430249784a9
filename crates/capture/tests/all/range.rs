//! A part of pictures and videos: its frames, their numbers, and what lies outside.

use std::fs;
use std::num::NonZeroU64;
use std::path::Path;
use std::time::Duration;

use image::{GrayImage, Luma};
use lariat_capture::{
    FileOptions, FrameSource, Position, Range, RenderOptions, Source, SourceError, open,
};
use tempfile::TempDir;

type Opened = Result<Box<dyn FrameSource>, SourceError>;

fn open_part(path: &Path, options: FileOptions) -> Opened {
    open(&Source::named(&[path], options, RenderOptions::default()))
}

/// Every n-th frame between two frames.
fn part(from: u64, to: u64, every: u64) -> FileOptions {
    FileOptions {
        range: Range {
            from: Some(Position::Frame(from)),
            to: Some(Position::Frame(to)),
            every: NonZeroU64::new(every).expect("not 0"),
        },
        ..FileOptions::default()
    }
}

fn from_s(from_s: f64, fps: Option<f64>) -> FileOptions {
    let from = Some(Position::Time(Duration::from_secs_f64(from_s)));
    FileOptions {
        range: Range {
            from,
            ..Range::default()
        },
        fps,
        ..FileOptions::default()
    }
}

/// Sequence number and first byte of the next frames. In these tests, the byte identifies the file.
fn shown(source: &mut dyn FrameSource, most: usize) -> Vec<(u64, u8)> {
    let mut frames = Vec::new();
    while frames.len() < most
        && let Some(frame) = source.next().unwrap()
    {
        let mut pixels = vec![0; frame.bytes()];
        source.write(&mut pixels);
        frames.push((frame.sequence, pixels[0]));
    }
    frames
}

/// Creates a folder of ten pictures and a video of ten frames. The value of every pixel is the
/// number of its frame.
fn ten() -> TempDir {
    let folder = TempDir::new().expect("the system has a folder for temporary files");
    fs::create_dir(folder.path().join("pictures")).unwrap();
    let mut video = b"YUV4MPEG2 W4 H2 F5:1 Cmono\n".to_vec();
    for number in 1..=10_u8 {
        let path = folder.path().join(format!("pictures/{number}.png"));
        let picture = GrayImage::from_pixel(4, 2, Luma([number]));
        picture.save(path).unwrap();
        // Every third line has a parameter, so that frames differ in length.
        let line: &[u8] = if number % 3 == 0 {
            b"FRAME Ip\n"
        } else {
            b"FRAME\n"
        };
        video.extend_from_slice(line);
        video.extend_from_slice(&[number; 8]);
    }
    fs::write(folder.path().join("video.y4m"), video).unwrap();
    folder
}

fn both(folder: &TempDir) -> [std::path::PathBuf; 2] {
    ["pictures", "video.y4m"].map(|name| folder.path().join(name))
}

#[test]
fn a_part_is_numbered_from_1_so_that_what_is_left_out_is_not_lost() {
    let folder = ten();
    for path in both(&folder) {
        let mut source = open_part(&path, part(3, 9, 3)).unwrap();
        assert_eq!(
            shown(&mut *source, 99),
            [(1, 3), (2, 6), (3, 9)],
            "{path:?}"
        );
        assert_eq!(source.take_warning(), None);
        let said = source.take_news().expect("how they are found again");
        assert_eq!(said, "frame n is frame 3 + 3 (n - 1) of the whole");

        let mut source = open_part(&path, part(9, 99, 1)).unwrap();
        assert_eq!(shown(&mut *source, 99), [(1, 9), (2, 10)], "{path:?}");
        let mut source = open_part(&path, part(1, 2, 1)).unwrap();
        assert_eq!(shown(&mut *source, 99), [(1, 1), (2, 2)], "{path:?}");
        assert_eq!(source.take_news(), None);
    }
}

#[test]
fn a_loop_goes_round_within_the_part() {
    let folder = ten();
    for path in both(&folder) {
        let options = FileOptions {
            looped: true,
            ..part(4, 8, 2)
        };
        let mut source = open_part(&path, options).unwrap();
        let numbers: Vec<u8> = shown(&mut *source, 7).iter().map(|frame| frame.1).collect();
        assert_eq!(numbers, [4, 6, 8, 4, 6, 8, 4], "{path:?}");
    }
}

#[test]
fn a_video_too_large_to_keep_goes_round_within_the_part_too() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("large.y4m");
    let mut video = b"YUV4MPEG2 W6000 H4000 F5:1 Cmono\n".to_vec();
    for number in 1..=5 {
        video.extend_from_slice(b"FRAME\n");
        video.resize(video.len() + 6000 * 4000, number);
    }
    fs::write(&path, video).unwrap();
    let options = FileOptions {
        looped: true,
        ..part(2, 4, 1)
    };
    let mut source = open_part(&path, options).unwrap();
    let expected = [(1, 2), (2, 3), (3, 4), (4, 2), (5, 3), (6, 4), (7, 2)];
    assert_eq!(shown(&mut *source, 7), expected);
}

#[test]
fn a_time_goes_by_the_videos_own_rate_and_by_the_pictures_pace() {
    let folder = ten();
    let [pictures, video] = both(&folder);
    let mut source = open_part(&video, from_s(1.8, Some(100.0))).unwrap();
    assert_eq!(shown(&mut *source, 99), [(1, 10)]);
    let mut source = open_part(&pictures, from_s(1.8, Some(5.0))).unwrap();
    assert_eq!(shown(&mut *source, 99), [(1, 10)]);
    let said = open_part(&pictures, from_s(1.8, None))
        .err()
        .unwrap()
        .to_string();
    assert!(
        said.contains("1.8 s") && said.contains("frames a second"),
        "{said}"
    );
}

#[test]
fn a_part_behind_the_end_is_refused_with_how_many_there_are() {
    let folder = ten();
    for path in both(&folder) {
        for first in [11, 12, 5000] {
            let said = open_part(&path, part(first, 9000, 1))
                .err()
                .unwrap()
                .to_string();
            assert!(said.contains(&format!("frame {first}")), "{said}");
            assert!(said.contains("only 10"), "{said}");
        }
        assert!(open_part(&path, part(10, 10, 7)).is_ok());
    }
}

#[test]
fn what_is_skipped_of_a_video_may_be_anything_but_its_frames_must_be_whole() {
    let folder = ten();
    let [_, path] = both(&folder);
    let whole = fs::read(&path).unwrap();
    // One cut is in the pixels of the ninth frame, the other in the line before it.
    let cut_in_pixels = &whole[..whole.len() - 14 - 3];
    let cut_in_line = &whole[..whole.len() - 14 - 8 - 2];
    for cut in [cut_in_pixels, cut_in_line] {
        fs::write(&path, cut).unwrap();
        let mut source = open_part(&path, part(2, 99, 4)).unwrap();
        assert_eq!(shown(&mut *source, 99), [(1, 2), (2, 6)]);
        let said = source.take_warning().expect("it is said");
        assert!(said.contains("cut off in frame 9"), "{said}");
        // The cut is not noticed if the part ends earlier.
        let mut source = open_part(&path, part(2, 6, 4)).unwrap();
        assert_eq!(shown(&mut *source, 99), [(1, 2), (2, 6)]);
        assert_eq!(source.take_warning(), None);
    }
    let mut damaged = whole;
    let ninth = damaged.len() - 14 - 8 - 9;
    damaged[ninth] = b'X';
    fs::write(&path, damaged).unwrap();
    let mut source = open_part(&path, part(2, 99, 4)).unwrap();
    assert_eq!(shown(&mut *source, 99), [(1, 2), (2, 6)]);
    let said = source.take_warning().expect("it is said");
    assert!(said.contains("damaged after frame 8"), "{said}");
}
