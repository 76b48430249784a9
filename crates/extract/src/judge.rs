//! The judge: the probability that a curve is a rope, whole and in order, and what the curve is
//! otherwise. It judges the finished curve against its image, whatever made the mask.
//!
//! At two dozen places along the curve, the image is read across it, once. The findings there, the
//! shape of the curve, its tips and the other curves become numbers between 0 and 1
//! ([`Evidence`]). Each other [`Class`] has odds against the rope: the exponential of a weighted
//! sum of these numbers (multinomial logistic regression). The weights are fitted to pictures with
//! known truth ([`weights`]).

mod across;
mod others;
pub(crate) mod remainder;
mod shape;
mod tips;
mod weights;

use crate::bitmap::bits::BitPlane;
use crate::image::gray::GrayPlane;
use crate::image::{Image, color};
use crate::mask::background::Background;
use crate::mask::shadow;
use crate::notice::Notice;
use crate::scene::{Curve, Status};
use crate::statistics::{grade, median, quantile};
use crate::vec2::{self, Vec2};
use across::{Across, Place};

/// Number of places along a curve that are read.
const PLACES: usize = 24;
/// Number of clues for or against a curve.
const CLUES: usize = Clue::Beyond as usize + 1;
/// Minimum step at an edge: in levels, plus multiples of the ground's own variation. Camera noise
/// changes a mean by less.
const EDGE: (f32, f32) = (6.0, 1.5);
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

/// The class of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Class {
    /// A rope, whole and in order.
    Rope,
    /// A part of a rope, or parts of several.
    Fragment,
    /// The shadow of a rope.
    Shadow,
    /// A pen, or another straight and short body.
    Pen,
    /// Print, or another small mark.
    Mark,
    /// The edge of a surface, or a strip at the picture's border.
    Edge,
    /// The rim of something round.
    Rim,
}

impl Class {
    /// All classes but [`Rope`](Self::Rope), in the order of their weights.
    pub const OTHERS: [Self; 6] = [
        Self::Fragment,
        Self::Shadow,
        Self::Pen,
        Self::Mark,
        Self::Edge,
        Self::Rim,
    ];

    /// The notice about a curve that is more likely of this class than a rope.
    pub(crate) fn notice(self) -> Option<Notice> {
        match self {
            Self::Rope => None,
            Self::Fragment => Some(Notice::Unsure),
            Self::Shadow => Some(Notice::MaybeShadow),
            Self::Pen => Some(Notice::LikeAPen),
            Self::Mark => Some(Notice::LikeAMark),
            Self::Edge => Some(Notice::LikeAnEdge),
            Self::Rim => Some(Notice::LikeARim),
        }
    }
}

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
    /// 1 for a straight curve.
    Straight,
    /// 1 for an arc of half a turn or more, or a closed ellipse, like a rim.
    Round,
    /// 1 for a straight or round curve without variation of light across it, such as a print, an
    /// edge, a bar or a rim. A taut rope is round in its section.
    Flat,
    /// Share of the curve that runs along the picture's border.
    Strip,
    /// Share of places without any edge, as far as it exceeds one half: the picture does not show
    /// the curve.
    Faint,
    /// The longest stretch without edges, as far as it exceeds that of a crossing.
    Stretch,
    /// Variation of light across the curve, in a network's mask: a rope is round, print is flat.
    Relief,
    /// Share of places that have the table's color in less light.
    Dim,
    /// Share of the curve that is a copy of the ropes, moved by one step, in less light.
    Cast,
    /// The longest other curve is longer, and has another color or width.
    Lesser,
    /// Number of other small things that are alike.
    Alike,
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

impl Maker {
    /// The classes that a curve of this maker's masks can have, except for a rope. Masks that the
    /// user gave show ropes only.
    pub fn others(self) -> &'static [Class] {
        match self {
            Self::Own | Self::Network => &Class::OTHERS,
            Self::Color | Self::Elsewhere => &Class::OTHERS[..1],
        }
    }

    /// The weights of the clues for each of these classes.
    fn weights(self) -> &'static [[f32; CLUES]] {
        match self {
            Self::Own => &weights::OWN,
            Self::Color => &weights::COLOR,
            Self::Network => &weights::NETWORK,
            Self::Elsewhere => &weights::ELSEWHERE,
        }
    }
}

/// The evidence for and against a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evidence {
    /// Numbers from 0 to 1, explained in [`MEANINGS`](Self::MEANINGS).
    pub clues: [f32; CLUES],
    /// The maker of the mask.
    pub maker: Maker,
}

/// The judgement of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict {
    /// The probability that the curve is a rope, whole and in order.
    pub confidence: f32,
    /// The most likely class besides a rope.
    pub other: Class,
}

impl Default for Evidence {
    fn default() -> Self {
        let (clues, maker) = ([0.0; CLUES], Maker::default());
        Self { clues, maker }
    }
}

impl Evidence {
    /// The meaning of each number, and the sign that its weights may have: 1 if it can only speak
    /// for a rope, −1 if only against one, 0 for both. A weight of the other sign would be an
    /// accident of the pictures it was fitted to.
    pub const MEANINGS: [(&'static str, i8); CLUES] = [
        ("constant", 0),
        ("unevenness of the width", -1),
        ("unlikeness of colour along the curve", -1),
        ("unlikeness of the two sides", -1),
        ("length in widths", 1),
        ("thinness", -1),
        ("bends", -1),
        ("straight", -1),
        ("an arc of a circle", -1),
        ("straight or an arc, and flat", -1),
        ("along the border", -1),
        ("not shown by the picture", -1),
        ("a stretch without edges", -1),
        ("light and shade across it", 1),
        ("the table in less light", -1),
        ("a copy of the ropes in less light", -1),
        ("unlike a longer one", -1),
        ("small things alike", -1),
        ("ends that go on", -1),
        ("tips at a strand", -1),
        ("tips that continue beyond a gap", -1),
        ("ends at the border", 0),
        ("crossings", -1),
        ("left out of the mask", -1),
        ("seen in part", -1),
        ("surely seen by the network", 1),
        ("seen by the network beyond its tips", -1),
    ];

    /// Returns whether the picture shows the curve. A mask of something that the picture does not
    /// show is a guess, even if it is right.
    pub fn is_shown(&self) -> bool {
        self.clues[Clue::Faint as usize] < 0.5
    }

    /// The judgement of a curve with this evidence. If `is_known`, it was a rope before and can
    /// only be a fragment otherwise.
    pub fn verdict(&self, is_known: bool) -> Verdict {
        let (mut odds, mut other, mut most) = (0.0, Class::Fragment, f32::NEG_INFINITY);
        for (&class, weights) in self.maker.others().iter().zip(self.maker.weights()) {
            if is_known && class != Class::Fragment {
                continue;
            }
            let sum: f32 = self.clues.iter().zip(weights).map(|(x, w)| x * w).sum();
            odds += libm::expf(sum);
            if sum > most {
                (other, most) = (class, sum);
            }
        }
        Verdict {
            confidence: 1.0 / (1.0 + odds),
            other,
        }
    }

    /// Adds what is known of the curve after it was tracked: its crossings, and whether it is seen
    /// in part.
    pub(crate) fn track(&mut self, curve: &Curve, crossings: usize, sees_covers: bool) {
        let share = |is: bool| f32::from(u8::from(is));
        let points = curve.points.len().max(1) as f32;
        let hidden = curve.hidden.iter().filter(|&&hidden| hidden).count() as f32 / points;
        // A bridged rope counts as whole, if the mask distinguishes a cover over a rope from a gap
        // in it.
        let bridged = share(sees_covers) * grade(hidden, BRIDGED.0, BRIDGED.1);
        self.clues[Clue::Partial as usize] =
            share(curve.status == Status::Partial) * (1.0 - bridged);
        self.clues[Clue::Crossings as usize] = of(crossings as f32, 3.0);
    }
}

/// Knowledge besides the curves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Context<'a> {
    pub(crate) image: &'a Image<'a>,
    pub(crate) maker: Maker,
    /// The table, if the mask is made from the image's difference from it, and so shows what covers
    /// a rope.
    pub(crate) table: Option<&'a Background>,
    /// Pixels that may be the ropes' shadow, if there are any.
    pub(crate) cast: Option<&'a BitPlane>,
    /// The network's output for each pixel, if the network made the mask.
    pub(crate) likely: Option<&'a GrayPlane>,
}

/// The evidence for curve `i` of a picture, before it is tracked. `colors` are the curves' colors,
/// and `left_out` is the remainder of the mask next to this one, in squares of the ropes' width
/// ([`Remainder::beside`](remainder::Remainder::beside)).
pub(crate) fn evidence(
    (curves, colors): (&[Curve], impl Fn(usize) -> [f32; 3]),
    i: usize,
    left_out: f32,
    context: &Context,
) -> Evidence {
    let (curve, image) = (&curves[i], context.image);
    let points = curve.points.len().max(1) as f32;
    let mut clues = [0.0; CLUES];
    let mut set = |clue: Clue, value: f32| clues[clue as usize] = value;
    set(Clue::Constant, 1.0);
    set(Clue::Uneven, unevenness(curve));
    let widths = curve.length_px / curve.width_px.max(1.0);
    let length = libm::logf(widths.clamp(1.0, LONGEST)) / libm::logf(LONGEST);
    set(Clue::Length, length);
    set(Clue::Thin, (1.0 - curve.width_px / 8.0).clamp(0.0, 1.0));
    set(Clue::Bends, shape::bends(curve));
    let straight = shape::straightness(curve);
    set(Clue::Straight, straight);
    let round = shape::roundness(curve);
    set(Clue::Round, round);
    let size_px = [image.width(), image.height()].map(|side| side as f32);
    set(Clue::Strip, shape::along_border(curve, size_px));
    set(Clue::LeftOut, of(left_out, 1.5));
    set(Clue::Met, tips::met(curves, i));
    set(Clue::Torn, tips::torn(curves, i));
    let at_border = curve.border.iter().filter(|&&border| border).count();
    set(Clue::Border, 0.5 * at_border as f32);
    let yuv = color::is_yuv(image.format());
    let beside = others::beside(curves, i, |a, b| color::distance(colors(a), colors(b), yuv));
    set(Clue::Lesser, beside.lesser);
    set(Clue::Alike, of(beside.alike as f32, 3.0));
    if let Some(plane) = context.cast {
        set(Clue::Cast, shape::share_within(curve, plane));
    }
    if let Some(table) = context.table {
        set(Clue::Dim, dimness(image, table, curve));
    }
    let relief = read(image, curve, &mut clues);
    let mut set = |clue: Clue, value: f32| clues[clue as usize] = value;
    set(
        Clue::Flat,
        straight.max(round) * (1.0 - 2.0 * relief).max(0.0),
    );
    if let Some(likely) = context.likely {
        // The network mistakes many prints for ropes. A flat object that is bent and on a plain
        // table may well be a rope.
        set(Clue::Relief, relief);
        let is_seen = |at: &&Vec2| likely.sample(**at) >= SEEN;
        let seen = curve.points.iter().filter(is_seen).count() as f32 / points;
        set(Clue::Seen, seen);
        set(Clue::Beyond, tips::beyond(likely, curve) / 255.0);
    }
    Evidence {
        clues,
        maker: context.maker,
    }
}

/// The share of a curve inside the image that is the table in less light.
fn dimness(image: &Image, table: &Background, curve: &Curve) -> f32 {
    let size = [image.width(), image.height()].map(|side| side as f32);
    let (mut dim, mut asked) = (0.0, 0.0f32);
    for i in places(curve) {
        let at = curve.points[i];
        if (0..2).all(|k| (0.0..size[k]).contains(&at[k])) {
            let light = shadow::light_left(image, table, at.map(|c| c as usize));
            dim += f32::from(u8::from(light.is_some_and(|light| light < 1.0)));
            asked += 1.0;
        }
    }
    dim / asked.max(1.0)
}

/// Maps a number without an upper limit to one below 1, with ½ at `half`.
fn of(value: f32, half: f32) -> f32 {
    value / (value + half)
}

/// Fills in the clues from the colors across and along the curve. Returns the variation of light
/// across it.
fn read(image: &Image, curve: &Curve, clues: &mut [f32; CLUES]) -> f32 {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::PixelFormat;
    use proptest::prelude::*;

    const SIDE: usize = 64;
    const MAKERS: [Maker; 4] = [Maker::Own, Maker::Color, Maker::Network, Maker::Elsewhere];

    fn evidence(clues: &[f32], maker: Maker) -> Evidence {
        let mut evidence = Evidence {
            maker,
            ..Evidence::default()
        };
        evidence.clues.copy_from_slice(clues);
        evidence.clues[Clue::Constant as usize] = 1.0;
        evidence
    }

    proptest! {
        #[test]
        fn a_clue_changes_the_confidence_only_in_its_direction(
            clues in proptest::collection::vec(0.0f32..1.0, CLUES),
            clue in 1..CLUES, maker in 0..MAKERS.len(), is_known: bool,
        ) {
            let at = |value: f32| {
                let mut evidence = evidence(&clues, MAKERS[maker]);
                evidence.clues[clue] = value;
                evidence.verdict(is_known).confidence
            };
            let (name, sign) = Evidence::MEANINGS[clue];
            let gain = f32::from(sign) * (at(1.0) - at(0.0));
            prop_assert!(sign == 0 || gain >= 0.0, "{}: {}", name, gain);
        }

        #[test]
        fn what_was_a_rope_before_can_only_be_a_fragment_of_one(
            clues in proptest::collection::vec(0.0f32..1.0, CLUES), maker in 0..MAKERS.len(),
        ) {
            let evidence = evidence(&clues, MAKERS[maker]);
            let [new, known] = [false, true].map(|is_known| evidence.verdict(is_known));
            prop_assert_eq!(known.other, Class::Fragment);
            prop_assert!(known.confidence >= new.confidence);
        }
    }

    #[test]
    fn what_lies_outside_of_the_image_does_not_say_whether_a_curve_is_shadow() {
        let [light, dim] = [200, 120].map(|level| vec![level; 3 * SIDE * SIDE]);
        let [light, dim] = [&light, &dim].map(|bytes| {
            let image = Image::new(bytes, SIDE, SIDE, 3 * SIDE, PixelFormat::Rgb8);
            image.expect("a whole image")
        });
        let mut table = Background::default();
        table.estimate(&light);
        for first in [-30, 30] {
            let points = (first..first + 64).map(|x| [x as f32, 70.0 - x as f32]);
            let curve = Curve {
                points: points.collect(),
                hidden: vec![false; 64],
                ..Curve::default()
            };
            assert_eq!(dimness(&dim, &table, &curve), 1.0, "{first}");
            assert_eq!(dimness(&light, &table, &curve), 0.0, "{first}");
        }
    }
}
