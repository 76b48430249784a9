//! Cost of decoding a camera's JPEG frame.
//!
//! Run it with `cargo bench --manifest-path bench/Cargo.toml --bench mjpeg`.
//!
//! The decoder is compared with zune-jpeg, for several sets of output channels, and with `image`.
//! Frames show the rendered rope with chroma at half the width and no Huffman tables, as most
//! cameras send them. The other decoders get the same frames with tables.
#![allow(missing_docs)] // criterion's macros generate undocumented functions.

#[path = "../crates/capture/tests/jpeg/mod.rs"]
mod jpeg;

use criterion::{Criterion, criterion_group, criterion_main};
use jpeg::{Coding, encode};
use lariat_capture::{Mjpeg, RenderOptions, Source, open};
use std::hint::black_box;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// Renders a frame of the rope, RGB.
fn rope(width: u32, height: u32) -> Vec<u8> {
    let options = RenderOptions {
        width,
        height,
        ..RenderOptions::default()
    };
    let mut source = open(&Source::Rendered(options)).expect("a rope of this size");
    let frame = source.next().expect("drawn").expect("there is no end");
    let mut pixels = vec![0; frame.bytes()];
    source.write(&mut pixels);
    pixels
}

fn frames(criterion: &mut Criterion) {
    for (width, height) in [(640u32, 480u32), (1280, 720)] {
        let (rgb, size) = (rope(width, height), [width as usize, height as usize]);
        let coded = |tables| {
            let coding = Coding {
                tables,
                // Gives a frame size similar to that of other encoders at a quality of 85 to 90.
                step: 1,
                ..Coding::CAMERA
            };
            encode(&rgb, size, &coding).jpeg
        };
        let (bare, whole) = (coded(false), coded(true));
        let mut decoder = Mjpeg::new(width, height);
        let mut into = vec![0; decoder.largest_frame_bytes()];
        let name = format!("{width}×{height}, {} kB", bare.len() / 1000);
        let mut group = criterion.benchmark_group(name);
        group.bench_function("lariat", |bencher| {
            bencher.iter(|| decoder.decode(black_box(&bare), &mut into));
        });
        for (name, color) in [
            ("zune-jpeg, RGB", ColorSpace::RGB),
            ("zune-jpeg, Y U V", ColorSpace::YCbCr),
            ("zune-jpeg, Y alone", ColorSpace::Luma),
        ] {
            let options = DecoderOptions::default().jpeg_set_out_colorspace(color);
            group.bench_function(name, |bencher| {
                bencher.iter(|| {
                    let frame = ZCursor::new(black_box(&whole[..]));
                    JpegDecoder::new_with_options(frame, options)
                        .decode_into(&mut into)
                        .is_ok()
                });
            });
        }
        group.bench_function("image", |bencher| {
            bencher.iter(|| {
                image::load_from_memory_with_format(black_box(&whole), image::ImageFormat::Jpeg)
                    .is_ok()
            });
        });
        group.bench_function("a copy of as many bytes", |bencher| {
            bencher.iter(|| into.copy_from_slice(black_box(&rgb)));
        });
        group.finish();
    }
}

criterion_group!(benches, frames);
criterion_main!(benches);
