//! DICE of each rope: twice the pixels that label and drawing share, divided by the sum of both
//! (Dice, 1945).

use super::assignment;
use super::labels::Labels;

/// Overlap of the drawn ropes with the labeled ones.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Overlap {
    /// Number of each labeled rope, index of the curve assigned to it, and their DICE.
    pub(super) ropes: Vec<(u8, Option<usize>, f64)>,
    /// Mean over the ropes. A label without a curve and a curve without a label count as 0.
    pub(super) dice: f64,
}

/// Pairs the `curves` drawn ropes (number i + 1 for index i) with those of the label. Both pictures
/// have the same size.
pub(super) fn overlap(label: &Labels, drawn: &Labels, curves: usize) -> Overlap {
    let numbers = label.numbers();
    let mut shared = vec![[0usize; 256]; 256];
    for (&a, &b) in label.ropes.iter().zip(&drawn.ropes) {
        shared[usize::from(a)][usize::from(b)] += 1;
    }
    let labelled = |a: u8| shared[usize::from(a)].iter().sum::<usize>();
    let covered = |b: usize| shared.iter().map(|row| row[b]).sum::<usize>();
    let dice = |a: u8, b: usize| {
        2.0 * shared[usize::from(a)][b] as f64 / (labelled(a) + covered(b)) as f64
    };
    let scores: Vec<Vec<f64>> = numbers
        .iter()
        .map(|&a| (1..=curves).map(|b| dice(a, b)).collect())
        .collect();
    let pairing = assignment::best(&scores);
    let ropes: Vec<_> = numbers
        .iter()
        .zip(&pairing)
        .zip(&scores)
        .map(|((&number, &curve), row)| (number, curve, curve.map_or(0.0, |c| row[c])))
        .collect();
    let all = numbers.len().max(curves);
    let sum: f64 = ropes.iter().map(|rope| rope.2).sum();
    // No rope was expected and none was found: a perfect result.
    let dice = if all == 0 { 1.0 } else { sum / all as f64 };
    Overlap { ropes, dice }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::drawing::draw;
    use crate::accuracy::drawing::tests::curve;

    /// Returns a label with a rectangle: columns 10 to 50, rows 16 to 24.
    fn rectangle() -> Labels {
        let mut label = Labels::empty(60, 40);
        for y in 16..=24 {
            label.ropes[y * 60 + 10..=y * 60 + 50].fill(7);
        }
        label
    }

    fn bar(from: f64, to: f64, width_px: f64) -> lariat_extract::Curve {
        curve(
            &[[from, 20.0], [0.5 * (from + to), 20.0], [to, 20.0]],
            width_px,
        )
    }

    #[test]
    fn a_rope_drawn_as_labelled_scores_one() {
        let drawn = draw(&[bar(10.0, 50.0, 9.0)], &[], (60, 40));
        let found = overlap(&rectangle(), &drawn, 1);
        assert_eq!(found.ropes, [(7, Some(0), 1.0)]);
        assert_eq!(found.dice, 1.0);
    }

    #[test]
    fn a_rope_two_rows_too_narrow_scores_its_share() {
        // 7 of 9 rows: 2·7/(7 + 9).
        let drawn = draw(&[bar(10.0, 50.0, 7.0)], &[], (60, 40));
        let found = overlap(&rectangle(), &drawn, 1);
        assert!((found.dice - 14.0 / 16.0).abs() < 1e-12);
    }

    #[test]
    fn a_curve_too_many_and_a_rope_not_found_count_as_nothing() {
        let curves = [bar(10.0, 30.0, 9.0), bar(40.0, 50.0, 9.0)];
        let drawn = draw(&curves, &[], (60, 40));
        let found = overlap(&rectangle(), &drawn, 2);
        // 21 of 41 columns: 2·21/(21 + 41), halved by the second curve.
        assert_eq!(found.ropes[0].1, Some(0));
        assert!((found.dice - 21.0 / 62.0).abs() < 1e-12);
        let none = overlap(&rectangle(), &Labels::empty(60, 40), 0);
        assert_eq!((none.ropes[0].1, none.dice), (None, 0.0));
        let empty = Labels::empty(60, 40);
        assert_eq!(overlap(&empty, &empty, 0).dice, 1.0);
        assert_eq!(overlap(&empty, &drawn, 2).dice, 0.0);
    }
}
