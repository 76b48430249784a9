#![allow(unsafe_code)] // Memory is mapped that other processes write to.
//! Something that is written twice, in turn, so that of a process that is killed while it writes the one before is left; and read by
//! others while it is written: one that is overwritten meanwhile is not taken.
//!
//! ```text
//! number   0 while it is written, else one more than the other's
//! length   in bytes
//! bytes    padded to words
//! ```

use std::fs::File;
use std::io;
use std::sync::atomic::{AtomicU64, Ordering, fence};

use rustix::mm::{MapFlags, ProtFlags, mmap};

const WORD: usize = size_of::<AtomicU64>();
/// Number and length.
const HEAD: usize = 2;

/// Maps a file of so many bytes, for as long as this process lives.
pub(super) fn map(file: &File, bytes: usize) -> io::Result<&'static [AtomicU64]> {
    let protection = ProtFlags::READ | ProtFlags::WRITE;
    // SAFETY: a new mapping, where the kernel likes it; nothing else is there.
    let start = unsafe {
        mmap(
            std::ptr::null_mut(),
            bytes,
            protection,
            MapFlags::SHARED,
            file,
            0,
        )?
    };
    // SAFETY: so many bytes are mapped, at a page's start, and never unmapped; any bytes are a number; who else writes there does so by
    // atomic stores, being lariat; and the file, which has no name, is never made shorter.
    Ok(unsafe { std::slice::from_raw_parts(start.cast::<AtomicU64>(), bytes / WORD) })
}

/// Where the two stand, in words.
#[derive(Debug, Clone, Copy)]
pub(super) struct Region {
    start: usize,
    /// How many words of bytes there may be in each.
    most: usize,
}

impl Region {
    pub(super) const fn at_the_start(most_bytes: usize) -> Self {
        let most = most_bytes.div_ceil(WORD);
        Self { start: 0, most }
    }

    pub(super) const fn after(before: Self, most_bytes: usize) -> Self {
        Self {
            start: before.end() / WORD,
            most: most_bytes.div_ceil(WORD),
        }
    }

    /// In bytes, at a page's end.
    pub(super) const fn end(self) -> usize {
        ((self.start + 2 * (HEAD + self.most)) * WORD).next_multiple_of(4096)
    }
}

/// The two of one kind.
#[derive(Debug, Clone, Copy)]
pub struct DoubleBuffer([&'static [AtomicU64]; 2]);

impl DoubleBuffer {
    pub(super) fn new(words: &'static [AtomicU64], region: Region) -> Self {
        let (first, second) = words[region.start..].split_at(HEAD + region.most);
        Self([first, &second[..HEAD + region.most]])
    }

    fn numbers(&self) -> [u64; 2] {
        self.0.map(|one| one[0].load(Ordering::Acquire))
    }

    /// Over the older one.
    ///
    /// # Errors
    /// There is no room for so many bytes: what was written stays.
    pub fn write(&self, bytes: &[u8]) -> io::Result<()> {
        let (whole, rest) = bytes.as_chunks::<WORD>();
        let mut last = [0; WORD];
        last[..rest.len()].copy_from_slice(rest);
        let last = Some(last).filter(|_| !rest.is_empty());
        let words = whole.iter().copied().chain(last).map(u64::from_le_bytes);
        if words.clone().count() > self.0[0].len() - HEAD {
            return Err(io::ErrorKind::FileTooLarge.into());
        }
        self.put(words, bytes.len());
        Ok(())
    }

    /// The same, of as many words as there is room for.
    pub(super) fn write_words<const N: usize>(&self, words: &[u64; N]) {
        self.put(words.iter().copied(), N * WORD);
    }

    fn put(&self, words: impl Iterator<Item = u64>, bytes: usize) {
        let [first, second] = self.numbers();
        let (one, number) = if first > second {
            (self.0[1], first)
        } else {
            (self.0[0], second)
        };
        // Whoever sees this sees the other whole; and this before anything else of it.
        one[0].store(0, Ordering::Release);
        fence(Ordering::Release);
        one[1].store(bytes as u64, Ordering::Relaxed);
        for (to, word) in one[HEAD..].iter().zip(words) {
            to.store(word, Ordering::Relaxed);
        }
        // After all of it.
        one[0].store(number + 1, Ordering::Release);
    }

    /// What was written last, then what was before it, as far as they are whole.
    pub fn newest_first(&self) -> impl Iterator<Item = Vec<u8>> {
        self.in_order().into_iter().filter_map(|(one, number)| {
            let length = one[1].load(Ordering::Relaxed) as usize;
            let words = one[HEAD..].get(..length.div_ceil(WORD))?;
            let words = words.iter().map(|word| word.load(Ordering::Relaxed));
            let mut bytes: Vec<u8> = words.flat_map(u64::to_le_bytes).collect();
            bytes.truncate(length);
            is_still(one, number).then_some(bytes)
        })
    }

    /// What was written last by [`write_words`](Self::write_words).
    pub(super) fn newest_words<const N: usize>(&self) -> Option<[u64; N]> {
        let mut whole = self.in_order().into_iter().filter_map(|(one, number)| {
            let words = std::array::from_fn(|i| one[HEAD + i].load(Ordering::Relaxed));
            is_still(one, number).then_some(words)
        });
        whole.next()
    }

    fn in_order(&self) -> [(&'static [AtomicU64], u64); 2] {
        let [first, second] = self.numbers();
        let (first, second) = ((self.0[0], first), (self.0[1], second));
        if first.1 > second.1 {
            [first, second]
        } else {
            [second, first]
        }
    }
}

/// Whether it was written whole, and nobody has begun to write over it.
fn is_still(one: &[AtomicU64], number: u64) -> bool {
    // After all that was read of it.
    fence(Ordering::Acquire);
    number != 0 && one[0].load(Ordering::Relaxed) == number
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLACE: Region = Region::after(Region::at_the_start(8), 100);

    fn buffers() -> DoubleBuffer {
        let file = tempfile::tempfile().expect("a file");
        file.set_len(PLACE.end() as u64).expect("room");
        DoubleBuffer::new(map(&file, PLACE.end()).expect("mapped"), PLACE)
    }

    fn all(buffers: &DoubleBuffer) -> Vec<Vec<u8>> {
        buffers.newest_first().collect()
    }

    #[test]
    fn the_last_two_are_there() {
        let buffers = buffers();
        assert!(all(&buffers).is_empty());
        for text in ["", "one", "two and two", "three"] {
            buffers.write(text.as_bytes()).expect("room");
        }
        assert_eq!(all(&buffers), [&b"three"[..], b"two and two"]);
    }

    #[test]
    fn what_is_too_large_leaves_all_as_it_was() {
        let buffers = buffers();
        buffers.write(&[7; 104]).expect("room");
        assert!(buffers.write(&[8; 105]).is_err());
        assert_eq!(all(&buffers), [[7; 104]]);
    }

    #[test]
    fn a_write_that_was_cut_off_leaves_the_one_before() {
        let buffers = buffers();
        for text in ["one", "two"] {
            buffers.write(text.as_bytes()).expect("room");
        }
        // As far as it came before it was killed.
        let older = buffers.in_order()[1].0;
        older[0].store(0, Ordering::Relaxed);
        older[HEAD].store(0x6572_6874, Ordering::Relaxed);
        assert_eq!(all(&buffers), [b"two"]);
        buffers.write(b"four").expect("room");
        assert_eq!(all(&buffers), [&b"four"[..], b"two"]);
    }

    #[test]
    fn what_is_written_meanwhile_is_never_half_read() {
        let buffers = buffers();
        std::thread::scope(|scope| {
            scope.spawn(|| {
                for number in 1..200_000_u64 {
                    buffers.write_words(&[number; 5]);
                }
            });
            let mut last = 0;
            while last < 199_999 {
                if let Some([first, rest @ ..]) = buffers.newest_words::<5>() {
                    assert!(rest == [first; 4] && first >= last);
                    last = first;
                }
            }
        });
    }
}
