//! Counts what was refused, and reports each cause at a limited rate.

use lariat_wire::now_ns;

use crate::datagram::Refused;
use crate::say;

/// Minimum time between two reports of the same cause.
const SAY_NS: u64 = 10_000_000_000;

/// Refused datagrams until now.
#[derive(Debug, Default)]
pub(crate) struct Refusals {
    count: u64,
    /// Reported causes, and when each was last reported.
    said: Vec<(Refused, u64)>,
}

impl Refusals {
    /// Counts a refusal, and reports its cause unless it was reported recently.
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

    /// Returns the number of refusals.
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
