//! The list of lane-wise vector operations. It generates the trait, its three implementations and
//! their tests. Each entry defines the operation in one lane.

/// Passes the list to a macro.
macro_rules! operations {
    ($then:ident) => {
        $then! {
            add_f32s(a: f32s, b: f32s) -> f32s = a + b;
            sub_f32s(a: f32s, b: f32s) -> f32s = a - b;
            mul_f32s(a: f32s, b: f32s) -> f32s = a * b;
            div_f32s(a: f32s, b: f32s) -> f32s = a / b;
            // As on x86: the second operand if they are equal or one is NaN.
            min_f32s(a: f32s, b: f32s) -> f32s = if a < b { a } else { b };
            max_f32s(a: f32s, b: f32s) -> f32s = if a > b { a } else { b };
            abs_f32s(a: f32s) -> f32s = a.abs();
            sqrt_f32s(a: f32s) -> f32s = a.sqrt();
            equal_f32s(a: f32s, b: f32s) -> m32s = a == b;
            less_than_f32s(a: f32s, b: f32s) -> m32s = a < b;
            less_than_or_equal_f32s(a: f32s, b: f32s) -> m32s = a <= b;
            select_f32s(mask: m32s, a: f32s, b: f32s) -> f32s = if mask { a } else { b };
            transmute_u32s_f32s(a: f32s) -> u32s = a.to_bits();
            transmute_f32s_u32s(a: u32s) -> f32s = f32::from_bits(a);
            add_u32s(a: u32s, b: u32s) -> u32s = a.wrapping_add(b);
            sub_u32s(a: u32s, b: u32s) -> u32s = a.wrapping_sub(b);
            and_u32s(a: u32s, b: u32s) -> u32s = a & b;
            or_u32s(a: u32s, b: u32s) -> u32s = a | b;
            wrapping_dyn_shl_u32s(a: u32s, b: u32s) -> u32s = a.wrapping_shl(b);
            wrapping_dyn_shr_u32s(a: u32s, b: u32s) -> u32s = a.wrapping_shr(b);
            add_f64s(a: f64s, b: f64s) -> f64s = a + b;
            sub_f64s(a: f64s, b: f64s) -> f64s = a - b;
            mul_f64s(a: f64s, b: f64s) -> f64s = a * b;
            min_f64s(a: f64s, b: f64s) -> f64s = if a < b { a } else { b };
            max_f64s(a: f64s, b: f64s) -> f64s = if a > b { a } else { b };
            abs_f64s(a: f64s) -> f64s = a.abs();
        }
    };
}

pub(crate) use operations;
