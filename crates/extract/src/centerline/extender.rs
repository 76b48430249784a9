//! Extends the ends of a line to the tips of its rope.
//!
//! Near a tip, a skeleton or a chain of centers is bent and too short. That part is cut off, and
//! the line continues along its arc to where the rope's difference from the table falls to half, or
//! to where the tip touches another strand.

use super::extrapolate;
use super::line::{Line, Sample};
use super::source::Source;
use super::tip_contact::Contact;
use crate::graph::strands::Leg;
use crate::image::gray::GrayPlane;
use crate::statistics::quantile_of_positive;

/// Memory of the step.
#[derive(Debug, Default)]
pub(crate) struct Extender {
    /// Samples beyond the first end.
    tip: Vec<Sample>,
    levels: Vec<f32>,
    /// The strands that the line's ends touch.
    contacts: [Option<Contact>; 2],
}

impl Extender {
    /// Makes room for lines of this many samples.
    pub(crate) fn reserve(&mut self, samples: usize) {
        self.tip.reserve(samples);
        self.levels.reserve(samples);
    }

    /// Begins a line along these legs.
    pub(crate) fn begin(&mut self, source: &Source, legs: &[Leg]) {
        let contact = |leg: Option<&Leg>, end| Contact::at(leg?, end, source.graph, source.zones);
        self.contacts = [contact(legs.first(), 0), contact(legs.last(), 1)];
    }

    /// True for each end that touches no strand.
    pub(crate) fn is_free(&self) -> [bool; 2] {
        self.contacts.map(|contact| contact.is_none())
    }

    /// Cuts `cut_px` from each visible end and extends it to the tip.
    pub(crate) fn extend(
        &mut self,
        difference: &GrayPlane,
        line: &mut Line,
        half_px: f32,
        step_px: f32,
        cut_px: f32,
    ) {
        if !line.closed {
            for end in [1, 0] {
                self.extend_end(difference, line, end, [half_px, step_px, cut_px]);
            }
        }
    }

    /// Extends the first (0) or the last (1) end of the line.
    fn extend_end(
        &mut self,
        difference: &GrayPlane,
        line: &mut Line,
        end: usize,
        [half_px, step_px, cut_px]: [f32; 3],
    ) {
        let n = line.samples.len();
        let cut = ((cut_px / step_px) as usize).min(n / 4);
        let last = n - cut - 1;
        // Counts samples from the other end of the line.
        let sample = |i: usize| &line.samples[if end == 1 { i } else { n - 1 - i }];
        let back = ((1.5 * half_px).max(4.0) / step_px) as usize;
        let back = back.clamp(1, (last / 3).max(1)).min(last);
        let places = [last, last - back, last.saturating_sub(2 * back)].map(|i| sample(i).at);
        let path = extrapolate::arc(places, last >= 2 * back);
        // The rope's own contrast: the median along the stretch that the direction comes from.
        self.levels.clear();
        let piece = (last - back..=last).map(|i| difference.sample(sample(i).at));
        self.levels.extend(piece);
        let level = 0.5 * quantile_of_positive(&mut self.levels, 0.5).max(2.0);
        let limit_px = cut_px + 4.0 * half_px + 4.0;
        let (far, border) = match self.contacts[end] {
            Some(contact) => {
                let rope = (half_px, level, limit_px);
                let far = contact.tip(difference, &path, rope, &mut self.levels);
                (far, false)
            }
            None => extrapolate::tip(difference, &path, level, limit_px),
        };
        line.border[end] = border;
        let count = (far / step_px).ceil() as usize;
        let width_px = sample(last).width_px;
        let share = far / count.max(1) as f32;
        let beyond = (1..=count).map(|k| Sample {
            at: path(share * k as f32),
            weight: 1.0,
            width_px,
            side: 0.0,
        });
        if end == 1 {
            line.samples.truncate(n - cut);
            line.samples.extend(beyond);
        } else {
            self.tip.clear();
            self.tip.extend(beyond);
            line.samples.splice(..cut, self.tip.drain(..).rev());
        }
    }
}
