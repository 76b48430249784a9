//! One picture in each of the twelve pixel formats.

use lariat_extract::PixelFormat;

/// The picture in each format. UV is the mean of the pixels that share it.
pub(crate) fn formats(rgb: &[u8], w: usize, h: usize) -> Vec<(PixelFormat, Vec<u8>, usize)> {
    let yuv = |x: usize, y: usize| {
        let i = 3 * (y.min(h - 1) * w + x.min(w - 1));
        let [r, g, b] = [0, 1, 2].map(|c| f32::from(rgb[i + c]));
        let luma = 0.299 * r + 0.587 * g + 0.114 * b;
        [luma, 128.0 + 0.564 * (b - luma), 128.0 + 0.713 * (r - luma)]
    };
    let byte = |v: f32| (v + 0.5).clamp(0.0, 255.0) as u8;
    let luma = |x: usize, y: usize| byte(yuv(x, y)[0]);
    let pixels = || (0..h).flat_map(|y| (0..w).map(move |x| (x, y)));
    let gray = pixels().map(|(x, y)| luma(x, y)).collect();
    let bgr = rgb
        .chunks_exact(3)
        .flat_map(|p| [p[2], p[1], p[0]])
        .collect();
    let pairs = w.div_ceil(2);
    let mut yuyv = Vec::new();
    for y in 0..h {
        for x in (0..2 * pairs).step_by(2) {
            let (a, b) = (yuv(x, y), yuv(x + 1, y));
            let mean = |c: usize| byte(0.5 * (a[c] + b[c]));
            yuyv.extend([byte(a[0]), mean(1), byte(b[0]), mean(2)]);
        }
    }
    let uyvy = yuyv.chunks_exact(2).flat_map(|p| [p[1], p[0]]).collect();
    let mut nv12 = Vec::new();
    for y in 0..h {
        nv12.extend((0..2 * pairs).map(|x| luma(x, y)));
    }
    for y in (0..h).step_by(2) {
        for x in (0..2 * pairs).step_by(2) {
            let four = [yuv(x, y), yuv(x + 1, y), yuv(x, y + 1), yuv(x + 1, y + 1)];
            let mean = |c: usize| byte(four.iter().map(|p| p[c]).sum::<f32>() / 4.0);
            nv12.extend([mean(1), mean(2)]);
        }
    }
    let bgra = rgb.chunks_exact(3).flat_map(|p| [p[2], p[1], p[0], 77]);
    // Any value that is closest to the level's multiple of 257 gives the same level.
    let gray16 = pixels().flat_map(|(x, y)| {
        let wide = u16::from(luma(x, y)) * 257;
        wide.saturating_add((x % 100) as u16).to_ne_bytes()
    });
    // `red` is the position of the first red pixel.
    let mosaic = |red: [usize; 2]| {
        let channel = move |x: usize, y: usize| (x + red[0]) % 2 + (y + red[1]) % 2;
        let bytes = pixels().map(|(x, y)| rgb[3 * (y * w + x) + channel(x, y)]);
        bytes.collect::<Vec<u8>>()
    };
    vec![
        (PixelFormat::Rgb8, rgb.to_vec(), 3 * w),
        (PixelFormat::Bgr8, bgr, 3 * w),
        (PixelFormat::Gray8, gray, w),
        (PixelFormat::Yuyv, yuyv, 4 * pairs),
        (PixelFormat::Uyvy, uyvy, 4 * pairs),
        (PixelFormat::Nv12, nv12, 2 * pairs),
        (PixelFormat::Bgra8, bgra.collect(), 4 * w),
        (PixelFormat::Gray16, gray16.collect(), 2 * w),
        (PixelFormat::BayerRggb8, mosaic([0, 0]), w),
        (PixelFormat::BayerBggr8, mosaic([1, 1]), w),
        (PixelFormat::BayerGrbg8, mosaic([1, 0]), w),
        (PixelFormat::BayerGbrg8, mosaic([0, 1]), w),
    ]
}
