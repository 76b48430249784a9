//! Notices: probable faults of a result and their remedies, in words for the user.

use crate::options::Mask;
use std::fmt;

/// A probable fault of a result, and its remedies. `Display` prints the
/// [`sentence`](Notice::sentence) for the automatic mask.
///
/// A picture whose curves are all confident gets no notice, whatever the table is like. Neither
/// does an empty table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Notice {
    /// No rope was found, and the table has checks, stripes or grain stronger than its noise.
    /// Brightness and color alone do not tell where the pattern ends and a rope begins.
    CheckeredTable,
    /// No rope was found, and the image has light and shade, or several surfaces.
    UnevenTable,
    /// No rope was found, and the noise would hide a rope that differs little from the table, as in
    /// a dark picture.
    Noisy,
    /// Something differs from the table by hardly more than its noise: a rope of the table's color.
    LikeTheTable,
    /// No rope was found, and what differs from the table fills too much of the image to be only
    /// ropes.
    Covered,
    /// Something far wider than a rope touches or covers ropes. Parts of them may be missing there.
    TooWide,
    /// Only the shadow of a rope was found, and it was rejected.
    OwnShadow,
    /// Something that looks like the shadow of a rope may be a parallel rope. Its status is
    /// [`Status::Doubtful`](crate::Status).
    MaybeShadow,
    /// Something straight and short, unlike the rope next to it, may be a pen. It is reported as a
    /// curve with status [`Doubtful`](crate::Status::Doubtful), and so are the objects of the next
    /// three notices.
    LikeAPen,
    /// Something small, unlike the rope next to it, may be print or a mark.
    LikeAMark,
    /// Something straight between two different surfaces, or a strip at the picture's border, may
    /// be an edge.
    LikeAnEdge,
    /// Something round may be a rim.
    LikeARim,
    /// More curves were found than can be reported, and the least confident and shortest were left
    /// out. If a mask by color or from elsewhere is a net, like a grid or a keyboard, all curves
    /// were left out.
    TooMany,
    /// A curve's [confidence](crate::Curve::confidence) is below [the
    /// threshold](crate::Options::min_confidence), and no other notice explains why.
    Unsure,
    /// The whole image is black.
    Black,
    /// The whole image is white.
    White,
}

impl Notice {
    /// Short name for programs: lowercase words joined by `-`.
    pub fn name(self) -> &'static str {
        match self {
            Notice::CheckeredTable => "checkered-table",
            Notice::UnevenTable => "uneven-table",
            Notice::Noisy => "noisy",
            Notice::LikeTheTable => "like-the-table",
            Notice::Covered => "covered",
            Notice::TooWide => "too-wide",
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

impl Notice {
    /// Returns whether the notice is about ropes, which may be missing or wrong. The others are
    /// about the table and matter only if no rope was found.
    pub(crate) fn is_of_ropes(self) -> bool {
        matches!(
            self,
            Notice::LikeTheTable | Notice::MaybeShadow | Notice::TooWide
        )
    }

    /// A whole sentence: what was seen, and what to do. If the user has already given a mask, the
    /// remedy `lariat pick`, which finds the rope's own color as a mask, is left out.
    pub fn sentence(self, mask: &Mask) -> String {
        let (seen, remedies) = self.words();
        let is_given = matches!(mask, Mask::Hsv(..) | Mask::External);
        let remedies = remedies
            .iter()
            .filter(|&&remedy| !(is_given && remedy == OWN_COLOR));
        let remedies: Vec<&str> = remedies.copied().collect();
        match remedies.split_last() {
            None => seen.to_owned(),
            Some((only, [])) => format!("{seen}: {only}"),
            Some((last, others)) => format!("{seen}: {}, or {last}", others.join(", ")),
        }
    }

    /// Wording of the observation, and the remedies.
    fn words(self) -> (&'static str, &'static [&'static str]) {
        match self {
            Notice::CheckeredTable => (
                "no rope was found, and the table is checkered, striped or grained, so that brightness and colour alone do not \
                 tell a rope from it",
                &["cover the table with a plain cloth", OWN_COLOR],
            ),
            Notice::UnevenTable => (
                "no rope was found, and light and shade, or more than one surface, lie across the image",
                &["light the table evenly", "show one surface only", OWN_COLOR],
            ),
            Notice::Noisy => (
                "no rope was found, and the picture is so noisy that a rope of almost the table's colour would not be seen",
                &[
                    "light it better",
                    "expose longer",
                    "put a table of another colour under the rope",
                    OWN_COLOR,
                ],
            ),
            Notice::LikeTheTable => (
                "something of almost the table's colour lies on it, too faint for the automatic mask to follow",
                &[
                    "put a table of another colour under the rope",
                    "light it better",
                    OWN_COLOR,
                ],
            ),
            Notice::Covered => (
                "no rope was found, and what differs from the table covers a large part of the image, more than ropes do",
                &[
                    "take what is not a rope out of the picture",
                    "show more of the table",
                    OWN_COLOR,
                ],
            ),
            Notice::TooWide => (
                "something far wider than a rope touches or covers the ropes, which may be incomplete there",
                &[
                    "take it out of the picture or out of the region that is read (roi)",
                    OWN_COLOR,
                ],
            ),
            Notice::OwnShadow => (
                "no rope was found but the shadow of one, which was left out",
                &["light the table from more sides", OWN_COLOR],
            ),
            Notice::MaybeShadow => (
                "something has the shape of the rope next to it and the table's colour in less light, like a shadow",
                &["light the table from more sides", OWN_COLOR],
            ),
            Notice::LikeAPen => (
                "something straight and short is unlike the rope next to it, like a pen",
                NO_ROPE,
            ),
            Notice::LikeAMark => (
                "something small is unlike the rope next to it, like letters and marks",
                NO_ROPE,
            ),
            Notice::LikeAnEdge => (
                "something parts two surfaces or fills a strip at the picture's border, as the edge of a board or a sheet does",
                NO_ROPE,
            ),
            Notice::LikeARim => ("something is as round as the rim of a cup", NO_ROPE),
            Notice::TooMany => (
                "there are more ropes, or things like them, than can be reported, and the least sure and shortest were left out",
                &["show fewer", "read a region only (roi)", OWN_COLOR],
            ),
            Notice::Unsure => (
                "a curve may not be a rope, or not the whole of it: its edges are faint, uneven or unlike each other, or much of it \
                 is covered",
                &[
                    "put the rope on a plain table of another colour",
                    "light it better",
                    OWN_COLOR,
                ],
            ),
            Notice::Black => (
                "the whole image is black",
                &["uncover the lens", "put the light on", "expose longer"],
            ),
            Notice::White => (
                "the whole image is white, burnt out",
                &["expose for a shorter time", "dim the light"],
            ),
        }
    }
}

/// The remedy that needs `lariat pick`.
const OWN_COLOR: &str = "give the rope's own colour as the mask (lariat pick finds it)";
/// The remedies for an object that may not be a rope.
const NO_ROPE: &[&str] = &[
    "take it out of the picture or out of the region that is read (roi)",
    "ask for as many ropes as there are (ropes)",
    OWN_COLOR,
];

impl fmt::Display for Notice {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.sentence(&Mask::Auto))
    }
}
