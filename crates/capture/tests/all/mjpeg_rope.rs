//! A camera's JPEG compression hardly moves the rope's centerline. The frames here take half the
//! bytes of quality 90.

use crate::jpeg;

use jpeg::{Coding, encode};
use lariat_capture::{Mjpeg, RenderOptions, Source, open};
use lariat_extract::{Extractor, Image, Options, PixelFormat};

const SIZE: [usize; 2] = [640, 480];
const FRAMES: u64 = 10;

/// The frames of the rendered rope, as RGB.
fn frames() -> Vec<Vec<u8>> {
    let options = RenderOptions {
        frames: Some(FRAMES),
        frame_interval_s: 0.4,
        ..RenderOptions::default()
    };
    let mut source = open(&Source::Rendered(options)).expect("a rope of the usual size");
    std::iter::from_fn(|| {
        let frame = source.next().expect("drawn")?;
        let mut pixels = vec![0; frame.bytes()];
        source.write(&mut pixels);
        Some(pixels)
    })
    .collect()
}

/// Extracts the centerline of the only rope in an RGB picture.
fn centerline(rgb: &[u8]) -> Vec<[f32; 2]> {
    let [width, height] = SIZE;
    let image = Image::new(rgb, width, height, 3 * width, PixelFormat::Rgb8);
    let mut extractor = Extractor::new(Options::default()).expect("valid options");
    let scene = extractor.extract(&image.expect("a whole image"));
    assert_eq!(scene.curves.len(), 1);
    scene.curves[0].points.clone()
}

/// RMS distance between points of the same number, in the direction that fits better.
fn rms_px(a: &[[f32; 2]], b: &[[f32; 2]]) -> f64 {
    let sum = |pairs: &mut dyn Iterator<Item = (&[f32; 2], &[f32; 2])>| -> f64 {
        pairs
            .map(|(p, q)| f64::from(p[0] - q[0]).powi(2) + f64::from(p[1] - q[1]).powi(2))
            .sum()
    };
    let along = sum(&mut a.iter().zip(b));
    let against = sum(&mut a.iter().zip(b.iter().rev()));
    (along.min(against) / a.len() as f64).sqrt()
}

#[test]
fn the_centerline_of_a_compressed_frame_is_that_of_the_frame() {
    let mut decoder = Mjpeg::new(SIZE[0] as u32, SIZE[1] as u32);
    let mut pixels = vec![0; decoder.largest_frame_bytes()];
    let frames = frames();
    let expected: Vec<_> = frames.iter().map(|rgb| centerline(rgb)).collect();
    for factors in [[[1, 1], [1, 1]], [[2, 1], [1, 1]], [[2, 2], [1, 1]]] {
        let coding = Coding {
            factors,
            ..Coding::CAMERA
        };
        let mut sum = 0.0;
        for (rgb, expected) in frames.iter().zip(&expected) {
            let jpeg = encode(rgb, SIZE, &coding).jpeg;
            decoder.decode(&jpeg, &mut pixels).expect("a whole frame");
            let off = rms_px(&centerline(&pixels), expected);
            assert!(off < 0.2, "{factors:?}: {off}");
            sum += off;
        }
        assert!(sum / (FRAMES as f64) < 0.1, "{factors:?}: {sum}");
    }
}
