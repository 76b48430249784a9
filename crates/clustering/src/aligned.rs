//! Lists of floats that begin where a line of the cache does: the widest registers are as long as a line, and each that
//! lies across two of them costs twice.

/// Floats of a line.
pub(crate) const LINE: usize = 16;

/// Some floats, the first at the start of a line.
#[derive(Debug, Default)]
pub(crate) struct Aligned {
    /// Up to a line longer than it is.
    list: Vec<f32>,
    length: usize,
}

impl Aligned {
    /// Makes it as long; what it holds is not kept.
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

    /// Floats before the line; none where the machine cannot tell.
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
