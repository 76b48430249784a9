//! Pixels as three numbers in any format. Colors are compared in this form.

use lariat_portable::{Arch, NullaryFnOnce};

use super::ray::{LANES, Lanes};
use super::{Image, PixelFormat, unpack};

/// Bytes read at once to get two adjacent pixels.
const EIGHT: usize = 8;

/// The pixel in the image's own color space: red, green, blue for RGB formats, Y, U, V for YUV
/// formats. Gray formats repeat the brightness three times.
#[inline]
pub(crate) fn native(image: &Image, x: usize, y: usize) -> [u8; 3] {
    let row = image.row(y);
    match image.format() {
        PixelFormat::Gray8 => [row[x]; 3],
        PixelFormat::Rgb8 => [row[3 * x], row[3 * x + 1], row[3 * x + 2]],
        PixelFormat::Bgr8 => [row[3 * x + 2], row[3 * x + 1], row[3 * x]],
        PixelFormat::Yuyv => {
            let pair = 4 * (x / 2);
            [row[2 * x], row[pair + 1], row[pair + 3]]
        }
        PixelFormat::Uyvy => {
            let pair = 4 * (x / 2);
            [row[2 * x + 1], row[pair], row[pair + 2]]
        }
        PixelFormat::Nv12 => {
            let chroma = image.chroma_row(y);
            let pair = 2 * (x / 2);
            [row[x], chroma[pair], chroma[pair + 1]]
        }
        PixelFormat::Bgra8 => [row[4 * x + 2], row[4 * x + 1], row[4 * x]],
        PixelFormat::Gray16 => [unpack::level([row[2 * x], row[2 * x + 1]]); 3],
        PixelFormat::BayerRggb8
        | PixelFormat::BayerBggr8
        | PixelFormat::BayerGrbg8
        | PixelFormat::BayerGbrg8 => unpack::demosaiced(image, x, y),
    }
}

/// Fills `out` with the native colors of pixels `xs` of row `y`. The channels are the bytes of each
/// number, the first channel in the lowest byte. `Gray8` sets only the lowest.
pub(crate) fn at_places(
    image: &Image,
    y: usize,
    xs: impl IntoIterator<Item = usize>,
    out: &mut [u32],
) {
    let row = image.row(y);
    let places = out.iter_mut().zip(xs);
    // Four bytes contain a whole pixel of any of these formats. The last pixel's four bytes may
    // pass the row's end.
    let four = |from: usize| {
        row.get(from..from + 4)
            .and_then(|bytes| bytes.first_chunk())
    };
    let plain = |x: usize| {
        let [a, b, c] = native(image, x, y);
        [a, b, c, 0]
    };
    // One loop per format: checking the format at each pixel would be slow.
    match image.format() {
        PixelFormat::Rgb8 => places.for_each(|(out, x)| {
            *out = u32::from_le_bytes(four(3 * x).copied().unwrap_or_else(|| plain(x)));
        }),
        PixelFormat::Yuyv => places.for_each(|(out, x)| {
            let [first, u, second, v] = four(4 * (x / 2)).copied().unwrap_or([0; 4]);
            let luma = if x % 2 == 0 { first } else { second };
            *out = u32::from_le_bytes([luma, u, v, 0]);
        }),
        PixelFormat::Uyvy => places.for_each(|(out, x)| {
            let [u, first, v, second] = four(4 * (x / 2)).copied().unwrap_or([0; 4]);
            let luma = if x % 2 == 0 { first } else { second };
            *out = u32::from_le_bytes([luma, u, v, 0]);
        }),
        PixelFormat::Gray8 => places.for_each(|(out, x)| *out = u32::from(row[x])),
        PixelFormat::Nv12 => {
            let chroma = image.chroma_row(y);
            places.for_each(|(out, x)| {
                let pair = &chroma[x & !1..][..2];
                *out = u32::from_le_bytes([row[x], pair[0], pair[1], 0]);
            });
        }
        _ => places.for_each(|(out, x)| *out = u32::from_le_bytes(plain(x))),
    }
}

/// As [`at_places`], for the first pixels of a row.
pub(crate) fn along(image: &Image, y: usize, out: &mut [u32]) {
    Arch::new().dispatch(ReadRow { image, y, out });
}

/// Reads a row with the widest registers.
struct ReadRow<'a> {
    image: &'a Image<'a>,
    y: usize,
    out: &'a mut [u32],
}

impl NullaryFnOnce for ReadRow<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { image, y, out } = self;
        let threes = out.iter_mut().zip(image.row(y).as_chunks::<3>().0);
        match image.format() {
            PixelFormat::Rgb8 => threes.for_each(|(out, &[r, g, b])| {
                *out = u32::from(r) | u32::from(g) << 8 | u32::from(b) << 16;
            }),
            PixelFormat::Bgr8 => threes.for_each(|(out, &[b, g, r])| {
                *out = u32::from(r) | u32::from(g) << 8 | u32::from(b) << 16;
            }),
            _ => at_places(image, y, 0.., out),
        }
    }
}

/// Calls `put` with the index and native color of each of `count` pixels, downward from [x, y].
#[inline(always)]
pub(crate) fn down(
    image: &Image,
    [x, y]: [usize; 2],
    count: usize,
    mut put: impl FnMut(usize, [u8; 3]),
) {
    match image.format() {
        PixelFormat::Rgb8 => {
            for (k, row) in image.rows_from(3 * x, y).take(count).enumerate() {
                if let Some(&pixel) = row.first_chunk::<3>() {
                    put(k, pixel);
                }
            }
        }
        PixelFormat::Bgr8 => {
            for (k, row) in image.rows_from(3 * x, y).take(count).enumerate() {
                if let Some(&[b, g, r]) = row.first_chunk::<3>() {
                    put(k, [r, g, b]);
                }
            }
        }
        PixelFormat::Gray8 => {
            (image.rows_from(x, y).take(count).enumerate()).for_each(|(k, row)| put(k, [row[0]; 3]))
        }
        PixelFormat::Yuyv => (image.rows_from(4 * (x / 2), y).take(count).enumerate())
            .for_each(|(k, row)| put(k, [row[2 * (x % 2)], row[1], row[3]])),
        PixelFormat::Uyvy => (image.rows_from(4 * (x / 2), y).take(count).enumerate())
            .for_each(|(k, row)| put(k, [row[2 * (x % 2) + 1], row[0], row[2]])),
        PixelFormat::Nv12 => {
            // Two rows share their U and V.
            let chroma = image.rows_from(x & !1, image.chroma_line(y));
            let chroma = chroma.flat_map(|row| [row, row]).skip(y % 2);
            let rows = image.rows_from(x, y).zip(chroma);
            for (k, (light, chroma)) in rows.take(count).enumerate() {
                put(k, [light[0], chroma[0], chroma[1]]);
            }
        }
        _ => (0..count).for_each(|k| put(k, native(image, x, y + k))),
    }
}

/// Native color at a position between pixels, bilinear. Past the edge, the edge's color continues.
pub(crate) fn between(image: &Image, [x, y]: [f32; 2]) -> [f32; 3] {
    let (right, bottom) = (image.width() - 1, image.height() - 1);
    let (x, y) = (x.clamp(0.0, right as f32), y.clamp(0.0, bottom as f32));
    let (x0, y0) = (x as usize, y as usize);
    let (x1, y1) = ((x0 + 1).min(right), (y0 + 1).min(bottom));
    let (fx, fy) = (x - x0 as f32, y - y0 as f32);
    let [a, b, d, e] = corners(image, [x0, x1], [y0, y1]);
    let mix = |from: f32, to: f32, share: f32| from + share * (to - from);
    let mut color = [0.0; 3];
    for c in 0..3 {
        let (a, b) = (f32::from(a[c]), f32::from(b[c]));
        let (d, e) = (f32::from(d[c]), f32::from(e[c]));
        color[c] = mix(mix(a, b, fx), mix(d, e, fx), fy);
    }
    color
}

/// As [`between`], for one position per lane. Returns one array per channel.
#[inline(always)]
pub(crate) fn between_each(image: &Image, at: &[Lanes; 2]) -> [Lanes; 3] {
    let (right, bottom) = (image.width() - 1, image.height() - 1);
    // The last pixel that has neighbors to the right and below.
    let last = [right.saturating_sub(1), bottom.saturating_sub(1)];
    let (mut whole, mut part) = ([[0; LANES]; 2], [[0.0; LANES]; 2]);
    for c in 0..2 {
        let most = [right, bottom][c] as f32;
        for l in 0..LANES {
            let at = at[c][l].clamp(0.0, most);
            whole[c][l] = (at as i32).min(last[c] as i32);
            part[c][l] = at - whole[c][l] as f32;
        }
    }
    let mut fours = [[0u32; LANES]; 4];
    if right > 0 && bottom > 0 && image.bytes().len() >= EIGHT {
        corners_each(image, &whole, &mut fours);
    } else {
        for l in 0..LANES {
            let (x, y) = (whole[0][l] as usize, whole[1][l] as usize);
            let corners = corners(image, [x, (x + 1).min(right)], [y, (y + 1).min(bottom)]);
            for (four, [a, b, c]) in fours.iter_mut().zip(corners) {
                four[l] = u32::from_le_bytes([a, b, c, 0]);
            }
        }
    }
    let mut colors = [[0.0; LANES]; 3];
    for (c, colors) in colors.iter_mut().enumerate() {
        for l in 0..LANES {
            let byte = |k: usize| (fours[k][l] >> (8 * c) & 0xff) as i32 as f32;
            let mix = |from: f32, to: f32, share: f32| from + share * (to - from);
            let (x, y) = (part[0][l], part[1][l]);
            colors[l] = mix(mix(byte(0), byte(1), x), mix(byte(2), byte(3), x), y);
        }
    }
    colors
}

/// Native colors of each pixel, its right neighbor and the two below, one byte per channel. All of
/// them must be in the image, which must have at least [`EIGHT`] bytes.
#[inline(always)]
fn corners_each(image: &Image, whole: &[[i32; LANES]; 2], fours: &mut [[u32; LANES]; 4]) {
    let (bytes, stride) = (image.bytes(), image.stride());
    // Eight bytes hold the data of two adjacent pixels. A read that would pass the image's end
    // starts earlier and is shifted.
    let eight = |place: usize| {
        let from = place.min(bytes.len() - EIGHT);
        let word = bytes[from..].first_chunk::<EIGHT>().copied();
        word.map_or(0, u64::from_le_bytes) >> ((8 * (place - from)) & 63)
    };
    // Two adjacent pixels of a format that stores pixels in pairs. If `x` is odd, the first is the
    // second of its pair. `light` is the offset of Y in the two bytes of a pixel.
    let pairs = |word: u64, x: usize, light: usize| {
        let odd = x & 1;
        let bits = |at: usize| (word >> (8 * at) & 0xff) as u32;
        let pixel = |k: usize| {
            let pair = 4 * (k / 2);
            let color = pair + 1 - light;
            bits(2 * k + light) | bits(color) << 8 | bits(color + 2) << 16
        };
        [pixel(odd), pixel(odd + 1)]
    };
    let format = image.format();
    for l in 0..LANES {
        let (x, y) = (whole[0][l] as usize, whole[1][l] as usize);
        for row in 0..2 {
            let start = (y + row) * stride;
            let two = match format {
                PixelFormat::Rgb8 => {
                    let word = eight(start + 3 * x);
                    [word as u32, (word >> 24) as u32]
                }
                PixelFormat::Bgr8 => {
                    let word = eight(start + 3 * x);
                    [word as u32, (word >> 24) as u32].map(|pixel| pixel.swap_bytes() >> 8)
                }
                PixelFormat::Yuyv => pairs(eight(start + 4 * (x / 2)), x, 0),
                PixelFormat::Uyvy => pairs(eight(start + 4 * (x / 2)), x, 1),
                PixelFormat::Nv12 => {
                    let light = eight(start + x);
                    let color = eight(image.chroma_line(y + row) * stride + (x & !1));
                    let pixel = |k: usize| {
                        let pair = 16 * (((x & 1) + k) / 2);
                        (light >> (8 * k)) as u32 & 0xff | ((color >> pair) as u32 & 0xffff) << 8
                    };
                    [pixel(0), pixel(1)]
                }
                PixelFormat::Gray8 => {
                    let word = eight(start + x) as u32;
                    [0x01_0101 * (word & 0xff), 0x01_0101 * (word >> 8 & 0xff)]
                }
                _ => [x, x + 1].map(|x| {
                    let [a, b, c] = native(image, x, y + row);
                    u32::from_le_bytes([a, b, c, 0])
                }),
            };
            (fours[2 * row][l], fours[2 * row + 1][l]) = (two[0], two[1]);
        }
    }
}

/// Native colors of the four pixels at two columns and two rows, the upper row first.
#[inline(always)]
fn corners(image: &Image, [x0, x1]: [usize; 2], [y0, y1]: [usize; 2]) -> [[u8; 3]; 4] {
    // Match the format once and take each row once.
    let interleaved = |order: [usize; 3]| {
        let [upper, lower] = [image.row(y0), image.row(y1)];
        let pixel = |row: &[u8], x: usize| {
            let pixel = &row[3 * x..3 * x + 3];
            [pixel[order[0]], pixel[order[1]], pixel[order[2]]]
        };
        [
            pixel(upper, x0),
            pixel(upper, x1),
            pixel(lower, x0),
            pixel(lower, x1),
        ]
    };
    match image.format() {
        PixelFormat::Rgb8 => interleaved([0, 1, 2]),
        PixelFormat::Bgr8 => interleaved([2, 1, 0]),
        _ => [(x0, y0), (x1, y0), (x0, y1), (x1, y1)].map(|(x, y)| native(image, x, y)),
    }
}

/// The pixel as red, green and blue.
pub(crate) fn rgb(image: &Image, x: usize, y: usize) -> [u8; 3] {
    let pixel = native(image, x, y);
    if is_yuv(image.format()) {
        yuv_to_rgb(pixel)
    } else {
        pixel
    }
}

/// Weight of a difference of the second or third channel relative to the first; see [`distance`].
pub(crate) fn chroma_weight(format: PixelFormat) -> f32 {
    if is_yuv(format) { 2.0 } else { 1.0 }
}

pub(crate) fn is_yuv(format: PixelFormat) -> bool {
    matches!(
        format,
        PixelFormat::Yuyv | PixelFormat::Uyvy | PixelFormat::Nv12
    )
}

/// Converts a color by BT.601, full range.
#[inline(always)]
pub(crate) fn yuv_to_rgb([y, u, v]: [u8; 3]) -> [u8; 3] {
    let (y, u, v) = (f32::from(y), f32::from(u) - 128.0, f32::from(v) - 128.0);
    // Converts through an integer as wide as a float. Otherwise, vectors are converted one lane at
    // a time.
    let to_byte = |c: f32| (c + 0.5).clamp(0.0, 255.0) as i32 as u8;
    [
        to_byte(y + 1.402 * v),
        to_byte(y - 0.344_136 * u - 0.714_136 * v),
        to_byte(y + 1.772 * u),
    ]
}

/// Distance of two native colors: the largest difference of a channel. U and V count double because
/// their range is half that of red, green and blue.
///
/// A mixture with a share α of rope is exactly α times as far from the table as the rope is.
/// Sub-pixel edges are computed from this.
pub(crate) fn distance(a: [f32; 3], b: [f32; 3], yuv: bool) -> f32 {
    let chroma = if yuv { 2.0 } else { 1.0 };
    let d = |i: usize| (a[i] - b[i]).abs();
    d(0).max(chroma * d(1)).max(chroma * d(2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn colors_at_many_places_are_those_at_each(
            bytes in prop::collection::vec(any::<u8>(), 2000), format in prop::sample::select(&PixelFormat::DIRECT[..]),
            size in (1..20usize, 1..20usize), padding in 0..4usize,
            places in prop::array::uniform16((-2.0f32..22.0, -2.0f32..22.0)),
        ) {
            let (width, height) = size;
            let bytes_a_row = match format {
                PixelFormat::Gray8 => width,
                PixelFormat::Nv12 => width.next_multiple_of(2),
                PixelFormat::Yuyv | PixelFormat::Uyvy => 2 * width.next_multiple_of(2),
                _ => 3 * width,
            };
            let stride = bytes_a_row + padding;
            let rows = if format == PixelFormat::Nv12 { height + height.div_ceil(2) } else { height };
            // Exactly the bytes that the image needs.
            let bytes = &bytes[..stride * (rows - 1) + bytes_a_row];
            let image = Image::new(bytes, width, height, stride, format).expect("a whole image");
            let mut at = [[0.0; LANES]; 2];
            for (l, (x, y)) in places.into_iter().enumerate() {
                (at[0][l], at[1][l]) = (x, y);
            }
            let found = between_each(&image, &at);
            for (l, (x, y)) in places.into_iter().enumerate() {
                let expected = between(&image, [x, y]);
                for (found, expected) in found.iter().zip(expected) {
                    prop_assert!((found[l] - expected).abs() < 1e-3);
                }
            }
        }
    }
}
