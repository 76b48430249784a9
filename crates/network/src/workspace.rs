//! The memory of a run.

use lariat_portable::Plane;

use crate::network::Network;

/// Activations of a picture. The memory is reused: a run allocates only for a picture larger than
/// all before it.
#[derive(Clone, Debug)]
pub struct Workspace {
    /// Ring of four picture rows with four bytes per pixel. Row y is at index y mod 4. The border
    /// holds `GREY`, the value outside the picture.
    pub(crate) picture: Plane,
    /// Ring of four rows at 1/2 scale.
    pub(crate) half: Plane,
    pub(crate) quarter: Plane,
    pub(crate) eighth: [Plane; 3],
    pub(crate) sixteenth: [Plane; 3],
    /// One row at 1/4 scale, from which the maps are computed.
    pub(crate) last: Plane,
    /// One row of signed bytes.
    pub(crate) signed: Vec<u8>,
}

/// Value of pixels outside the picture, which represents zero.
pub(crate) const GREY: u8 = 64;

impl Workspace {
    /// Creates an empty workspace.
    pub fn new() -> Self {
        // A border is as wide as the largest dilation of its readers.
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

    /// Allocates for pictures of this size, so that no run on one allocates.
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
