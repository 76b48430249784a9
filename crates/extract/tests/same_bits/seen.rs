//! Hashes of extractions: films in all pixel formats, cold and followed; the clusterings; a picture
//! of each class.

use lariat_drawn::moving::{Film, Story};
use lariat_drawn::scenes::{self, Class, Still};
use lariat_extract::{
    Extractor, HsvRange, Image, Mask, Method, Options, PixelFormat, Scene, mask_of, pick,
};

use super::Told;
use super::drawing::formats::formats;
use super::hash::Hash;

const SIZE: [usize; 2] = [360, 270];

/// A frame in one of the formats.
struct Frame {
    bytes: Vec<u8>,
    stride: usize,
    format: PixelFormat,
    /// A true mask, for a film on clutter.
    mask: Option<Vec<u8>>,
}

impl Frame {
    fn of(rgb: &[u8], format: PixelFormat) -> Self {
        let all = formats(rgb, SIZE[0], SIZE[1]).into_iter();
        let found = { all }.find(|(other, ..)| *other == format);
        let (format, bytes, stride) = found.expect("a picture in every format");
        Self {
            bytes,
            stride,
            format,
            mask: None,
        }
    }

    /// Shows it to an extractor. If there is a mask, the ropes are followed where possible.
    fn show(&self, extractor: &mut Extractor) {
        let (image, [width, height]) = (self.image(), SIZE);
        let Some(mask) = &self.mask else {
            extractor.extract(&image);
            return;
        };
        if extractor.follow(&image).is_none() {
            let mask = Image::new(mask, width, height, width, PixelFormat::Gray8);
            let mask = mask.expect("a byte a pixel");
            extractor.extract_masked(&image, &mask).expect("its size");
        }
    }

    fn image(&self) -> Image<'_> {
        let [width, height] = SIZE;
        Image::new(&self.bytes, width, height, self.stride, self.format).expect("a whole image")
    }
}

fn blue() -> Mask {
    Mask::Hsv(vec![HsvRange {
        hue_deg: [200.0, 250.0],
        saturation: [0.3, 1.0],
        value: [0.1, 1.0],
    }])
}

fn tell(told: &mut Told, case: &str, scene: &Scene) {
    let mut hash = Hash::new();
    for curve in scene.curves {
        hash = hash
            .floats(curve.points.as_flattened())
            .floats(&curve.widths_px)
            .floats(&[curve.width_px, curve.length_px])
            .bytes(&curve.track.to_le_bytes())
            .bytes(
                &curve
                    .hidden
                    .iter()
                    .map(|&hidden| u8::from(hidden))
                    .collect::<Vec<_>>(),
            )
            .bytes(&[
                curve.status as u8,
                u8::from(curve.closed),
                u8::from(scene.followed),
            ]);
    }
    told.frame(case, "curves", hash);
    let mut hash = Hash::new();
    for crossing in scene.crossings {
        hash = hash
            .floats(&crossing.at)
            .floats(&[crossing.over_rho, crossing.under_rho, crossing.confidence])
            .bytes(&[crossing.over as u8, crossing.under as u8]);
    }
    told.frame(case, "crossings", hash);
}

/// All pictures, drawn once.
pub(crate) struct Pictures {
    films: Vec<(String, Mask, Vec<Frame>)>,
    /// Frames for the clusterings.
    short: Vec<Frame>,
    stills: Vec<(String, Still)>,
}

fn film(story: Story, seed: u64, format: PixelFormat, frames: usize) -> Vec<Frame> {
    let mut film = Film::new(story, seed, SIZE[0] as u32, SIZE[1] as u32);
    let mut rgb = Vec::new();
    (0..frames)
        .map(|_| {
            let truth = film.next(&mut rgb);
            let mut frame = Frame::of(&rgb, format);
            if story.is_cluttered() {
                film.mask(&truth, frame.mask.get_or_insert_default());
            }
            frame
        })
        .collect()
}

impl Pictures {
    /// Draws every story in its own format, for the automatic mask or for a range of colors, and a
    /// picture of each class.
    pub(crate) fn draw() -> Self {
        use PixelFormat::{BayerGrbg8, Bgr8, Gray8, Nv12, Rgb8, Uyvy, Yuyv};
        let films = [
            (Story::Writhing, Rgb8, Mask::Auto, 32),
            (Story::Two, Bgr8, Mask::Auto, 20),
            (Story::Vanishing, Gray8, Mask::Auto, 16),
            (Story::Gripper, Yuyv, Mask::Auto, 16),
            (Story::Visitor, Uyvy, Mask::Auto, 16),
            (Story::Cuts, Nv12, Mask::Auto, 16),
            (Story::BadFrames, Rgb8, Mask::Auto, 16),
            (Story::Writhing, Rgb8, blue(), 8),
            (Story::Two, Yuyv, blue(), 8),
            (Story::Two, Nv12, blue(), 8),
            (Story::Two, BayerGrbg8, Mask::Auto, 8),
            (Story::Leaving, Nv12, Mask::Auto, 16),
            (Story::Clutter, Rgb8, Mask::External, 32),
            (Story::Handheld, Yuyv, Mask::External, 16),
            (Story::Passing, Bgr8, Mask::External, 110),
        ];
        let stills = Class::ALL.map(|class| {
            let still = scenes::draw(class, 11, 640, 480);
            let still = still.expect("there is room in the picture");
            (format!("class {class}"), still)
        });
        Self {
            films: Vec::from(films.map(|(story, format, mask, frames)| {
                let how = match mask {
                    Mask::Auto => "auto",
                    Mask::External => "true masks",
                    _ => "hsv",
                };
                let case = format!("{} in {format:?} by {how}", story.name());
                (case, mask, film(story, 7, format, frames))
            })),
            short: film(Story::Two, 3, Rgb8, 3),
            stills: stills.into(),
        }
    }

    /// Extracts from all pictures and records the hashes.
    pub(crate) fn tell(&self, told: &mut Told) {
        for (case, mask, frames) in &self.films {
            let options = Options::default().mask(mask.clone());
            let mut extractor = Extractor::new(options).expect("valid options");
            for (number, frame) in (0..).zip(frames) {
                told.frame(case, "picture", Hash::new().bytes(&frame.bytes));
                let image = frame.image();
                if number % 8 == 0 && frame.mask.is_none() {
                    told.frame(case, "mask", Hash::new().bytes(&mask_of(&image, mask)));
                }
                frame.show(extractor.at(number * 33_000_000));
                tell(told, case, &extractor.scene());
            }
            if *mask == Mask::External {
                continue;
            }
            let first = frames[0].image();
            let mut extractor = Extractor::new(Options::default()).expect("valid options");
            let on_rope = extractor.extract(&first).curves[0].points[60];
            let picked = format!("{:?} {:?}", pick(&first, &[]), pick(&first, &[on_rope]));
            told.frame(case, "pick", Hash::new().bytes(picked.as_bytes()));
        }
        // The clusterings instead of the skeleton.
        for (name, method) in Method::ALL.into_iter().skip(1) {
            let options = Options::default().method(method);
            let mut extractor = Extractor::new(options).expect("valid options");
            for frame in &self.short {
                tell(told, name, &extractor.extract(&frame.image()));
            }
        }
        let mut extractor = Extractor::new(Options::default()).expect("valid options");
        for (case, still) in &self.stills {
            told.frame(case, "picture", Hash::new().bytes(&still.rgb));
            let image = Image::new(&still.rgb, 640, 480, 3 * 640, PixelFormat::Rgb8);
            extractor.reset();
            tell(
                told,
                case,
                &extractor.extract(&image.expect("a whole image")),
            );
        }
    }
}
