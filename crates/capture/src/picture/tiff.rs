//! Reads the directories of a TIFF file (TIFF 6.0, and BigTIFF with its longer numbers): the number
//! of pictures and the kind of their samples. `image` decodes the pictures but reports neither.

/// Maximum number of directories read. In a broken file, they may form a circle.
const MOST: usize = 1 << 12;

const NEW_SUBFILE_TYPE: u64 = 254;
const PHOTOMETRIC: u64 = 262;
const SAMPLE_FORMAT: u64 = 339;

/// Properties of a file's pictures.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Directories {
    /// Number of pictures, without reduced copies and masks.
    pub(super) pictures: usize,
    /// True if the first picture's samples are floating-point numbers.
    pub(super) has_floats: bool,
    /// True if the first picture's samples are palette indices.
    pub(super) has_palette: bool,
}

impl Directories {
    /// Reads as much of the file as is intact.
    pub(super) fn of(file: &[u8]) -> Self {
        let mut found = Self::default();
        if let Some(numbers) = Numbers::of(file) {
            // Stops at a damaged directory; the decoder reports what is wrong.
            let _ = found.read(&numbers);
        }
        found
    }

    fn read(&mut self, numbers: &Numbers) -> Option<()> {
        let long = if numbers.is_big { 8 } else { 4 };
        let mut at = numbers.number(if numbers.is_big { 8 } else { 4 }, long)?;
        for place in 0..MOST {
            if at == 0 {
                break;
            }
            let count = numbers.number(at, if numbers.is_big { 8 } else { 2 })?;
            let entries = at + if numbers.is_big { 8 } else { 2 };
            let entry_bytes = if numbers.is_big { 20 } else { 12 };
            let mut kind = 0;
            for entry in (0..count).map(|k| entries + k * entry_bytes) {
                let value = || numbers.value(entry);
                match numbers.number(entry, 2)? {
                    NEW_SUBFILE_TYPE => kind = value()?,
                    PHOTOMETRIC if place == 0 => self.has_palette = value()? == 3,
                    SAMPLE_FORMAT if place == 0 => self.has_floats = value()? == 3,
                    _ => {}
                }
            }
            // Bit 0: a smaller copy; bit 2: a mask.
            self.pictures += usize::from(kind & 5 == 0);
            at = numbers.number(entries + count * entry_bytes, long)?;
        }
        Some(())
    }
}

/// Reads numbers in the file's byte order.
struct Numbers<'a> {
    file: &'a [u8],
    is_little: bool,
    is_big: bool,
}

impl<'a> Numbers<'a> {
    fn of(file: &'a [u8]) -> Option<Self> {
        let (is_little, is_big) = match file.first_chunk()? {
            b"II*\0" => (true, false),
            b"MM\0*" => (false, false),
            b"II+\0" => (true, true),
            b"MM\0+" => (false, true),
            _ => return None,
        };
        Some(Self {
            file,
            is_little,
            is_big,
        })
    }

    /// Returns the number with this many bytes at a position.
    fn number(&self, at: u64, bytes: u64) -> Option<u64> {
        let at = usize::try_from(at).ok()?;
        let bytes = self.file.get(at..at.checked_add(bytes as usize)?)?;
        let join = |all: u64, byte: &u8| all << 8 | u64::from(*byte);
        Some(if self.is_little {
            bytes.iter().rev().fold(0, join)
        } else {
            bytes.iter().fold(0, join)
        })
    }

    /// First value of an integer entry. Values are stored in the entry itself if they fit.
    fn value(&self, entry: u64) -> Option<u64> {
        let long = if self.is_big { 8 } else { 4 };
        let bytes = match self.number(entry + 2, 2)? {
            3 => 2,
            4 => 4,
            16 => 8,
            _ => 1,
        };
        let count = self.number(entry + 4, long)?;
        let place = entry + 4 + long;
        if count.checked_mul(bytes)? <= long {
            return self.number(place, bytes);
        }
        self.number(self.number(place, long)?, bytes)
    }
}
