//! How wide the ropes of a mask are, taken at places along them, and how much wider with their faint edges.

use crate::bitmap::bits::BitPlane;
use crate::bitmap::components::for_each_run;
use crate::bitmap::edge_distance::EdgeDistance;
use crate::bitmap::strips::Strips;

/// Rows from one that the width is taken in to the next, and the most widths that are taken.
const STRIDE: usize = 3;
const MOST_WIDTHS: usize = 2048;
/// Of a longer run of pixels several widths are taken.
const LONGEST_PX: usize = 24;
/// How far a rope's side is sought from a pixel.
const WIDEST_PX: usize = 128;

/// Memory and result of the step.
#[derive(Debug, Default)]
pub(crate) struct Widths {
    sure: EdgeDistance,
    all: EdgeDistance,
    /// Where widths are taken, each with the pixels that it stands for: their share of the ropes' area.
    places: Vec<([usize; 2], f32)>,
    /// Widths along the ropes and what faint pixels add to them, weighted by area.
    widths: Vec<Weighted>,
    edges: Vec<Weighted>,
}

/// A mask in strips and in rows.
type Both<'a> = (&'a Strips, &'a BitPlane);

impl Widths {
    /// Takes the widths of the ropes in `sure`, and of those in `all`, which has all of its pixels.
    pub(crate) fn take(&mut self, sure: Both, all: Both) {
        self.sure.take(sure.0);
        self.all.take(all.0);
        self.find_places(sure.1);
        for weighted in [&mut self.widths, &mut self.edges] {
            weighted.clear();
            weighted.reserve(MOST_WIDTHS);
        }
        lariat_portable::Arch::new().dispatch(Measure {
            widths: self,
            sure,
            all,
        });
        self.widths.sort_unstable();
        self.edges.sort_unstable();
    }

    /// The width below which this share of the ropes' area lies; 0 of nothing.
    pub(crate) fn width(&self, share: f32) -> f32 {
        quantile(&self.widths, share)
    }

    /// The same of what faint pixels add to the width.
    pub(crate) fn edge(&self, share: f32) -> f32 {
        quantile(&self.edges, share)
    }

    fn find_places(&mut self, rows: &BitPlane) {
        self.places.clear();
        self.places.reserve(MOST_WIDTHS);
        for y in (0..rows.height()).step_by(STRIDE) {
            for_each_run(rows, y, true, |from, to| {
                let count = (to - from).div_ceil(LONGEST_PX);
                let area = (to - from) as f32 / count as f32;
                for k in 0..count.min(MOST_WIDTHS - self.places.len()) {
                    let x = from as f32 + (k as f32 + 0.5) * area;
                    self.places.push(([x as usize, y], area));
                }
            });
        }
    }

    #[inline(always)]
    fn measure(&mut self, sure: Both, all: Both) {
        for &(place, area) in &self.places {
            let [x, y] = middle(sure.0, place);
            let sure_px = width_at(&self.sure, sure.1, [x, y]);
            let [x, y] = middle(all.0, [x, y]);
            let all_px = width_at(&self.all, all.1, [x, y]);
            self.widths.push(Weighted::new(all_px, area));
            let edge_px = (all_px - sure_px).max(0.0);
            self.edges.push(Weighted::new(edge_px, area));
        }
    }
}

/// The measuring, to be compiled for each kind of machine.
struct Measure<'a> {
    widths: &'a mut Widths,
    sure: Both<'a>,
    all: Both<'a>,
}

impl lariat_portable::NullaryFnOnce for Measure<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.widths.measure(self.sure, self.all);
    }
}

/// The width of the rope about a pixel in its middle. An even number of pixels has none there: half a pixel is lacking
/// then, a quarter in the mean.
#[inline(always)]
fn width_at(edge_distance: &EdgeDistance, rows: &BitPlane, [x, y]: [usize; 2]) -> f32 {
    2.0 * edge_distance.half_px(rows, x as u16, y as u16) + 0.25
}

/// The middle of a straight rope near the set pixel (x, y): that of its row's or its column's run, the shorter of the two.
#[inline(always)]
fn middle(mask: &Strips, [x, y]: [usize; 2]) -> [usize; 2] {
    let (left, right) = mask.reach_along_row([x, y], WIDEST_PX);
    let across = left + right;
    // Most ropes are thin enough to be seen at once.
    let (up, down, is_all) = mask.column([x, y]);
    if across < up + down {
        return [towards(x, left, right), y];
    } else if is_all {
        return [x, towards(y, up, down)];
    }
    // The column is followed only until it is longer.
    let down = mask.reach_down([x, y], WIDEST_PX.min(across + 1));
    let up = mask.reach_up([x, y], WIDEST_PX.min(across + 1 - down));
    if across < up + down {
        [towards(x, left, right), y]
    } else {
        [x, towards(y, up, down)]
    }
}

/// The middle between so many pixels before `at` and so many behind it, from `at` rounded.
#[inline(always)]
fn towards(at: usize, before: usize, behind: usize) -> usize {
    if behind > before {
        at + (behind - before) / 2
    } else {
        at - (before - behind) / 2
    }
}

/// A value and its weight, both positive: as bits they stand in the same order, and one comparison sorts them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Weighted(u64);

impl Weighted {
    #[inline(always)]
    fn new(value: f32, weight: f32) -> Self {
        Self(u64::from(value.to_bits()) << 32 | u64::from(weight.to_bits()))
    }

    fn value(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }

    fn weight(self) -> f32 {
        f32::from_bits(self.0 as u32)
    }
}

/// The value below which `share` of the weights of sorted `values` lie; 0 of nothing.
fn quantile(values: &[Weighted], share: f32) -> f32 {
    let all: f32 = values.iter().map(|v| v.weight()).sum();
    let mut sum = 0.0;
    let found = values.iter().find(|v| {
        sum += v.weight();
        sum >= share * all
    });
    found.map_or(0.0, |v| v.value())
}
