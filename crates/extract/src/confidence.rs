//! The probability that a curve is a rope, whole and in order. It judges the finished curve against
//! its image, whatever made the mask.
//!
//! At two dozen places along the curve, the image is read across it. The findings there and the
//! shape of the curve become numbers between 0 and 1 ([`Evidence`]). A logistic function of their
//! weighted sum is the probability of being right. The weights are fitted to drawn pictures
//! ([`weights`]). The judgement takes microseconds and no memory.

mod across;
pub(crate) mod remainder;
mod tips;
mod weights;

use crate::image::Image;
use crate::image::gray::GrayPlane;
use crate::scene::{Curve, Status};
use crate::statistics::{grade, median, quantile};
use crate::vec2::{self, Vec2};
use across::{Across, Place};
use weights::{COLOR, ELSEWHERE, NETWORK, OWN};

/// Number of places along a curve that are read.
const PLACES: usize = 24;
/// Number of clues for or against a curve.
const CLUES: usize = Clue::Beyond as usize + 1;
/// Minimum step at an edge: in levels, plus multiples of the ground's own variation. Camera noise
/// changes a mean by less.
const EDGE: (f32, f32) = (6.0, 1.5);
/// Turn of an arc, in radians, at which it begins to count as a circle and at which it counts
/// fully.
/// Deviation from its circle, as a share of the radius, at which an arc does not count and at which
/// it counts fully.
const ARC: (f32, f32) = (2.5, 4.0);
const EXACT: (f32, f32) = (0.03, 0.01);
/// Length, in widths, beyond which a longer curve adds no evidence.
const LONGEST: f32 = 64.0;
/// Hidden share of a rope at which it begins to count as bridged, and at which it counts fully. A
/// smaller share may be an end under another strand.
const BRIDGED: (f32, f32) = (0.03, 0.1);
/// Length, in rope widths, over which a rope of the same width hides the edges at a crossing: 1 /
/// sin α with α = 24°. Flatter crossings are uncertain and count as stretches without edges.
const CROSSING: f32 = 2.5;
/// Network output, of 255, at which a pixel counts as confident.
const SEEN: f32 = 0.9 * 255.0;

/// Clues for or against a curve: a number from 0 to 1 each.
#[derive(Clone, Copy)]
enum Clue {
    /// Always 1.
    Constant,
    /// Variation of the width.
    Uneven,
    /// Variation of color along the curve.
    Unlike,
    /// Difference of the ground between the two sides.
    SidesUnlike,
    /// The length in widths.
    Length,
    /// Thinness, in pixels.
    Thin,
    /// The sharpest bend.
    Bends,
    /// 1 for a straight curve without variation of light across it, such as a print, an edge or a
    /// bar. A taut rope is round.
    FlatBar,
    /// 1 for an arc of half a turn or more, like a rim.
    Round,
    /// Share of places without any edge, as far as it exceeds one half: the picture does not show
    /// the curve.
    Faint,
    /// The longest stretch without edges, as far as it exceeds that of a crossing.
    Stretch,
    /// Variation of light across the curve, in a network's mask: a rope is round, print is flat.
    Relief,
    /// Share of ends followed by more of the same color.
    GoesOn,
    /// Share of tips that point at the flank of a strand, or are within one.
    Met,
    /// Evidence that a tip continues at another tip beyond a gap.
    Torn,
    /// Share of ends at the picture's border.
    Border,
    /// The number of crossings.
    Crossings,
    /// The part of the mask next to the curve that no curve runs through.
    LeftOut,
    /// 1 if the curve is a part of a rope that was longer before.
    Partial,
    /// 1 if the curve may be something else.
    Doubted,
    /// Share of the curve where the network is confident.
    Seen,
    /// The network's output beyond the curve's tips.
    Beyond,
}

/// The maker of the mask. Each maker has its own weights of the clues.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Maker {
    /// The extractor, from the difference from the table.
    #[default]
    Own,
    /// The extractor, with the user's color ranges.
    Color,
    /// The network.
    Network,
    /// Another source, which knows more than colors.
    Elsewhere,
}

/// The evidence for and against a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evidence {
    /// Numbers from 0 to 1, explained in [`MEANINGS`](Self::MEANINGS).
    pub clues: [f32; CLUES],
    /// The maker of the mask.
    pub maker: Maker,
}

impl Evidence {
    /// The meaning of each number, and the sign that its weight may have: 1 if it can only speak
    /// for a curve, −1 if only against one, 0 for both. A weight of the other sign would be an
    /// accident of the pictures it was fitted to.
    pub const MEANINGS: [(&'static str, i8); CLUES] = [
        ("constant", 0),
        ("unevenness of the width", -1),
        ("unlikeness of colour along the curve", -1),
        ("unlikeness of the two sides", -1),
        ("length in widths", 1),
        ("thinness", -1),
        ("bends", -1),
        ("straight and flat", -1),
        ("an arc of a circle", -1),
        ("not shown by the picture", -1),
        ("a stretch without edges", -1),
        ("light and shade across it", 1),
        ("ends that go on", -1),
        ("tips at a strand", -1),
        ("tips that continue beyond a gap", -1),
        ("ends at the border", 0),
        ("crossings", -1),
        ("left out of the mask", -1),
        ("seen in part", -1),
        ("its own doubt", -1),
        ("surely seen by the network", 1),
        ("seen by the network beyond its tips", -1),
    ];

    /// Returns whether the picture shows the curve. A mask of something that the picture does not
    /// show is a guess, even if it is right.
    pub fn is_shown(&self) -> bool {
        self.clues[Clue::Faint as usize] < 0.5
    }

    /// The probability that a curve with this evidence is right.
    pub fn confidence(&self) -> f32 {
        let weights = match self.maker {
            Maker::Own => &OWN,
            Maker::Color => &COLOR,
            Maker::Network => &NETWORK,
            Maker::Elsewhere => &ELSEWHERE,
        };
        let sum: f32 = self.clues.iter().zip(weights).map(|(x, w)| x * w).sum();
        1.0 / (1.0 + libm::expf(-sum))
    }
}

/// Knowledge besides the image and the curve.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Context<'a> {
    /// True if the curve may be something other than a rope.
    pub(crate) is_doubted: bool,
    pub(crate) maker: Maker,
    /// True if the mask is made from the image's difference from the table, and so shows what
    /// covers a rope.
    pub(crate) sees_covers: bool,
    /// The network's output for each pixel, if the network made the mask.
    pub(crate) likely: Option<&'a GrayPlane>,
    /// The part of the mask next to the curve that no curve runs through, from
    /// [`Remainder::beside`](remainder::Remainder::beside).
    pub(crate) left_out: f32,
    /// Number of the curve's crossings.
    pub(crate) crossings: usize,
}

/// The evidence for one of a picture's curves.
pub(crate) fn evidence(
    image: &Image,
    (curves, number): (&[Curve], usize),
    context: Context,
) -> Evidence {
    let curve = &curves[number];
    let share = |is: bool| f32::from(u8::from(is));
    let points = curve.points.len().max(1) as f32;
    let hidden = curve.hidden.iter().filter(|&&hidden| hidden).count() as f32 / points;
    let mut clues = [0.0; CLUES];
    clues[Clue::Constant as usize] = 1.0;
    let relief = colors(image, curve, &mut clues);
    clues[Clue::FlatBar as usize] = share(is_straight(curve)) * (1.0 - 2.0 * relief).max(0.0);
    clues[Clue::Uneven as usize] = unevenness(curve);
    let widths = curve.length_px / curve.width_px.max(1.0);
    clues[Clue::Length as usize] = libm::logf(widths.clamp(1.0, LONGEST)) / libm::logf(LONGEST);
    clues[Clue::Thin as usize] = (1.0 - curve.width_px / 8.0).clamp(0.0, 1.0);
    clues[Clue::Bends as usize] = bends(curve);
    clues[Clue::Round as usize] = roundness(curve);
    // A bridged rope counts as whole, if the mask distinguishes a cover over a rope from a gap in
    // it.
    let bridged = share(context.sees_covers) * grade(hidden, BRIDGED.0, BRIDGED.1);
    clues[Clue::Partial as usize] = share(curve.status == Status::Partial) * (1.0 - bridged);
    clues[Clue::Doubted as usize] = share(context.is_doubted);
    clues[Clue::LeftOut as usize] = context.left_out;
    clues[Clue::Crossings as usize] = of(context.crossings as f32, 3.0);
    clues[Clue::Met as usize] = tips::met(curves, number);
    clues[Clue::Torn as usize] = tips::torn(curves, number);
    clues[Clue::Border as usize] =
        0.5 * curve.border.iter().filter(|&&border| border).count() as f32;
    if let Some(likely) = context.likely {
        // The network mistakes many prints for ropes. A flat object that is bent and on a plain
        // table may well be a rope.
        clues[Clue::Relief as usize] = relief;
        let is_seen = |at: &&Vec2| likely.sample(**at) >= SEEN;
        clues[Clue::Seen as usize] = curve.points.iter().filter(is_seen).count() as f32 / points;
        clues[Clue::Beyond as usize] = tips::beyond(likely, curve) / 255.0;
    }
    Evidence {
        clues,
        maker: context.maker,
    }
}

/// Maps a number without an upper limit to one below 1, with ½ at `half`.
fn of(value: f32, half: f32) -> f32 {
    value / (value + half)
}

/// Fills in the clues from the colors across and along the curve. Returns the variation of light
/// across it.
fn colors(image: &Image, curve: &Curve, clues: &mut [f32; CLUES]) -> f32 {
    let mut at = [Place::default(); PLACES];
    let mut count = 0;
    for place in places(curve).filter_map(|i| Place::new(image, curve, i)) {
        at[count] = place;
        count += 1;
    }
    if count == 0 {
        return 0.0;
    }
    let mut all = [Across::default(); PLACES];
    let all = &mut all[..count];
    Across::read(image, &at[..count], all);
    let all = &*all;
    let middle = |of: &dyn Fn(&Across) -> f32| {
        let mut values = [0.0; PLACES];
        values
            .iter_mut()
            .zip(all)
            .for_each(|(value, across)| *value = of(across));
        median(&mut values[..count])
    };
    let least = EDGE.0 + EDGE.1 * middle(&|across| across.texture);
    let has_edge = |across: &&Across| across.edges[0].max(across.edges[1]) > least;
    let shown = all.iter().filter(has_edge).count() as f32 / count as f32;
    clues[Clue::Faint as usize] = (1.0 - 2.0 * shown).max(0.0);
    let contrast = middle(&|across| across.edges[0].min(across.edges[1]));
    let relief =
        middle(&|across| across.relief[0]).abs() + 0.5 * middle(&|across| across.relief[1].abs());
    // A twisted rope alternates between two colors, so the two most similar of three neighbors are
    // compared.
    let along = |of: &dyn Fn(&Across) -> [f32; 3]| {
        let mut values = [0.0; PLACES];
        let mut steps = 0;
        for three in all.windows(3) {
            let apart = |a: usize, b: usize| three[0].distance(of(&three[a]), of(&three[b]));
            values[steps] = apart(0, 1).min(apart(1, 2)).min(apart(0, 2));
            steps += 1;
        }
        // The upper quartile, because a rope looks alike along its whole length.
        quantile(&mut values[..steps], 0.75)
    };
    clues[Clue::Unlike as usize] = of(along(&|across| across.inside), contrast + 4.0);
    clues[Clue::SidesUnlike as usize] = of(
        middle(&|across| across.distance(across.beside[0], across.beside[1])),
        contrast + 4.0,
    );
    clues[Clue::GoesOn as usize] = going_on(image, curve, all);
    let (mut run, mut longest) = (0u8, 0u8);
    for across in all {
        let is_weak = across.edges[0].min(across.edges[1]) < 0.35 * contrast;
        run = if is_weak { run + 1 } else { 0 };
        longest = longest.max(run);
    }
    let at_crossing =
        (CROSSING * curve.width_px * PLACES as f32 / curve.length_px.max(1.0)).max(1.0);
    clues[Clue::Stretch as usize] = ((f32::from(longest) - at_crossing) / 6.0).clamp(0.0, 1.0);
    of(relief, 6.0)
}

/// The curve's points that are read: all that are not hidden.
fn places(curve: &Curve) -> impl Iterator<Item = usize> {
    let points = curve.points.len();
    let seen = (0..PLACES).map(move |k| (2 * k + 1) * points / (2 * PLACES));
    seen.filter(|&i| curve.hidden.get(i) == Some(&false))
}

/// Variation of the width along the curve, around its median.
fn unevenness(curve: &Curve) -> f32 {
    let mut off = [0.0; PLACES];
    let mut count = 0;
    for i in places(curve) {
        off[count] = (curve.widths_px[i] - curve.width_px).abs();
        count += 1;
    }
    let off_px = quantile(&mut off[..count], 0.75);
    of(off_px, 0.25 * curve.width_px.max(1.0))
}

/// Sharpness of the curve's sharpest bend. A rope's stiffness keeps the radius above its width.
fn bends(curve: &Curve) -> f32 {
    let points = &curve.points;
    let step_px = curve.length_px / points.len().max(2) as f32;
    let reach = (libm::ceilf(1.5 * curve.width_px / step_px.max(0.1)) as usize).max(1);
    let mut sharpest = 0.0f32;
    for i in reach..points.len().saturating_sub(reach) {
        let before = vec2::unit_or(vec2::sub(points[i], points[i - reach]), [1.0, 0.0]);
        let after = vec2::unit_or(vec2::sub(points[i + reach], points[i]), [1.0, 0.0]);
        sharpest = sharpest.max(1.0 - vec2::dot(before, after));
    }
    0.5 * sharpest
}

/// Returns whether a curve is as straight as an edge.
fn is_straight(curve: &Curve) -> bool {
    let (Some(&from), Some(&to)) = (curve.points.first(), curve.points.last()) else {
        return false;
    };
    vec2::distance(from, to) > 0.995 * curve.length_px
}

/// The curve's resemblance to a circle: its turn and its deviation from the least-squares circle
/// (Kåsa, 1976).
fn roundness(curve: &Curve) -> f32 {
    let share = 1.0 / curve.points.len().max(1) as f32;
    let sum = (curve.points.iter()).fold([0.0; 2], |sum, &at| vec2::along(sum, at, share));
    let places = || curve.points.iter().map(move |&at| vec2::sub(at, sum));
    let (mut xx, mut xy, mut yy, mut xz, mut yz) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for [x, y] in places() {
        let z = x * x + y * y;
        (xx, xy, yy) = (xx + share * x * x, xy + share * x * y, yy + share * y * y);
        (xz, yz) = (xz + share * x * z, yz + share * y * z);
    }
    let determinant = 2.0 * (xx * yy - xy * xy);
    if determinant <= 1e-3 * (xx + yy) * (xx + yy) {
        return 0.0;
    }
    let middle = [
        (xz * yy - yz * xy) / determinant,
        (yz * xx - xz * xy) / determinant,
    ];
    let radius_px = (vec2::dot(middle, middle) + xx + yy).sqrt();
    let off = places().map(|at| {
        let off_px = vec2::distance(at, middle) - radius_px;
        share * off_px * off_px
    });
    let off = off.sum::<f32>().sqrt() / radius_px;
    let turn = curve.length_px / radius_px;
    grade(turn, ARC.0, ARC.1) * grade(off, EXACT.0, EXACT.1)
}

/// The share of a curve's two ends beyond which its color continues, so that the rope is longer
/// than the curve.
fn going_on(image: &Image, curve: &Curve, all: &[Across]) -> f32 {
    let (Some(first), Some(last)) = (all.first(), all.last()) else {
        return 0.0;
    };
    if curve.closed {
        return 0.0;
    }
    let points = &curve.points;
    let back = (points.len() / PLACES).clamp(1, points.len() - 1);
    let ends = [
        (points[0], points[back], first, 0),
        (
            points[points.len() - 1],
            points[points.len() - 1 - back],
            last,
            1,
        ),
    ];
    let goes_on = ends.iter().filter(|(tip, before, across, end)| {
        let along = vec2::unit_or(vec2::sub(*tip, *before), [1.0, 0.0]);
        !curve.border[*end] && across.goes_on(image, *tip, along, curve.width_px)
    });
    0.5 * goes_on.count() as f32
}
