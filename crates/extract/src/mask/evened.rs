//! Smooths the outline of a mask that was painted span by span. The outline frays where rope and
//! ground have similar colors, and the skeleton of a frayed outline has spurs.

use lariat_portable::{Arch, NullaryFnOnce};

use crate::image::gray::GrayPlane;

/// Reach of the filter in pixels, along the row and across it. The weights of the five pixels are
/// 1, 2, 2, 2, 1 eighths. A rope of three pixels keeps more than half of its level in the middle.
const REACH: usize = 2;
const ROWS: usize = 2 * REACH + 1;

/// Memory of the step.
#[derive(Debug, Default)]
pub(crate) struct Evener {
    /// A row, padded with copies of its first and last pixels.
    row: Vec<u16>,
    /// Some rows, each filtered along itself.
    rows: [Vec<u16>; ROWS],
}

impl Evener {
    /// Reserves the buffers for images of this width.
    pub(crate) fn reserve(&mut self, width: usize) {
        self.row.resize(width + 2 * REACH, 0);
        for row in &mut self.rows {
            row.resize(width, 0);
        }
    }

    /// Smooths `levels` in place.
    pub(crate) fn run(&mut self, levels: &mut GrayPlane) {
        self.reserve(levels.width());
        let evener = self;
        Arch::new().dispatch(Evened { evener, levels });
    }
}

struct Evened<'a> {
    evener: &'a mut Evener,
    levels: &'a mut GrayPlane,
}

impl NullaryFnOnce for Evened<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Evener { row, rows } = self.evener;
        let (width, height) = (self.levels.width(), self.levels.height());
        for y in 0..height + REACH {
            if y < height {
                let own = self.levels.row(y);
                let (before, rest) = row.split_at_mut(REACH);
                let (within, behind) = rest.split_at_mut(width);
                before.fill(u16::from(own[0]));
                behind.fill(u16::from(own[width - 1]));
                for (to, &from) in within.iter_mut().zip(own) {
                    *to = u16::from(from);
                }
                let shifted: [&[u16]; ROWS] = std::array::from_fn(|k| &row[k..k + width]);
                sum(shifted, &mut rows[y % ROWS]);
            }
            let Some(out) = y.checked_sub(REACH) else {
                continue;
            };
            let place = |k: usize| (out + k).saturating_sub(REACH).min(height - 1) % ROWS;
            let around: [&[u16]; ROWS] = std::array::from_fn(|k| &rows[place(k)][..width]);
            sum(around, &mut row[..width]);
            for (to, &from) in self.levels.row_mut(out).iter_mut().zip(&*row) {
                *to = (from / 64) as u8;
            }
        }
    }
}

/// Eight times the weighted mean of five rows.
#[inline(always)]
fn sum([a, b, c, d, e]: [&[u16]; ROWS], out: &mut [u16]) {
    let ends = a.iter().zip(e);
    let middle = b.iter().zip(c).zip(d);
    for ((out, (a, e)), ((b, c), d)) in out.iter_mut().zip(ends).zip(middle) {
        *out = a + e + 2 * (b + c + d);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The middle row of a smoothed plane whose rows are all equal.
    fn evened(row: &[u8]) -> Vec<u8> {
        let mut levels = GrayPlane::default();
        levels.resize(row.len(), 3);
        (0..3).for_each(|y| levels.row_mut(y).copy_from_slice(row));
        Evener::default().run(&mut levels);
        levels.row(1).to_vec()
    }

    #[test]
    fn a_pixel_gets_of_those_beside_it() {
        assert_eq!(
            evened(&[0, 0, 0, 64, 0, 0, 0, 0]),
            [0, 8, 16, 16, 16, 8, 0, 0]
        );
        assert_eq!(evened(&[200; 3]), [200; 3]);
        assert_eq!(evened(&[0, 80]), [30, 50]);
        assert_eq!(evened(&[255]), [255]);
    }

    #[test]
    fn spikes_go_and_ropes_stay() {
        let mut levels = GrayPlane::default();
        levels.resize(40, 20);
        (0..20).for_each(|y| {
            levels
                .row_mut(y)
                .fill(if (8..11).contains(&y) { 255 } else { 0 })
        });
        (0..8).for_each(|y| levels.row_mut(y)[20] = 255);
        Evener::default().run(&mut levels);
        let is_rope = |x: usize, y: usize| levels.row(y)[x] >= 128;
        assert!((0..40).all(|x| is_rope(x, 9)));
        assert!((0..6).all(|y| !is_rope(20, y)));
    }
}
