//! Selects the frames of a file sequence that are shown: the first, the last, and every n-th.

use std::num::NonZeroU64;
use std::time::Duration;

use crate::source::SourceError;

/// A place in a sequence of frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Position {
    /// A frame's number, from 1.
    Frame(u64),
    /// Time after the first frame.
    Time(Duration),
}

/// A part of a sequence of frames. Its own frames are numbered from 1: if they kept their numbers,
/// frames left out by `every` would count as losses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Range {
    /// First frame shown. A time selects the first frame that is not before it.
    pub from: Option<Position>,
    /// Last frame shown. A time selects the last frame before it, so that two ranges that meet at a
    /// time share no frame.
    pub to: Option<Position>,
    /// Shows every n-th of these frames, beginning with the first.
    pub every: NonZeroU64,
}

impl Default for Range {
    /// The whole sequence.
    fn default() -> Self {
        Self {
            from: None,
            to: None,
            every: NonZeroU64::MIN,
        }
    }
}

/// A range in frame numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Frames {
    /// Number of the first frame, from 1.
    pub(crate) first: u64,
    /// Number of the last frame, at least `first`.
    pub(crate) last: u64,
    pub(crate) every: u64,
}

impl Range {
    /// Converts the range to frame numbers, at `fps` frames per second.
    ///
    /// # Errors
    /// The range has a time but the rate is unknown, or the range is empty.
    pub(crate) fn frames(&self, fps: Option<f64>) -> Result<Frames, SourceError> {
        // Number of frames before a moment.
        let before = |time: Duration| match fps {
            // Allows for rounding by the user: a ten-thousandth of a frame.
            Some(fps) => Ok((time.as_secs_f64() * fps - 1e-4).ceil().max(0.0) as u64),
            None => Err(SourceError::NoRate { time }),
        };
        let first = match self.from {
            None => 1,
            Some(Position::Frame(number)) => number.max(1),
            Some(Position::Time(time)) => before(time)?.saturating_add(1),
        };
        let last = match self.to {
            None => u64::MAX,
            Some(Position::Frame(number)) => number,
            Some(Position::Time(time)) => before(time)?,
        };
        if last < first {
            return Err(SourceError::EmptyRange { first, last });
        }
        Ok(Frames {
            first,
            last,
            every: self.every.get(),
        })
    }
}

impl Frames {
    /// Says how the part's frame numbers map to those of the whole; `None` if they are equal.
    pub(crate) fn news(&self) -> Option<String> {
        let Self { first, every, .. } = *self;
        match (first, every) {
            (1, 1) => None,
            (_, 1) => Some(format!("frame n is frame {} + n of the whole", first - 1)),
            _ => Some(format!(
                "frame n is frame {first} + {every} (n - 1) of the whole"
            )),
        }
    }

    /// Number of these frames in a sequence of `count`.
    pub(crate) fn of(&self, count: u64) -> u64 {
        match self.last.min(count).checked_sub(self.first) {
            Some(steps) => steps / self.every + 1,
            None => 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn range(from: Option<Position>, to: Option<Position>) -> Range {
        Range {
            from,
            to,
            ..Range::default()
        }
    }

    fn time(ms: u64) -> Option<Position> {
        Some(Position::Time(Duration::from_millis(ms)))
    }

    #[test]
    fn neighbouring_times_share_no_frame_and_leave_none_out() {
        for fps in [0.1, 24.0, 29.97, 30.0, 30000.0 / 1001.0, 1000.0] {
            let mut next = 1;
            for second in 1..=120 {
                let ends = range(time(1000 * (second - 1)), time(1000 * second));
                // At a tenth of a frame per second, most seconds contain no frame.
                let Ok(frames) = ends.frames(Some(fps)) else {
                    continue;
                };
                assert_eq!(frames.first, next, "{fps}");
                next = frames.last + 1;
            }
            let moments = next - 1;
            assert!(moments.abs_diff((120.0 * fps).ceil() as u64) <= 1, "{fps}");
        }
    }

    #[test]
    fn a_time_on_a_frame_is_that_frame() {
        let frames = range(time(2500), time(5000)).frames(Some(30.0)).unwrap();
        assert_eq!((frames.first, frames.last), (76, 150));
        let frames = range(time(1001), None).frames(Some(30000.0 / 1001.0));
        assert_eq!(frames.unwrap().first, 31);
    }

    #[test]
    fn numbers_are_from_the_first_to_the_last_included() {
        let ends = range(Some(Position::Frame(120)), Some(Position::Frame(240)));
        let frames = ends.frames(None).unwrap();
        assert_eq!((frames.first, frames.last), (120, 240));
        assert_eq!(frames.of(1000), 121);
        assert_eq!(frames.of(130), 11);
        assert_eq!(frames.of(119), 0);
        let thirds = Frames { every: 3, ..frames };
        assert_eq!([122, 123, 1000].map(|count| thirds.of(count)), [1, 2, 41]);
        let said = "frame n is frame 120 + 3 (n - 1) of the whole";
        assert_eq!(thirds.news().as_deref(), Some(said));
        assert_eq!(range(None, None).frames(None).unwrap().news(), None);
    }

    #[test]
    fn a_range_without_a_frame_and_a_time_without_a_rate_are_refused() {
        let turned = range(Some(Position::Frame(9)), Some(Position::Frame(8)));
        let said = turned.frames(None).unwrap_err().to_string();
        assert!(
            said.contains("frame 9") && said.contains("frame 8"),
            "{said}"
        );
        let said = range(time(1500), None)
            .frames(None)
            .unwrap_err()
            .to_string();
        assert!(said.contains("1.5 s"), "{said}");
    }
}
