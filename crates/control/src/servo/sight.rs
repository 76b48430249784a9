//! Checks an image and extracts what the servo needs from it.

use super::{Phase, Servo};
use crate::command::{Observation, Why};
use crate::error::ServoError;
use crate::pairs::Frame;
use crate::{Features, MAX_FEATURES};

/// Largest valid coordinate, px.
pub(super) const FARTHEST_PX: f64 = 1e6;

/// A usable image.
pub(super) struct Sight {
    pub(super) frame: Frame,
    pub(super) is_new: bool,
    pub(super) partial: bool,
    /// Target minus shape.
    pub(super) error: Features,
    pub(super) error_px: f64,
}

impl<const A: usize> Servo<A> {
    /// Checks an image. If it is unusable, returns the reason and changes nothing.
    pub(super) fn sight(&mut self, seen: &Observation, now_ns: u64) -> Result<Sight, Why> {
        let (given, expected) = (seen.features.len(), self.size);
        if given != expected {
            return Err(Why::Size { given, expected });
        }
        let features = checked(seen.features).map_err(|_| Why::NotAShape)?;
        let before = self.commanded.is_some_and(|last| now_ns < last.at_ns);
        let older = self.exposed_ns.is_some_and(|last| seen.exposed_ns < last);
        if before || older || seen.exposed_ns > now_ns {
            return Err(Why::Clock);
        }
        if (now_ns - seen.exposed_ns) as f64 * 1e-9 > self.options.oldest_image_s {
            return Err(Why::Stale);
        }
        if seen.partial && (self.options.hold_on_partial || self.phase == Phase::Exploring) {
            return Err(Why::Partial);
        }
        let at_ns = seen.exposed_ns.saturating_sub(self.delay_ns());
        let r = self.history.at(at_ns).ok_or(Why::Stale)?;
        let noise_px2 = self.weighing.take(seen.weights, self.options.noise_px)?;
        let is_new = self.exposed_ns != Some(seen.exposed_ns);
        self.exposed_ns = Some(seen.exposed_ns);
        self.choose_way(&features);
        let error = std::array::from_fn(|k| self.target[k] - features[k]);
        let frame = Frame {
            features,
            r,
            at_ns,
            noise_px2,
        };
        Ok(Sight {
            frame,
            is_new,
            partial: seen.partial,
            error,
            error_px: self.weighing.distance_px(&error),
        })
    }

    fn choose_way(&mut self, features: &Features) {
        if self.way_chosen {
            return;
        }
        self.way_chosen = true;
        let mut reversed = [0.0; MAX_FEATURES];
        let each = Self::DIMENSIONS;
        let points = self.target[..self.size].chunks_exact(each).rev();
        for (to, from) in reversed.chunks_exact_mut(each).zip(points) {
            to.copy_from_slice(from);
        }
        let [as_it_is, other] = [&self.target, &reversed].map(|target| {
            let error = std::array::from_fn(|k| target[k] - features[k]);
            self.weighing.distance_px(&error)
        });
        if other < as_it_is {
            self.target = reversed;
        }
    }
}

/// Copies a shape whose coordinates are all valid.
pub(super) fn checked(shape: &[f64]) -> Result<Features, ServoError> {
    let mut features = [0.0; MAX_FEATURES];
    for (index, (place, &value)) in features.iter_mut().zip(shape).enumerate() {
        // Also rejects NaN.
        if !(-FARTHEST_PX..=FARTHEST_PX).contains(&value) {
            return Err(ServoError::NotATarget { index, value });
        }
        *place = value;
    }
    Ok(features)
}
