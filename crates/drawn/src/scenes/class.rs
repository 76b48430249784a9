//! Difficulties in pictures of ropes, one at a time.

use std::fmt;
use std::str::FromStr;

/// Kind of picture. Unless its class says otherwise, a picture shows one rope of 7 to 14 px. It has
/// up to two crossings above 35°, bends with a radius of at least 1.5 widths, and strands at least
/// two widths apart (between their centers). The camera has a blur of 0.6 px and noise of 2 levels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Class {
    /// A rope of 4 to 6 px.
    Thin,
    /// A rope of 7 to 15 px.
    Medium,
    /// A rope of 16 to 30 px.
    Thick,
    /// Sensor noise of 6 to 14 levels.
    Noise,
    /// Out of focus: a Gaussian of 1.2 to 3 px, but at most a third of the rope's width.
    Blur,
    /// The camera moves 3 to 10 px while the shutter is open, but at most ¾ of the rope's width.
    MotionBlur,
    /// The light falls to 35–60 % from one side to the other, with the spot of a lamp.
    UnevenLight,
    /// A rope that shines like plastic, with a near-white highlight along it.
    Shine,
    /// A coarse twist and dashes on the rope, and a mottled table.
    Texture,
    /// A soft shadow next to the rope.
    Shadow,
    /// No crossing.
    Crossings0,
    /// One crossing above 30°.
    Crossings1,
    /// Two crossings above 30°.
    Crossings2,
    /// Three crossings above 30°.
    Crossings3,
    /// Four crossings above 30°.
    Crossings4,
    /// Five crossings above 30°.
    Crossings5,
    /// One or two crossings, at least one of 20° to 30°.
    FlatCrossings,
    /// Two strands (of one rope or of two) run side by side in contact for 1 to 4 widths and part
    /// again without crossing.
    Touch,
    /// A tip next to a strand, or pointing at a strand, 0.3 to 2 widths (at least 1.5 px) from the
    /// strand's edge.
    EndsNear,
    /// A tip that touches a strand's edge, or overlaps it by up to 0.3 widths.
    EndsTouching,
    /// One end or both ends leave the image.
    Border,
    /// A closed loop with up to two crossings.
    Closed,
    /// A dark rope on a light table.
    DarkOnLight,
    /// A light rope on a dark table.
    LightOnDark,
    /// Two to four ropes of different colors, with up to three crossings in all.
    SeveralColors,
    /// Seeds 2k and 2k + 1 show the same scene, the second in half the light.
    LightChange,
    /// The rope's own sharp shadow on a light table, half a width to four widths from the rope. For
    /// seeds 4k to 4k + 3 it takes 15, 30, 45 and 60 % of the light.
    HardShadow,
    /// The same shadow as [`HardShadow`](Class::HardShadow), soft as from a wide lamp.
    SoftShadow,
    /// An object next to the rope that is not a rope: for seeds 5k to 5k + 4 a pen, a marker, a
    /// board's edge, a cup's rim, letters.
    Things,
    /// A white, shining rope on a light gray table: the dark rim of the rope is as light as the
    /// table.
    WhiteShine,
    /// A table whose color changes to a darker one.
    Gradient,
    /// A rope of two colors, twisted.
    Twisted,
    /// One to three ropes with a soft shadow on a plain surface. Seeds 4k to 4k + 3 have the usual
    /// noise, noise of 8 to 14 levels, noise of 14 to 20 levels, and noise of 8 to 20 levels as
    /// grain of a pixel or two.
    OnNoise,
    /// The ropes of [`OnNoise`](Class::OnNoise) on a texture: for seeds 4k to 4k + 3 wood, cloth,
    /// print, gravel.
    OnTexture,
    /// The ropes of [`OnNoise`](Class::OnNoise) on a desk with boxes, text, pens, cups.
    OnClutter,
    /// A rope pulled tight through the image, straight or slightly bent, on such surfaces: for
    /// seeds 4k to 4k + 3 plain, a texture, and twice a desk.
    Taut,
    /// The picture of a figure-eight knot with four crossings above 20°. The knot is tightened
    /// until 2.5 to 5 widths of rope are left between two crossings. Half of the pictures are
    /// knots; in the others, chance decides which strands are on top.
    Eights,
    /// A coil of three to five loops, which cross their neighbors at such flat angles that the
    /// crossings merge.
    Coils,
    /// Two ropes that run side by side in contact for 10 to 25 widths and part at both ends.
    Parallel,
    /// Three or four ropes of one color, with two to six crossings above 20° in all.
    OneColor,
    /// A hand from outside the picture, or a gripper, covers part of a rope.
    Covered,
    /// The picture was stored as a JPEG of quality 30, with color at half the resolution.
    Jpeg,
    /// A bend of the rope, by up to 90°, is outside the picture. It extends 1 to 3.5 widths beyond
    /// the border, over up to 14 widths of rope.
    Returning,
    /// One to three ropes of 8 to 45 widths, laid straight, in an even arc, or as a ring: like pens
    /// and rims.
    Laid,
}

impl Class {
    /// All classes whose ropes stand out from a plain table, in the order of the table.
    pub const ALL: [Self; 30] = [
        Self::Thin,
        Self::Medium,
        Self::Thick,
        Self::Noise,
        Self::Blur,
        Self::MotionBlur,
        Self::UnevenLight,
        Self::Shine,
        Self::Texture,
        Self::Shadow,
        Self::Crossings0,
        Self::Crossings1,
        Self::Crossings2,
        Self::Crossings3,
        Self::Crossings4,
        Self::Crossings5,
        Self::FlatCrossings,
        Self::Touch,
        Self::EndsNear,
        Self::EndsTouching,
        Self::Border,
        Self::Closed,
        Self::DarkOnLight,
        Self::LightOnDark,
        Self::SeveralColors,
        Self::LightChange,
        Self::HardShadow,
        Self::SoftShadow,
        Self::Things,
        Self::Jpeg,
    ];

    /// Classes in which a difference from the table does not identify a rope.
    pub const HARD: [Self; 10] = [
        Self::HardShadow,
        Self::SoftShadow,
        Self::WhiteShine,
        Self::Gradient,
        Self::Twisted,
        Self::OnNoise,
        Self::OnTexture,
        Self::OnClutter,
        Self::Taut,
        Self::Things,
    ];

    /// Classes in which ropes are hard to tell apart, or incomplete, even with a perfect mask.
    pub const SHAPES: [Self; 6] = [
        Self::Eights,
        Self::Coils,
        Self::Parallel,
        Self::OneColor,
        Self::Covered,
        Self::Returning,
    ];

    /// Classes of ropes with the shapes of other objects, on a plain table.
    pub const PLAIN: [Self; 1] = [Self::Laid];

    /// Returns whether the ropes are on a surface as in photographs.
    pub fn is_composed(self) -> bool {
        matches!(
            self,
            Self::OnNoise | Self::OnTexture | Self::OnClutter | Self::Taut
        )
    }

    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Thin => "thin",
            Self::Medium => "medium",
            Self::Thick => "thick",
            Self::Noise => "noise",
            Self::Blur => "blur",
            Self::MotionBlur => "motion-blur",
            Self::UnevenLight => "uneven-light",
            Self::Shine => "shine",
            Self::Texture => "texture",
            Self::Shadow => "shadow",
            Self::Crossings0 => "crossings-0",
            Self::Crossings1 => "crossings-1",
            Self::Crossings2 => "crossings-2",
            Self::Crossings3 => "crossings-3",
            Self::Crossings4 => "crossings-4",
            Self::Crossings5 => "crossings-5",
            Self::FlatCrossings => "flat-crossings",
            Self::Touch => "touch",
            Self::EndsNear => "ends-near",
            Self::EndsTouching => "ends-touching",
            Self::Border => "border",
            Self::Closed => "closed",
            Self::DarkOnLight => "dark-on-light",
            Self::LightOnDark => "light-on-dark",
            Self::SeveralColors => "several-colors",
            Self::LightChange => "light-change",
            Self::HardShadow => "hard-shadow",
            Self::SoftShadow => "soft-shadow",
            Self::Things => "things",
            Self::WhiteShine => "white-shine",
            Self::Gradient => "gradient",
            Self::Twisted => "twisted",
            Self::OnNoise => "on-noise",
            Self::OnTexture => "on-texture",
            Self::OnClutter => "on-clutter",
            Self::Taut => "taut",
            Self::Eights => "eights",
            Self::Coils => "coils",
            Self::Parallel => "parallel",
            Self::OneColor => "one-color",
            Self::Covered => "covered",
            Self::Jpeg => "jpeg",
            Self::Returning => "returning",
            Self::Laid => "laid",
        }
    }
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Class {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let mut classes = Self::ALL.to_vec();
        classes.extend(Self::HARD.iter().filter(|class| !Self::ALL.contains(class)));
        classes.extend(Self::SHAPES);
        classes.extend(Self::PLAIN);
        let found = classes.iter().find(|class| class.name() == name);
        found.copied().ok_or_else(|| {
            let names: Vec<_> = classes.iter().map(|class| class.name()).collect();
            let names = names.join(", ");
            format!("there is no class '{name}': choose one of {names}")
        })
    }
}
