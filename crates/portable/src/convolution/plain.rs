//! The kernels as plain loops, which define them.

use super::Finish;
use super::kernels::{Block, Job, Spin};

/// Computes a block's channels of a row.
pub(super) fn row(job: &mut Job, block: &Block) {
    let (shape, step) = (job.shape, job.step());
    let (bytes, channels) = (shape.in_bytes(), shape.out_channels);
    let groups = block.bias.len();
    for x in 0..job.width {
        for group in 0..groups {
            let mut sums = block.bias[group].0;
            let mut weights = block.weights[group..].iter().step_by(groups);
            for row in job.rows {
                for kx in 0..shape.side {
                    let pixel = &row[x * step + kx * shape.dilation * bytes..][..bytes];
                    for (four, weights) in pixel.as_chunks::<4>().0.iter().zip(&mut weights) {
                        for (sum, weights) in sums.iter_mut().zip(weights.0.as_chunks::<4>().0) {
                            *sum += (0..4)
                                .map(|k| i32::from(four[k]) * i32::from(weights[k]))
                                .sum::<i32>();
                        }
                    }
                }
            }
            let at = x * channels + block.first + 16 * group;
            for (lane, (sum, scale)) in sums.iter().zip(block.scale[group].0).enumerate() {
                let value = (*sum as f32 * scale).round_ties_even() as i32;
                let residual = job.residual.map_or(0, |r| i32::from(r[at + lane]));
                job.out[at + lane] = match job.finish {
                    Finish::Relu => (value + residual).clamp(0, 127) as u8,
                    Finish::Signed => (value.clamp(-128, 127) as i8).cast_unsigned(),
                };
            }
        }
    }
}

/// Converts pixels of three bytes to pixels of four.
pub(super) fn widen(rgb: &[u8], out: &mut [u8]) {
    let pixels = rgb.as_chunks::<3>().0.iter();
    for (&[r, g, b], out) in pixels.zip(out.as_chunks_mut::<4>().0) {
        *out = [r >> 1, g >> 1, b >> 1, 0];
    }
}

/// Replaces bytes using a table.
pub(super) fn look_up(table: &[u8; 256], bytes: &mut [u8]) {
    for byte in bytes {
        *byte = table[usize::from(*byte)];
    }
}

/// Multiply-adds in 16 lanes.
pub(super) fn spin(rounds: u64) -> Spin {
    let mut sums = [0i32; 16];
    for round in 0..rounds {
        let input = std::hint::black_box(round as u8 & 127);
        for (lane, sum) in sums.iter_mut().enumerate() {
            *sum = sum.wrapping_add(i32::from(input) * i32::from(lane as i8));
        }
    }
    Spin {
        multiply_adds: 16 * rounds,
        sum: sums.iter().fold(0, |a, b| a.wrapping_add(*b)),
    }
}
