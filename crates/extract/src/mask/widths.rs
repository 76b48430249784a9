//! Widths of a mask's ropes, measured at places along them, and the width that their faint edges
//! add.

use crate::bitmap::bits::BitPlane;
use crate::bitmap::components::for_each_run;
use crate::bitmap::edge_distance::EdgeDistance;
use crate::bitmap::strips::Strips;

/// Step between the rows in which widths are measured, and maximum number of widths.
const STRIDE: usize = 3;
const MOST_WIDTHS: usize = 2048;
/// Maximum length of a run of pixels that gets a single width; longer runs get several.
const LONGEST_PX: usize = 24;
/// Maximum distance from a pixel at which a rope's side is searched for.
const WIDEST_PX: usize = 128;

/// Memory and result of the step.
#[derive(Debug, Default)]
pub(crate) struct Widths {
    sure: EdgeDistance,
    all: EdgeDistance,
    /// Places where widths are measured, each with the number of pixels that it stands for: its
    /// share of the ropes' area.
    places: Vec<([usize; 2], f32)>,
    /// Widths along the ropes and what faint pixels add to them, weighted by area.
    widths: Vec<Weighted>,
    edges: Vec<Weighted>,
}

/// A mask in strips and in rows.
type Both<'a> = (&'a Strips, &'a BitPlane);

impl Widths {
    /// Measures the widths of the ropes in `sure`, and again with the pixels of `all`, which
    /// include those of `sure`.
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

    /// The width that a share of the ropes' area does not reach; 0 without ropes.
    pub(crate) fn width(&self, share: f32) -> f32 {
        quantile(&self.widths, share)
    }

    /// As [`width`](Self::width), for the part of the width that faint pixels add.
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

/// The measuring, compiled for each kind of machine.
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

/// Width of the rope around a pixel in its middle. A rope of an even number of pixels lacks a
/// middle pixel and measures too little, which the constant corrects on average.
#[inline(always)]
fn width_at(edge_distance: &EdgeDistance, rows: &BitPlane, [x, y]: [usize; 2]) -> f32 {
    2.0 * edge_distance.half_px(rows, x as u16, y as u16) + 0.25
}

/// Middle of a straight rope near the set pixel (x, y): that of its row's or its column's run,
/// whichever is shorter.
#[inline(always)]
fn middle(mask: &Strips, [x, y]: [usize; 2]) -> [usize; 2] {
    let (left, right) = mask.reach_along_row([x, y], WIDEST_PX);
    let across = left + right;
    // Most ropes are so thin that one reading of the column is enough.
    let (up, down, is_all) = mask.column([x, y]);
    if across < up + down {
        return [towards(x, left, right), y];
    } else if is_all {
        return [x, towards(y, up, down)];
    }
    // The column is followed only until it is longer than the row's run.
    let down = mask.reach_down([x, y], WIDEST_PX.min(across + 1));
    let up = mask.reach_up([x, y], WIDEST_PX.min(across + 1 - down));
    if across < up + down {
        [towards(x, left, right), y]
    } else {
        [x, towards(y, up, down)]
    }
}

/// Middle of a run with `before` pixels before `at` and `behind` after it, rounded toward `at`.
#[inline(always)]
fn towards(at: usize, before: usize, behind: usize) -> usize {
    if behind > before {
        at + (behind - before) / 2
    } else {
        at - (before - behind) / 2
    }
}

/// A value and its weight, both positive. Their bits have the same order as the values, so one
/// comparison sorts them.
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

/// Value below which `share` of the weights of the sorted `values` are; 0 without values.
fn quantile(values: &[Weighted], share: f32) -> f32 {
    let all: f32 = values.iter().map(|v| v.weight()).sum();
    let mut sum = 0.0;
    let found = values.iter().find(|v| {
        sum += v.weight();
        sum >= share * all
    });
    found.map_or(0.0, |v| v.value())
}
