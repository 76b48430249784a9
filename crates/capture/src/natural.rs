//! Natural order, in which people number files: `img2` comes before `img10`.

use std::cmp::Ordering;

/// Compares names piece by piece, numbers by their values. Names that differ only in leading zeros
/// or in case are compared by their bytes. This is a total order.
///
/// Digits after a point that follows digits are a fraction: `1.125` comes before `1.5`. Names such
/// as `f"{time.time()}.png"` need this. Digits with more than one point (`1.2.10`, a date or a
/// version) are whole numbers, each compared by its value.
pub fn natural_order(a: &[u8], b: &[u8]) -> Ordering {
    let (mut rest_a, mut rest_b) = (a, b);
    loop {
        let order = match (rest_a, rest_b) {
            ([], []) => return a.cmp(b),
            ([], _) => Ordering::Less,
            (_, []) => Ordering::Greater,
            ([x, ..], [y, ..]) if x.is_ascii_digit() && y.is_ascii_digit() => {
                Digits::take(&mut rest_a).cmp(&Digits::take(&mut rest_b))
            }
            ([x, after_a @ ..], [y, after_b @ ..]) => {
                (rest_a, rest_b) = (after_a, after_b);
                x.to_ascii_lowercase().cmp(&y.to_ascii_lowercase())
            }
        };
        if order != Ordering::Equal {
            return order;
        }
    }
}

/// Digits, with single points between them.
struct Digits<'a> {
    whole: &'a [u8],
    /// Digits and points after the first point; empty without a point.
    rest: &'a [u8],
}

impl<'a> Digits<'a> {
    /// Takes the longest such run off the start of `text`.
    fn take(text: &mut &'a [u8]) -> Self {
        let digits = |from: usize| {
            text[from..]
                .iter()
                .take_while(|c| c.is_ascii_digit())
                .count()
        };
        let whole = digits(0);
        let mut end = whole;
        while text.get(end) == Some(&b'.') && digits(end + 1) > 0 {
            end += 1 + digits(end + 1);
        }
        let (taken, after) = text.split_at(end);
        *text = after;
        Self {
            whole: &taken[..whole],
            rest: taken.get(whole + 1..).unwrap_or_default(),
        }
    }

    /// The number of points.
    fn points(&self) -> usize {
        let inner = self.rest.iter().filter(|&&c| c == b'.').count();
        inner + usize::from(!self.rest.is_empty())
    }

    /// Orders equal whole parts by kind: a whole number, a number with a fraction, one with several
    /// points. Any fixed order would do.
    fn cmp(&self, other: &Self) -> Ordering {
        let kind = |digits: &Self| digits.points().min(2);
        by_value(self.whole, other.whole)
            .then_with(|| kind(self).cmp(&kind(other)))
            .then_with(|| match self.points() {
                0 => Ordering::Equal,
                1 => without_last_zeros(self.rest).cmp(without_last_zeros(other.rest)),
                _ => by_fields(self.rest, other.rest),
            })
    }
}

/// Compares whole numbers of any length: without leading zeros, the longer one is larger.
fn by_value(a: &[u8], b: &[u8]) -> Ordering {
    let [a, b] = [a, b].map(|digits| {
        let zeros = digits.iter().take_while(|&&c| c == b'0').count();
        &digits[zeros..]
    });
    a.len().cmp(&b.len()).then_with(|| a.cmp(b))
}

/// Compares runs of digits between points one by one.
fn by_fields(a: &[u8], b: &[u8]) -> Ordering {
    let (mut a, mut b) = (a.split(|&c| c == b'.'), b.split(|&c| c == b'.'));
    loop {
        let order = match (a.next(), b.next()) {
            (None, None) => return Ordering::Equal,
            (None, _) => Ordering::Less,
            (_, None) => Ordering::Greater,
            (Some(a), Some(b)) => by_value(a, b),
        };
        if order != Ordering::Equal {
            return order;
        }
    }
}

fn without_last_zeros(fraction: &[u8]) -> &[u8] {
    let zeros = fraction.iter().rev().take_while(|&&c| c == b'0').count();
    &fraction[..fraction.len() - zeros]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn numbers_count_by_value() {
        let mut names = [
            "img10.png",
            "img2.png",
            "Img1.png",
            "img02.png",
            "a9b10",
            "a9b9",
            "img",
            "a10",
            "99999999999999999999999999",
            "100000000000000000000000000",
        ];
        names.sort_by(|a, b| natural_order(a.as_bytes(), b.as_bytes()));
        let expected = [
            "99999999999999999999999999",
            "100000000000000000000000000",
            "a9b9",
            "a9b10",
            "a10",
            "img",
            "Img1.png",
            "img02.png",
            "img2.png",
            "img10.png",
        ];
        assert_eq!(names, expected);
    }

    fn sorted<const N: usize>(mut names: [&str; N]) -> [&str; N] {
        names.sort_by(|a, b| natural_order(a.as_bytes(), b.as_bytes()));
        names
    }

    #[test]
    fn digits_after_a_point_are_a_fraction() {
        let times = [
            "1699999999.9.png",
            "1700000000.0.png",
            "1700000000.125.png",
            "1700000000.25.png",
            "1700000000.5.png",
            "1700000000.75.png",
            "1700000001.0.png",
        ];
        let mut shuffled = times;
        shuffled.reverse();
        assert_eq!(sorted(shuffled), times);
        assert_eq!(
            sorted(["f0.10", "f0.9", "f0.095"]),
            ["f0.095", "f0.10", "f0.9"]
        );
    }

    #[test]
    fn digits_with_several_points_are_whole_numbers() {
        let names = [
            "2024.1.9.png",
            "2024.1.10.png",
            "2024.02.1.png",
            "2024.10.1.png",
        ];
        assert_eq!(sorted([names[3], names[1], names[2], names[0]]), names);
    }

    proptest! {
        #[test]
        fn it_is_a_total_order(a in "[ab0-2.]{0,7}", b in "[ab0-2.]{0,7}", c in "[ab0-2.]{0,7}") {
            let order = |x: &str, y: &str| natural_order(x.as_bytes(), y.as_bytes());
            prop_assert_eq!(order(&a, &b), order(&b, &a).reverse());
            prop_assert_eq!(order(&a, &b) == Ordering::Equal, a == b);
            if order(&a, &b) == Ordering::Less && order(&b, &c) == Ordering::Less {
                prop_assert_eq!(order(&a, &c), Ordering::Less);
            }
        }

        #[test]
        fn letters_of_both_cases_are_in_the_order(a in "[a-cA-C0-3.]{0,6}", b in "[a-cA-C0-3.]{0,6}", c in "[a-cA-C0-3.]{0,6}") {
            let order = |x: &str, y: &str| natural_order(x.as_bytes(), y.as_bytes());
            prop_assert_eq!(order(&a, &b), order(&b, &a).reverse());
            prop_assert_eq!(order(&a, &b) == Ordering::Equal, a == b);
            if order(&a, &b) == Ordering::Less && order(&b, &c) == Ordering::Less {
                prop_assert_eq!(order(&a, &c), Ordering::Less);
            }
        }

        #[test]
        fn padding_a_number_never_moves_it_past_another(x: u32, y: u32, zeros in 0usize..4) {
            let padded = format!("f{}{x}", "0".repeat(zeros));
            if x != y {
                let order = natural_order(padded.as_bytes(), format!("f{y}").as_bytes());
                prop_assert_eq!(order, x.cmp(&y));
            }
        }
    }
}
