//! Cuts off a connector, a ferrule or bare wire at a rope's end. Its color occurs nowhere else on
//! the rope.

use lariat_portable::{Arch, NullaryFnOnce};

use super::line::Line;
use crate::image::ray::LANES;
use crate::image::{Image, color};
use crate::statistics::median;
use crate::vec2;

/// Minimum number of samples. A shorter line is not changed.
const LEAST_SAMPLES: usize = 16;
/// Maximum length of a connector: in widths, and as a share of the line.
const MOST: (f32, f32) = (9.0, 0.4);
/// Minimum length of a line, in widths. A shorter one is not a rope, and lacks a body to compare a
/// connector with.
const SHORTEST_WIDTHS: f32 = 4.0;
/// Minimum length of a connector, in widths.
const LEAST_WIDTHS: f32 = 0.5;
/// Positions across the rope where its color is read, in widths from the middle.
const ACROSS: [f32; 3] = [-0.25, 0.0, 0.25];
/// A color is different if it is this many deviations from the rope's own, as a root mean square
/// over the channels. `LEAST_DEVIATION`, in levels, is added to each deviation.
const DEVIATIONS: f32 = 3.0;
const LEAST_DEVIATION: f32 = 6.0;
/// The color at a connector's end changes by more than `STEP` deviations within this many widths to
/// either side.
const ASIDE_WIDTHS: f32 = 0.25;
const STEP: f32 = 2.0;
/// Ratio of a normal distribution's standard deviation to the median of its absolute deviations.
const DEVIATION: f32 = 1.5;

/// Cuts connectors off. It allocates only for a line longer than all before.
#[derive(Debug, Default)]
pub(crate) struct ConnectorCutter {
    /// The color of each sample.
    colors: Vec<[f32; 3]>,
    sorted: Vec<f32>,
}

impl ConnectorCutter {
    pub(crate) fn reserve(&mut self, samples: usize) {
        self.colors.reserve(samples);
        self.sorted.reserve(samples);
    }

    /// Cuts off connectors at those ends of the line that do not leave the image. Returns their
    /// lengths, in pixels.
    pub(crate) fn cut(&mut self, line: &mut Line, image: &Image) -> [f32; 2] {
        let (count, length_px) = (line.samples.len(), line.length_px());
        if line.closed || line.border == [true; 2] || count < LEAST_SAMPLES {
            return [0.0; 2];
        }
        Arch::new().dispatch(ReadColors {
            line,
            image,
            colors: &mut self.colors,
        });
        self.sorted.clear();
        self.sorted.extend(line.samples.iter().map(|s| s.width_px));
        let samples_a_width = median(&mut self.sorted) * count as f32 / length_px.max(1.0);
        if (count as f32) < SHORTEST_WIDTHS * samples_a_width {
            return [0.0; 2];
        }
        let most = (MOST.0 * samples_a_width).min(MOST.1 * count as f32) as usize;
        let least = LEAST_WIDTHS * samples_a_width;
        let own = self.own(most);
        let [first, last] = [0, 1].map(|end| {
            let color = |i: usize| match end {
                0 => self.colors[i],
                _ => self.colors[count - 1 - i],
            };
            if line.border[end] {
                return 0;
            }
            let limit = 3.0 * DEVIATIONS * DEVIATIONS;
            let are_other = (0..most).map(|i| own.squares_off(color(i), own.usual) > limit);
            let length = connector_length(are_other, least);
            match own.is_step(color, length, samples_a_width) {
                true => length,
                false => 0,
            }
        });
        line.samples.truncate(count - last);
        line.samples.drain(..first);
        let px_a_sample = length_px / (count - 1) as f32;
        [first, last].map(|samples| samples as f32 * px_a_sample)
    }

    /// The rope's own color, measured away from the ends.
    fn own(&mut self, most: usize) -> Own {
        let body = &self.colors[most..self.colors.len() - most];
        let channels = [0, 1, 2].map(|c| {
            self.sorted.clear();
            self.sorted.extend(body.iter().map(|color| color[c]));
            let usual = median(&mut self.sorted);
            for value in &mut self.sorted {
                *value = (*value - usual).abs();
            }
            let deviation = DEVIATION * median(&mut self.sorted) + LEAST_DEVIATION;
            (usual, deviation)
        });
        Own {
            usual: channels.map(|(usual, _)| usual),
            deviations: channels.map(|(_, deviation)| deviation),
        }
    }
}

/// A rope's own color, and its usual deviations.
struct Own {
    usual: [f32; 3],
    deviations: [f32; 3],
}

impl Own {
    /// Squared distance of two colors in deviations, summed over the channels.
    fn squares_off(&self, a: [f32; 3], b: [f32; 3]) -> f32 {
        let off = [0, 1, 2].map(|c| (a[c] - b[c]) / self.deviations[c]);
        off.iter().map(|off| off * off).sum()
    }

    /// Returns whether the color changes abruptly at a sample. Shade comes gradually.
    fn is_step(&self, color: impl Fn(usize) -> [f32; 3], at: usize, samples_a_width: f32) -> bool {
        let mean = |from: usize, to: usize| {
            let sum = (from..to)
                .map(&color)
                .fold([0.0; 3], |sum, color| [0, 1, 2].map(|c| sum[c] + color[c]));
            sum.map(|sum| sum / (to - from).max(1) as f32)
        };
        let [width, aside] = [1.0, ASIDE_WIDTHS].map(|w| (w * samples_a_width).ceil() as usize);
        let outer = mean(
            at.saturating_sub(aside + width),
            at.saturating_sub(aside).max(1),
        );
        let inner = mean(at + aside, at + aside + width);
        self.squares_off(outer, inner) > 3.0 * STEP * STEP
    }
}

/// Number of a connector's samples, counted from the tip. Up to that number, samples of another
/// color outnumber the others by the most.
fn connector_length(are_other: impl Iterator<Item = bool>, least: f32) -> usize {
    let (mut sum, mut best, mut length) = (0, 0, 0);
    for (i, is_other) in are_other.enumerate() {
        sum += if is_other { 1 } else { -1 };
        if sum > best {
            (best, length) = (sum, i + 1);
        }
    }
    if best as f32 >= least { length } else { 0 }
}

/// Reads colors, for the widest registers.
struct ReadColors<'a> {
    line: &'a Line,
    image: &'a Image<'a>,
    colors: &'a mut Vec<[f32; 3]>,
}

impl NullaryFnOnce for ReadColors<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let samples = &self.line.samples;
        self.colors.clear();
        for first in (0..samples.len()).step_by(LANES) {
            let count = LANES.min(samples.len() - first);
            let (mut at, mut across) = ([[0.0; LANES]; 2], [[0.0; LANES]; 2]);
            for l in 0..count {
                let sample = &samples[first + l];
                let slope = self.line.slope(first + l, 2);
                let normal = vec2::normal(vec2::unit_or(slope, [1.0, 0.0]));
                for c in 0..2 {
                    at[c][l] = sample.at[c];
                    across[c][l] = normal[c] * sample.width_px;
                }
            }
            let mut sums = [[0.0; LANES]; 3];
            for widths in ACROSS {
                let places =
                    [0, 1].map(|c| std::array::from_fn(|l| at[c][l] + widths * across[c][l]));
                let colors = color::between_each(self.image, &places);
                for (sums, colors) in sums.iter_mut().zip(&colors) {
                    for (sum, color) in sums.iter_mut().zip(colors) {
                        *sum += color / ACROSS.len() as f32;
                    }
                }
            }
            let colors = (0..count).map(|l| sums.map(|channel| channel[l]));
            self.colors.extend(colors);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::centerline::line::Sample;
    use crate::image::PixelFormat;

    /// A rope from x = 10 to 190 on white, with these colors along it.
    fn picture(color: impl Fn(usize) -> [u8; 3]) -> Vec<u8> {
        let pixel = |i: usize| match (i % 200, i / 200) {
            (x @ 10..190, 16..24) => color(x),
            _ => [240; 3],
        };
        (0..200 * 40).flat_map(pixel).collect()
    }

    /// Red, with the last 12 pixels blue.
    fn plugged(x: usize) -> [u8; 3] {
        if x < 178 {
            [200, 30, 30]
        } else {
            [30, 30, 200]
        }
    }

    fn line(closed: bool, border: [bool; 2]) -> Line {
        let sample = |x: usize| Sample {
            at: [x as f32, 19.5],
            weight: 1.0,
            width_px: 8.0,
            side: 0.0,
        };
        Line {
            samples: (10..190).map(sample).collect(),
            closed,
            border,
        }
    }

    fn cut(line: &mut Line, color: impl Fn(usize) -> [u8; 3]) -> [f32; 2] {
        let pixels = picture(color);
        let image = Image::new(&pixels, 200, 40, 600, PixelFormat::Rgb8).expect("of its size");
        ConnectorCutter::default().cut(line, &image)
    }

    #[test]
    fn an_end_of_another_color_is_cut_off() {
        let mut rope = line(false, [false; 2]);
        let [first_px, last_px] = cut(&mut rope, plugged);
        assert_eq!(first_px, 0.0);
        assert!((last_px - 12.0).abs() < 1.1, "{last_px}");
        assert!((rope.samples[rope.samples.len() - 1].at[0] - 177.0).abs() < 1.1);
        // A rope does not end where it leaves the image, and a ring does not end at all.
        for mut whole in [line(false, [false, true]), line(true, [false; 2])] {
            assert_eq!(cut(&mut whole, plugged), [0.0; 2]);
            assert_eq!(whole.samples.len(), 180);
        }
    }

    #[test]
    fn a_tip_that_darkens_little_by_little_stays() {
        let shaded = |x: usize| [200 - x.saturating_sub(140) as u8, 30, 30];
        assert_eq!(cut(&mut line(false, [false; 2]), shaded), [0.0; 2]);
    }

    #[test]
    fn what_is_as_wide_as_long_is_left_alone() {
        let mut short = line(false, [false; 2]);
        short.samples.drain(..140);
        for width_px in [20.0, 40.0, 400.0] {
            (short.samples.iter_mut()).for_each(|sample| sample.width_px = width_px);
            assert_eq!(cut(&mut short, plugged), [0.0; 2]);
        }
    }

    #[test]
    fn a_fleck_near_a_tip_is_no_plug() {
        let flecks = [false, false, false, true, true, false, false, false];
        assert_eq!(connector_length(flecks.into_iter(), 2.0), 0);
        assert_eq!(
            connector_length([true, true, false, true, false].into_iter(), 2.0),
            2
        );
    }
}
