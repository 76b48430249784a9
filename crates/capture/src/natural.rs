//! The order in which people number files: `img2` before `img10`.

use std::cmp::Ordering;

/// Compares names piece by piece, numbers by their value; names that differ only in leading zeros or in case by their
/// bytes. A total order.
pub fn natural_order(a: &[u8], b: &[u8]) -> Ordering {
    let (mut rest_a, mut rest_b) = (a, b);
    loop {
        let order = match (rest_a, rest_b) {
            ([], []) => return a.cmp(b),
            ([], _) => Ordering::Less,
            (_, []) => Ordering::Greater,
            ([x, ..], [y, ..]) if x.is_ascii_digit() && y.is_ascii_digit() => {
                let (number_a, number_b) = (take_number(&mut rest_a), take_number(&mut rest_b));
                // Without leading zeros the longer number is the larger one, however long.
                let lengths = number_a.len().cmp(&number_b.len());
                lengths.then_with(|| number_a.cmp(number_b))
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

/// Takes the digits at the start off, and gives them without leading zeros.
fn take_number<'a>(text: &mut &'a [u8]) -> &'a [u8] {
    let end = text.iter().position(|c| !c.is_ascii_digit());
    let (digits, rest) = text.split_at(end.unwrap_or(text.len()));
    *text = rest;
    let zeros = digits.iter().take_while(|&&c| c == b'0').count();
    &digits[zeros..]
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

    proptest! {
        #[test]
        fn it_is_a_total_order(a in "[a-cA-C0-3.]{0,6}", b in "[a-cA-C0-3.]{0,6}", c in "[a-cA-C0-3.]{0,6}") {
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
