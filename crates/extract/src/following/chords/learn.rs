//! What is learnt of a rope in the image that it was extracted from: how its chords read there.

use super::chord::Reader;
use super::rope::{LEAST_MEASURED, Rope, Tip};
use super::station::{Station, beyond, set_normals, table};
use crate::image::color;
use crate::scene::{Curve, Status};
use crate::vec2;

/// Ropes of these widths, in pixels: of thinner ones no pixel need have the contrast, and of thicker ones a chord does not
/// fit into a span.
const WIDTHS_PX: std::ops::RangeInclusive<f32> = 1.8..=36.0;
/// Fewer points than this are no shape to follow.
const LEAST_POINTS: usize = 16;
/// The farthest that points may lie apart, in widths: what lies between them is not looked at.
const APART_WIDTHS: f32 = 2.0;
/// A smooth curve through the points is as long as the rope, up to this share: or they lie too far apart for its bends.
const LENGTH: f32 = 0.002;
/// Points to either side that a bias and a contrast are averaged with.
const AROUND: usize = 4;
/// A tip may lie so far, in widths, beside the way that the rope runs on to it, and its difference fall so far beyond it.
const OFF_TIP: f32 = 0.15;
const BEYOND_TIP: f32 = 0.5;
/// A rope is followed if that leaves each of its points where it was extracted, to so many pixels, or widths.
const OFF: (f32, f32) = (0.4, 0.04);

impl Rope {
    /// Takes the rope as it was extracted; false when it cannot be followed.
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

    /// Learns how the chords read in the image that the rope was extracted from; false when they do not tell it.
    pub(super) fn learn(&mut self, reader: &Reader) -> bool {
        self.learn_contrast(reader);
        self.learn_biases(reader) && self.learn_tips(reader) && self.agrees(reader)
    }

    /// Whether the rope, followed into the very image that it was extracted from, stays where it is.
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

    /// Reads the rope's contrast at its points, in the mean of those around.
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

    /// Gives each station the mean of what the stations around it say.
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
