//! Which curve is which rope: the pairing with the largest sum of scores.

/// For each row of `scores` the column paired with it, none twice, so that the scores' sum is largest. Every row has
/// the same number of columns; rows or columns are at most 16. Pairs of score 0 are left unpaired.
///
/// By dynamic programming over the sets taken of the fewer: a picture has few ropes, however many curves were found.
pub(super) fn best(scores: &[Vec<f64>]) -> Vec<Option<usize>> {
    let columns = scores.first().map_or(0, Vec::len);
    if columns > scores.len() {
        let column = |c: usize| scores.iter().map(|row| row[c]).collect();
        let turned: Vec<Vec<f64>> = (0..columns).map(column).collect();
        let rows = best(&turned);
        let column_of = |row: usize| rows.iter().position(|taken| *taken == Some(row));
        return (0..scores.len()).map(column_of).collect();
    }
    debug_assert!(
        columns <= 16,
        "{columns} columns are too many for all their sets"
    );
    let sets = 1usize << columns;
    let mut sums = vec![f64::NEG_INFINITY; sets];
    sums[0] = 0.0;
    // For each row and set taken by it and the rows before: the column that the row took.
    let mut choices = Vec::with_capacity(scores.len());
    for row in scores {
        let (mut next, mut choice) = (sums.clone(), vec![None; sets]);
        for (set, &sum) in sums.iter().enumerate() {
            for (column, &score) in row.iter().enumerate() {
                let with = set | 1 << column;
                if with != set && score > 0.0 && sum + score > next[with] {
                    next[with] = sum + score;
                    choice[with] = Some(column);
                }
            }
        }
        sums = next;
        choices.push(choice);
    }
    let mut set = (0..sets)
        .max_by(|&a, &b| sums[a].total_cmp(&sums[b]))
        .unwrap_or(0);
    let mut pairing: Vec<_> = choices
        .iter()
        .rev()
        .map(|choice| choice[set].inspect(|&column| set &= !(1 << column)))
        .collect();
    pairing.reverse();
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
        // Scores of no pattern, from a linear congruence.
        let mut state = 12_345_u64;
        let mut score = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 40) as f64 / f64::from(1 << 24)
        };
        for (rows, columns) in [(1, 4), (4, 1), (3, 5), (5, 3), (5, 5)] {
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
