//! Notices: probable faults of a result, and what to do, in words for the user.

use crate::options::Mask;
use std::fmt;

/// A probable fault of a result, and what to do. Its `Display` is its [`sentence`](Notice::sentence) for the automatic mask.
///
/// A picture whose curves are all confident has no notice, whatever the table is like. An empty table has no notice either.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Notice {
    /// No rope was found on a table that is checkered, striped or grained more strongly than its noise: brightness and colour
    /// alone do not tell where the pattern ends and a rope begins.
    CheckeredTable,
    /// No rope was found, and light and shade, or different surfaces, lie across the image.
    UnevenTable,
    /// No rope was found, and the noise would hide one that differs little from the table: a dark picture.
    Noisy,
    /// Something lies there that differs from the table by hardly more than its noise: a rope of the table's colour.
    LikeTheTable,
    /// No rope was found, and what differs from the table is a large part of the image: hardly ropes alone.
    Covered,
    /// Something far wider than a rope touches ropes, or covers them: where it does, they may be missing.
    TooWide,
    /// No rope was found but the shadow of one, which was left out.
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
    /// Returns true if it is about ropes, which may be missing or wrong. The others are about the table, and matter only if no rope
    /// was found.
    pub(crate) fn is_of_ropes(self) -> bool {
        matches!(
            self,
            Notice::LikeTheTable | Notice::MaybeShadow | Notice::TooWide
        )
    }

    /// A whole sentence: what was seen, and what to do. The remedy `lariat pick`, to give the rope's own colour as the mask, is left
    /// out where the user has given a mask already.
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

    /// The words for what was seen, and the remedies.
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
/// The remedies for a thing that may not be a rope.
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
