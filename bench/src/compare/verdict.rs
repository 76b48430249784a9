//! Decides whether a figure changed beyond the noise, and in which direction.

use super::read::Measured;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Verdict {
    Better,
    Worse,
    /// Within the noise.
    Same,
}

/// Compares a figure with its earlier value.
pub(super) fn verdict(before: &Measured, now: &Measured) -> Verdict {
    let change = now.value - before.value;
    let noise = before.spread() + now.spread();
    let least = now.least_change * before.value.abs().max(now.value.abs());
    if !change.is_finite() || change.abs() <= noise.max(least).max(now.resolution) {
        return Verdict::Same;
    }
    if (change > 0.0) == now.more_is_better {
        Verdict::Better
    } else {
        Verdict::Worse
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measured(value: f64, low: f64, high: f64) -> Measured {
        Measured {
            id: "chain.640x480@120".to_owned(),
            figure: "p50_us".to_owned(),
            value,
            low,
            high,
            rounds: 5,
            ours: true,
            more_is_better: false,
            least_change: 0.05,
            resolution: 0.0,
        }
    }

    #[test]
    fn what_lies_within_both_spreads_is_noise() {
        let before = measured(100.0, 95.0, 110.0);
        assert_eq!(
            verdict(&before, &measured(120.0, 112.0, 125.0)),
            Verdict::Same
        );
        assert_eq!(verdict(&before, &measured(80.0, 75.0, 90.0)), Verdict::Same);
    }

    #[test]
    fn fewer_rounds_show_less_of_the_noise() {
        let (mut before, mut now) = (measured(100.0, 95.0, 105.0), measured(125.0, 120.0, 130.0));
        assert_eq!(verdict(&before, &now), Verdict::Worse);
        (before.rounds, now.rounds) = (3, 3);
        assert_eq!(verdict(&before, &now), Verdict::Same);
    }

    #[test]
    fn what_lies_beyond_them_is_better_or_worse() {
        let before = measured(100.0, 95.0, 110.0);
        assert_eq!(
            verdict(&before, &measured(150.0, 145.0, 155.0)),
            Verdict::Worse
        );
        assert_eq!(
            verdict(&before, &measured(60.0, 58.0, 62.0)),
            Verdict::Better
        );
    }

    #[test]
    fn more_frames_a_second_are_better() {
        let mut now = measured(150.0, 150.0, 150.0);
        now.more_is_better = true;
        assert_eq!(
            verdict(&measured(100.0, 100.0, 100.0), &now),
            Verdict::Better
        );
        assert_eq!(
            verdict(&measured(200.0, 200.0, 200.0), &now),
            Verdict::Worse
        );
    }

    #[test]
    fn a_change_too_small_to_matter_is_none() {
        let before = measured(100.0, 100.0, 100.0);
        assert_eq!(
            verdict(&before, &measured(104.0, 104.0, 104.0)),
            Verdict::Same
        );
        let mut none_lost = measured(0.0, 0.0, 0.0);
        assert_eq!(verdict(&none_lost, &none_lost), Verdict::Same);
        none_lost.resolution = 1.0;
        let mut one_lost = measured(1.0, 1.0, 1.0);
        one_lost.resolution = 0.5;
        assert_eq!(verdict(&none_lost, &one_lost), Verdict::Worse);
    }
}
