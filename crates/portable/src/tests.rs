//! Every operation equals its definition bit for bit, in every kind of registers.

use proptest::prelude::*;

use crate::operations::operations;
use crate::{Arch, Plain, Simd, WithSimd};

/// Numbers of each type, including special values.
#[derive(Clone, Debug)]
struct Numbers {
    f32s: [[f32; 16]; 3],
    f64s: [[f64; 8]; 3],
    u32s: [[u32; 16]; 2],
}

fn floats() -> impl Strategy<Value = f32> {
    prop_oneof![
        6 => any::<f32>(),
        4 => -300f32..300.0,
        1 => prop::sample::select(vec![0.0, -0.0, 1.0, f32::INFINITY, f32::NEG_INFINITY, f32::NAN]),
    ]
}

fn doubles() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => any::<f64>(),
        4 => -300f64..300.0,
        1 => prop::sample::select(vec![0.0, -0.0, 1.0, f64::INFINITY, f64::NEG_INFINITY, f64::NAN]),
    ]
}

fn numbers() -> impl Strategy<Value = Numbers> {
    (
        prop::array::uniform3(prop::array::uniform16(floats())),
        prop::array::uniform3(prop::array::uniform8(doubles())),
        prop::array::uniform2(prop::array::uniform16(any::<u32>())),
    )
        .prop_map(|(f32s, f64s, u32s)| Numbers { f32s, f64s, u32s })
}

/// The results of every operation, as bits. All NaNs count as equal, because it is not specified
/// which NaN an operation returns.
struct All<'a>(&'a Numbers);

trait Bits {
    fn bits(&self, to: &mut Vec<u64>);
}

impl Bits for f32 {
    fn bits(&self, to: &mut Vec<u64>) {
        to.push(if self.is_nan() {
            1 << 40
        } else {
            u64::from(self.to_bits())
        });
    }
}

impl Bits for f64 {
    fn bits(&self, to: &mut Vec<u64>) {
        to.push(if self.is_nan() {
            u64::MAX
        } else {
            self.to_bits()
        });
    }
}

/// Converts an array to a vector.
macro_rules! lanes {
    (f32s, $simd:ident, $array:expr) => {
        S::as_simd_f32s(&$array).0[0]
    };
    (f64s, $simd:ident, $array:expr) => {
        S::as_simd_f64s(&$array).0[0]
    };
    (u32s, $simd:ident, $array:expr) => {
        S::as_simd_u32s(&$array).0[0]
    };
}

/// The operand of a given name and type.
macro_rules! operand {
    ($numbers:ident, $simd:ident, a, f32s) => {
        lanes!(f32s, $simd, $numbers.f32s[0])
    };
    ($numbers:ident, $simd:ident, b, f32s) => {
        lanes!(f32s, $simd, $numbers.f32s[1])
    };
    ($numbers:ident, $simd:ident, a, f64s) => {
        lanes!(f64s, $simd, $numbers.f64s[0])
    };
    ($numbers:ident, $simd:ident, b, f64s) => {
        lanes!(f64s, $simd, $numbers.f64s[1])
    };
    ($numbers:ident, $simd:ident, a, u32s) => {
        lanes!(u32s, $simd, $numbers.u32s[0])
    };
    ($numbers:ident, $simd:ident, b, u32s) => {
        lanes!(u32s, $simd, $numbers.u32s[1])
    };
    ($numbers:ident, $simd:ident, mask, m32s) => {
        $simd.less_than_f32s(
            lanes!(f32s, $simd, $numbers.f32s[2]),
            lanes!(f32s, $simd, $numbers.f32s[0]),
        )
    };
}

/// Writes the bits of a result.
macro_rules! write_bits {
    ($to:ident, $simd:ident, f32s, $result:expr) => {{
        let mut out = [0.0f32; 16];
        S::as_mut_simd_f32s(&mut out).0[0] = $result;
        out.iter().for_each(|x| x.bits(&mut $to));
    }};
    ($to:ident, $simd:ident, f64s, $result:expr) => {{
        let mut out = [0.0f64; 8];
        S::as_mut_simd_f64s(&mut out).0[0] = $result;
        out.iter().for_each(|x| x.bits(&mut $to));
    }};
    ($to:ident, $simd:ident, u32s, $result:expr) => {{
        let mut out = [0u32; 16];
        S::as_mut_simd_u32s(&mut out).0[0] = $result;
        $to.extend(out.iter().map(|&x| u64::from(x)));
    }};
    ($to:ident, $simd:ident, m32s, $result:expr) => {{
        let answers = $result;
        let chosen = $simd.select_f32s(answers, $simd.splat_f32s(1.0), $simd.splat_f32s(0.0));
        write_bits!($to, $simd, f32s, chosen);
    }};
}

macro_rules! run_all {
    ($($name:ident($($a:ident: $from:ident),*) -> $to:ident = $definition:expr;)*) => {
        impl WithSimd for All<'_> {
            type Output = Vec<u64>;

            #[inline(always)]
            fn with_simd<S: Simd>(self, simd: S) -> Vec<u64> {
                let numbers = self.0;
                let mut bits = Vec::new();
                $(write_bits!(bits, simd, $to, simd.$name($(operand!(numbers, simd, $a, $from)),*));)*
                let [a, b, c] = [0, 1, 2].map(|k| lanes!(f32s, simd, numbers.f32s[k]));
                write_bits!(bits, simd, f32s, simd.mul_add_f32s(a, b, c));
                simd.reduce_sum_f32s(a).bits(&mut bits);
                simd.reduce_min_f32s(a).bits(&mut bits);
                simd.reduce_max_f32s(a).bits(&mut bits);
                write_bits!(bits, simd, u32s, simd.splat_u32s(numbers.u32s[0][0]));
                let [a, b, c] = [0, 1, 2].map(|k| lanes!(f64s, simd, numbers.f64s[k]));
                write_bits!(bits, simd, f64s, simd.mul_add_f64s(a, b, c));
                simd.reduce_sum_f64s(a).bits(&mut bits);
                simd.reduce_max_f64s(a).bits(&mut bits);
                write_bits!(bits, simd, f64s, simd.splat_f64s(numbers.f64s[0][0]));
                bits
            }
        }

        /// The results by the definitions alone.
        fn defined(numbers: &Numbers) -> Vec<Vec<u64>> {
            let mut all = Vec::new();
            $(all.push(define!(numbers, $to, [$($a: $from),*], $definition));)*
            all
        }
    };
}

/// One operation by its definition, lane by lane.
macro_rules! define {
    ($numbers:ident, $to:ident, [$($a:ident: $from:ident),*], $definition:expr) => {{
        let mut bits = Vec::new();
        for i in 0..count!($to) {
            $(let $a = lane!($numbers, $a, $from, i);)*
            lane_bits!($to, $definition, bits);
        }
        bits
    }};
}

macro_rules! count {
    (f64s) => {
        8
    };
    ($other:ident) => {
        16
    };
}

macro_rules! lane {
    ($numbers:ident, a, $from:ident, $i:ident) => {
        $numbers.$from[0][$i]
    };
    ($numbers:ident, b, $from:ident, $i:ident) => {
        $numbers.$from[1][$i]
    };
    ($numbers:ident, mask, m32s, $i:ident) => {
        $numbers.f32s[2][$i] < $numbers.f32s[0][$i]
    };
}

macro_rules! lane_bits {
    (u32s, $value:expr, $bits:ident) => {
        $bits.push(u64::from($value))
    };
    (m32s, $value:expr, $bits:ident) => {
        f32::from(u8::from($value)).bits(&mut $bits)
    };
    ($other:ident, $value:expr, $bits:ident) => {
        $value.bits(&mut $bits)
    };
}

operations!(run_all);

proptest! {
    #[test]
    fn every_operation_is_its_definition_in_all_registers(numbers in numbers()) {
        let plain = All(&numbers).with_simd(Plain);
        let defined = defined(&numbers).concat();
        prop_assert_eq!(&plain[..defined.len()], &defined[..]);
        for arch in Arch::all() {
            prop_assert_eq!(&arch.dispatch(All(&numbers)), &plain, "{:?}", arch);
        }
    }

    #[test]
    fn a_slice_is_its_vectors_and_a_rest(length in 0usize..70) {
        let floats: Vec<f32> = (0..length).map(|i| i as f32).collect();
        let doubles: Vec<f64> = (0..length).map(|i| i as f64).collect();
        for arch in Arch::all() {
            let found = arch.dispatch(Lengths(&floats, &doubles));
            prop_assert_eq!(found, [length / 16, length % 16, length / 8, length % 8]);
        }
    }
}

struct Lengths<'a>(&'a [f32], &'a [f64]);

impl WithSimd for Lengths<'_> {
    type Output = [usize; 4];

    fn with_simd<S: Simd>(self, _: S) -> [usize; 4] {
        let (floats, rest) = S::as_simd_f32s(self.0);
        let (doubles, more) = S::as_simd_f64s(self.1);
        [floats.len(), rest.len(), doubles.len(), more.len()]
    }
}

#[test]
fn sums_are_of_halves() {
    // 2²⁴ and ones: the result depends on the order.
    let mut numbers = [1.0f32; 16];
    numbers[0] = 16_777_216.0;
    let expected = {
        let mut a = numbers.to_vec();
        while a.len() > 1 {
            let half = a.len() / 2;
            a = (0..half).map(|i| a[i] + a[i + half]).collect();
        }
        a[0]
    };
    for arch in Arch::all() {
        assert_eq!(arch.dispatch(Sum(&numbers)), expected, "{arch:?}");
    }
}

struct Sum<'a>(&'a [f32; 16]);

impl WithSimd for Sum<'_> {
    type Output = f32;

    fn with_simd<S: Simd>(self, simd: S) -> f32 {
        simd.reduce_sum_f32s(S::as_simd_f32s(self.0).0[0])
    }
}
