//! A camera's offers: pixel formats, their frame sizes, and the frame rates of each size.

use std::fmt;
use std::str::FromStr;

use super::device::{Device, text};
use super::sys;

/// The kernel's four-letter code of a pixel format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct FourCc(pub u32);

/// Other common names of pixel formats.
const ALIASES: [(&str, &[u8; 4]); 10] = [
    ("YUY2", b"YUYV"),
    ("GRAY", b"GREY"),
    ("GRAY8", b"GREY"),
    ("Y8", b"GREY"),
    ("GRAY16", b"Y16 "),
    ("BGGR", b"BA81"),
    ("RGB24", b"RGB3"),
    ("BGR24", b"BGR3"),
    ("MJPEG", b"MJPG"),
    ("JPG", b"JPEG"),
];

impl FromStr for FourCc {
    type Err = ();

    /// Parses its letters in either case, or another common name (`mjpeg`, `yuy2`, `gray`).
    fn from_str(name: &str) -> Result<Self, ()> {
        let name = name.trim().to_ascii_uppercase();
        if let Some((_, code)) = ALIASES.iter().find(|(alias, _)| *alias == name) {
            return Ok(Self(sys::fourcc(code)));
        }
        let mut code = [b' '; 4];
        let letters = name.as_bytes();
        let is_code = (2..=4).contains(&letters.len()) && letters.iter().all(u8::is_ascii_graphic);
        if !is_code {
            return Err(());
        }
        code[..letters.len()].copy_from_slice(letters);
        Ok(Self(sys::fourcc(&code)))
    }
}

impl fmt::Display for FourCc {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The highest bit marks the big-endian variant.
        let letters = (self.0 & 0x7fff_ffff).to_le_bytes();
        let shown = |b: u8| {
            if b.is_ascii_graphic() {
                char::from(b)
            } else {
                ' '
            }
        };
        let name: String = letters.map(shown).iter().collect();
        f.pad(name.trim_end())?;
        f.write_str(if self.0 >> 31 == 1 { "-BE" } else { "" })
    }
}

/// Interval between frames, as a fraction of seconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Interval {
    /// Numerator of the fraction.
    pub numerator: u32,
    /// Denominator of the fraction.
    pub denominator: u32,
}

impl Interval {
    /// Converts the kernel's fraction; `None` if it is not a time.
    pub(super) fn new([numerator, denominator]: [u32; 2]) -> Option<Self> {
        (numerator > 0 && denominator > 0).then_some(Self {
            numerator,
            denominator,
        })
    }

    /// The nearest interval for this frame rate, to a thousandth of a frame per second.
    pub(super) fn of_fps(fps: f64) -> Self {
        // Whole rates as cameras list them: 1/30.
        let is_whole = fps.fract() == 0.0 && fps <= 1e6;
        let (numerator, scale) = if is_whole { (1, 1.0) } else { (1000, 1000.0) };
        Self {
            numerator,
            denominator: (fps * scale).round().clamp(1.0, 4e9) as u32,
        }
    }

    /// Frames per second.
    pub fn fps(self) -> f64 {
        f64::from(self.denominator) / f64::from(self.numerator)
    }
}

/// Available frame rates.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Rates {
    /// The driver does not report them.
    Untold,
    /// Only these.
    Listed(Vec<Interval>),
    /// All rates between two limits.
    Between {
        /// Interval of the fastest rate.
        shortest: Interval,
        /// Interval of the slowest rate.
        longest: Interval,
    },
}

impl Rates {
    /// The interval nearest to this frame rate or, without one, the shortest. `None` if rates are
    /// not reported.
    pub(super) fn nearest(&self, fps: Option<f64>) -> Option<Interval> {
        let distance = |interval: &Interval| match fps {
            // As a ratio, so that 30 is as far from 15 as from 60.
            Some(fps) => (interval.fps() / fps).ln().abs(),
            None => -interval.fps(),
        };
        match self {
            Self::Untold => None,
            Self::Listed(all) => all
                .iter()
                .copied()
                .min_by(|a, b| distance(a).total_cmp(&distance(b))),
            Self::Between { shortest, longest } => Some(match fps {
                Some(fps) if fps <= longest.fps() => *longest,
                Some(fps) if fps < shortest.fps() => Interval::of_fps(fps),
                _ => *shortest,
            }),
        }
    }
}

/// Available frame sizes: one, or many at even steps. Width and height, px.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SizeRange {
    /// Only this one.
    One([u32; 2]),
    /// From the smallest to the largest, in steps.
    Steps {
        /// Smallest size.
        least: [u32; 2],
        /// Largest size.
        most: [u32; 2],
        /// Step between sizes, at least 1.
        step: [u32; 2],
    },
}

impl SizeRange {
    /// Returns the available size nearest to this one.
    pub fn nearest(&self, size: [u32; 2]) -> [u32; 2] {
        match *self {
            Self::One(size) => size,
            Self::Steps { least, most, step } => std::array::from_fn(|axis| {
                let (least, step) = (least[axis], step[axis].max(1));
                let most = most[axis].max(least);
                let over = size[axis].clamp(least, most) - least;
                let down = least + over / step * step;
                let up = down.saturating_add(step);
                if up <= most && up - size[axis].min(up) < size[axis].saturating_sub(down) {
                    up
                } else {
                    down
                }
            }),
        }
    }
}

/// One or several sizes and their rates.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SizeOffer {
    /// The size or sizes.
    pub range: SizeRange,
    /// The rates. For several sizes, the rates of the size nearest to the request.
    pub rates: Rates,
}

/// A pixel format with its sizes and rates.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FormatOffer {
    /// Code of the format.
    pub code: FourCc,
    /// The driver's description of it.
    pub description: String,
    /// True if frames are compressed.
    pub compressed: bool,
    /// Empty if the driver does not report them.
    pub sizes: Vec<SizeOffer>,
}

/// Limit on the length of each list, in case a driver never ends it.
const MOST: u32 = 512;

impl Device {
    /// Returns all formats of the camera. Sizes and rates, which take many calls, are queried only
    /// for formats that `wanted` accepts. If sizes are stepwise, rates are queried at the size
    /// nearest to `near`.
    pub(crate) fn offers(
        &self,
        near: [u32; 2],
        wanted: impl Fn(FourCc) -> bool,
    ) -> Vec<FormatOffer> {
        let describe = |index| {
            let mut format = sys::FormatDescription {
                index,
                kind: self.buffer_type(),
                ..Default::default()
            };
            sys::enumerate_formats(self, &mut format).ok()?;
            Some(format)
        };
        (0..MOST)
            .map_while(describe)
            .map(|format| FormatOffer {
                code: FourCc(format.pixelformat),
                description: text(&format.description),
                compressed: format.flags & sys::FMT_FLAG_COMPRESSED != 0,
                sizes: match wanted(FourCc(format.pixelformat)) {
                    true => self.sizes(format.pixelformat, near),
                    false => Vec::new(),
                },
            })
            .collect()
    }

    fn sizes(&self, pixel_format: u32, near: [u32; 2]) -> Vec<SizeOffer> {
        let describe = |index| {
            let mut size = sys::SizeDescription {
                index,
                pixel_format,
                ..Default::default()
            };
            sys::enumerate_sizes(self, &mut size).ok()?;
            Some(size)
        };
        (0..MOST)
            .map_while(describe)
            .map(|size| {
                let [a, b, c, d, e, f] = size.size;
                let range = match size.kind {
                    sys::SIZE_DISCRETE => SizeRange::One([a, b]),
                    kind => SizeRange::Steps {
                        least: [a, d],
                        most: [b, e],
                        step: match kind {
                            sys::SIZE_STEPWISE => [c.max(1), f.max(1)],
                            _ => [1, 1],
                        },
                    },
                };
                let rates = self.rates(pixel_format, range.nearest(near));
                SizeOffer { range, rates }
            })
            .collect()
    }

    fn rates(&self, pixel_format: u32, [width, height]: [u32; 2]) -> Rates {
        let mut listed = Vec::new();
        for index in 0..MOST {
            let mut rate = sys::IntervalDescription {
                index,
                pixel_format,
                width,
                height,
                ..Default::default()
            };
            if sys::enumerate_intervals(self, &mut rate).is_err() {
                break;
            }
            let [shortest, longest, _] = rate.interval.map(Interval::new);
            match (rate.kind, shortest, longest) {
                (sys::INTERVAL_DISCRETE, Some(interval), _) => listed.push(interval),
                (sys::INTERVAL_DISCRETE, None, _) => {}
                (_, Some(shortest), Some(longest)) => return Rates::Between { shortest, longest },
                _ => break,
            }
        }
        match listed.is_empty() {
            true => Rates::Untold,
            false => Rates::Listed(listed),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_format_is_found_by_any_of_its_names() {
        let code = |name: &str| name.parse::<FourCc>().map(|code| code.to_string());
        for (name, meant) in [
            ("yuyv", "YUYV"),
            ("YUY2", "YUYV"),
            ("Grey", "GREY"),
            ("mjpeg", "MJPG"),
            ("rgb24", "RGB3"),
            ("Y16", "Y16"),
        ] {
            assert_eq!(code(name).as_deref(), Ok(meant));
        }
        for name in ["", "colour", "a b", "é"] {
            assert!(code(name).is_err(), "{name:?}");
        }
    }

    #[test]
    fn rates_are_the_nearest_or_the_fastest() {
        let per_second = |denominator| Interval {
            numerator: 1,
            denominator,
        };
        let listed = Rates::Listed([30, 15, 60, 5].map(per_second).to_vec());
        assert_eq!(listed.nearest(None), Some(per_second(60)));
        assert_eq!(listed.nearest(Some(20.0)), Some(per_second(15)));
        assert_eq!(listed.nearest(Some(500.0)), Some(per_second(60)));

        let between = Rates::Between {
            shortest: per_second(90),
            longest: per_second(5),
        };
        assert_eq!(between.nearest(None), Some(per_second(90)));
        assert_eq!(between.nearest(Some(25.0)), Some(per_second(25)));
        assert_eq!(between.nearest(Some(1.0)), Some(per_second(5)));
        assert_eq!(Rates::Untold.nearest(Some(30.0)), None);
    }

    proptest! {
        #[test]
        fn no_size_of_a_range_is_nearer_than_the_nearest(
            least in 1_u32..40, steps in 0_u32..20, step in 1_u32..9, asked in 0_u32..300,
        ) {
            let most = least + steps * step;
            let range = SizeRange::Steps { least: [least; 2], most: [most; 2], step: [step, 1] };
            let [width, height] = range.nearest([asked; 2]);
            let best = (0..=steps).map(|i| (least + i * step).abs_diff(asked)).min();
            prop_assert_eq!(Some(width.abs_diff(asked)), best);
            prop_assert_eq!((width - least) % step, 0);
            prop_assert_eq!(height, asked.clamp(least, most));
        }

        #[test]
        fn whatever_a_driver_says_has_a_nearest_size(
            numbers in proptest::array::uniform6(any::<u32>()), asked in proptest::array::uniform2(any::<u32>()),
        ) {
            let [a, b, c, d, e, f] = numbers;
            SizeRange::Steps { least: [a, b], most: [c, d], step: [e, f] }.nearest(asked);
        }
    }
}
