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
    /// A shadow that ropes cast beside them was left out.
    OwnShadow,
    /// What looks like the shadow of a rope may be a rope that lies parallel to it: it is [`Status::Doubtful`](crate::Status).
    MaybeShadow,
    /// Something straight and short, unlike the rope beside it, may be a pen. It is reported as a curve whose status is
    /// [`Doubtful`](crate::Status::Doubtful), as what the next ones tell of.
    LikeAPen,
    /// Something small, unlike the rope beside it, may be print or a mark.
    LikeAMark,
    /// Something straight with another surface on each side, or a strip at the picture's border, may be an edge.
    LikeAnEdge,
    /// Something round may be a rim.
    LikeARim,
    /// More curves were found than are ever reported: the least sure and shortest were left out. Of a mask by color or from elsewhere
    /// that is a net, as of a grid or a keyboard, all were.
    TooMany,
    /// A curve's [confidence](crate::Curve::confidence) is below [the threshold](crate::Options::min_confidence), and nothing
    /// else says why.
    Unsure,
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
            Notice::OwnShadow => "own-shadow",
            Notice::MaybeShadow => "maybe-shadow",
            Notice::LikeAPen => "like-a-pen",
            Notice::LikeAMark => "like-a-mark",
            Notice::LikeAnEdge => "like-an-edge",
            Notice::LikeARim => "like-a-rim",
            Notice::TooMany => "too-many",
            Notice::Unsure => "unsure",
            Notice::Black => "black",
            Notice::White => "white",
        }
    }
}

/// What to do about a thing that may be no rope.
const NO_ROPE: &str = "take it out of the picture or out of the region that is read (roi), ask for as many ropes as there \
                       are (ropes), or give the rope's own colour as the mask";

impl fmt::Display for Notice {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Notice::LikeAPen => {
                let seen = "something straight and short is unlike the rope beside it, as a pen is";
                return write!(f, "{seen}: {NO_ROPE}");
            }
            Notice::LikeAMark => {
                let seen = "something small is unlike the rope beside it, as letters and marks are";
                return write!(f, "{seen}: {NO_ROPE}");
            }
            Notice::LikeAnEdge => {
                let seen = "something parts two surfaces or fills a strip at the picture's border, as the edge of a board or a sheet does";
                return write!(f, "{seen}: {NO_ROPE}");
            }
            Notice::LikeARim => {
                return write!(f, "something is as round as the rim of a cup: {NO_ROPE}");
            }
            Notice::CheckeredTable => {
                "the table is checkered, striped or grained, and the automatic mask took what has the shape of a rope, which \
                 is not sure: cover the table with a plain cloth, or give the rope's own colour as the mask"
            }
            Notice::UnevenTable => {
                "light and shade, or more than one surface, lie across the image, and the automatic mask took what has the \
                 shape of a rope: light the table evenly, show one surface only, or give the rope's own colour as the mask"
            }
            Notice::LikeTheTable => {
                "something of almost the table's colour lies on it, too faint for the automatic mask to follow: put a \
                 table of another colour under the rope, light it better, or give the rope's own colour as the mask"
            }
            Notice::Covered => {
                "what differs from the table covers a large part of the image, more than ropes do: take what is no \
                 rope out of the picture, show more of the table, or give the rope's own colour as the mask"
            }
            Notice::OwnShadow => {
                "ropes cast a shadow on the table, of their own shape, which was left out: if a rope is missing, light \
                 the table from more sides, or give the rope's own colour as the mask"
            }
            Notice::MaybeShadow => {
                "something has the shape of a rope beside it and the table's colour in less light, as its shadow would: \
                 light the table from more sides, or give the rope's own colour as the mask"
            }
            Notice::TooMany => {
                "there are more ropes, or things like them, than can be reported, and the least sure and shortest were left out: show \
                 fewer, read a region only (roi), or give the ropes' own colour as the mask"
            }
            Notice::Unsure => {
                "a rope's edges are faint, uneven or unlike each other, or much of it is covered, so that it may be no rope, or not \
                 whole: put it on a table of another colour, light it better, or give the rope's own colour as the mask"
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
