//! The memory of a run.

use lariat_portable::Plane;

use crate::network::Network;

/// The activations of a picture, kept for the next one: it allocates only for a picture that is larger than all before.
#[derive(Clone, Debug)]
pub struct Workspace {
    /// Four rows of the picture, four bytes a pixel: row y lies at y mod 4, and the border is what is not of the picture.
    pub(crate) picture: Plane,
    /// Four rows at 1/2, likewise.
    pub(crate) half: Plane,
    pub(crate) quarter: Plane,
    pub(crate) eighth: [Plane; 3],
    pub(crate) sixteenth: [Plane; 3],
    /// A row at 1/4 that becomes the maps.
    pub(crate) last: Plane,
    /// A row of signed bytes.
    pub(crate) signed: Vec<u8>,
}

/// What is not of the picture: its zero.
pub(crate) const GREY: u8 = 64;

impl Workspace {
    /// Nothing yet.
    pub fn new() -> Self {
        // A border is as wide as the largest dilation.
        Self {
            picture: Plane::new(4, 1),
            half: Plane::new(16, 1),
            quarter: Plane::new(32, 1),
            eighth: [(); 3].map(|()| Plane::new(48, 1)),
            sixteenth: [(); 3].map(|()| Plane::new(64, 4)),
            last: Plane::new(32, 0),
            signed: Vec::new(),
        }
    }

    /// Makes room for pictures of this size, so that no run on one allocates.
    pub fn reserve(&mut self, width: usize, height: usize) {
        let [width, height] = [width, height].map(|side| side.next_multiple_of(Network::MULTIPLE));
        self.picture.resize(width, 4, GREY);
        self.half.resize(width / 2, 4, 0);
        self.quarter.resize(width / 4, height / 4, 0);
        for plane in &mut self.eighth {
            plane.resize(width / 8, height / 8, 0);
        }
        for plane in &mut self.sixteenth {
            plane.resize(width / 16, height / 16, 0);
        }
        self.last.resize(width / 4, 1, 0);
        self.signed.resize(width / 4 * 32, 0);
    }
}

impl Default for Workspace {
    fn default() -> Self {
        Self::new()
    }
}
