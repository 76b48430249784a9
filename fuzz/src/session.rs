//! One extractor and a few frames, with events between them, and the invariants that must hold
//! after each.

use std::time::Duration;

use crate::picture::{Picture, Pixels};
use arbitrary::Arbitrary;
use lariat_extract::{
    CrossingSequence, Extractor, HsvRange, Image, Mask, Options, Scene, mask_of, pick,
};

/// Maximum number of frames. More frames reveal little more, and slow the fuzzer down.
const MOST_FRAMES: usize = 5;
/// Maximum number of points, as many as a user clicks.
const MOST_POINTS: usize = 3;

/// Number of frames after which stationary ropes are followed.
const UNTIL_FOLLOWED: usize = 4;

/// Session that a fuzzer's bytes describe.
#[derive(Arbitrary, Debug)]
pub struct Session {
    mask: Kind,
    points: u8,
    ropes: u8,
    start: Option<[f32; 2]>,
    keep_lost_frames: u8,
    frames: Vec<Frame>,
    /// Claim about bytes that may be too few.
    claim: Claim,
}

#[derive(Arbitrary, Debug)]
enum Kind {
    Auto,
    Hsv(Vec<Range>),
    External,
}

#[derive(Arbitrary, Debug)]
struct Range {
    hue: [u8; 2],
    saturation: [u8; 2],
    value: [u8; 2],
}

#[derive(Arbitrary, Debug)]
enum Frame {
    Image(Picture),
    /// The last image again: a stationary rope.
    Again,
    /// The last image until its clear ropes are followed, and then moved by this many columns and
    /// rows.
    Moved([i8; 2]),
    /// An image with an external mask, of its size or of the mask's own.
    Masked {
        picture: Picture,
        mask: Picture,
        is_of_its_size: bool,
    },
    Reset,
    Prepare([u8; 2]),
    /// Picks the ropes' colors, at points or automatically.
    Pick(Picture, Vec<[f32; 2]>),
}

#[derive(Arbitrary, Debug)]
struct Claim {
    bytes: Vec<u8>,
    size: [u16; 2],
    stride: u16,
}

impl Session {
    /// Runs the session.
    ///
    /// # Panics
    /// Panics if an invariant does not hold, which the fuzzer looks for.
    pub fn run(&self) {
        self.claim.check();
        // Invalid options must be refused with an error, without a panic; nothing else is left to
        // check.
        let Ok(mut extractor) = Extractor::new(self.options()) else {
            return;
        };
        let mut last: Option<Pixels> = None;
        for frame in self.frames.iter().take(MOST_FRAMES) {
            match frame {
                Frame::Reset => extractor.reset(),
                Frame::Prepare([width, height]) => {
                    extractor.prepare(usize::from(*width), usize::from(*height));
                }
                Frame::Again => {
                    if let Some(pixels) = &last {
                        self.check(&extractor.extract(&image(pixels)), pixels);
                    }
                }
                Frame::Moved([bytes, rows]) => {
                    let Some(pixels) = &mut last else { continue };
                    for _ in 0..UNTIL_FOLLOWED {
                        self.check(&extractor.extract(&image(pixels)), pixels);
                    }
                    let by = i32::from(*bytes) + i32::from(*rows) * pixels.stride as i32;
                    let count = pixels.bytes.len();
                    pixels
                        .bytes
                        .rotate_left(by.unsigned_abs() as usize % count.max(1));
                    self.check(&extractor.extract(&image(pixels)), pixels);
                }
                Frame::Image(picture) => {
                    let pixels = last.insert(picture.pixels());
                    self.check(&extractor.extract(&image(pixels)), pixels);
                }
                Frame::Masked {
                    picture,
                    mask,
                    is_of_its_size,
                } => {
                    let pixels = last.insert(picture.pixels());
                    let mask = match is_of_its_size {
                        true => mask.mask_of_size(pixels.width, pixels.height),
                        false => mask.pixels(),
                    };
                    if let Ok(scene) = extractor.extract_masked(&image(pixels), &image(&mask)) {
                        self.check(&scene, pixels);
                    }
                }
                Frame::Pick(picture, at) => picked(&picture.pixels(), &at[..at.len().min(MOST_POINTS)]),
            }
        }
    }

    fn options(&self) -> Options {
        let unit = |bounds: [u8; 2]| bounds.map(|b| f32::from(b) / 255.0);
        Options::default().mask(match &self.mask {
                Kind::Auto => Mask::Auto,
                Kind::External => Mask::External,
                Kind::Hsv(ranges) => Mask::Hsv(
                    (ranges.iter().take(8))
                        .map(|range| HsvRange {
                            hue_deg: unit(range.hue).map(|h| 360.0 * h),
                            saturation: unit(range.saturation),
                            value: unit(range.value),
                        })
                        .collect(),
                ),
            }).points(self.points.into()).ropes(self.ropes.into()).start(self.start).keep_lost(Duration::from_millis(33 * u64::from(self.keep_lost_frames)))
    }

    /// Checks the invariants of every scene, whatever the image.
    fn check(&self, scene: &Scene, pixels: &Pixels) {
        let (right, bottom) = (pixels.width as f32 - 1.0, pixels.height as f32 - 1.0);
        assert!(scene.crossings.len() <= 32);
        // Only the automatic mask has notices.
        assert!(scene.notice.is_none() || matches!(self.mask, Kind::Auto));
        for (index, curve) in scene.curves.iter().enumerate() {
            let points = usize::from(self.points);
            assert_eq!(
                (curve.points.len(), curve.widths_px.len()),
                (points, points)
            );
            for &[x, y] in &curve.points {
                assert!(
                    (0.0..=right).contains(&x) && (0.0..=bottom).contains(&y),
                    "{x} {y}"
                );
            }
            assert!(
                curve
                    .widths_px
                    .iter()
                    .all(|width| width.is_finite() && *width >= 0.0)
            );
            assert!(curve.length_px.is_finite() && curve.width_px.is_finite());
            let sequence = CrossingSequence::of(scene, index);
            let _ = (sequence.to_string(), sequence.pulls_straight());
        }
        for crossing in scene.crossings {
            assert!(crossing.over < scene.curves.len() && crossing.under < scene.curves.len());
            let shares = [crossing.over_rho, crossing.under_rho, crossing.confidence];
            assert!(
                shares.iter().all(|share| (0.0..=1.0).contains(share)),
                "{shares:?}"
            );
        }
    }
}

impl Claim {
    /// Checks that bytes that are not an image of that size are refused, and that no others are.
    fn check(&self) {
        use lariat_extract::PixelFormat::{
            BayerBggr8, BayerGbrg8, BayerGrbg8, BayerRggb8, Bgr8, Bgra8, Gray8, Gray16, Nv12, Rgb8, Uyvy, Yuyv,
        };
        let [width, height] = self.size.map(usize::from);
        for format in [
            Gray8, Rgb8, Bgr8, Yuyv, Uyvy, Nv12, Bgra8, Gray16, BayerRggb8, BayerBggr8, BayerGrbg8, BayerGbrg8,
        ] {
            if let Ok(image) = Image::new(&self.bytes, width, height, self.stride.into(), format) {
                mask_of(&image, &Mask::Auto);
            }
        }
    }
}

fn image(pixels: &Pixels) -> Image<'_> {
    Image::new(
        &pixels.bytes,
        pixels.width,
        pixels.height,
        pixels.stride,
        pixels.format,
    )
    .expect("the bytes are made for the size")
}

/// Checks that the options accept ranges that were picked.
fn picked(pixels: &Pixels, at: &[[f32; 2]]) {
    let image = image(pixels);
    let Ok(picked) = pick(&image, at) else { return };
    assert!(
        (0.0..=1.0).contains(&picked.agreement),
        "{}",
        picked.agreement
    );
    let options = Options::default().mask(Mask::Hsv(picked.ranges));
    let mut extractor = Extractor::new(options).expect("the ranges that are picked are valid");
    extractor.extract(&image);
}
