//! Arithmetic that gives the same bits on every machine: a sine from IEEE basic operations (the
//! platform's own may differ in its last bit) and a small random generator.

/// Sine of an angle in turns, |turns| < 2⁵¹, to 2·10⁻⁹.
pub(crate) fn sin_turns(turns: f64) -> f64 {
    // Reduced to [−½, ½], then folded about ±¼ to the half wave around zero.
    let rest = turns - (turns + if turns < 0.0 { -0.5 } else { 0.5 }) as i64 as f64;
    let x = if rest > 0.25 {
        0.5 - rest
    } else if rest < -0.25 {
        -0.5 - rest
    } else {
        rest
    };
    // Taylor series about 0 for |angle| ≤ π/2: the first term left out is (π/2)¹⁵ / 15! < 7·10⁻¹⁰.
    let angle = x * std::f64::consts::TAU;
    let square = angle * angle;
    let mut sum = 0.0;
    for denominator in [156.0, 110.0, 72.0, 42.0, 20.0, 6.0] {
        sum = (1.0 + sum) * (-square / denominator);
    }
    angle * (1.0 + sum)
}

/// Cosine of an angle in turns, with the range and accuracy of [`sin_turns`].
pub(crate) fn cos_turns(turns: f64) -> f64 {
    sin_turns(turns + 0.25)
}

/// Smooth step from 0 to 1 over x in [0, 1], with horizontal ends: 3x² − 2x³.
pub(crate) fn smoothstep(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sine_is_a_sine() {
        for i in -4000..4000 {
            let turns = f64::from(i) / 1000.0 + 1e-4;
            let angle = turns * std::f64::consts::TAU;
            assert!((sin_turns(turns) - angle.sin()).abs() < 2e-9, "{turns}");
            assert!((cos_turns(turns) - angle.cos()).abs() < 2e-9, "{turns}");
        }
    }
}
