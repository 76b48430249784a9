//! Numbers formatted for sentences.

/// Formats a number with three significant digits: 0.0123, 1.23, 123, 1.2·10⁵.
pub fn digits(number: f64) -> String {
    let size = number.abs();
    if !number.is_finite() {
        "–".to_owned()
    } else if size == 0.0 {
        "0".to_owned()
    } else if !(1e-3..99_999.5).contains(&size) {
        power_of_ten(number)
    } else if size >= 99.95 {
        format!("{number:.0}")
    } else if size >= 9.995 {
        format!("{number:.1}")
    } else if size >= 0.9995 {
        format!("{number:.2}")
    } else if size >= 0.09995 {
        format!("{number:.3}")
    } else {
        format!("{number:.4}")
    }
}

fn power_of_ten(number: f64) -> String {
    let mut power = number.abs().log10().floor() as i32;
    let mut mantissa = format!("{:.1}", number / 10f64.powi(power));
    if mantissa.trim_start_matches('-') == "10.0" {
        power += 1;
        mantissa = mantissa.replace("10.0", "1.0");
    }
    format!("{mantissa}·10{}", raised(power))
}

/// Formats an integer as an exponent.
pub fn raised(power: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    power
        .to_string()
        .chars()
        .map(|c| match c.to_digit(10) {
            Some(digit) => DIGITS[digit as usize],
            None => '⁻',
        })
        .collect()
}

/// Formats a number of pixels: "0.123 px".
pub fn px(number: f64) -> String {
    format!("{} px", digits(number))
}

/// Formats a time given in microseconds in a suitable unit.
pub fn time(us: f64) -> String {
    if us < 1.0 {
        format!("{} ns", digits(1e3 * us))
    } else if us < 1e3 {
        format!("{} µs", digits(us))
    } else if us < 1e6 {
        format!("{} ms", digits(1e-3 * us))
    } else {
        format!("{} s", digits(1e-6 * us))
    }
}

/// Formats a share as a whole percentage. A share between 0 and 1 % becomes "under 1 %", and a
/// share between 99 and 100 % becomes "over 99 %".
pub fn percent(share: f64) -> String {
    let whole = 100.0 * share;
    if !share.is_finite() {
        "–".to_owned()
    } else if whole > 99.0 && whole < 100.0 {
        "over 99 %".to_owned()
    } else if whole > 0.0 && whole < 1.0 {
        "under 1 %".to_owned()
    } else {
        format!("{whole:.0} %")
    }
}

/// Formats a count with the right form of the noun.
pub fn count(number: usize, one: &str, many: &str) -> String {
    format!("{number} {}", if number == 1 { one } else { many })
}

/// Joins items: "a", "a and b", "a, b and c".
pub fn list(items: &[String]) -> String {
    match items {
        [] => "none".to_owned(),
        [one] => one.clone(),
        [rest @ .., last] => format!("{} and {last}", rest.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_told_to_three_digits() {
        let told = [0.0123, 0.123, 1.234, 12.34, 123.4, 12345.0, 1.23e5, 2.5e-9].map(digits);
        assert_eq!(
            told,
            [
                "0.0123",
                "0.123",
                "1.23",
                "12.3",
                "123",
                "12345",
                "1.2·10⁵",
                "2.5·10⁻⁹"
            ]
        );
        assert_eq!(
            [0.9999, 9.999, 99.99, 0.0].map(digits),
            ["1.00", "10.0", "100", "0"]
        );
        assert_eq!(digits(-9.99e6), "-1.0·10⁷");
        assert_eq!(digits(f64::NAN), "–");
    }

    #[test]
    fn times_have_the_unit_that_suits_them() {
        assert_eq!(
            [0.4, 12.0, 4200.0, 2.5e6].map(time),
            ["400 ns", "12.0 µs", "4.20 ms", "2.50 s"]
        );
    }

    #[test]
    fn nearly_all_is_not_all() {
        assert_eq!(
            [0.0, 0.001, 0.5, 0.999, 1.0].map(percent),
            ["0 %", "under 1 %", "50 %", "over 99 %", "100 %"]
        );
        assert_eq!(list(&["a", "b", "c"].map(str::to_owned)), "a, b and c");
    }
}
