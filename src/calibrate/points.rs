//! Pairs of points as text.

use anyhow::{Result, bail};
use lariat_camera::Pair;
use lariat_chain::exit::wrong_use;

/// Parses `x,y=X,Y` entries, separated by spaces or semicolons.
///
/// # Errors
/// Returns an error that quotes the first malformed entry.
pub(super) fn of_flag(text: &str) -> Result<Vec<Pair>> {
    let entries = text.split(|c: char| c.is_whitespace() || c == ';');
    let entries = entries.filter(|entry| !entry.is_empty());
    entries
        .map(|entry| {
            let numbers = entry.split_once('=').and_then(|(pixel, mm)| {
                Some((two(pixel.split(','))?, two(mm.split(','))?))
            });
            match numbers {
                Some((pixel, plane_mm)) => Ok(Pair { pixel, plane_mm }),
                None => wrong_use!(
                    "\"{entry}\" is no pair of points: write x,y=X,Y, pixels before and millimetres after the sign, without \
                     spaces, as in 320,240=150,100"
                ),
            }
        })
        .collect()
}

/// Parses lines `x y X Y`, separated by spaces, commas or tabs. A `#` starts a comment.
///
/// # Errors
/// Returns an error with the number of the first malformed line.
pub(super) fn of_file(text: &str) -> Result<Vec<Pair>> {
    let mut pairs = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default().trim();
        if line.is_empty() {
            continue;
        }
        let is_between = |c: char| c.is_whitespace() || matches!(c, ',' | ';' | '=');
        let numbers: Vec<&str> = line.split(is_between).filter(|n| !n.is_empty()).collect();
        let pair = match numbers[..] {
            [x, y, u, v] => two([x, y].into_iter()).zip(two([u, v].into_iter())),
            _ => None,
        };
        let Some((pixel, plane_mm)) = pair else {
            bail!(
                "line {}: a point is four numbers, x y in pixels and X Y in millimetres",
                index + 1
            );
        };
        pairs.push(Pair { pixel, plane_mm });
    }
    Ok(pairs)
}

fn two<'a>(mut numbers: impl Iterator<Item = &'a str>) -> Option<[f64; 2]> {
    let mut one = || {
        numbers
            .next()?
            .trim()
            .parse()
            .ok()
            .filter(|x: &f64| x.is_finite())
    };
    let both = [one()?, one()?];
    numbers.next().is_none().then_some(both)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flag_and_a_file_say_the_same() {
        let flag = of_flag(" 1,2=3,4  -5.5,6e1=7,-8;9,10=11,12").unwrap();
        let file =
            of_file("# x y X Y\n1 2 3 4\n\n-5.5, 60, 7, -8 # a corner\n9\t10\t11\t12\n").unwrap();
        assert_eq!(flag, file);
        assert_eq!(flag[1].plane_mm, [7.0, -8.0]);
    }

    #[test]
    fn what_is_no_point_is_quoted() {
        for text in [
            "1,2",
            "1,2=3",
            "1,2,3=4,5",
            "1,2=a,5",
            "1,2=nan,5",
            "=",
            "1,2=3,4=5,6",
        ] {
            let error = of_flag(text).unwrap_err().to_string();
            assert!(error.contains(text), "{error}");
        }
        let error = of_file("1 2 3 4\n1 2 3\n").unwrap_err().to_string();
        assert!(error.starts_with("line 2:"), "{error}");
    }
}
