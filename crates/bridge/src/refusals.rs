//! What was refused: counted, and each cause said now and then, however often somebody gives it.

use lariat_wire::now_ns;

use crate::datagram::Refused;
use crate::say;

/// The same is not said more often.
const SAY_NS: u64 = 10_000_000_000;

/// What was refused so far.
#[derive(Debug, Default)]
pub(crate) struct Refusals {
    count: u64,
    /// What was said, and when.
    said: Vec<(Refused, u64)>,
}

impl Refusals {
    /// Counts one, and says why, unless that was said lately.
    pub(crate) fn add(&mut self, cause: Refused) {
        self.count += 1;
        if self.is_news(cause, now_ns()) {
            say(&cause.to_string());
        }
    }

    fn is_news(&mut self, cause: Refused, now_ns: u64) -> bool {
        match self.said.iter_mut().find(|(said, _)| *said == cause) {
            Some((_, at)) if now_ns.saturating_sub(*at) < SAY_NS => false,
            Some((_, at)) => {
                *at = now_ns;
                true
            }
            None => {
                self.said.push((cause, now_ns));
                true
            }
        }
    }

    /// How many.
    pub(crate) fn count(&self) -> u64 {
        self.count
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn causes_in_turns_are_each_said_now_and_then() {
        let mut refusals = Refusals::default();
        let causes = [
            Refused::Seal,
            Refused::Foreign,
            Refused::Seal,
            Refused::Foreign,
        ];
        let news = causes.map(|cause| refusals.is_news(cause, 5));
        assert_eq!(news, [true, true, false, false]);
        assert!(!refusals.is_news(Refused::Seal, 4 + SAY_NS));
        assert!(refusals.is_news(Refused::Seal, 5 + SAY_NS));
    }
}
