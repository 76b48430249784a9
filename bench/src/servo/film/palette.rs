//! 255 colors for all pictures of a film: median cut (P. Heckbert, *Color Image Quantization for Frame Buffer Display*,
//! 1982), where boxes with many shades are cut before boxes with many pixels, since most pixels are of one table.

/// A GIF has 256; one is the transparent one.
const COLORS: usize = 255;
/// Bits of a color that are told apart: the first of the counts, the second of the search.
const COUNTED_BITS: u32 = 5;
const SOUGHT_BITS: u32 = 6;

/// Colors, and how to find the nearest.
#[derive(Debug)]
pub(super) struct Palette {
    pub(super) colors: Vec<[u8; 3]>,
    /// By the first bits of a color; `UNKNOWN` before it was looked for.
    nearest: Vec<u16>,
}

const UNKNOWN: u16 = u16::MAX;

/// Shades that were counted together: how many, and their sum.
#[derive(Debug, Clone, Copy)]
struct Bin {
    count: u32,
    sums: [u64; 3],
}

impl Bin {
    fn mean(&self) -> [f64; 3] {
        self.sums
            .map(|sum| sum as f64 / f64::from(self.count.max(1)))
    }
}

impl Palette {
    pub(super) fn of<'a>(pixels: impl Iterator<Item = &'a [u8; 3]>) -> Self {
        let empty = Bin {
            count: 0,
            sums: [0; 3],
        };
        let mut bins = vec![empty; 1 << (3 * COUNTED_BITS)];
        for pixel in pixels {
            let bin = &mut bins[first_bits(*pixel, COUNTED_BITS)];
            // More would overflow, and changes no mean.
            if bin.count < u32::MAX {
                bin.count += 1;
                (0..3).for_each(|k| bin.sums[k] += u64::from(pixel[k]));
            }
        }
        bins.retain(|bin| bin.count > 0);
        let colors = cut(bins).iter().map(|part| mean(part)).collect();
        Self {
            colors,
            nearest: vec![UNKNOWN; 1 << (3 * SOUGHT_BITS)],
        }
    }

    /// The index behind those of the colors.
    pub(super) fn transparent(&self) -> u8 {
        self.colors.len() as u8
    }

    /// Red, green and blue of each index, the transparent one included.
    pub(super) fn bytes(&self) -> Vec<u8> {
        let colors = self.colors.iter().chain([&[0; 3]]);
        colors.flatten().copied().collect()
    }

    /// The index of the nearest color.
    pub(super) fn nearest(&mut self, color: [u8; 3]) -> u8 {
        let key = first_bits(color, SOUGHT_BITS);
        if self.nearest[key] == UNKNOWN {
            let apart = |other: &[u8; 3]| -> i32 {
                (0..3)
                    .map(|k| (i32::from(other[k]) - i32::from(color[k])).pow(2))
                    .sum()
            };
            let found = self.colors.iter().enumerate().min_by_key(|(_, c)| apart(c));
            self.nearest[key] = found.map_or(0, |(index, _)| index as u16);
        }
        self.nearest[key] as u8
    }
}

fn first_bits(color: [u8; 3], bits: u32) -> usize {
    let first = |c: u8| usize::from(c >> (8 - bits));
    (first(color[0]) << (2 * bits)) | (first(color[1]) << bits) | first(color[2])
}

/// Cuts the part that is widest for its pixels, at the median of its longest side, until there are as many as colors.
fn cut(bins: Vec<Bin>) -> Vec<Vec<Bin>> {
    let mut parts = vec![bins];
    parts.retain(|part| !part.is_empty());
    while parts.len() < COLORS {
        let widths = parts.iter().map(|part| {
            let pixels: f64 = part.iter().map(|bin| f64::from(bin.count)).sum();
            longest_side(part).1 * pixels.powf(0.25)
        });
        let widest = widths.enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((index, width)) = widest else {
            break;
        };
        if width <= 0.0 {
            break;
        }
        let mut part = parts.swap_remove(index);
        let axis = longest_side(&part).0;
        part.sort_by(|a, b| a.mean()[axis].total_cmp(&b.mean()[axis]));
        let half = part.iter().map(|bin| u64::from(bin.count)).sum::<u64>() / 2;
        let mut below = 0;
        let at = part.iter().position(|bin| {
            below += u64::from(bin.count);
            below > half
        });
        let at = at.unwrap_or(0).clamp(1, part.len() - 1);
        let rest = part.split_off(at);
        parts.extend([part, rest]);
    }
    parts
}

/// The axis along which shades differ most, and by how much; 0 if there is but one.
fn longest_side(part: &[Bin]) -> (usize, f64) {
    let side = |axis: usize| {
        let values = || part.iter().map(|bin| bin.mean()[axis]);
        let high = values().fold(f64::NEG_INFINITY, f64::max);
        (axis, high - values().fold(f64::INFINITY, f64::min))
    };
    let [a, b, c] = [0, 1, 2].map(side);
    let longer = |a: (usize, f64), b: (usize, f64)| if b.1 > a.1 { b } else { a };
    longer(longer(a, b), c)
}

fn mean(part: &[Bin]) -> [u8; 3] {
    let count: u64 = part.iter().map(|bin| u64::from(bin.count)).sum();
    [0, 1, 2].map(|k| {
        let sum: u64 = part.iter().map(|bin| bin.sums[k]).sum();
        ((sum + count / 2) / count.max(1)) as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_colors_are_kept_as_they_are() {
        let pixels = [[255, 255, 255], [0, 0, 0], [0, 114, 178], [255, 140, 0]];
        let mut palette = Palette::of(pixels.iter().cycle().take(4000));
        assert_eq!(palette.colors.len(), 4);
        for pixel in pixels {
            let index = palette.nearest(pixel);
            assert_eq!(palette.colors[usize::from(index)], pixel);
        }
    }

    #[test]
    fn many_colors_become_near_ones() {
        let pixels: Vec<[u8; 3]> = (0..=255u8)
            .flat_map(|a| (0..=255u8).step_by(5).map(move |b| [a, b, a / 2 + b / 2]))
            .collect();
        let mut palette = Palette::of(pixels.iter());
        assert_eq!(palette.colors.len(), COLORS);
        for &pixel in &pixels {
            let index = usize::from(palette.nearest(pixel));
            let near = palette.colors[index];
            let apart = (0..3).map(|k| near[k].abs_diff(pixel[k])).max().unwrap();
            assert!(apart < 24, "{pixel:?} {near:?}");
        }
    }

    #[test]
    fn a_palette_of_nothing_has_no_color() {
        assert!(Palette::of([].iter()).colors.is_empty());
    }
}
