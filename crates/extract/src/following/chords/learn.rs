//! Learns how a rope's chords read in the reference image, which is that of the full extraction.

use super::chord::Reader;
use super::rope::{LEAST_MEASURED, Rope, Tip};
use super::station::{Station, beyond, set_normals, table};
use crate::image::color;
use crate::scene::{Curve, Status};
use crate::vec2;

/// Range of rope widths, in pixels. A thinner rope may lack pixels with full contrast, and a chord
/// of a thicker one does not fit into a span.
const WIDTHS_PX: std::ops::RangeInclusive<f32> = 1.8..=36.0;
/// Minimum number of points for a shape that can be followed.
const LEAST_POINTS: usize = 16;
/// Maximum distance between points, in widths, as the space between them is not read.
const APART_WIDTHS: f32 = 2.0;
/// Maximum difference between the lengths of the rope and of a smooth curve through its points, as
/// a share. A larger one means that the points are too far apart for its bends.
const LENGTH: f32 = 0.002;
/// Number of points on either side over which a bias and a contrast are averaged.
const AROUND: usize = 4;
/// Maximum distance of a tip from its extrapolation, sideways, in widths.
const OFF_TIP: f32 = 0.15;
/// Maximum distance of the tip from where the difference falls to half, in widths.
const BEYOND_TIP: f32 = 0.5;
/// Maximum error at any point if the rope is followed into its own reference image: in pixels, or
/// in widths if that is more.
const OFF: (f32, f32) = (0.4, 0.04);

impl Rope {
    /// Takes over an extracted rope. Returns false if it cannot be followed.
    pub(super) fn anchor(&mut self, curve: &Curve) -> bool {
        let n = curve.points.len();
        let spacing_px = curve.length_px / (n.max(2) - 1) as f32;
        let plain = matches!(curve.status, Status::Ok | Status::Doubtful)
            && !curve.closed
            && curve.border == [false; 2];
        let fits = n >= LEAST_POINTS
            && WIDTHS_PX.contains(&curve.width_px)
            && spacing_px <= APART_WIDTHS * curve.width_px;
        if !plain || !fits {
            return false;
        }
        self.width_px = curve.width_px;
        self.stations.clear();
        self.stations
            .extend(
                (curve.points.iter().zip(&curve.widths_px)).map(|(&at, &width_px)| Station {
                    at,
                    width_px,
                    ..Station::default()
                }),
            );
        set_normals(&mut self.stations);
        self.length_px = self.lay.measure(self.stations.iter().map(|s| s.at));
        (self.length_px - curve.length_px).abs() <= LENGTH * curve.length_px
    }

    /// Learns how the chords read in the reference image. Returns false if they do not determine
    /// the rope.
    pub(super) fn learn(&mut self, reader: &Reader) -> bool {
        self.learn_contrast(reader);
        self.learn_biases(reader) && self.learn_tips(reader) && self.agrees(reader)
    }

    /// Returns whether the rope stays in place if it is followed into its own reference image.
    fn agrees(&mut self, reader: &Reader) -> bool {
        self.next.clone_from(&self.stations);
        if self.measure(reader).is_none() {
            return false;
        }
        let most_px = OFF.0.max(OFF.1 * self.width_px);
        let both = self.next.iter().zip(&self.stations);
        both.into_iter()
            .all(|(next, was)| vec2::distance(next.at, was.at) <= most_px)
    }

    /// Measures the rope's contrast at its points, averaged over their neighbors.
    fn learn_contrast(&mut self, reader: &Reader) {
        let yuv = color::is_yuv(reader.image.format());
        for station in &mut self.stations {
            let color = color::between(reader.image, station.at);
            station.contrast = color::distance(color, table(reader, station.at), yuv);
        }
        self.average(|s| Some(s.contrast), |s, mean| s.contrast = mean.max(2.0));
    }

    fn learn_biases(&mut self, reader: &Reader) -> bool {
        self.stations.iter_mut().for_each(|s| s.bias_px = [0.0; 2]);
        self.next.clone_from(&self.stations);
        self.read(reader);
        let mut measured = 0;
        for (station, reading) in self.stations.iter_mut().zip(&self.readings) {
            station.is_measured = reading.is_some();
            if let Some(reading) = reading {
                measured += 1;
                station.bias_px = [reading.aside_px, reading.width_px - station.width_px];
            }
        }
        for part in 0..2 {
            self.average(
                |s| s.is_measured.then_some(s.bias_px[part]),
                |s, mean| s.bias_px[part] = mean,
            );
        }
        measured as f32 >= LEAST_MEASURED * self.stations.len() as f32
    }

    fn learn_tips(&mut self, reader: &Reader) -> bool {
        self.tips = [Tip::default(); 2];
        let known: fn(&Station) -> bool = |s| s.is_measured;
        let ends = [
            self.stations.iter().position(known),
            self.stations.iter().rev().position(known),
        ];
        self.next.clone_from(&self.stations);
        for (end, unread) in ends.into_iter().enumerate() {
            let Some(unread) = unread.filter(|&unread| self.can_run_on(end, unread)) else {
                return false;
            };
            let (true_tip, normal) = (self.end(end, 0).at, self.end(end, 0).normal);
            self.run_on(end, unread);
            let run_on = self.next[self.place(end, 0)].at;
            self.tips[end].aside_px = vec2::dot(vec2::sub(true_tip, run_on), normal);
            let Some(beyond_px) = beyond(reader, &self.stations, end, self.width_px) else {
                return false;
            };
            self.tips[end].beyond_px = beyond_px;
            let [off, beyond] = [OFF_TIP, BEYOND_TIP].map(|widths| widths * self.width_px);
            if self.tips[end].aside_px.abs() > off || beyond_px.abs() > beyond {
                return false;
            }
        }
        true
    }

    /// Sets a value of each station to the mean over its neighbors.
    fn average(
        &mut self,
        of: impl Fn(&Station) -> Option<f32>,
        mut put: impl FnMut(&mut Station, f32),
    ) {
        let n = self.stations.len();
        self.next.clone_from(&self.stations);
        for (i, station) in self.stations.iter_mut().enumerate() {
            let around = &self.next[i.saturating_sub(AROUND)..(i + AROUND + 1).min(n)];
            let (sum, count) = (around.iter().filter_map(&of))
                .fold((0.0, 0), |(sum, count), value| (sum + value, count + 1));
            put(station, if count > 0 { sum / count as f32 } else { 0.0 });
        }
    }
}
