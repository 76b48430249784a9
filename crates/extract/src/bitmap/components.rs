//! Connected components of a bit plane, found from its runs. Used to drop specks and fill pinholes.
//!
//! He, Chao and Suzuki, "A run-based two-scan labeling algorithm" (2008): rows are cut into runs. A
//! union-find joins runs that touch runs of the row above, and the root identifies the component.
//! The number of runs is bounded: an image with more is noise, not ropes.

use super::bits::BitPlane;

/// Memory of the labeling.
#[derive(Debug, Default)]
pub(crate) struct Components {
    runs: Vec<Run>,
    /// For each run, another run of its component; a root points to itself.
    parent: Vec<u32>,
    /// For each root, the component's number of pixels, and whether it touches the image's edge.
    area: Vec<u32>,
    at_edge: Vec<bool>,
}

#[derive(Clone, Copy, Debug)]
struct Run {
    y: u16,
    from: u16,
    to: u16,
}

/// The plane has more runs than a picture of ropes.
#[derive(Debug)]
pub(crate) struct TooManyRuns;

/// Maximum number of runs in a plane of this size: one per 16 pixels, plus some for tiny planes.
pub(crate) fn budget(width: usize, height: usize) -> usize {
    width * height / 16 + 1024
}

impl Components {
    /// Reserves memory for planes of this size.
    pub(crate) fn reserve(&mut self, width: usize, height: usize) {
        // The last row that is read may exceed the budget.
        let runs = budget(width, height) + width;
        self.runs.clear();
        self.runs.reserve(runs);
        for numbers in [&mut self.parent, &mut self.area] {
            numbers.clear();
            numbers.reserve(runs);
        }
        self.at_edge.clear();
        self.at_edge.reserve(runs);
    }

    /// Clears components (pixels that touch by side or corner) of fewer than `least` pixels.
    pub(crate) fn drop_specks(
        &mut self,
        plane: &mut BitPlane,
        least: u32,
    ) -> Result<(), TooManyRuns> {
        self.label(plane, true)?;
        for i in 0..self.runs.len() {
            let root = find(&mut self.parent, i as u32) as usize;
            if self.area[root] < least {
                self.paint(plane, i, false);
            }
        }
        Ok(())
    }

    /// Sets holes (unset pixels that touch by their sides) of at most `most` pixels that do not
    /// touch the image's edge.
    pub(crate) fn fill_holes(
        &mut self,
        plane: &mut BitPlane,
        most: u32,
    ) -> Result<(), TooManyRuns> {
        self.label(plane, false)?;
        for i in 0..self.runs.len() {
            let root = find(&mut self.parent, i as u32) as usize;
            if self.area[root] <= most && !self.at_edge[root] {
                self.paint(plane, i, true);
            }
        }
        Ok(())
    }

    /// Finds the components of a plane and lists the names of the `most` largest, the largest
    /// first.
    pub(crate) fn largest(
        &mut self,
        plane: &BitPlane,
        most: usize,
        names: &mut Vec<u32>,
    ) -> Result<(), TooManyRuns> {
        names.clear();
        self.label(plane, true)?;
        let roots = (0..self.runs.len() as u32).filter(|&i| self.parent[i as usize] == i);
        names.extend(roots);
        let area = |&name: &u32| (std::cmp::Reverse(self.area[name as usize]), name);
        names.sort_unstable_by_key(area);
        names.truncate(most);
        Ok(())
    }

    /// Calls `run` with each run of component `name`, in row order: the row, the first pixel, and
    /// one past the last.
    pub(crate) fn for_each_run_of(&mut self, name: u32, mut run: impl FnMut(u16, u16, u16)) {
        for i in 0..self.runs.len() {
            if find(&mut self.parent, i as u32) == name {
                let Run { y, from, to } = self.runs[i];
                run(y, from, to);
            }
        }
    }

    fn paint(&self, plane: &mut BitPlane, run: usize, value: bool) {
        let Run { y, from, to } = self.runs[run];
        plane.fill(usize::from(y), usize::from(from), usize::from(to), value);
    }

    /// Labels the components of pixels that equal `value`: 8-connected for set pixels, 4-connected
    /// for unset ones.
    fn label(&mut self, plane: &BitPlane, value: bool) -> Result<(), TooManyRuns> {
        self.runs.clear();
        self.parent.clear();
        let budget = budget(plane.width(), plane.height());
        let (mut above_from, mut above_to) = (0, 0);
        for y in 0..plane.height() {
            let first = self.runs.len();
            for_each_run(plane, y, value, |from, to| {
                self.runs.push(Run {
                    y: y as u16,
                    from: from as u16,
                    to: to as u16,
                });
            });
            if self.runs.len() > budget {
                return Err(TooManyRuns);
            }
            self.parent.extend(first as u32..self.runs.len() as u32);
            self.join_rows(above_from..above_to, first, u16::from(value));
            (above_from, above_to) = (first, self.runs.len());
        }
        self.measure(plane);
        Ok(())
    }

    /// Joins the last row's runs with touching runs of the row above. With `reach` 1, corners
    /// count.
    fn join_rows(&mut self, above: std::ops::Range<usize>, first: usize, reach: u16) {
        let mut upper = above.start;
        for i in first..self.runs.len() {
            let Run { from, to, .. } = self.runs[i];
            while upper < above.end && self.runs[upper].to + reach <= from {
                upper += 1;
            }
            let mut j = upper;
            while j < above.end && self.runs[j].from < to + reach {
                let (a, b) = (
                    find(&mut self.parent, i as u32),
                    find(&mut self.parent, j as u32),
                );
                self.parent[a.max(b) as usize] = a.min(b);
                j += 1;
            }
        }
    }

    fn measure(&mut self, plane: &BitPlane) {
        let (width, height) = (plane.width() as u16, plane.height() as u16);
        self.area.clear();
        self.area.resize(self.runs.len(), 0);
        self.at_edge.clear();
        self.at_edge.resize(self.runs.len(), false);
        for i in 0..self.runs.len() {
            let root = find(&mut self.parent, i as u32) as usize;
            let Run { y, from, to } = self.runs[i];
            self.area[root] += u32::from(to - from);
            self.at_edge[root] |= y == 0 || y + 1 == height || from == 0 || to == width;
        }
    }
}

fn find(parent: &mut [u32], mut i: u32) -> u32 {
    while parent[i as usize] != i {
        parent[i as usize] = parent[parent[i as usize] as usize];
        i = parent[i as usize];
    }
    i
}

/// Calls `run(from, to)` for each maximal run of pixels of row `y` that equal `value`.
pub(crate) fn for_each_run(
    plane: &BitPlane,
    y: usize,
    value: bool,
    mut run: impl FnMut(usize, usize),
) {
    let flip = if value { 0 } else { u64::MAX };
    let width = plane.width();
    let row = plane.row(y);
    let mut open = None;
    for (i, &word) in row.iter().enumerate() {
        let word = word ^ flip;
        let base = 64 * i;
        match (word, open) {
            (0, None) | (u64::MAX, Some(_)) => continue,
            _ => {}
        }
        let mut bit = 0;
        while bit < 64 {
            let rest = if open.is_some() { !word } else { word } >> bit;
            if rest == 0 {
                break;
            }
            bit += rest.trailing_zeros() as usize;
            match open.take() {
                Some(from) => run(from, (base + bit).min(width)),
                None => open = Some(base + bit),
            }
        }
    }
    // Flipped, the unset bits past the width read as set, so the run ends at the width.
    if let Some(from) = open
        && from < width
    {
        run(from, width);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use imageproc::region_labelling::{Connectivity, connected_components};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn specks_and_holes_agree_with_an_independent_labeling(
            width in 1usize..140, height in 1usize..16,
            bits in proptest::collection::vec(any::<u64>(), 64), limit in 1u32..12,
        ) {
            let set = |x: usize, y: usize| bits[(y * 3 + x / 64) % 64] >> (x % 64) & 1 == 1;
            let mut plane = BitPlane::default();
            plane.resize(width, height);
            // With one more empty row, because imageproc panics on a picture of one set pixel.
            let mut picture = image::GrayImage::new(width as u32, height as u32 + 1);
            for y in 0..height {
                for x in 0..width {
                    if set(x, y) {
                        plane.fill(y, x, x + 1, true);
                        picture.put_pixel(x as u32, y as u32, image::Luma([255]));
                    }
                }
            }
            let labels = connected_components(&picture, Connectivity::Eight, image::Luma([0]));
            let mut areas = std::collections::HashMap::new();
            labels.pixels().for_each(|p| *areas.entry(p[0]).or_insert(0u32) += 1);
            prop_assert!(Components::default().drop_specks(&mut plane, limit).is_ok());
            for (x, y, label) in labels.enumerate_pixels().filter(|&(_, y, _)| y < height as u32) {
                let stays = label[0] != 0 && areas[&label[0]] >= limit;
                prop_assert_eq!(plane.get(x as i32, y as i32), stays);
            }
        }
    }

    #[test]
    fn a_hole_is_filled_and_a_bay_is_not() {
        let mut plane = BitPlane::default();
        plane.resize(70, 5);
        (0..5).for_each(|y| plane.fill(y, 60, 70, true));
        plane.fill(2, 63, 66, false);
        plane.fill(0, 61, 62, false);
        assert!(Components::default().fill_holes(&mut plane, 3).is_ok());
        assert!(plane.get(64, 2));
        assert!(!plane.get(61, 0));
    }
}
