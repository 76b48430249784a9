//! Converts images from encodings that frames do not support to formats that they support.
//!
//! The encodings are those of `sensor_msgs/image_encodings` and a few that drivers use. Nothing
//! that extraction would use is lost. Alpha is dropped, 16 bits are rounded to 8 as in picture
//! files, and depths in meters become whole millimeters.

use lariat_message::PixelFormat;

use crate::ImageRecord;

/// Encodings of images that are read.
pub const ENCODINGS: [&str; 34] = [
    "mono8",
    "mono16",
    "rgb8",
    "bgr8",
    "rgba8",
    "bgra8",
    "rgb16",
    "bgr16",
    "rgba16",
    "bgra16",
    "8UC1",
    "8UC3",
    "8UC4",
    "16UC1",
    "16UC3",
    "32FC1",
    "yuv422",
    "yuv422_yuy2",
    "yuyv",
    "uyvy",
    "nv12",
    "nv21",
    "nv24",
    "i420",
    "yuv420",
    "yv12",
    "bayer_rggb8",
    "bayer_bggr8",
    "bayer_grbg8",
    "bayer_gbrg8",
    "bayer_rggb16",
    "bayer_bggr16",
    "bayer_grbg16",
    "bayer_gbrg16",
];

/// Layout of an image converted to a frame's format. The pixels are in the buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Converted {
    /// Pixel format.
    pub format: PixelFormat,
    /// Bytes from the start of one row to the next.
    pub stride: u32,
}

/// Storage of pixels.
#[derive(Debug, Clone, Copy)]
enum Stored {
    /// Bytes per pixel, and the positions of the bytes that are kept.
    Bytes(usize, &'static [usize]),
    /// 16-bit numbers per pixel, and the positions of the numbers that are kept.
    Words(usize, &'static [usize]),
    /// 16-bit gray in another machine's byte order.
    TurnedGray,
    /// Meters.
    Float,
    /// Luma, then planes or pairs of chroma.
    Chroma(Chroma),
}

/// Layout of chroma after luma.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Chroma {
    /// Pairs for 2×2 pixels, U first.
    Pairs,
    /// Pairs for 2×2 pixels, V first.
    TurnedPairs,
    /// Pairs for each pixel.
    FullPairs,
    /// A plane of U, then one of V, for 2×2 pixels.
    Planes,
    /// A plane of V, then one of U, for 2×2 pixels.
    TurnedPlanes,
}

fn stored(encoding: &str) -> Option<(Stored, PixelFormat)> {
    use PixelFormat::{Bgr8, Gray16, Nv12, Rgb8};
    use Stored::{Bytes, Chroma as C, Words};
    Some(match encoding {
        "rgba8" => (Bytes(4, &[0, 1, 2]), Rgb8),
        "rgb16" => (Words(3, &[0, 1, 2]), Rgb8),
        "bgr16" | "16UC3" => (Words(3, &[0, 1, 2]), Bgr8),
        "rgba16" => (Words(4, &[0, 1, 2]), Rgb8),
        "bgra16" | "16UC4" => (Words(4, &[0, 1, 2]), Bgr8),
        "bayer_rggb16" => (Words(1, &[0]), PixelFormat::BayerRggb8),
        "bayer_bggr16" => (Words(1, &[0]), PixelFormat::BayerBggr8),
        "bayer_grbg16" => (Words(1, &[0]), PixelFormat::BayerGrbg8),
        "bayer_gbrg16" => (Words(1, &[0]), PixelFormat::BayerGbrg8),
        "mono16" | "16UC1" => (Stored::TurnedGray, Gray16),
        "32FC1" => (Stored::Float, Gray16),
        "nv12" => (C(Chroma::Pairs), Nv12),
        "nv21" => (C(Chroma::TurnedPairs), Nv12),
        "nv24" => (C(Chroma::FullPairs), Nv12),
        "i420" | "I420" | "yuv420" | "yuv420p" => (C(Chroma::Planes), Nv12),
        "yv12" | "YV12" => (C(Chroma::TurnedPlanes), Nv12),
        _ => return None,
    })
}

/// Returns whether [`convert`] knows an encoding.
pub(crate) fn is_convertible(encoding: &str) -> bool {
    stored(encoding).is_some()
}

/// Converts an image into a buffer, replacing its contents. Returns `None` if the encoding is
/// unknown, or if the number of bytes does not match the size.
pub fn convert(image: &ImageRecord, into: &mut Vec<u8>) -> Option<Converted> {
    let (stored, format) = stored(image.encoding)?;
    let (width, height) = (image.width as usize, image.height as usize);
    if width == 0 || height == 0 {
        return None;
    }
    into.clear();
    let step = image.step as usize;
    let rows = |pixel_bytes: usize| {
        let row = width.checked_mul(pixel_bytes).filter(|row| *row <= step)?;
        let is_whole = step.checked_mul(height) == Some(image.data.len());
        is_whole.then(|| {
            image
                .data
                .chunks_exact(step)
                .map(move |padded| &padded[..row])
        })
    };
    let word = |bytes: [u8; 2]| match image.is_big_endian {
        true => u16::from_be_bytes(bytes),
        false => u16::from_le_bytes(bytes),
    };
    match stored {
        Stored::Bytes(count, kept) => {
            let pixels = rows(count)?.flat_map(|row| row.chunks_exact(count));
            into.extend(pixels.flat_map(|pixel| kept.iter().map(|&at| pixel[at])));
        }
        Stored::Words(count, kept) => {
            let pixels = rows(2 * count)?.flat_map(|row| row.chunks_exact(2 * count));
            let nearest = |word: u16| ((u32::from(word) + 128) / 257) as u8;
            into.extend(pixels.flat_map(|pixel| {
                let at = |at: usize| nearest(word([pixel[2 * at], pixel[2 * at + 1]]));
                kept.iter().map(move |&place| at(place))
            }));
        }
        Stored::TurnedGray => {
            let pixels = rows(2)?.flat_map(|row| row.as_chunks::<2>().0);
            into.extend(pixels.flat_map(|pixel| word(*pixel).to_ne_bytes()));
        }
        Stored::Float => {
            let pixels = rows(4)?.flat_map(|row| row.as_chunks::<4>().0);
            let metres = |bytes: [u8; 4]| match image.is_big_endian {
                true => f32::from_be_bytes(bytes),
                false => f32::from_le_bytes(bytes),
            };
            // NaN and values out of the range of 16 bits are not measured.
            let mm = |metres: f32| match (1000.0 * metres).round() {
                mm if (0.0..=65_535.0).contains(&mm) => mm as u16,
                _ => 0,
            };
            into.extend(pixels.flat_map(|pixel| mm(metres(*pixel)).to_ne_bytes()));
        }
        Stored::Chroma(chroma) => {
            let planes = Planes::of(image, chroma)?;
            planes.write_nv12([width, height], into);
            return Some(Converted {
                format,
                stride: width.next_multiple_of(2) as u32,
            });
        }
    }
    Some(Converted {
        format,
        stride: format.row_bytes(image.width) as u32,
    })
}

/// Luma and chroma of an image, each with its stride in bytes.
struct Planes<'a> {
    chroma: Chroma,
    luma: (&'a [u8], usize),
    /// Pairs, or U and then V.
    colors: [(&'a [u8], usize); 2],
}

impl<'a> Planes<'a> {
    /// Splits an image into planes. Writers disagree on the meaning of `step`. Either it is the
    /// stride of the luma, or it is meaningless and rows have no padding.
    fn of(image: &ImageRecord<'a>, chroma: Chroma) -> Option<Self> {
        let tight = Self::with_step(image, chroma, (image.width as usize).next_multiple_of(2));
        let odd = || Self::with_step(image, chroma, image.width as usize);
        Self::with_step(image, chroma, image.step as usize)
            .or(tight)
            .or_else(odd)
    }

    fn with_step(image: &ImageRecord<'a>, chroma: Chroma, step: usize) -> Option<Self> {
        let (width, height) = (image.width as usize, image.height as usize);
        if step < width {
            return None;
        }
        let (color_step, rows, planes) = match chroma {
            Chroma::Pairs | Chroma::TurnedPairs => {
                (step.next_multiple_of(2), height.div_ceil(2), 1)
            }
            Chroma::FullPairs => (2 * step, height, 1),
            Chroma::Planes | Chroma::TurnedPlanes => (step.div_ceil(2), height.div_ceil(2), 2),
        };
        let (luma, rest) = image.data.split_at_checked(step.checked_mul(height)?)?;
        let size = color_step.checked_mul(rows)?;
        if rest.len() != size.checked_mul(planes)? {
            return None;
        }
        let (first, second) = rest.split_at(size);
        let mut colors = [(first, color_step), (second, color_step)];
        if chroma == Chroma::TurnedPlanes {
            colors.swap(0, 1);
        }
        Some(Self {
            chroma,
            luma: (luma, step),
            colors,
        })
    }

    fn write_nv12(&self, [width, height]: [usize; 2], into: &mut Vec<u8>) {
        let stride = width.next_multiple_of(2);
        for row in self.luma.0.chunks_exact(self.luma.1) {
            into.extend_from_slice(&row[..width]);
            // Repeats the last column of an odd width.
            into.extend(row[..width].last().filter(|_| stride > width));
        }
        let at = |plane: usize, y: usize, x: usize| {
            let (bytes, step) = self.colors[plane];
            bytes[y * step + x]
        };
        for y in 0..height.div_ceil(2) {
            for x in 0..width.div_ceil(2) {
                let pair = match self.chroma {
                    Chroma::Pairs => [at(0, y, 2 * x), at(0, y, 2 * x + 1)],
                    Chroma::TurnedPairs => [at(0, y, 2 * x + 1), at(0, y, 2 * x)],
                    Chroma::Planes | Chroma::TurnedPlanes => [at(0, y, x), at(1, y, x)],
                    Chroma::FullPairs => [0, 1].map(|color| {
                        let [right, below] =
                            [(2 * x + 1).min(width - 1), (2 * y + 1).min(height - 1)];
                        let four = [
                            (2 * y, 2 * x),
                            (2 * y, right),
                            (below, 2 * x),
                            (below, right),
                        ];
                        let sum: u32 = four
                            .iter()
                            .map(|&(y, x)| u32::from(at(0, y, 2 * x + color)))
                            .sum();
                        ((sum + 2) / 4) as u8
                    }),
                };
                into.extend(pair);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image<'a>(
        encoding: &'a str,
        [width, height]: [u32; 2],
        step: u32,
        data: &'a [u8],
    ) -> ImageRecord<'a> {
        ImageRecord {
            stamp_ns: 0,
            frame_id: "",
            width,
            height,
            encoding,
            is_big_endian: false,
            step,
            data,
        }
    }

    fn converted(image: ImageRecord) -> (PixelFormat, u32, Vec<u8>) {
        let mut into = vec![9; 3];
        let Converted { format, stride } = convert(&image, &mut into).expect(image.encoding);
        let whole = format.image_bytes(stride, image.height);
        assert_eq!(into.len(), whole, "{}", image.encoding);
        (format, stride, into)
    }

    #[test]
    fn alpha_is_left_out_and_16_bits_become_8() {
        let pixels = [1, 2, 3, 255, 4, 5, 6, 0, 99];
        let right = (PixelFormat::Rgb8, 6, vec![1, 2, 3, 4, 5, 6]);
        assert_eq!(converted(image("rgba8", [2, 1], 9, &pixels)), right);
        let words: Vec<u8> = [65_535_u16, 257, 128, 127, 0, 514]
            .iter()
            .flat_map(|w| w.to_le_bytes())
            .collect();
        let bytes = vec![255, 1, 0, 0, 0, 2];
        assert_eq!(
            converted(image("rgb16", [2, 1], 12, &words)),
            (PixelFormat::Rgb8, 6, bytes.clone())
        );
        assert_eq!(
            converted(image("bgr16", [2, 1], 12, &words)),
            (PixelFormat::Bgr8, 6, bytes.clone())
        );
        let bayer = converted(image("bayer_grbg16", [6, 1], 12, &words));
        assert_eq!(bayer, (PixelFormat::BayerGrbg8, 6, bytes));
        let turned = ImageRecord {
            is_big_endian: true,
            ..image("rgb16", [1, 1], 6, &[1, 1, 0, 128, 255, 255])
        };
        assert_eq!(converted(turned).2, [1, 0, 255]);
    }

    #[test]
    fn metres_become_millimetres_and_what_is_not_measured_0() {
        let metres = [0.5_f32, 1.2344, f32::NAN, f32::INFINITY, -1.0, 70.0];
        let bytes: Vec<u8> = metres.iter().flat_map(|m| m.to_le_bytes()).collect();
        let (format, stride, pixels) = converted(image("32FC1", [3, 2], 12, &bytes));
        assert_eq!((format, stride), (PixelFormat::Gray16, 6));
        let mm: Vec<u16> = pixels
            .as_chunks::<2>()
            .0
            .iter()
            .map(|b| u16::from_ne_bytes(*b))
            .collect();
        assert_eq!(mm, [500, 1234, 0, 0, 0, 0]);
    }

    #[test]
    fn chroma_of_every_order_becomes_pairs() {
        let luma = [1, 2, 3, 4, 5, 6, 7, 8];
        let nv12 = vec![1, 2, 3, 4, 5, 6, 7, 8, 10, 20, 11, 21];
        let with = |chroma: &[u8]| [&luma[..], chroma].concat();
        for (encoding, chroma) in [
            ("nv12", &[10, 20, 11, 21][..]),
            ("nv21", &[20, 10, 21, 11]),
            ("i420", &[10, 11, 20, 21]),
            ("yuv420", &[10, 11, 20, 21]),
            ("yv12", &[20, 21, 10, 11]),
            (
                "nv24",
                &[
                    9, 20, 11, 20, 11, 21, 11, 21, 10, 20, 10, 20, 11, 21, 11, 21,
                ],
            ),
        ] {
            // A `step` that includes the chroma is ignored.
            for step in [4, 6, 12] {
                let data = with(chroma);
                let right = (PixelFormat::Nv12, 4, nv12.clone());
                assert_eq!(
                    converted(image(encoding, [4, 2], step, &data)),
                    right,
                    "{encoding} {step}"
                );
            }
        }
        // Rows with padding, and an odd last column.
        let padded = [1, 2, 3, 0, 4, 5, 6, 0, 20, 10, 21, 11];
        let right = (
            PixelFormat::Nv12,
            4,
            vec![1, 2, 3, 3, 4, 5, 6, 6, 10, 20, 11, 21],
        );
        assert_eq!(converted(image("nv21", [3, 2], 4, &padded)), right);
    }

    #[test]
    fn every_encoding_of_the_list_is_read() {
        for encoding in ENCODINGS {
            let is_frames = image(encoding, [2, 2], 2, &[]).format().is_some();
            assert!(is_frames || is_convertible(encoding), "{encoding}");
        }
    }

    #[test]
    fn bytes_that_are_too_few_or_too_many_are_refused() {
        let bytes = [0; 64];
        for (encoding, size, step, count) in [
            ("rgba8", [2, 2], 8, 15),
            ("rgba8", [2, 2], 7, 14),
            ("rgb16", [1, 1], 6, 7),
            ("nv21", [4, 2], 4, 11),
            ("nv24", [4, 2], 4, 12),
            ("i420", [4, 2], 4, 13),
            ("32FC1", [u32::MAX, u32::MAX], u32::MAX, 8),
            ("nv21", [u32::MAX, u32::MAX], u32::MAX, 8),
            ("rgba8", [0, 0], 0, 0),
            ("yuv444", [1, 1], 3, 3),
        ] {
            let image = image(encoding, size, step, &bytes[..count]);
            assert_eq!(convert(&image, &mut Vec::new()), None, "{encoding}");
        }
    }
}
