//! Conversion of a picture to another pixel format, as a camera would send it.

use lariat_extract::PixelFormat;

use crate::Picture;

/// Converts an RGB picture to `format`, by ITU-R BT.601 in full range. Color is averaged over the
/// pixels that share it. Returns `None` if the picture is not `Rgb8`, or if a side is odd where
/// pixels share color.
pub fn converted(picture: &Picture, format: PixelFormat) -> Option<Picture> {
    let [width, height] = picture.size();
    let shared = match format {
        PixelFormat::Yuyv | PixelFormat::Uyvy => [2, 1],
        PixelFormat::Nv12 => [2, 2],
        _ => [1, 1],
    };
    let bytes = format.row_bytes(width) * format.rows(height);
    if picture.format() != PixelFormat::Rgb8 || width % shared[0] != 0 || height % shared[1] != 0 {
        return None;
    }
    let pixels = width * height;
    let rgb = picture.bytes();
    let yuv: Vec<[f32; 3]> = rgb.chunks_exact(3).map(to_yuv).collect();
    let luma = yuv.iter().map(|yuv| to_byte(yuv[0]));
    // U and V of the pixels that share them.
    let chroma = |x: usize, y: usize| {
        let mut sum = [0.0f32; 2];
        for (dx, dy) in (0..shared[1]).flat_map(|dy| (0..shared[0]).map(move |dx| (dx, dy))) {
            let [_, u, v] = yuv[(y + dy) * width + x + dx];
            sum = [sum[0] + u, sum[1] + v];
        }
        sum.map(|sum| to_byte(sum / (shared[0] * shared[1]) as f32 + 128.0))
    };
    let size = [width, height];
    match format {
        PixelFormat::Rgb8 => Picture::rgb(size, rgb),
        PixelFormat::Bgr8 => Picture::new(size, format, 3 * pixels, |bytes| {
            for (to, from) in bytes.chunks_exact_mut(3).zip(rgb.chunks_exact(3)) {
                to.copy_from_slice(&[from[2], from[1], from[0]]);
            }
        }),
        PixelFormat::Gray8 => Picture::new(size, format, pixels, |bytes| {
            bytes.iter_mut().zip(luma).for_each(|(to, y)| *to = y);
        }),
        PixelFormat::Yuyv | PixelFormat::Uyvy => Picture::new(size, format, 2 * pixels, |bytes| {
            for (i, to) in bytes.chunks_exact_mut(4).enumerate() {
                let [u, v] = chroma(2 * i % width, 2 * i / width);
                let [first, second] = [yuv[2 * i][0], yuv[2 * i + 1][0]].map(to_byte);
                to.copy_from_slice(&match format {
                    PixelFormat::Uyvy => [u, first, v, second],
                    _ => [first, u, second, v],
                });
            }
        }),
        PixelFormat::Nv12 => Picture::new(size, format, pixels + pixels / 2, |bytes| {
            let (plane, pairs) = bytes.split_at_mut(pixels);
            plane.iter_mut().zip(luma).for_each(|(to, y)| *to = y);
            for (i, to) in pairs.chunks_exact_mut(2).enumerate() {
                let (x, y) = (2 * i % width, 2 * (2 * i / width));
                to.copy_from_slice(&chroma(x, y));
            }
        }),
        PixelFormat::Bgra8 => Picture::new(size, format, bytes, |bytes| {
            for (to, from) in bytes.chunks_exact_mut(4).zip(rgb.chunks_exact(3)) {
                to.copy_from_slice(&[from[2], from[1], from[0], 255]);
            }
        }),
        PixelFormat::Gray16 => Picture::new(size, format, bytes, |bytes| {
            for (to, luma) in bytes.chunks_exact_mut(2).zip(luma) {
                to.fill(luma);
            }
        }),
        PixelFormat::BayerRggb8
        | PixelFormat::BayerBggr8
        | PixelFormat::BayerGrbg8
        | PixelFormat::BayerGbrg8 => {
            // Color index of the first two pixels of the first two rows.
            let mosaic = match format {
                PixelFormat::BayerRggb8 => [[0, 1], [1, 2]],
                PixelFormat::BayerBggr8 => [[2, 1], [1, 0]],
                PixelFormat::BayerGrbg8 => [[1, 0], [2, 1]],
                _ => [[1, 2], [0, 1]],
            };
            Picture::new(size, format, bytes, |bytes| {
                for (i, (to, from)) in bytes.iter_mut().zip(rgb.chunks_exact(3)).enumerate() {
                    let (x, y) = (i % width, i / width);
                    *to = from[mosaic[y % 2][x % 2]];
                }
            })
        }
    }
}

/// Returns Y, and U and V centered on 0.
fn to_yuv(rgb: &[u8]) -> [f32; 3] {
    let [r, g, b] = [rgb[0], rgb[1], rgb[2]].map(f32::from);
    let y = 0.299 * r + 0.587 * g + 0.114 * b;
    [y, (b - y) / 1.772, (r - y) / 1.402]
}

fn to_byte(value: f32) -> u8 {
    (value + 0.5).clamp(0.0, 255.0) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns four columns and two rows: the left half red, the right half white.
    fn picture() -> Picture {
        let row = [[255, 0, 0], [255, 0, 0], [255, 255, 255], [255, 255, 255]].concat();
        Picture::rgb([4, 2], &row.repeat(2)).unwrap()
    }

    #[test]
    fn red_and_white_are_what_the_standard_says() {
        // BT.601, full range: red is Y 76, U 85, V 255 (clamped from 255.5); white is 255, 128,
        // 128.
        let bytes = |format| converted(&picture(), format).unwrap().bytes().to_vec();
        assert_eq!(bytes(PixelFormat::Gray8), [76, 76, 255, 255].repeat(2));
        let yuyv = [76, 85, 76, 255, 255, 128, 255, 128];
        assert_eq!(bytes(PixelFormat::Yuyv), yuyv.repeat(2));
        let uyvy = [85, 76, 255, 76, 128, 255, 128, 255];
        assert_eq!(bytes(PixelFormat::Uyvy), uyvy.repeat(2));
        let nv12 = [[76, 76, 255, 255], [76, 76, 255, 255], [85, 255, 128, 128]];
        assert_eq!(bytes(PixelFormat::Nv12), nv12.concat());
        assert_eq!(bytes(PixelFormat::Bgr8)[..3], [0, 0, 255]);
        assert_eq!(bytes(PixelFormat::Bgra8)[..4], [0, 0, 255, 255]);
        assert_eq!(bytes(PixelFormat::Gray16)[..2], [76, 76]);
        let mosaic = [[255, 0, 255, 255], [0, 0, 255, 255]];
        assert_eq!(bytes(PixelFormat::BayerRggb8), mosaic.concat());
        let mosaic = [[0, 0, 255, 255], [255, 0, 255, 255]];
        assert_eq!(bytes(PixelFormat::BayerGbrg8), mosaic.concat());
        assert_eq!(bytes(PixelFormat::Rgb8), picture().bytes());
    }

    #[test]
    fn pixels_that_share_colour_come_in_pairs() {
        let odd = Picture::rgb([3, 1], &[0; 9]).unwrap();
        assert!(converted(&odd, PixelFormat::Yuyv).is_none());
        assert!(converted(&odd, PixelFormat::Uyvy).is_none());
        assert!(converted(&odd, PixelFormat::Gray8).is_some());
    }
}
