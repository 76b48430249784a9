//! Loops over all pixels: splitting a row into its channels, and lookups in the cube.

use super::cube::Cube;

#[cfg(target_arch = "x86_64")]
mod x86;

/// Takes a cube, a row's channels, and the outputs for the selected pixels as bytes and as bits.
type Select = fn(&Cube, [&[u8]; 3], &mut [u8], &mut [u64]);

/// The kernels for this machine.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kernels {
    /// Splits three interleaved channels into a slice each.
    pub(super) split_three: fn(&[u8], [&mut [u8]; 3]),
    /// Splits two pixels at a time from Y, U, Y, V into Y, U and V, one byte per pixel.
    pub(super) split_yuyv: fn(&[u8], [&mut [u8]; 3]),
    /// As `split_yuyv`, from U, Y, V, Y.
    pub(super) split_uyvy: fn(&[u8], [&mut [u8]; 3]),
    /// Splits the U and V of two pixels at a time, one byte per pixel.
    pub(super) split_uv: fn(&[u8], [&mut [u8]; 2]),
    /// Tests a row's colors, given its channels. Sets one bit per pixel if the cube holds the
    /// color, and one byte to 255 or 0.
    pub(super) select: Select,
}

impl Kernels {
    /// The fastest kernels that this machine can run.
    fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(kernels) = x86::detect() {
            return kernels;
        }
        PLAIN
    }
}

impl Default for Kernels {
    fn default() -> Self {
        Self::detect()
    }
}

const PLAIN: Kernels = Kernels {
    split_three,
    split_yuyv: |row, out| lariat_portable::Arch::new().dispatch(|| split_pairs::<0>(row, out)),
    split_uyvy: |row, out| lariat_portable::Arch::new().dispatch(|| split_pairs::<8>(row, out)),
    split_uv: |row, out| lariat_portable::Arch::new().dispatch(|| split_uv(row, out)),
    select,
};

/// All kernels that this machine can run.
#[cfg(test)]
pub(super) fn all() -> Vec<Kernels> {
    let mut all = vec![PLAIN];
    #[cfg(target_arch = "x86_64")]
    all.extend(x86::all());
    all
}

fn split_three(row: &[u8], [a, b, c]: [&mut [u8]; 3]) {
    for (((a, b), c), pixel) in a.iter_mut().zip(b).zip(c).zip(row.as_chunks::<3>().0) {
        [*a, *b, *c] = *pixel;
    }
}

/// Splits two pixels at a time. Their first Y begins at bit `LIGHT` of the four bytes: 0 or 8.
#[inline(always)]
fn split_pairs<const LIGHT: u32>(row: &[u8], planes: [&mut [u8]; 3]) {
    let color = 8 - LIGHT;
    let [y, u, v] = planes.map(|plane| plane.as_chunks_mut::<2>().0);
    for (((y, u), v), pair) in y.iter_mut().zip(u).zip(v).zip(row.as_chunks::<4>().0) {
        let pair = u32::from_le_bytes(*pair);
        let (light, color) = (pair >> LIGHT, pair >> color);
        *y = ((light & 0xFF | light >> 8 & 0xFF00) as u16).to_le_bytes();
        *u = (0x0101 * (color & 0xFF) as u16).to_le_bytes();
        *v = (0x0101 * (color >> 16 & 0xFF) as u16).to_le_bytes();
    }
}

#[inline(always)]
fn split_uv(row: &[u8], planes: [&mut [u8]; 2]) {
    let [u, v] = planes.map(|plane| plane.as_chunks_mut::<2>().0);
    for ((u, v), pair) in u.iter_mut().zip(v).zip(row.as_chunks::<2>().0) {
        let pair = u16::from_le_bytes(*pair);
        *u = (0x0101 * (pair & 0xFF)).to_le_bytes();
        *v = (0x0101 * (pair >> 8)).to_le_bytes();
    }
}

/// Definition of `select`: one lookup per pixel.
fn select(cube: &Cube, planes: [&[u8]; 3], inside: &mut [u8], words: &mut [u64]) {
    for (i, (inside, word)) in inside.chunks_mut(64).zip(words).enumerate() {
        *word = 0;
        let planes = planes.map(|plane| &plane[64 * i..][..inside.len()]);
        for (x, byte) in inside.iter_mut().enumerate() {
            let holds = cube.holds(planes.map(|plane| plane[x]));
            *byte = if holds { 255 } else { 0 };
            *word |= u64::from(holds) << x;
        }
    }
}

/// Returns which of up to 64 pixels the cube holds. Only those in `may` are looked up.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn among(may: u64, cube: &Cube, planes: [&[u8; 64]; 3]) -> u64 {
    let (mut rest, mut word) = (may, 0);
    while rest != 0 {
        let x = rest.trailing_zeros() as usize;
        rest &= rest - 1;
        word |= u64::from(cube.holds(planes.map(|plane| plane[x & 63]))) << x;
    }
    word
}

#[cfg(test)]
mod tests {
    use super::super::cube::tests::examples;
    use super::*;
    use proptest::prelude::*;
    use std::sync::LazyLock;

    static CUBES: LazyLock<Vec<Cube>> = LazyLock::new(|| {
        let cube = |ranges: &Vec<_>| {
            let mut cube = Cube::default();
            cube.fill(ranges, false);
            cube
        };
        examples()[..2].iter().map(cube).collect()
    });

    fn planes() -> impl Strategy<Value = [Vec<u8>; 3]> {
        let any_colors = prop::collection::vec(any::<[u8; 3]>(), 0..300);
        // A single color for all pixels, inside or outside the ranges.
        let color = prop_oneof![Just([20, 40, 120]), Just([150, 40, 30]), any::<[u8; 3]>()];
        let one_color = (0..300usize, color).prop_map(|(pixels, color)| vec![color; pixels]);
        prop_oneof![any_colors, one_color]
            .prop_map(|pixels| [0, 1, 2].map(|c| pixels.iter().map(|pixel| pixel[c]).collect()))
    }

    proptest! {
        #[test]
        fn pixels_are_selected_as_one_by_one(planes in planes(), which in 0usize..2) {
            let (cube, pixels) = (&CUBES[which], planes[0].len());
            let planes = planes.each_ref().map(|plane| &plane[..]);
            let run = |kernels: &Kernels, rubbish: u8| {
                let mut inside = vec![rubbish; pixels];
                let mut words = vec![u64::from(rubbish); pixels.div_ceil(64)];
                (kernels.select)(cube, planes, &mut inside, &mut words);
                (inside, words)
            };
            let expected = run(&PLAIN, 7);
            for kernels in all() {
                prop_assert_eq!(&run(&kernels, 9), &expected);
            }
        }
    }
}
