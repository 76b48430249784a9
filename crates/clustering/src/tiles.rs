//! Pixels grouped by square tiles of the picture. A question about a place is then asked once per
//! tile, and coordinates are small numbers.

use super::{Pixels, Run};

/// A tile's side in pixels. It is about a rope's width, so that a tile contains some hundred
/// pixels.
const SIDE: u16 = 16;
/// Each tile's pixels are padded to a multiple of this, the lanes of the widest register.
pub(crate) const LANES: usize = 16;

/// The pixels of one tile.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tile {
    /// Start of its pixels in the lists; a multiple of [`LANES`], as is `to`.
    pub(crate) from: usize,
    /// End of its pixels and padding, exclusive.
    pub(crate) to: usize,
    /// Middle of the tile, the origin of its pixels' coordinates.
    pub(crate) middle: [f32; 2],
    /// Minimum and maximum coordinates of its pixels.
    pub(crate) low: [f32; 2],
    pub(crate) high: [f32; 2],
}

/// All pixels, tile by tile.
#[derive(Debug, Default)]
pub(crate) struct Tiles {
    tiles: Vec<Tile>,
    /// Coordinates relative to the tile's middle.
    x: Vec<f32>,
    y: Vec<f32>,
    /// 1 for a pixel, 0 for padding, which repeats the last pixel.
    counts: Vec<f32>,
    /// For each tile of the current band: first the number of its pixels, then the index of the
    /// next one to store.
    places: Vec<usize>,
}

impl Tiles {
    /// Replaces the contents by these pixels.
    pub(crate) fn fill(&mut self, pixels: &Pixels) {
        self.tiles.clear();
        self.x.clear();
        self.y.clear();
        self.counts.clear();
        for band in pixels
            .runs()
            .chunk_by(|above, below| above.y / SIDE == below.y / SIDE)
        {
            self.count(band);
            self.lay_out(band[0].y / SIDE);
            self.place(band);
        }
        for tile in &mut self.tiles {
            for (axis, list) in [&self.x, &self.y].into_iter().enumerate() {
                for c in &list[tile.from..tile.to] {
                    tile.low[axis] = tile.low[axis].min(*c);
                    tile.high[axis] = tile.high[axis].max(*c);
                }
            }
        }
    }

    /// Returns the tiles that contain pixels.
    pub(crate) fn tiles(&self) -> &[Tile] {
        &self.tiles
    }

    /// Returns the pixels' x and y relative to the middle of their tile, and 1 for each pixel or 0
    /// for padding.
    pub(crate) fn lists(&self) -> [&[f32]; 3] {
        [&self.x, &self.y, &self.counts]
    }

    fn count(&mut self, band: &[Run]) {
        self.places.clear();
        for part in parts(band) {
            let column = usize::from(part.from / SIDE);
            if column >= self.places.len() {
                self.places.resize(column + 1, 0);
            }
            self.places[column] += usize::from(part.to - part.from);
        }
    }

    /// Allocates space for the band's pixels.
    fn lay_out(&mut self, row: u16) {
        let middle = |tile: usize| (usize::from(SIDE) * tile) as f32 + 0.5 * f32::from(SIDE - 1);
        for (column, place) in self.places.iter_mut().enumerate() {
            let (count, from) = (*place, self.x.len());
            *place = from;
            if count == 0 {
                continue;
            }
            let to = from + count.next_multiple_of(LANES);
            self.counts.resize(from + count, 1.0);
            self.counts.resize(to, 0.0);
            self.x.resize(to, f32::NAN);
            self.y.resize(to, f32::NAN);
            self.tiles.push(Tile {
                from,
                to,
                middle: [middle(column), middle(row.into())],
                low: [f32::INFINITY; 2],
                high: [f32::NEG_INFINITY; 2],
            });
        }
    }

    fn place(&mut self, band: &[Run]) {
        let half = 0.5 * f32::from(SIDE - 1);
        for part in parts(band) {
            let place = &mut self.places[usize::from(part.from / SIDE)];
            let y = f32::from(part.y % SIDE) - half;
            for x in part.from..part.to {
                self.x[*place] = f32::from(x % SIDE) - half;
                self.y[*place] = y;
                *place += 1;
            }
            // Padding repeats the last pixel; the tile's next pixel overwrites it.
            let end = place.next_multiple_of(LANES);
            let last = [self.x[*place - 1], self.y[*place - 1]];
            self.x[*place..end].fill(last[0]);
            self.y[*place..end].fill(last[1]);
        }
    }
}

/// Splits the runs at tile boundaries.
fn parts(band: &[Run]) -> impl Iterator<Item = Run> {
    band.iter().filter(|run| run.from < run.to).flat_map(|run| {
        (run.from / SIDE..=(run.to - 1) / SIDE).map(move |column| Run {
            y: run.y,
            from: run.from.max(column * SIDE),
            to: run.to.min((column * SIDE).saturating_add(SIDE)),
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn each_pixel_is_in_one_cell_and_counts_once(
            runs in prop::collection::vec((0..60u16, 0..80u16, 0..40u16), 0..60),
        ) {
            let mut pixels = Pixels::default();
            for (y, from, length) in runs {
                pixels.push(Run { y, from, to: from + length });
            }
            let mut tiles = Tiles::default();
            // The second pass reuses memory.
            for _ in 0..2 {
                tiles.fill(&pixels);
            }
            let mut found = Vec::new();
            let [x, y, counts] = tiles.lists();
            for tile in tiles.tiles() {
                prop_assert_eq!((tile.from % LANES, tile.to % LANES), (0, 0));
                for i in tile.from..tile.to {
                    for (axis, c) in [x[i], y[i]].into_iter().enumerate() {
                        prop_assert!((tile.low[axis]..=tile.high[axis]).contains(&c));
                        prop_assert!(c.abs() <= 7.5);
                    }
                    if counts[i] > 0.0 {
                        found.push([x[i] + tile.middle[0], y[i] + tile.middle[1]]);
                    }
                }
            }
            let places = pixels.xs().iter().zip(pixels.ys());
            let mut expected: Vec<_> = places.map(|(&x, &y)| [x, y]).collect();
            let order = |a: &[f32; 2], b: &[f32; 2]| a.partial_cmp(b).expect("numbers");
            found.sort_by(order);
            expected.sort_by(order);
            prop_assert_eq!(found, expected);
        }
    }

    #[test]
    fn the_last_column_of_all_is_a_cell_too() {
        let mut pixels = Pixels::default();
        pixels.push(Run {
            y: u16::MAX,
            from: u16::MAX - 1,
            to: u16::MAX,
        });
        let mut tiles = Tiles::default();
        tiles.fill(&pixels);
        assert_eq!(tiles.tiles().len(), 1);
    }
}
