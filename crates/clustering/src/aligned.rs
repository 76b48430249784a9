//! Lists of floats aligned to a cache line. The widest registers are as long as a line, and an
//! access that crosses two lines costs twice as much.

/// Floats in a cache line.
pub(crate) const LINE: usize = 16;

/// A list of floats whose first is at the start of a cache line.
#[derive(Debug, Default)]
pub(crate) struct Aligned {
    /// Storage, up to a line longer than the aligned list.
    list: Vec<f32>,
    length: usize,
}

impl Aligned {
    /// Sets the length. The contents are unspecified afterwards.
    pub(crate) fn set_length(&mut self, length: usize) {
        self.list.resize(length + LINE - 1, 0.0);
        self.length = length;
    }

    pub(crate) fn as_slice(&self) -> &[f32] {
        &self.list[self.skipped()..][..self.length]
    }

    pub(crate) fn as_mut_slice(&mut self) -> &mut [f32] {
        let skipped = self.skipped();
        &mut self.list[skipped..][..self.length]
    }

    /// Floats before the aligned start; 0 if the alignment cannot be determined.
    fn skipped(&self) -> usize {
        let skipped = self.list.as_ptr().align_offset(LINE * size_of::<f32>());
        skipped.min(self.list.len() - self.length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_begins_with_a_line_whatever_its_length() {
        let mut aligned = Aligned::default();
        assert!(aligned.as_slice().is_empty());
        for length in [1, 100, 5000, 3] {
            aligned.set_length(length);
            assert_eq!(aligned.as_mut_slice().len(), length);
            assert_eq!(aligned.as_slice().as_ptr().addr() % 64, 0);
        }
    }
}
