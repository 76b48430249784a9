//! The bounding box of all pixels, which centers never need to leave.

use super::Pixels;

/// Minimum and maximum coordinates, x and y.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    low: [f32; 2],
    high: [f32; 2],
}

impl Extent {
    /// Computes the bounding box; `None` without pixels.
    pub(crate) fn of(pixels: &Pixels) -> Option<Self> {
        let mut extent = Self {
            low: [f32::INFINITY; 2],
            high: [f32::NEG_INFINITY; 2],
        };
        for run in pixels.runs().iter().filter(|run| run.from < run.to) {
            for (axis, [from, to]) in [[run.from, run.to - 1], [run.y, run.y]]
                .into_iter()
                .enumerate()
            {
                extent.low[axis] = extent.low[axis].min(f32::from(from));
                extent.high[axis] = extent.high[axis].max(f32::from(to));
            }
        }
        (extent.low[0] <= extent.high[0]).then_some(extent)
    }

    /// Returns the middle of the box.
    pub(crate) fn middle(&self) -> [f32; 2] {
        [0, 1].map(|axis| 0.5 * (self.low[axis] + self.high[axis]))
    }

    /// Moves each center to the nearest point of the box.
    pub(crate) fn confine(&self, centers: &mut [[f32; 2]]) {
        for center in centers {
            for (axis, c) in center.iter_mut().enumerate() {
                *c = c.clamp(self.low[axis], self.high[axis]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Run;

    #[test]
    fn centers_are_brought_to_the_nearest_point_of_the_box() {
        let mut pixels = Pixels::default();
        assert!(Extent::of(&pixels).is_none());
        for (y, from, to) in [(3, 5, 9), (4, 2, 3), (4, 7, 7)] {
            pixels.push(Run { y, from, to });
        }
        let mut centers = [[-1.0, 3.5], [9.0, 9.0], [2.5, 3.0]];
        let extent = Extent::of(&pixels).expect("there are pixels");
        extent.confine(&mut centers);
        assert_eq!(centers, [[2.0, 3.5], [8.0, 4.0], [2.5, 3.0]]);
    }
}
