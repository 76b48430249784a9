//! Decides which notices about a chain's results are reported to the user. A notice is not repeated
//! for every frame.

use lariat_extract::Notice;

/// Number of consecutive frames for which a notice must hold before it is reported. A hand that
/// passes through the picture must not trigger one.
const HOLD: u32 = 10;
/// Number of frames without a notice after which the same one is reported again. At 30 frames/s
/// this is ten seconds. A notice that comes and goes would otherwise fill the screen.
const FORGET: u32 = 300;

/// Filters the notices of successive frames.
#[derive(Debug, Default)]
pub struct Doubts {
    /// The notice of the last frames.
    last: Option<Notice>,
    held: u32,
    told: Option<Notice>,
}

impl Doubts {
    /// Takes the notice of the next frame. Returns the notice to report now. While a notice holds,
    /// it is returned only once.
    pub fn next(&mut self, notice: Option<Notice>) -> Option<Notice> {
        if notice != self.last {
            (self.last, self.held) = (notice, 0);
        }
        self.held = self.held.saturating_add(1);
        match notice {
            None if self.held == FORGET => self.told = None,
            Some(_) if self.held == HOLD && notice != self.told => {
                self.told = notice;
                return notice;
            }
            _ => {}
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Notice::{Black, CheckeredTable};

    /// Returns what is reported for runs of frames with the same notice.
    fn told(runs: &[(Option<Notice>, u32)]) -> Vec<Notice> {
        let mut doubts = Doubts::default();
        let frames = runs
            .iter()
            .flat_map(|&(notice, frames)| (0..frames).map(move |_| notice));
        frames.filter_map(|notice| doubts.next(notice)).collect()
    }

    #[test]
    fn a_doubt_that_lasts_is_told_once() {
        assert_eq!(told(&[(Some(CheckeredTable), 2000)]), [CheckeredTable]);
    }

    #[test]
    fn a_doubt_that_passes_is_not_told() {
        let passing = [(Some(Black), HOLD - 1), (None, 1)].repeat(50);
        assert_eq!(told(&passing), []);
    }

    #[test]
    fn a_doubt_that_comes_and_goes_is_told_once() {
        let flicker = [(Some(CheckeredTable), 20), (None, 20)].repeat(50);
        assert_eq!(told(&flicker), [CheckeredTable]);
    }

    #[test]
    fn another_doubt_is_told_and_a_new_one_after_a_while() {
        let runs = [
            (Some(Black), 20),
            (Some(CheckeredTable), 20),
            (None, FORGET),
            (Some(CheckeredTable), 20),
        ];
        assert_eq!(told(&runs), [Black, CheckeredTable, CheckeredTable]);
    }
}
