//! Finds parts of a rope that moved farther than a chord search reaches, starting from their
//! neighbors.

use super::chord::Reader;
use super::rope::Rope;
use crate::vec2;

/// Maximum number of rounds in which the found parts extend to their neighbors.
const ROUNDS: usize = 16;
/// Number of points added in a round, at each end of a found part.
const STRIDE: usize = 4;
/// Number of points over which the gradient of the movement along the rope is measured.
const BASE: usize = 3;
/// Maximum movement of a point: in widths, plus pixels.
const FARTHEST: (f32, f32) = (4.0, 8.0);

impl Rope {
    /// Searches for the stations of the next frame that were not read. Stations that were read move
    /// to their readings.
    pub(super) fn chase(&mut self, reader: &Reader) {
        for _ in 0..ROUNDS {
            self.place_read();
            self.reach_out(0);
            self.reach_out(1);
            let found = |rope: &Self| rope.readings.iter().flatten().count();
            let before = found(self);
            self.read(reader);
            if found(self) <= before {
                break;
            }
        }
        self.place_read();
    }

    /// Moves each station that was read to its place, where it is then read again.
    fn place_read(&mut self) {
        for (station, reading) in self.next.iter_mut().zip(&self.readings) {
            if let Some(reading) = reading {
                let aside_px = reading.aside_px - station.bias_px[0];
                station.at = vec2::along(station.at, station.normal, aside_px);
            }
        }
    }

    /// Moves the points behind those that were read by extrapolating the movement. Points are
    /// counted from `end`.
    fn reach_out(&mut self, end: usize) {
        let most_px = FARTHEST.0 * self.width_px + FARTHEST.1;
        let n = self.next.len();
        let mut read = 0;
        for i in 0..n {
            if self.readings[self.place(end, i)].is_some() {
                read += 1;
                continue;
            }
            if read > BASE {
                let moved = |i: usize| {
                    let k = self.place(end, i);
                    vec2::sub(self.next[k].at, self.stations[k].at)
                };
                let [from, to] = [i - 1 - BASE, i - 1].map(moved);
                let change = vec2::scale(vec2::sub(to, from), 1.0 / BASE as f32);
                for step in 0..STRIDE.min(n - i) {
                    let k = self.place(end, i + step);
                    if self.readings[k].is_some() {
                        break;
                    }
                    let by = vec2::along(to, change, (step + 1) as f32);
                    let was = &self.stations[k];
                    if vec2::norm(by) <= most_px && !was.is_crossed {
                        let aside_px = vec2::dot(by, was.normal);
                        self.next[k].at = vec2::along(was.at, was.normal, aside_px);
                    }
                }
            }
            read = 0;
        }
    }
}
