//! A rendered frame allocates nothing after the first: neither drawing, nor writing, nor the truth.
//! For a camera's JPEG, the decoder makes a few allocations, for rows and not for images, and frees
//! them.

use crate::jpeg::{Coding, encode};
use lariat_capture::{Mjpeg, RenderOptions, Source, open};
use lariat_message::Centerlines;
use lariat_test_support::{allocations, bytes, held_bytes};

#[test]
fn a_rendered_frame_allocates_nothing_once_warm() {
    let mut source = open(&Source::Rendered(RenderOptions::default())).unwrap();
    let mut pixels = vec![0; source.largest_frame_bytes()];
    let mut truth = Box::new(Centerlines::EMPTY);
    let mut rendering = || {
        let before = allocations();
        for _ in 0..300 {
            source.next().unwrap();
            source.write(&mut pixels);
            source.truth(&mut truth);
            source.take_warning();
        }
        allocations() - before
    };
    assert_eq!(rendering(), 0);
}

#[test]
fn a_cameras_jpeg_costs_its_decoders_rows_and_no_more() {
    let size = [640, 480];
    let rgb: Vec<u8> = (0..size[0] * size[1] * 3).map(|i| (i / 40) as u8).collect();
    let frame = encode(&rgb, size, &Coding::CAMERA).jpeg;
    let mut decoder = Mjpeg::new(640, 480);
    let mut pixels = vec![0; decoder.largest_frame_bytes()];
    let mut cost = |frames: i64| {
        let before = [allocations() as i64, bytes() as i64, held_bytes()];
        for _ in 0..frames {
            decoder.decode(&frame, &mut pixels).unwrap();
        }
        let after = [allocations() as i64, bytes() as i64, held_bytes()];
        [0, 1, 2].map(|k| after[k] - before[k])
    };
    let [allocations, bytes, held] = cost(1);
    assert_eq!(cost(50), [50 * allocations, 50 * bytes, 0]);
    assert_eq!(held, 0);
    assert!(allocations <= 20, "{allocations}");
    // The image takes 921,600 bytes.
    assert!(bytes <= 80_000, "{bytes}");
}
