//! A followed folder: which pictures are shown, when, and in which order, and which are not.

use std::fs::{self, File};
use std::io::Write;
use std::num::NonZeroU64;
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;
use std::path::Path;

use image::{GrayImage, ImageFormat, Luma};
use lariat_capture::{FollowOptions, Frame, FrameSource, Next, Source, SourceError, Until, open};
use lariat_message::now_ns;
use tempfile::TempDir;

const LONG_NS: u64 = 60_000_000_000;

type Opened = Result<Box<dyn FrameSource>, SourceError>;

fn folder() -> TempDir {
    TempDir::new().expect("the system has a folder for temporary files")
}

fn options(folder: &Path) -> FollowOptions {
    FollowOptions {
        folder: folder.to_owned(),
        fps: None,
        every: NonZeroU64::MIN,
    }
}

fn follow(folder: &TempDir) -> Box<dyn FrameSource> {
    open(&Source::Followed(options(folder.path()))).unwrap()
}

/// A picture of a single gray level, which identifies it.
fn picture(grey: u8) -> Vec<u8> {
    let mut bytes = Vec::new();
    GrayImage::from_pixel(5, 4, Luma([grey]))
        .write_to(&mut std::io::Cursor::new(&mut bytes), ImageFormat::Png)
        .unwrap();
    bytes
}

/// Writes a picture outside the folder and moves it into place.
fn put(folder: &TempDir, name: &str, grey: u8) {
    let beside = folder.path().with_extension("beside");
    fs::write(&beside, picture(grey)).unwrap();
    fs::rename(&beside, folder.path().join(name)).unwrap();
}

/// Waits for the next frame and returns it with its gray level. Only sentences may come before it.
fn next(source: &mut dyn FrameSource) -> (Frame, u8) {
    let (_in, stop) = UnixStream::pair().unwrap();
    let deadline_ns = now_ns() + LONG_NS;
    loop {
        match source
            .advance(&Until::new(Some(deadline_ns), stop.as_fd()))
            .unwrap()
        {
            Next::Frame(frame) => {
                let mut pixels = vec![0; frame.bytes()];
                source.write(&mut pixels);
                return (frame, pixels[0]);
            }
            Next::Nothing => assert!(now_ns() < deadline_ns, "nothing came"),
            Next::End => panic!("a folder that is followed has no end"),
        }
    }
}

fn greys(source: &mut dyn FrameSource, count: usize) -> Vec<(u64, u8)> {
    let frames = std::iter::repeat_with(|| next(source)).take(count);
    frames.map(|(frame, grey)| (frame.sequence, grey)).collect()
}

/// Returns whether the source waits because nothing is available.
fn is_idle(source: &mut dyn FrameSource) -> bool {
    let (_in, stop) = UnixStream::pair().unwrap();
    let until = Until::new(Some(now_ns() + 1_000_000), stop.as_fd());
    source.advance(&until).unwrap() == Next::Nothing
}

fn warnings(source: &mut dyn FrameSource) -> Vec<String> {
    std::iter::from_fn(|| source.take_warning()).collect()
}

#[test]
fn what_is_there_is_shown_in_natural_order_and_then_what_comes_in_its_own() {
    let folder = folder();
    for number in [10, 9, 1] {
        put(&folder, &format!("{number}.png"), number);
    }
    fs::write(folder.path().join("notes.txt"), "no picture").unwrap();
    let mut source = follow(&folder);
    assert_eq!(source.largest_frame_bytes(), 20);
    assert_eq!(greys(&mut *source, 3), [(1, 1), (2, 9), (3, 10)]);
    assert!(is_idle(&mut *source));
    put(&folder, "5.png", 5);
    put(&folder, "2.png", 2);
    fs::write(folder.path().join("3.png"), picture(3)).unwrap();
    put(&folder, ".4.png", 4);
    assert_eq!(greys(&mut *source, 3), [(4, 5), (5, 2), (6, 3)]);
    assert!(is_idle(&mut *source));
    assert_eq!(warnings(&mut *source), [""; 0]);
}

#[test]
fn a_picture_is_not_taken_before_it_is_closed() {
    let folder = folder();
    put(&folder, "1.png", 1);
    let mut source = follow(&folder);
    assert_eq!(greys(&mut *source, 1), [(1, 1)]);
    let bytes = picture(2);
    let mut file = File::create(folder.path().join("2.png")).unwrap();
    for part in bytes.chunks(bytes.len().div_ceil(3)) {
        file.write_all(part).unwrap();
        file.sync_all().unwrap();
        assert!(is_idle(&mut *source));
    }
    let before_ns = now_ns();
    drop(file);
    let (frame, grey) = next(&mut *source);
    assert_eq!((frame.sequence, grey), (2, 2));
    let exposed_ns = frame.exposed_ns.expect("it came at a moment of its own");
    assert!((before_ns..now_ns()).contains(&exposed_ns));
}

#[test]
fn one_that_is_in_the_making_at_the_start_is_shown_when_it_is_closed() {
    let folder = folder();
    put(&folder, "1.png", 1);
    let bytes = picture(2);
    let mut file = File::create(folder.path().join("2.png")).unwrap();
    file.write_all(&bytes[..30]).unwrap();
    let mut source = follow(&folder);
    assert_eq!(greys(&mut *source, 1), [(1, 1)]);
    assert!(is_idle(&mut *source));
    let said = warnings(&mut *source);
    assert!(
        said[0].contains("2.png") && said[0].contains("when it is closed"),
        "{said:?}"
    );
    file.write_all(&bytes[30..]).unwrap();
    drop(file);
    assert_eq!(greys(&mut *source, 1), [(2, 2)]);
}

#[test]
fn an_empty_folder_knows_its_room_with_the_first_picture() {
    let folder = folder();
    let mut source = follow(&folder);
    assert_eq!(source.largest_frame_bytes(), 0);
    assert!(is_idle(&mut *source));
    let said = source.take_news().expect("that it waits");
    assert!(said.contains("no picture is there yet"), "{said}");
    fs::write(folder.path().join("broken.png"), "broken").unwrap();
    put(&folder, "1.png", 1);
    assert_eq!(greys(&mut *source, 1), [(2, 1)]);
    assert_eq!(source.largest_frame_bytes(), 20);
    let large = GrayImage::from_pixel(7, 7, Luma([7]));
    large.save(folder.path().join("large.png")).unwrap();
    put(&folder, "2.png", 2);
    assert_eq!(greys(&mut *source, 1), [(4, 2)]);
    let said = warnings(&mut *source);
    assert!(
        said[0].contains("lost frame 1") && said[0].contains("broken.png"),
        "{said:?}"
    );
    assert!(
        said[1].contains("lost frame 3") && said[1].contains("7×7"),
        "{said:?}"
    );
}

#[test]
fn a_picture_that_is_written_under_another_name_first_is_shown_once() {
    let folder = folder();
    put(&folder, "1.png", 1);
    let mut source = follow(&folder);
    greys(&mut *source, 1);
    // Renamed before it is read, and after.
    for (grey, is_looked_at) in [(2, false), (3, true)] {
        let (first, last) = ("writing.png", format!("{grey}.png"));
        fs::write(folder.path().join(first), picture(grey)).unwrap();
        if is_looked_at {
            assert_eq!(next(&mut *source).1, grey);
        }
        fs::rename(folder.path().join(first), folder.path().join(last)).unwrap();
        if !is_looked_at {
            assert_eq!(next(&mut *source).1, grey);
        }
        assert!(is_idle(&mut *source));
    }
    assert_eq!(warnings(&mut *source), [""; 0]);
}

#[test]
fn a_picture_that_is_written_over_again_and_again_is_shown_each_time() {
    let folder = folder();
    let path = folder.path().join("latest.png");
    fs::write(&path, picture(1)).unwrap();
    let mut source = follow(&folder);
    for grey in 1..=4 {
        assert_eq!(next(&mut *source).1, grey);
        fs::write(&path, picture(grey + 1)).unwrap();
    }
}

#[test]
fn a_folder_that_is_removed_is_said_and_followed_again_when_it_is_back() {
    let around = folder();
    let path = around.path().join("pictures");
    fs::create_dir(&path).unwrap();
    fs::write(path.join("1.png"), picture(1)).unwrap();
    let mut source = open(&Source::Followed(options(&path))).unwrap();
    assert_eq!(greys(&mut *source, 1), [(1, 1)]);
    fs::remove_dir_all(&path).unwrap();
    assert!(is_idle(&mut *source));
    let said = warnings(&mut *source);
    assert!(said[0].contains("pictures is gone"), "{said:?}");
    assert!(is_idle(&mut *source));
    fs::create_dir(&path).unwrap();
    assert!(is_idle(&mut *source));
    assert!(
        source
            .take_news()
            .expect("it is said")
            .contains("there again")
    );
    fs::write(path.join("2.png"), picture(2)).unwrap();
    assert_eq!(greys(&mut *source, 1), [(2, 2)]);
    // A folder that was moved away counts as gone, and files written to it there do not count.
    fs::rename(&path, around.path().join("old")).unwrap();
    fs::write(around.path().join("old/3.png"), picture(3)).unwrap();
    assert!(is_idle(&mut *source));
    assert_eq!(warnings(&mut *source).len(), 1);
}

#[test]
fn a_pace_holds_back_what_comes_faster_and_every_leaves_out() {
    let folder = folder();
    for number in 1..=7 {
        put(&folder, &format!("{number}.png"), number);
    }
    let mut source = open(&Source::Followed(FollowOptions {
        fps: Some(500.0),
        every: NonZeroU64::new(3).unwrap(),
        ..options(folder.path())
    }))
    .unwrap();
    let frames: Vec<_> = (0..3).map(|_| next(&mut *source)).collect();
    let numbers: Vec<_> = frames
        .iter()
        .map(|(frame, grey)| (frame.sequence, *grey))
        .collect();
    assert_eq!(numbers, [(1, 1), (2, 4), (3, 7)]);
    let exposed_ns: Vec<_> = frames
        .iter()
        .map(|(frame, _)| frame.exposed_ns.unwrap())
        .collect();
    assert!(
        exposed_ns
            .windows(2)
            .all(|pair| pair[1] - pair[0] >= 2_000_000)
    );
}

#[test]
fn what_is_no_folder_is_not_followed() {
    let folder = folder();
    let file = folder.path().join("1.png");
    fs::write(&file, picture(1)).unwrap();
    let refusal = |path: &Path| -> String {
        let opened: Opened = open(&Source::Followed(options(path)));
        opened.err().expect("it is refused").to_string()
    };
    assert!(refusal(&file).contains("only a folder can be followed"));
    assert!(refusal(&folder.path().join("nowhere")).contains("No such file"));
}
