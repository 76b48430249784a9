//! What the automatic mask is unsure of, in words for the user.

use std::fmt;

/// Why the automatic mask may be wrong about an image, and what to do: its `Display` is a whole sentence.
///
/// A picture on which the rope stands out is without one, and so is an empty table: no rope is an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Notice {
    /// The table is checkered, striped or grained, more strongly than its noise: where the pattern ends and the rope
    /// begins cannot be told from brightness and colour alone.
    CheckeredTable,
    /// Light and shade, or different surfaces, lie across the image: no smooth table to tell a rope from.
    UnevenTable,
    /// Something lies there that differs from the table by hardly more than its noise: a rope of the table's colour.
    LikeTheTable,
    /// What differs from the table is a large part of the image: hardly ropes alone.
    Covered,
    /// The whole image is black.
    Black,
    /// The whole image is white.
    White,
}

impl Notice {
    /// A short name for programs, of lower-case words joined by `-`.
    pub fn name(self) -> &'static str {
        match self {
            Notice::CheckeredTable => "checkered-table",
            Notice::UnevenTable => "uneven-table",
            Notice::LikeTheTable => "like-the-table",
            Notice::Covered => "covered",
            Notice::Black => "black",
            Notice::White => "white",
        }
    }
}

impl fmt::Display for Notice {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Notice::CheckeredTable => {
                "the table is checkered, striped or grained, and the automatic mask cannot tell a rope from its \
                 pattern for sure: cover it with a plain cloth, or give the rope's own colour as the mask"
            }
            Notice::UnevenTable => {
                "light and shade, or more than one surface, lie across the image, and the automatic mask takes only \
                 what stands out more than they do: light the table evenly, show one surface only, or give the rope's \
                 own colour as the mask"
            }
            Notice::LikeTheTable => {
                "something of almost the table's colour lies on it, too faint for the automatic mask to follow: put a \
                 table of another colour under the rope, light it better, or give the rope's own colour as the mask"
            }
            Notice::Covered => {
                "what differs from the table covers a large part of the image, more than ropes do: take what is no \
                 rope out of the picture, show more of the table, or give the rope's own colour as the mask"
            }
            Notice::Black => {
                "the whole image is black: uncover the lens, put the light on, or expose longer"
            }
            Notice::White => {
                "the whole image is white, burnt out: expose for a shorter time, or dim the light"
            }
        })
    }
}
