#![allow(unsafe_code)] // This file maps memory that other processes write to.
//! A double buffer in shared memory. The two copies are written alternately, so that the previous
//! one survives if a process is killed during a write. Others can read at any time; a copy that is
//! overwritten meanwhile is discarded.
//!
//! ```text
//! number   0 during a write, otherwise one more than the other copy's
//! length   in bytes
//! bytes    padded to words
//! ```

use std::fs::File;
use std::io;
use std::sync::atomic::{AtomicU64, Ordering, fence};

use rustix::mm::{MapFlags, ProtFlags, mmap};

const WORD: usize = size_of::<AtomicU64>();
/// Words for number and length.
const HEAD: usize = 2;

/// Maps `bytes` bytes of a file for the lifetime of this process.
pub(super) fn map(file: &File, bytes: usize) -> io::Result<&'static [AtomicU64]> {
    let protection = ProtFlags::READ | ProtFlags::WRITE;
    // SAFETY: This is a new mapping at an address that the kernel chooses, so it overlaps nothing.
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
    // SAFETY: This many bytes are mapped at the start of a page and never unmapped. Any bytes form
    // a valid number. All other writers are processes of lariat and use atomic stores. The file is
    // anonymous and never shrinks.
    Ok(unsafe { std::slice::from_raw_parts(start.cast::<AtomicU64>(), bytes / WORD) })
}

/// Position of the two copies, in words.
#[derive(Debug, Clone, Copy)]
pub(super) struct Region {
    start: usize,
    /// Capacity of each copy, in words.
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

    /// Returns the end in bytes, rounded up to a page.
    pub(super) const fn end(self) -> usize {
        ((self.start + 2 * (HEAD + self.most)) * WORD).next_multiple_of(4096)
    }
}

/// The two copies.
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

    /// Overwrites the older copy.
    ///
    /// # Errors
    /// Returns an error if the bytes do not fit. The existing copies stay unchanged.
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

    /// Overwrites the older copy with words that always fit.
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
        // Ordering: the other copy was completed before this store, and this store comes before the
        // new content.
        one[0].store(0, Ordering::Release);
        fence(Ordering::Release);
        one[1].store(bytes as u64, Ordering::Relaxed);
        for (to, word) in one[HEAD..].iter().zip(words) {
            to.store(word, Ordering::Relaxed);
        }
        // Stored after the content.
        one[0].store(number + 1, Ordering::Release);
    }

    /// Returns the complete copies, newest first.
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

    /// Returns the words last written by [`write_words`](Self::write_words).
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

/// Returns true if the copy was complete and has not been overwritten since.
fn is_still(one: &[AtomicU64], number: u64) -> bool {
    // Ordered after all reads of the content.
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
        // Simulate a write that was interrupted by a kill.
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
