//! Every kind of registers gives the result of the formula.

use proptest::prelude::*;

use super::*;
use crate::SplitMix64;

/// A convolution with its parameters, and an image.
struct Case {
    shape: ConvolutionShape,
    weights: Vec<i8>,
    bias: Vec<i32>,
    scale: Vec<f32>,
    input: Plane,
    residual: Option<Vec<u8>>,
    finish: Finish,
}

impl Case {
    fn new(
        shape: ConvolutionShape,
        [width, height]: [usize; 2],
        finish: Finish,
        seed: u64,
    ) -> Self {
        let mut random = SplitMix64::new(seed);
        let wide = random.below(2) == 0;
        let weights = shape.side * shape.side * shape.in_channels * shape.out_channels;
        let weights = Vec::from_iter((0..weights).map(|_| match wide {
            true => random.below(255) as i8 as i32,
            false => [127, -127][random.below(2)],
        }));
        let weights = Vec::from_iter(weights.into_iter().map(|w| w.max(-127) as i8));
        let outs = shape.out_channels;
        let bias = Vec::from_iter((0..outs).map(|_| random.below(40_001) as i32 - 20_000));
        // From all zero to saturated.
        let scale = Vec::from_iter((0..outs).map(|_| {
            let most = [0.0, 0.0005, 0.01, 64.0][random.below(4)];
            random.uniform_f32(0.0, most)
        }));
        let mut input = Plane::new(shape.in_bytes(), shape.reach() + 1);
        input.resize(width * shape.stride, height * shape.stride, 0);
        for y in 0..input.height() {
            for byte in input.row_mut(y) {
                *byte = if wide { random.below(128) as u8 } else { 127 };
            }
        }
        let residual = (finish == Finish::Relu && random.below(2) == 0)
            .then(|| Vec::from_iter((0..width * height * outs).map(|_| random.below(128) as u8)));
        Self {
            shape,
            weights,
            bias,
            scale,
            input,
            residual,
            finish,
        }
    }

    fn width(&self) -> usize {
        self.input.width() / self.shape.stride
    }

    /// The formula, index by index.
    fn expected(&self, y: usize) -> Vec<u8> {
        let shape = self.shape;
        let mut out = Vec::new();
        for (x, o) in (0..self.width()).flat_map(|x| (0..shape.out_channels).map(move |o| (x, o))) {
            let mut sum = self.bias[o];
            for (ky, kx) in (0..shape.side).flat_map(|ky| (0..shape.side).map(move |kx| (ky, kx))) {
                let at = |from: usize, k: usize| {
                    (from * shape.stride + k * shape.dilation) as isize - shape.reach() as isize
                };
                let (x, y) = (at(x, kx), at(y, ky));
                let inside = |k: isize, size: usize| (0..size as isize).contains(&k);
                if !inside(x, self.input.width()) || !inside(y, self.input.height()) {
                    continue;
                }
                let pixel = &self.input.row(y as usize)[x as usize * shape.in_bytes()..];
                for (i, activation) in pixel[..shape.in_channels].iter().enumerate() {
                    let tap = (ky * shape.side + kx) * shape.in_channels + i;
                    let weight = self.weights[tap * shape.out_channels + o];
                    sum += i32::from(*activation) * i32::from(weight);
                }
            }
            let value = (sum as f32 * self.scale[o]).round_ties_even() as i32;
            let at = (y * self.width() + x) * shape.out_channels + o;
            out.push(match self.finish {
                Finish::Signed => value.clamp(-128, 127) as u8,
                Finish::Relu => {
                    let residual = self.residual.as_ref().map_or(0, |r| i32::from(r[at]));
                    (value + residual).clamp(0, 127) as u8
                }
            });
        }
        out
    }

    fn found(&self, convolution: &Convolution, kernels: ConvolutionKernels, y: usize) -> Vec<u8> {
        let (shape, reach) = (self.shape, self.shape.reach());
        let top = (y * shape.stride) as isize - reach as isize;
        let rows = (0..shape.side).map(|k| (top + (k * shape.dilation) as isize, reach));
        let rows = Vec::from_iter(rows.map(|(y, reach)| self.input.windows(y, reach)));
        let bytes = self.width() * shape.out_channels;
        let residual = self.residual.as_ref().map(|r| &r[y * bytes..][..bytes]);
        let mut out = vec![9; bytes];
        convolution.row(kernels, &rows, residual, &mut out);
        out
    }
}

fn shapes() -> impl Strategy<Value = ConvolutionShape> {
    let windows = prop_oneof![
        Just((1, 1, 1)),
        Just((3, 1, 1)),
        Just((3, 2, 1)),
        Just((3, 1, 2)),
        Just((3, 1, 4)),
        Just((1, 2, 1)),
    ];
    let ins = prop_oneof![Just(3usize), 1usize..8, (1usize..6).prop_map(|n| 16 * n)];
    (windows, ins, 1usize..8).prop_map(|((side, stride, dilation), in_channels, outs)| {
        ConvolutionShape {
            in_channels,
            out_channels: 16 * outs,
            side,
            stride,
            dilation,
        }
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    #[test]
    fn every_kind_of_registers_gives_what_the_formula_gives(
        shape in shapes(), width in 1usize..40, height in 1usize..4, signed: bool, seed: u64,
    ) {
        let finish = if signed { Finish::Signed } else { Finish::Relu };
        let case = Case::new(shape, [width, height], finish, seed);
        let made = Convolution::new(shape, &case.weights, &case.bias, &case.scale, finish);
        let convolution = made.expect("the numbers are within bounds");
        for y in 0..height {
            let expected = case.expected(y);
            for kernels in ConvolutionKernels::all() {
                let found = case.found(&convolution, kernels, y);
                prop_assert_eq!(&found, &expected, "{}", kernels.name());
            }
        }
    }

    #[test]
    fn pixels_are_widened_as_the_plain_loop_does(
        rgb in prop::collection::vec(any::<u8>(), 0..400), room in 0usize..140,
    ) {
        let mut expected = vec![7; 4 * room];
        plain::widen(&rgb, &mut expected);
        for kernels in ConvolutionKernels::all() {
            let mut found = vec![7; 4 * room];
            kernels.widen(&rgb, &mut found);
            prop_assert_eq!(&found, &expected, "{}", kernels.name());
        }
    }

    #[test]
    fn bytes_are_looked_up_as_the_plain_loop_does(
        bytes in prop::collection::vec(any::<u8>(), 0..400), factor: u8,
    ) {
        let table = std::array::from_fn(|k| (k as u8).wrapping_mul(factor) ^ 5);
        let mut expected = bytes.clone();
        plain::look_up(&table, &mut expected);
        for kernels in ConvolutionKernels::all() {
            let mut found = bytes.clone();
            kernels.look_up(&table, &mut found);
            prop_assert_eq!(&found, &expected, "{}", kernels.name());
        }
    }
}

#[test]
fn numbers_out_of_bounds_are_refused_in_words() {
    let shape = ConvolutionShape {
        in_channels: 16,
        out_channels: 16,
        side: 1,
        stride: 1,
        dilation: 1,
    };
    let make = |shape, weight: i8, bias: i32, scale: f32, scales: usize| {
        let made = Convolution::new(
            shape,
            &[weight; 256],
            &[bias; 16],
            &vec![scale; scales],
            Finish::Relu,
        );
        made.map(|_| ()).map_err(|error| error.to_string())
    };
    assert_eq!(make(shape, 127, 1 << 23, 0.5, 16), Ok(()));
    let refused = [
        (make(shape, -128, 0, 0.5, 16), "−128: weights lie from"),
        (make(shape, 1, 1 << 24, 0.5, 16), "reach 16779248"),
        (make(shape, 1, i32::MIN, 0.5, 16), "reach 2147485680"),
        (make(shape, 1, 0, f32::NAN, 16), "A scale of NaN"),
        (make(shape, 1, 0, -0.1, 16), "from 0 to 64"),
        (
            make(shape, 1, 0, 0.5, 15),
            "15 scales for a convolution of 16",
        ),
        (
            make(ConvolutionShape { side: 5, ..shape }, 1, 0, 0.5, 16),
            "1 × 1 or 3 × 3",
        ),
        (
            make(
                ConvolutionShape {
                    out_channels: 0,
                    ..shape
                },
                1,
                0,
                0.5,
                16,
            ),
            "multiple of 16",
        ),
    ];
    for (found, expected) in refused {
        assert!(
            found.as_ref().is_err_and(|text| text.contains(expected)),
            "{found:?}"
        );
    }
}

#[test]
fn a_window_of_stride_two_begins_at_its_output_s_place() {
    let shape = ConvolutionShape {
        in_channels: 16,
        out_channels: 16,
        side: 3,
        stride: 2,
        dilation: 1,
    };
    // Only the window's last pixel counts: (2, 2) for output (0, 0).
    let mut weights = vec![0; 9 * 256];
    weights[8 * 256] = 1;
    let convolution = Convolution::new(shape, &weights, &[0; 16], &[1.0; 16], Finish::Relu);
    let convolution = convolution.expect("the numbers are within bounds");
    let mut plane = Plane::new(16, 1);
    plane.resize(4, 4, 0);
    plane.row_mut(2)[2 * 16] = 77;
    for kernels in ConvolutionKernels::all() {
        let mut out = [9; 32];
        let rows = [0, 1, 2].map(|y| plane.windows(y, 0));
        convolution.row(kernels, &rows, None, &mut out);
        assert_eq!((out[0], out[16]), (77, 0));
    }
}
