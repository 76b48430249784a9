//! Assignment of curves to ropes: the pairing with the largest sum of scores.

/// Returns, for each row of `scores`, its column in the pairing with the largest sum of scores. No
/// column is paired twice. Every row has the same number of columns. Pairs of score 0 are left
/// unpaired.
///
/// Uses the Hungarian method, row by row along shortest augmenting paths (Jonker and Volgenant,
/// 1987).
pub(super) fn best(scores: &[Vec<f64>]) -> Vec<Option<usize>> {
    let columns = scores.first().map_or(0, Vec::len).max(scores.len());
    let cost = |row: usize, column: usize| -scores[row].get(column).unwrap_or(&0.0);
    // The row assigned to each column. The last entry is the row that is being placed.
    let (seeking, mut row_of) = (columns, vec![None; columns + 1]);
    let (mut of_rows, mut of_columns) = (vec![0.0; scores.len()], vec![0.0; columns + 1]);
    for row in 0..scores.len() {
        row_of[seeking] = Some(row);
        let mut least = vec![f64::INFINITY; columns];
        let (mut before, mut is_on_path) = (vec![seeking; columns], vec![false; columns + 1]);
        let mut at = seeking;
        while let Some(row) = row_of[at] {
            is_on_path[at] = true;
            let (mut step, mut next) = (f64::INFINITY, seeking);
            for column in (0..columns).filter(|&column| !is_on_path[column]) {
                let reduced = cost(row, column) - of_rows[row] - of_columns[column];
                if reduced < least[column] {
                    (least[column], before[column]) = (reduced, at);
                }
                if least[column] < step {
                    (step, next) = (least[column], column);
                }
            }
            for column in 0..=columns {
                match row_of[column] {
                    Some(row) if is_on_path[column] => {
                        of_rows[row] += step;
                        of_columns[column] -= step;
                    }
                    _ if column < columns => least[column] -= step,
                    _ => {}
                }
            }
            at = next;
        }
        while at != seeking {
            row_of[at] = row_of[before[at]];
            at = before[at];
        }
    }
    let mut pairing = vec![None; scores.len()];
    for (column, row) in row_of[..columns].iter().enumerate() {
        if let Some(row) = row.filter(|&row| cost(row, column) < 0.0) {
            pairing[row] = Some(column);
        }
    }
    pairing
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_sum_wins_over_the_best_pair() {
        let scores = [vec![0.9, 0.8], vec![0.8, 0.1]];
        assert_eq!(best(&scores), [Some(1), Some(0)]);
    }

    #[test]
    fn what_has_no_partner_stays_alone() {
        assert_eq!(
            best(&[vec![0.2], vec![0.7], vec![0.5]]),
            [None, Some(0), None]
        );
        assert_eq!(best(&[vec![0.2, 0.7, 0.5]]), [Some(1)]);
        assert_eq!(best(&[vec![0.0, 0.0]]), [None]);
        assert_eq!(best(&[vec![], vec![]]), [None, None]);
        assert!(best(&[]).is_empty());
    }

    #[test]
    fn it_equals_the_best_of_all_permutations() {
        fn exhaustive(scores: &[Vec<f64>], taken: usize) -> f64 {
            let Some((row, rest)) = scores.split_first() else {
                return 0.0;
            };
            let alone = exhaustive(rest, taken);
            let free = (0..row.len()).filter(|c| taken >> c & 1 == 0);
            free.map(|c| row[c] + exhaustive(rest, taken | 1 << c))
                .fold(alone, f64::max)
        }
        // Pseudorandom scores from a linear congruential generator.
        let mut state = 12_345_u64;
        let mut score = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 40) as f64 / f64::from(1 << 24)
        };
        for (rows, columns) in [(1, 4), (4, 1), (3, 5), (5, 3), (5, 5), (7, 6)] {
            let scores: Vec<Vec<f64>> = (0..rows)
                .map(|_| (0..columns).map(|_| score()).collect())
                .collect();
            let paired = best(&scores);
            let sum: f64 = paired
                .iter()
                .zip(&scores)
                .filter_map(|(c, row)| c.map(|c| row[c]))
                .sum();
            assert!((sum - exhaustive(&scores, 0)).abs() < 1e-12);
        }
    }
}
