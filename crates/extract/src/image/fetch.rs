//! Prefetches pixels, so that many are on their way from memory at once.
//!
//! `unsafe` is needed because the prefetch instruction takes a pointer. Nothing is read through it,
//! and it always points at a byte of the image.
#![allow(unsafe_code)]

use super::Image;
use std::ops::Range;

/// Size of a cache line, in bytes.
const LINE: usize = 64;

impl Image<'_> {
    /// Prefetches a stretch of row (axis 0) or column (axis 1) `line`, clipped to the image.
    #[inline]
    pub(crate) fn fetch(&self, axis: usize, line: usize, stretch: Range<usize>) {
        let to = stretch.end.min([self.width(), self.height()][axis]);
        let bytes = |x: usize| self.format().row_bytes(x);
        if axis == 1 {
            for y in stretch.start..to {
                fetch(self.bytes(), y * self.stride() + bytes(line));
            }
        } else {
            let start = line * self.stride();
            let from = (start + bytes(stretch.start)) & !(LINE - 1);
            for place in (from..start + bytes(to)).step_by(LINE) {
                fetch(self.bytes(), place);
            }
        }
    }
}

/// Prefetches the cache line of a byte, if there is such a byte.
#[inline(always)]
fn fetch(bytes: &[u8], place: usize) {
    let Some(byte) = bytes.get(place).map(std::ptr::from_ref) else {
        return;
    };
    #[cfg(target_arch = "x86_64")]
    // SAFETY: every x86-64 has the instruction, and the pointer is to a byte of the slice.
    unsafe {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        _mm_prefetch::<_MM_HINT_T0>(byte.cast());
    }
    #[cfg(target_arch = "aarch64")]
    // SAFETY: every AArch64 has the instruction, the pointer is to a byte of the slice, and neither
    // memory nor registers change.
    unsafe {
        std::arch::asm!("prfm pldl1keep, [{}]", in(reg) byte, options(nostack, preserves_flags, readonly));
    }
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    let _ = byte;
}

#[cfg(test)]
mod tests {
    use crate::image::{Image, PixelFormat};

    #[test]
    fn what_lies_beyond_the_image_is_not_asked_for() {
        for format in PixelFormat::DIRECT {
            let (width, height) = (34, 20);
            let stride = format.row_bytes(width) + 5;
            let bytes = vec![0; stride * format.rows(height)];
            let image = Image::new(&bytes, width, height, stride, format).expect("it is an image");
            for axis in 0..2 {
                for stretch in [0..17, 25..42, 90..107] {
                    image.fetch(axis, 19, stretch);
                }
            }
        }
    }
}
