//! A camera's MJPG frames decode to what was encoded. Everything else is refused, and nothing is
//! written past the memory.

use crate::jpeg;

use std::sync::LazyLock;

use jpeg::{Coding, Encoded, by_image, encode, without_tables};
use lariat_capture::{Mjpeg, MjpegError, RenderOptions, Source, open};
use lariat_message::PixelFormat;
use proptest::prelude::*;

/// Bytes after the lent memory, which must stay unchanged.
const GUARD: [u8; 64] = [0xA5; 64];

/// A frame of the rendered rope, as RGB.
fn rope(width: u32, height: u32) -> Vec<u8> {
    let options = RenderOptions {
        width,
        height,
        // The widest that fits such an image.
        rope_px: f64::from(width.min(height)) / 20.0,
        ..RenderOptions::default()
    };
    let mut source = open(&Source::Rendered(options)).expect("a rope of this size");
    let frame = source.next().expect("drawn").expect("there is no end");
    let mut pixels = vec![0; frame.bytes()];
    source.write(&mut pixels);
    pixels
}

/// Waves of color, of any size.
fn waves([width, height]: [usize; 2]) -> Vec<u8> {
    let pixel = |x: f64, y: f64| {
        [(0.11, 0.03), (-0.05, 0.09), (0.04, -0.13)]
            .map(|(a, b)| (128.0 + 100.0 * (a * x + b * y).sin()) as u8)
    };
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x as f64, y as f64)));
    pixels.flat_map(|(x, y)| pixel(x, y)).collect()
}

fn decode(jpeg: &[u8], size: [usize; 2]) -> Result<(PixelFormat, Vec<u8>), MjpegError> {
    let mut decoder = Mjpeg::new(size[0] as u32, size[1] as u32);
    let mut into = vec![0; decoder.largest_frame_bytes()];
    into.extend(GUARD);
    let decoded = decoder.decode(jpeg, &mut into);
    assert!(into.ends_with(&GUARD), "more was written than was lent");
    let format = decoded?;
    assert_eq!(decoder.format(jpeg), Ok(format));
    into.truncate(format.row_bytes(size[0] as u32) * size[1]);
    Ok((format, into))
}

/// The largest and the mean difference between two pictures, in levels.
fn apart(a: &[u8], b: &[u8]) -> (u8, f64) {
    assert_eq!(a.len(), b.len());
    let differences = || a.iter().zip(b).map(|(a, b)| a.abs_diff(*b));
    let sum: u64 = differences().map(u64::from).sum();
    (
        differences().max().unwrap_or(0),
        sum as f64 / a.len() as f64,
    )
}

/// Samplings that cameras use: 4:4:4, 4:2:2, 4:2:0, 4:4:0, 4:1:1, and 4:2:2 with other factors.
const FACTORS: [[[usize; 2]; 2]; 6] = [
    [[1, 1], [1, 1]],
    [[2, 1], [1, 1]],
    [[2, 2], [1, 1]],
    [[1, 2], [1, 1]],
    [[4, 1], [1, 1]],
    [[2, 2], [1, 2]],
];

/// Maximum error of a decoder with this color sampling, in levels. Each sample may be off by one
/// (ITU-T T.83). U is off by half a level more for each axis along which it is interpolated,
/// because that is rounded separately. U is weighted by 1.772 in blue. Both pictures are rounded at
/// the end.
fn levels(factors: [[usize; 2]; 2]) -> u8 {
    let between = |axis: &usize| factors[0][*axis] == 2 * factors[1][*axis];
    let axes = [0, 1].iter().filter(|axis| between(axis)).count();
    (1.0 + 1.772 * (1.0 + 0.5 * axes as f64) + 0.5 + 0.5) as u8
}

fn with(factors: [[usize; 2]; 2]) -> Coding {
    Coding {
        factors,
        ..Coding::CAMERA
    }
}

#[test]
fn a_frame_comes_out_as_it_was_encoded_however_its_colour_is_sampled() {
    let (rgb, size) = (rope(320, 240), [320, 240]);
    for factors in FACTORS {
        let Encoded { jpeg, pixels, .. } = encode(&rgb, size, &with(factors));
        let (format, found) = decode(&jpeg, size).expect("a whole frame");
        assert_eq!(format, PixelFormat::Rgb8);
        let (most, mean) = apart(&found, &pixels);
        assert!(
            most <= levels(factors) && mean < 0.1,
            "{factors:?}: {most} {mean}"
        );
    }
}

#[test]
fn an_image_whose_last_bit_ends_a_byte_is_whole() {
    let size = [81, 21];
    let coding = Coding {
        restart: 2,
        step: 0,
        ..with([[1, 2], [1, 1]])
    };
    let Encoded { jpeg, .. } = encode(&waves(size), size, &coding);
    decode(&jpeg, size).expect("a whole frame");
}

#[test]
fn a_frame_without_colour_is_gray() {
    let (rgb, size) = (rope(200, 120), [200, 120]);
    let coding = Coding {
        gray: true,
        ..Coding::CAMERA
    };
    let Encoded {
        mut jpeg, pixels, ..
    } = encode(&rgb, size, &coding);
    let start = jpeg.windows(2).position(|pair| pair == [0xFF, 0xC0]);
    // The sampling factors of a single channel are meaningless, and some cameras write any.
    let factors = start.expect("the frame has a size") + 11;
    assert_eq!(jpeg[factors], 0x11);
    for said in [0x11, 0x21, 0x22] {
        jpeg[factors] = said;
        let (format, found) = decode(&jpeg, size).expect("a whole frame");
        assert_eq!(format, PixelFormat::Gray8);
        let (most, _) = apart(&found, &pixels);
        assert!(most <= 1, "{said:x}: {most}");
    }
}

#[test]
fn the_usual_tables_are_put_in_where_the_camera_leaves_them_out() {
    for (size, quality) in [([640, 480], 90), ([333, 77], 50)] {
        let rgb = rope(size[0] as u32, size[1] as u32);
        let gray: Vec<u8> = rgb.iter().copied().step_by(3).collect();
        for (pixels, is_gray) in [(&rgb, false), (&gray, true)] {
            let whole = by_image(pixels, size, is_gray, quality);
            let bare = without_tables(&whole);
            assert!(bare.len() < whole.len());
            let expected = image::load_from_memory(&whole)
                .expect("a JPEG")
                .into_bytes();
            for jpeg in [&whole, &bare] {
                let (_, found) = decode(jpeg, size).expect("a whole frame");
                assert!(apart(&found, &expected).0 <= 2);
            }
        }
    }
}

#[test]
fn restart_markers_are_followed() {
    let (rgb, size) = (rope(320, 240), [320, 240]);
    for (restart, tables) in [(1, false), (20, true), (33, false)] {
        let coding = Coding {
            restart,
            tables,
            ..Coding::CAMERA
        };
        let Encoded { jpeg, pixels, .. } = encode(&rgb, size, &coding);
        let (_, found) = decode(&jpeg, size).expect("a whole frame");
        let most = apart(&found, &pixels).0;
        assert!(most <= levels(Coding::CAMERA.factors), "{restart}");
    }
}

/// A frame of the rope as a camera sends it, and the decoded pixels.
static CAMERA: LazyLock<(Encoded, Vec<u8>)> = LazyLock::new(|| {
    let encoded = encode(&rope(160, 96), [160, 96], &Coding::CAMERA);
    let (_, pixels) = decode(&encoded.jpeg, [160, 96]).expect("a whole frame");
    (encoded, pixels)
});

#[test]
fn what_stands_behind_the_end_is_nothing_to_the_image() {
    let (Encoded { jpeg, .. }, pixels) = &*CAMERA;
    let bare = &jpeg[..jpeg.len() - 2];
    let stale = [&jpeg[jpeg.len() / 2..], &[0, 7, 0xFF]].concat();
    for (name, frame) in [
        ("no end marker", bare.to_vec()),
        ("zeros", [jpeg, &[0; 4000][..]].concat()),
        ("fill bytes", [jpeg, &[0xFF; 4000][..]].concat()),
        (
            "fill bytes before the end",
            [bare, &[0xFF; 9], &[0xD9]].concat(),
        ),
        ("the end of a frame before", [jpeg, &stale[..]].concat()),
        ("another frame", [&jpeg[..], &jpeg[..]].concat()),
    ] {
        let (_, found) = decode(&frame, [160, 96]).expect(name);
        assert!(found == *pixels, "{name}");
    }
}

/// The part of a picture of this width that is above the last row of units, and above the rows
/// interpolated with it.
fn above_the_last_row(pixels: &[u8]) -> &[u8] {
    &pixels[..3 * 160 * (96 - 8 - 1)]
}

#[test]
fn a_frame_that_is_cut_off_is_refused() {
    let (Encoded { jpeg, .. }, pixels) = &*CAMERA;
    assert_eq!(decode(&[], [160, 96]), Err(MjpegError::Empty));
    let mut passed = 0;
    for length in 1..jpeg.len() {
        // Once as the bus leaves it, and once with the end marker that some cameras always send.
        let cut = &jpeg[..length];
        let ended = [cut, &[0xFF, 0xD9]].concat();
        for frame in [cut, &ended] {
            match decode(frame, [160, 96]) {
                Ok((_, found)) => {
                    passed += 1;
                    assert!(
                        above_the_last_row(&found) == above_the_last_row(pixels),
                        "{length}"
                    );
                }
                Err(MjpegError::CutOff | MjpegError::Damaged { .. }) => {}
                Err(other) => panic!("{length}: {other:?}"),
            }
        }
    }
    // Only the last few bytes may be missing.
    assert!(passed <= 2 * 8, "{passed} of {}", 2 * jpeg.len());
}

#[test]
fn a_loss_in_the_middle_that_leaves_too_little_is_refused() {
    let (Encoded { jpeg, scan, .. }, _) = &*CAMERA;
    let lost = (jpeg.len() - scan) / 2;
    for from in (*scan..jpeg.len() - lost).step_by(7) {
        let frame = [&jpeg[..from], &jpeg[from + lost..]].concat();
        let found = decode(&frame, [160, 96]);
        assert!(found.is_err(), "half of the image is lost from {from} on");
    }
}

#[test]
fn another_size_and_too_little_room_are_refused_with_what_was_agreed_on() {
    let (Encoded { jpeg, .. }, _) = &*CAMERA;
    let mut decoder = Mjpeg::new(320, 240);
    let mut into = vec![0; decoder.largest_frame_bytes()];
    let error = decoder.decode(jpeg, &mut into).unwrap_err().to_string();
    assert_eq!(
        error,
        "the frame is 160×96 pixels where 320×240 were agreed on: ask the camera for one of the sizes that it lists"
    );
    let mut decoder = Mjpeg::new(160, 96);
    let needed = decoder.largest_frame_bytes();
    let error = decoder.decode(jpeg, &mut into[..needed - 1]).unwrap_err();
    let given = needed - 1;
    assert_eq!(error, MjpegError::Room { needed, given });
    // The decoder continues with the next frame.
    assert_eq!(decoder.decode(jpeg, &mut into), Ok(PixelFormat::Rgb8));
}

#[test]
fn what_no_camera_sends_is_refused_by_name() {
    let (Encoded { jpeg, .. }, _) = &*CAMERA;
    let at = |marker: u8| {
        let place = jpeg.windows(2).position(|pair| pair == [0xFF, marker]);
        place.expect("the frame has one") + 1
    };
    let (frame, scan) = (at(0xC0), at(0xDA));
    for (place, byte, expected) in [
        (frame, 0xC2, "a progressive JPEG"),
        (frame, 0xC9, "arithmetic"),
        (frame + 3, 12, "more than 8 bits"),
        (frame + 8, 4, "three channels"),
        (scan + 3, 1, "one by one"),
    ] {
        let mut jpeg = jpeg.clone();
        jpeg[place] = byte;
        let error = decode(&jpeg, [160, 96]).unwrap_err();
        assert!(matches!(error, MjpegError::Unsupported { .. }), "{error}");
        assert!(error.to_string().contains(expected), "{error}");
    }
    let error = decode(b"RIFF, and more of it", [160, 96]).unwrap_err();
    let expected = "the frame is damaged (it does not begin as a JPEG does): if most are, ask the camera for another pixel format";
    assert_eq!(error.to_string(), expected);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, ..ProptestConfig::default() })]

    #[test]
    fn frames_of_any_size_come_out_as_they_were_encoded(
        width in 1usize..100, height in 1usize..60, factors in prop::sample::select(&FACTORS[..]),
        gray: bool, restart in 0usize..5, step in 0u8..9,
    ) {
        let size = [width, height];
        let coding = Coding { factors, gray, restart, step, tables: step % 2 == 0 };
        let Encoded { jpeg, pixels, .. } = encode(&waves(size), size, &coding);
        let (_, found) = decode(&jpeg, size).expect("a whole frame");
        let (most, mean) = apart(&found, &pixels);
        prop_assert!(most <= levels(factors), "{} {}", most, mean);
    }

    #[test]
    fn damaged_frames_are_decoded_or_refused(
        flips in prop::collection::vec((any::<prop::sample::Index>(), 0u8..8), 0..12),
        cut in prop::option::of(any::<prop::sample::Index>()),
        factors in prop::sample::select(&FACTORS[..]), restart in 0usize..3,
    ) {
        let size = [75, 43];
        let mut jpeg = encode(&waves(size), size, &Coding { restart, ..with(factors) }).jpeg;
        for (at, bit) in flips {
            let at = at.index(jpeg.len());
            jpeg[at] ^= 1 << bit;
        }
        if let Some(cut) = cut {
            jpeg.truncate(cut.index(jpeg.len()));
        }
        // Any result is allowed. `decode` checks that nothing was written past the end.
        if let Err(error) = decode(&jpeg, size) {
            prop_assert!(error.to_string().starts_with("the frame"));
        }
    }

    #[test]
    fn any_bytes_are_refused(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        prop_assert!(decode(&bytes, [16, 16]).is_err());
        let begun = [&[0xFF, 0xD8, 0xFF], &bytes[..]].concat();
        prop_assert!(decode(&begun, [16, 16]).is_err());
    }
}
