//! Powers of two and base-2 logarithms of a register of numbers.
//!
//! ```text
//! 2^z     z = n + f, |f| ≤ ½, n whole     →  p(f), its exponent raised by n;  p of degree 6
//! log₂ s  s = 2ⁿ m, √½ ≤ m < √2           →  n + 2/ln 2 · (t + t³/3 + t⁵/5 + t⁷/7),  t = (m − 1)/(m + 1)
//! ```
//!
//! The relative error of a power is at most 3·10⁻⁷. The error of a logarithm is at most 3·10⁻⁷ too:
//! absolute up to 1, relative beyond.

use lariat_portable::Simd;

/// Exponents are clamped to at least this, so that powers and their sums stay normal numbers.
const LEAST: f32 = -120.0;
/// Adding this rounds a float to an integer and leaves the integer in its last bits. Negative
/// integers work as well.
const WHOLE: f32 = 12_582_912.0;
/// Bits of a float's mantissa.
const MANTISSA: u32 = 23;
/// Coefficients of 2^f for |f| ≤ ½, interpolated at Chebyshev points. The error is at most 2·10⁻⁸
/// before rounding.
const POWERS: [f32; 7] = [
    1.0,
    std::f32::consts::LN_2,
    0.240_226_5,
    0.055_503_27,
    0.009_618_025,
    0.001_340_043_3,
    0.000_154_697_32,
];

/// Computes 2 to the power of each `z`, which must be 0 or less. A `z` below −120 is treated as
/// −120.
#[inline(always)]
pub(crate) fn power_of_two<S: Simd>(simd: S, z: S::f32s) -> S::f32s {
    let z = simd.max_f32s(z, simd.splat_f32s(LEAST));
    let whole = simd.splat_f32s(WHOLE);
    let n = simd.add_f32s(z, whole);
    let f = simd.sub_f32s(z, simd.sub_f32s(n, whole));
    let mut power = simd.splat_f32s(POWERS[6]);
    for k in 0..6 {
        power = simd.mul_add_f32s(power, f, simd.splat_f32s(POWERS[5 - k]));
    }
    let raised = simd.wrapping_dyn_shl_u32s(simd.transmute_u32s_f32s(n), simd.splat_u32s(MANTISSA));
    simd.transmute_f32s_u32s(simd.add_u32s(simd.transmute_u32s_f32s(power), raised))
}

/// Computes the base-2 logarithm of each `s`, a normal number above 0.
#[inline(always)]
pub(crate) fn logarithm<S: Simd>(simd: S, s: S::f32s) -> S::f32s {
    // √½: mantissas from here on, rather than from 1, start the next power.
    const HALF_ROOT: u32 = 0x3F35_04F3;
    let bits = simd.sub_u32s(simd.transmute_u32s_f32s(s), simd.splat_u32s(HALF_ROOT));
    // The bias of 127 keeps the exponent nonnegative and is subtracted afterwards.
    let bits = simd.add_u32s(bits, simd.splat_u32s(127 << MANTISSA));
    let n = simd.wrapping_dyn_shr_u32s(bits, simd.splat_u32s(MANTISSA));
    let mantissa = simd.and_u32s(bits, simd.splat_u32s((1 << MANTISSA) - 1));
    let m = simd.transmute_f32s_u32s(simd.add_u32s(mantissa, simd.splat_u32s(HALF_ROOT)));
    let n = simd.or_u32s(n, simd.splat_u32s(WHOLE.to_bits()));
    let n = simd.sub_f32s(simd.transmute_f32s_u32s(n), simd.splat_f32s(WHOLE + 127.0));
    let one = simd.splat_f32s(1.0);
    let t = simd.div_f32s(simd.sub_f32s(m, one), simd.add_f32s(m, one));
    let square = simd.mul_f32s(t, t);
    let twice = 2.0 * std::f32::consts::LOG2_E;
    let mut series = simd.splat_f32s(twice / 7.0);
    for odd in [5.0, 3.0, 1.0] {
        series = simd.mul_add_f32s(series, square, simd.splat_f32s(twice / odd));
    }
    simd.mul_add_f32s(series, t, n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lariat_portable::{Arch, WithSimd};

    struct Powers<'a>(&'a mut [f32]);

    impl WithSimd for Powers<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            for z in S::as_mut_simd_f32s(self.0).0 {
                *z = power_of_two(simd, *z);
            }
        }
    }

    struct Logarithms<'a>(&'a mut [f32]);

    impl WithSimd for Logarithms<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            for s in S::as_mut_simd_f32s(self.0).0 {
                *s = logarithm(simd, *s);
            }
        }
    }

    const COUNT: usize = 1 << 18;

    #[test]
    fn powers_are_within_their_bound() {
        let arguments: Vec<f32> = (0..COUNT)
            .map(|i| -120.0 * i as f32 / (COUNT - 1) as f32)
            .collect();
        let mut powers = arguments.clone();
        Arch::new().dispatch(Powers(&mut powers));
        for (z, found) in arguments.iter().zip(powers) {
            let expected = f64::from(*z).exp2();
            let off = (f64::from(found) / expected - 1.0).abs();
            assert!(off < 3e-7, "2^{z}: {found} {expected}");
        }
    }

    #[test]
    fn powers_of_the_least_numbers_are_small_and_above_zero() {
        let mut powers = vec![
            f32::NEG_INFINITY,
            -1e30,
            -1e9,
            f32::MIN,
            0.0,
            -0.0,
            -150.0,
            -121.0,
        ];
        powers.resize(16, -1e6);
        Arch::new().dispatch(Powers(&mut powers));
        assert_eq!(powers[4..6], [1.0, 1.0]);
        for (i, &power) in powers.iter().enumerate() {
            assert!(
                (4..6).contains(&i) || (power > 0.0 && power < 1e-36),
                "{power}"
            );
        }
    }

    #[test]
    fn logarithms_are_within_their_bound() {
        let mut arguments: Vec<f32> = (0..COUNT)
            .map(|i| (-40.0 + 80.0 * i as f32 / COUNT as f32).exp2())
            .collect();
        arguments.extend((0..COUNT).map(|i| 0.5 + 2.0 * i as f32 / COUNT as f32));
        let mut logarithms = arguments.clone();
        Arch::new().dispatch(Logarithms(&mut logarithms));
        for (s, found) in arguments.iter().zip(logarithms) {
            let expected = f64::from(*s).log2();
            let off = (f64::from(found) - expected).abs();
            assert!(
                off < 3e-7 * expected.abs().max(1.0),
                "log₂ {s}: {found} {expected}"
            );
        }
    }
}
