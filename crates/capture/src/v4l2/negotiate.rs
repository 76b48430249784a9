//! Chooses a camera's format, size and rate.
//!
//! The rule, in this order:
//!
//! 1. Only formats that lariat reads ([`READABLE`]; for a depth camera [`DEPTHS`]), or the
//!    requested one.
//! 2. Only the requested size. Without a request, only sizes with half to twice as many pixels as
//!    [`DEFAULT_SIZE`], or the nearest size if there are none.
//! 3. The rate nearest to the requested one, otherwise the highest. Rates within 2 % are equal (30
//!    and 29.97).
//! 4. The best of the remaining formats for a mask. Uncompressed colors come first, with those of a
//!    color filter mosaic last, because each pixel has only one of three colors. Compressed colors
//!    are next: they take time to decode and blur the edges of colors. Gray is last, because
//!    without hue nothing distinguishes rope from table.
//! 5. The size nearest to [`DEFAULT_SIZE`], then the rate.
//!
//! For example, a camera whose USB connection carries only 10 uncompressed frames of 1280×720 per
//! second is read at that size in a compressed format, at 30 frames per second.

use std::fmt;

use super::offers::{FormatOffer, FourCc, Interval};
use super::sys;

/// Formats that lariat reads, the best first.
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

/// Formats that lariat reads as depth, the best first: 16-bit integers whose unit is in the depth
/// camera's calibration.
pub(super) const DEPTHS: [u32; 2] = [sys::PIX_Z16, sys::PIX_Y16];

/// Preferred size of frames if none is requested, px.
pub const DEFAULT_SIZE: [u32; 2] = [640, 480];

/// Maximum width and height of a frame, px.
const LARGEST: u32 = 8192;

/// Two rates count as equal if their ratio differs from 1 by at most this much.
const SAME_RATE: f64 = 0.02;

/// Content of a camera's frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Wanted {
    /// Pictures.
    #[default]
    Pictures,
    /// Distances: a depth camera's `Z16` or `Y16`.
    Depth,
}

impl Wanted {
    /// Pixel formats with this content that lariat reads, the best first.
    pub(super) fn formats(self) -> &'static [u32] {
        match self {
            Self::Pictures => &READABLE,
            Self::Depth => &DEPTHS,
        }
    }
}

/// A request to a camera. Lariat chooses whatever is not requested.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Request {
    /// Width and height, px.
    pub size: Option<[u32; 2]>,
    /// Frames per second; `None` selects the highest rate.
    pub fps: Option<f64>,
    /// The pixel format.
    pub format: Option<FourCc>,
    /// Content of the frames.
    pub wanted: Wanted,
}

impl Request {
    /// The requested size, or the default size if none is requested.
    pub(super) fn near(&self) -> [u32; 2] {
        self.size.unwrap_or(DEFAULT_SIZE)
    }
}

/// The settings to make.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Choice {
    pub(super) code: FourCc,
    pub(super) size: [u32; 2],
    /// `None` if the driver does not report its rates.
    pub(super) interval: Option<Interval>,
}

/// Why none of a camera's offers can be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoCommonFormat {
    /// Lariat reads none of its pixel formats.
    #[error(
        "it offers {}, and lariat reads none of these but {}",
        List(offered),
        readable()
    )]
    NothingReadable {
        /// The offered formats.
        offered: Vec<FourCc>,
    },
    /// Pictures are requested from a depth camera.
    #[error(
        "it offers {}, which is depth: name it as the --depth-source, and the colour camera as the source",
        List(offered)
    )]
    OnlyDepth {
        /// The offered formats.
        offered: Vec<FourCc>,
    },
    /// Depth is requested from a camera without depth.
    #[error("it offers {}, and depth is read of {}", List(offered), List(&DEPTHS.map(FourCc)))]
    NoDepth {
        /// The offered formats.
        offered: Vec<FourCc>,
    },
    /// Lariat does not read the requested pixel format.
    #[error(
        "lariat does not read the pixel format {asked}; of this camera's formats it reads {}",
        List(readable)
    )]
    NotReadable {
        /// The requested format.
        asked: FourCc,
        /// The offered formats that can be requested.
        readable: Vec<FourCc>,
    },
    /// The camera does not have the requested pixel format.
    #[error("it has no pixel format {asked}; it has {}", List(offered))]
    FormatNotOffered {
        /// The requested format.
        asked: FourCc,
        /// The offered formats.
        offered: Vec<FourCc>,
    },
    /// The camera does not have the requested size.
    #[error("it has no size {}x{}{}; the nearest are {}", asked[0], asked[1], within(*format), Sizes(nearest))]
    SizeNotOffered {
        /// Width and height, px.
        asked: [u32; 2],
        /// The pixel format, if one was requested too.
        format: Option<FourCc>,
        /// The nearest offered sizes, the nearest first; at most 4.
        nearest: Vec<[u32; 2]>,
    },
}

fn within(format: Option<FourCc>) -> String {
    format.map_or(String::new(), |format| format!(" in {format}"))
}

fn readable() -> String {
    List(&READABLE.map(FourCc)).to_string()
}

/// A list within a sentence: `A, B and C`.
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

/// A possible choice and its merits.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    choice: Choice,
    /// Index in [`READABLE`] or [`DEPTHS`].
    rank: usize,
    /// Absolute logarithm of the ratio of its pixel count to the default's.
    from_default: f64,
    /// 0 if the driver does not report it.
    fps: f64,
}

/// Chooses by the rule at the top of this file.
///
/// # Errors
/// No offer matches the request, or none can be read.
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
        // An unreported rate may be anything, but a reported rate is preferred.
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

/// The error if none of these formats can be used.
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

/// Returns the formats that can be used, each with its rank.
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

/// Returns the candidates of one format: for each size or range of sizes the one nearest to the
/// request, at the nearest rate.
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
        // The driver does not list its sizes. Its answer will show how it adjusts this one.
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

/// Returns the offered sizes nearest to `asked`, the nearest first.
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
