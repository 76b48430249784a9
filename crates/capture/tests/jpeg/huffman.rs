//! Encodes levels as bits.

use super::blocks::ZIGZAG;
use super::segments;

/// Bits and length of the code of each byte.
pub(super) type Code = [(u16, u8); 256];

/// The codes of a JPEG's tables: for the lowest frequency and for the others, for Y and for UV.
pub(super) fn codes(jpeg: &[u8]) -> [[Box<Code>; 2]; 2] {
    let mut codes: [[Box<Code>; 2]; 2] =
        std::array::from_fn(|_| std::array::from_fn(|_| Box::new([(0, 0); 256])));
    for (_, segment) in segments(jpeg).filter(|(marker, _)| *marker == 0xC4) {
        let mut rest = &segment[4..];
        while let Some((&class, after)) = rest.split_first() {
            let (lengths, after) = after.split_at(16);
            let count = lengths.iter().map(|&n| usize::from(n)).sum();
            let (mut values, after) = after.split_at(count);
            rest = after;
            let code = &mut codes[usize::from(class >> 4)][usize::from(class & 15)];
            let mut bits = 0;
            for (length, &count) in (1..).zip(lengths) {
                for _ in 0..count {
                    code[usize::from(values[0])] = (bits, length);
                    (bits, values) = (bits + 1, &values[1..]);
                }
                bits <<= 1;
            }
        }
    }
    codes
}

/// Bits, most significant first, with a 0 byte after each byte of ones.
#[derive(Default)]
pub(super) struct Bits {
    pub(super) bytes: Vec<u8>,
    waiting: u8,
    count: u8,
}

impl Bits {
    fn put(&mut self, bits: u16, count: u8) {
        for k in (0..count).rev() {
            self.waiting = self.waiting << 1 | (bits >> k & 1) as u8;
            self.count += 1;
            if self.count == 8 {
                self.bytes.push(self.waiting);
                if self.waiting == 0xFF {
                    self.bytes.push(0);
                }
                (self.waiting, self.count) = (0, 0);
            }
        }
    }

    /// Fills the last byte with ones.
    pub(super) fn end(&mut self) {
        while self.count > 0 {
            self.put(1, 1);
        }
    }

    /// Writes a block's levels. The lowest frequency is the difference from that of the last block.
    pub(super) fn block(&mut self, levels: &[i32; 64], last_dc: &mut i32, dc: &Code, ac: &Code) {
        let difference = levels[0] - *last_dc;
        *last_dc = levels[0];
        self.number(0, difference, dc);
        let mut zeros = 0;
        for level in ZIGZAG.into_iter().skip(1).map(|k| levels[k]) {
            if level == 0 {
                zeros += 1;
                continue;
            }
            while zeros > 15 {
                self.put(ac[0xF0].0, ac[0xF0].1);
                zeros -= 16;
            }
            self.number(zeros, level, ac);
            zeros = 0;
        }
        if zeros > 0 {
            self.put(ac[0].0, ac[0].1);
        }
    }

    fn number(&mut self, zeros: usize, level: i32, code: &Code) {
        let size = (32 - level.unsigned_abs().leading_zeros()) as u8;
        let (bits, count) = code[zeros << 4 | usize::from(size)];
        assert!(count > 0, "there is a code for {zeros} zeros and {level}");
        self.put(bits, count);
        // A negative number is coded by the low bits of the number minus one.
        let own = if level < 0 { level - 1 } else { level };
        self.put(own as u16 & ((1u32 << size) - 1) as u16, size);
    }
}
