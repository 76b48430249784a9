//! Which of a camera's formats, sizes and rates to take.
//!
//! The rule, in this order:
//!
//! 1. Only formats that lariat reads ([`READABLE`]; of a depth camera [`DEPTHS`]), or the one that was asked for.
//! 2. Only the size that was asked for. Without a wish: sizes of about [`DEFAULT_SIZE`], which are those of at least half
//!    and at most twice as many pixels, or, if there are none, the nearest.
//! 3. The rate nearest to the one asked for; without a wish the highest. Rates within 2 % are the same (30 and 29.97).
//! 4. Of what is left, the best format for a mask: uncompressed colours as the camera makes them (those of a mosaic of colour
//!    filters last, as each pixel has but one of three), then compressed ones,
//!    which cost a decoder's time and blur the edges of colours, then grey, in which no hue tells rope from table.
//! 5. Then the size nearest to [`DEFAULT_SIZE`], then the rate.
//!
//! So a camera whose USB cable carries only 10 uncompressed frames of 1280×720 is read compressed there, at 30.

use std::fmt;

use super::offers::{FormatOffer, FourCc, Interval};
use super::sys;

/// What lariat reads, the best first.
pub(super) const READABLE: [u32; 16] = [
    sys::PIX_YUYV,
    sys::PIX_UYVY,
    sys::PIX_NV12,
    sys::PIX_BGR3,
    sys::PIX_RGB3,
    sys::PIX_AR24,
    sys::PIX_XR24,
    sys::PIX_BGR4,
    sys::PIX_RGGB,
    sys::PIX_BA81,
    sys::PIX_GRBG,
    sys::PIX_GBRG,
    sys::PIX_MJPG,
    sys::PIX_JPEG,
    sys::PIX_GREY,
    sys::PIX_Y16,
];

/// What lariat reads as depth, the best first: whole numbers of 16 bits, whose unit the depth camera's calibration says.
pub(super) const DEPTHS: [u32; 2] = [sys::PIX_Z16, sys::PIX_Y16];

/// About how large frames are if no size is asked for, px.
pub const DEFAULT_SIZE: [u32; 2] = [640, 480];

/// The largest side that a frame can have, px.
const LARGEST: u32 = 8192;

/// Rates that differ by no more than this, as a ratio, are the same.
const SAME_RATE: f64 = 0.02;

/// What a camera's frames are to show.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Wanted {
    /// Pictures.
    #[default]
    Pictures,
    /// How far what is seen is: a depth camera's `Z16`, or `Y16`.
    Depth,
}

impl Wanted {
    /// The pixel formats that are read, the best first.
    pub(super) fn formats(self) -> &'static [u32] {
        match self {
            Self::Pictures => &READABLE,
            Self::Depth => &DEPTHS,
        }
    }
}

/// What is asked of a camera; what is not asked for is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Request {
    /// Width and height, px.
    pub size: Option<[u32; 2]>,
    /// Frames a second; without it, as many as there are.
    pub fps: Option<f64>,
    /// The pixel format.
    pub format: Option<FourCc>,
    /// What it is to show.
    pub wanted: Wanted,
}

impl Request {
    /// The size near which to look.
    pub(super) fn near(&self) -> [u32; 2] {
        self.size.unwrap_or(DEFAULT_SIZE)
    }
}

/// What to set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Choice {
    pub(super) code: FourCc,
    pub(super) size: [u32; 2],
    /// `None` if the driver does not tell its rates.
    pub(super) interval: Option<Interval>,
}

/// Why nothing of what a camera offers can be taken.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoCommonFormat {
    /// It has no pixel format that lariat reads.
    #[error(
        "it offers {}, and lariat reads none of these but {}",
        List(offered),
        readable()
    )]
    NothingReadable {
        /// What it has.
        offered: Vec<FourCc>,
    },
    /// Pictures are wanted, and it is a depth camera.
    #[error(
        "it offers {}, which is depth: name it as the --depth-source, and the colour camera as the source",
        List(offered)
    )]
    OnlyDepth {
        /// What it has.
        offered: Vec<FourCc>,
    },
    /// Depth is wanted, and it gives none.
    #[error("it offers {}, and depth is read of {}", List(offered), List(&DEPTHS.map(FourCc)))]
    NoDepth {
        /// What it has.
        offered: Vec<FourCc>,
    },
    /// Lariat does not read the pixel format that was asked for.
    #[error(
        "lariat does not read the pixel format {asked}; of this camera's formats it reads {}",
        List(readable)
    )]
    NotReadable {
        /// Which.
        asked: FourCc,
        /// What it has and can be asked for.
        readable: Vec<FourCc>,
    },
    /// It does not have the pixel format that was asked for.
    #[error("it has no pixel format {asked}; it has {}", List(offered))]
    FormatNotOffered {
        /// Which.
        asked: FourCc,
        /// What it has.
        offered: Vec<FourCc>,
    },
    /// It does not have the size that was asked for.
    #[error("it has no size {}x{}{}; the nearest are {}", asked[0], asked[1], within(*format), Sizes(nearest))]
    SizeNotOffered {
        /// Width and height, px.
        asked: [u32; 2],
        /// The pixel format, if one was asked for too.
        format: Option<FourCc>,
        /// What it has, the nearest first; at most 4.
        nearest: Vec<[u32; 2]>,
    },
}

fn within(format: Option<FourCc>) -> String {
    format.map_or(String::new(), |format| format!(" in {format}"))
}

fn readable() -> String {
    List(&READABLE.map(FourCc)).to_string()
}

/// Words of a sentence: `A, B and C`.
struct List<'a>(&'a [FourCc]);

impl fmt::Display for List<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<_> = self.0.iter().map(FourCc::to_string).collect();
        f.write_str(&match names.split_last() {
            None => "no format at all".to_owned(),
            Some((last, [])) => last.clone(),
            Some((last, others)) => format!("{} and {last}", others.join(", ")),
        })
    }
}

struct Sizes<'a>(&'a [[u32; 2]]);

impl fmt::Display for Sizes<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sizes: Vec<_> = self.0.iter().map(|[w, h]| format!("{w}x{h}")).collect();
        f.write_str(&sizes.join(", "))
    }
}

/// One thing that could be taken, and what it is worth.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    choice: Choice,
    /// Of [`READABLE`].
    rank: usize,
    /// By how much the pixels are more or fewer than the default's: the logarithm of the ratio.
    from_default: f64,
    /// 0 if the driver does not tell.
    fps: f64,
}

/// Chooses by the rule at the head of this file.
///
/// # Errors
/// Nothing there is what was asked for, or what lariat reads.
pub(super) fn negotiate(
    offers: &[FormatOffer],
    request: &Request,
) -> Result<Choice, NoCommonFormat> {
    let formats = formats(offers, request)?;
    let mut candidates: Vec<_> = formats
        .iter()
        .flat_map(|(rank, offer)| candidates(*rank, offer, request))
        .collect();
    if let Some(asked) = request.size {
        candidates.retain(|candidate| candidate.choice.size == asked);
        if candidates.is_empty() {
            return Err(NoCommonFormat::SizeNotOffered {
                asked,
                format: request.format,
                nearest: nearest_sizes(&formats, asked),
            });
        }
    } else {
        let nearest = least(&candidates, |candidate| candidate.from_default);
        let limit = nearest.max(2_f64.ln() + 1e-9);
        candidates.retain(|candidate| candidate.from_default <= limit);
    }
    let rate_error = |candidate: &Candidate| match request.fps {
        Some(fps) if candidate.fps > 0.0 => (candidate.fps / fps).ln().abs(),
        // A rate that is not told may be any, but one that is told is better.
        Some(_) => 1e3,
        None => -candidate.fps.max(1e-3).ln(),
    };
    let best_rate = least(&candidates, rate_error);
    candidates.retain(|candidate| rate_error(candidate) <= best_rate + SAME_RATE);
    candidates
        .into_iter()
        .min_by(|a, b| {
            (a.rank.cmp(&b.rank))
                .then(a.from_default.total_cmp(&b.from_default))
                .then(rate_error(a).total_cmp(&rate_error(b)))
        })
        .map(|best| best.choice)
        .ok_or_else(|| nothing(offers, request.wanted))
}

/// Why none of these formats can be taken.
fn nothing(offers: &[FormatOffer], wanted: Wanted) -> NoCommonFormat {
    let offered: Vec<_> = offers.iter().map(|offer| offer.code).collect();
    match wanted {
        Wanted::Depth => NoCommonFormat::NoDepth { offered },
        Wanted::Pictures if offered.contains(&FourCc(sys::PIX_Z16)) => {
            NoCommonFormat::OnlyDepth { offered }
        }
        Wanted::Pictures => NoCommonFormat::NothingReadable { offered },
    }
}

fn least(candidates: &[Candidate], of: impl Fn(&Candidate) -> f64) -> f64 {
    candidates.iter().map(of).fold(f64::INFINITY, f64::min)
}

/// The formats that may be taken, each with its rank.
fn formats<'o>(
    offers: &'o [FormatOffer],
    request: &Request,
) -> Result<Vec<(usize, &'o FormatOffer)>, NoCommonFormat> {
    let readable = request.wanted.formats();
    let rank = |code: FourCc| readable.iter().position(|&readable| readable == code.0);
    let all = || offers.iter().map(|offer| offer.code);
    let readable: Vec<_> = offers
        .iter()
        .filter_map(|offer| Some((rank(offer.code)?, offer)))
        .collect();
    if readable.is_empty() {
        return Err(nothing(offers, request.wanted));
    }
    let Some(asked) = request.format else {
        return Ok(readable);
    };
    if rank(asked).is_none() {
        return Err(NoCommonFormat::NotReadable {
            asked,
            readable: readable.iter().map(|(_, offer)| offer.code).collect(),
        });
    }
    let is_asked = |(_, offer): &(usize, &FormatOffer)| offer.code == asked;
    let of_this: Vec<_> = readable.into_iter().filter(is_asked).collect();
    match of_this.is_empty() {
        true => Err(NoCommonFormat::FormatNotOffered {
            asked,
            offered: all().collect(),
        }),
        false => Ok(of_this),
    }
}

/// What could be taken of one format: of each size, or steps of sizes, the nearest to what is asked for, at the nearest
/// rate.
fn candidates(rank: usize, offer: &FormatOffer, request: &Request) -> Vec<Candidate> {
    let candidate = |size: [u32; 2], interval: Option<Interval>| Candidate {
        choice: Choice {
            code: offer.code,
            size,
            interval,
        },
        rank,
        from_default: (pixels(size) / pixels(DEFAULT_SIZE)).ln().abs(),
        fps: interval.map_or(0.0, Interval::fps),
    };
    if offer.sizes.is_empty() {
        // The driver does not say: what it makes of this will be seen.
        return vec![candidate(request.near(), None)];
    }
    offer
        .sizes
        .iter()
        .map(|size| (size.range.nearest(request.near()), &size.rates))
        .filter(|(size, _)| size.iter().all(|side| (1..=LARGEST).contains(side)))
        .map(|(size, rates)| candidate(size, rates.nearest(request.fps)))
        .collect()
}

fn pixels([width, height]: [u32; 2]) -> f64 {
    f64::from(width) * f64::from(height)
}

/// The sizes there are instead of `asked`, the nearest first.
fn nearest_sizes(formats: &[(usize, &FormatOffer)], asked: [u32; 2]) -> Vec<[u32; 2]> {
    let distance = |size: &[u32; 2]| {
        let [width, height] = [0, 1].map(|axis| size[axis].abs_diff(asked[axis]));
        u64::from(width) + u64::from(height)
    };
    let mut sizes: Vec<_> = formats
        .iter()
        .flat_map(|(_, offer)| &offer.sizes)
        .map(|size| size.range.nearest(asked))
        .collect();
    sizes.sort_by_key(|size| (distance(size), *size));
    sizes.dedup();
    sizes.truncate(4);
    sizes
}

#[cfg(test)]
mod tests;
