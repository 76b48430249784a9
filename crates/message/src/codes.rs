//! What the numbers in the messages stand for. They travel as numbers, because a number that this version does not know
//! must be no more than that.

use std::borrow::Cow;

/// What a number of a message may stand for.
#[derive(Debug)]
#[non_exhaustive]
pub struct Codes {
    /// What they say, such as `Status`.
    pub name: &'static str,
    /// Each of them.
    pub all: &'static [Code],
}

/// One of them.
#[derive(Debug)]
#[non_exhaustive]
pub struct Code {
    /// Its number in messages.
    pub number: u32,
    /// What it is called in Rust.
    pub variant: &'static str,
    /// Its name in flags, settings and output.
    pub name: &'static str,
    /// What it means, as its documentation has it.
    pub about: &'static str,
}

impl Codes {
    /// The name of what a number stands for; the number itself, if this version does not know it.
    pub fn word(&self, number: u32) -> Cow<'static, str> {
        let known = self.all.iter().find(|code| code.number == number);
        known.map_or_else(|| number.to_string().into(), |code| code.name.into())
    }
}

/// Declares what a number may stand for: each of them with its number, and its name in flags, settings and output.
macro_rules! codes {
    ($(#[$about:meta])* $type:ident { $($(#[doc = $each:literal])+ $variant:ident = $code:literal $name:literal,)+ }) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[repr(u32)]
        pub enum $type {
            $($(#[doc = $each])+ $variant = $code,)+
        }

        impl $type {
            /// All of them, in the order of their numbers.
            pub const ALL: [Self; [$($code),+].len()] = [$(Self::$variant),+];

            /// The table of them.
            pub const CODES: Codes = Codes {
                name: stringify!($type),
                all: &[$(Code {
                    number: $code,
                    variant: stringify!($variant),
                    name: $name,
                    about: concat!($($each),+),
                }),+],
            };

            /// What a message's number stands for, if it stands for anything.
            pub const fn from_code(code: u32) -> Option<Self> {
                match code {
                    $($code => Some(Self::$variant),)+
                    _ => None,
                }
            }

            /// Its name in flags, settings and output.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)+
                }
            }

            /// What has this [name](Self::name), in small letters or large ones.
            pub fn from_name(name: &str) -> Option<Self> {
                Self::ALL.into_iter().find(|known| known.name().eq_ignore_ascii_case(name))
            }

            /// The name of what a message's number stands for; the number itself, if this version does not know it.
            pub fn word(code: u32) -> Cow<'static, str> {
                Self::CODES.word(code)
            }
        }
    };
}

codes! {
    /// How the bytes of a frame make pixels.
    PixelFormat {
        /// One byte of luminance a pixel.
        Gray8 = 1 "gray8",
        /// Three bytes a pixel: red, green, blue.
        Rgb8 = 2 "rgb8",
        /// Three bytes a pixel: blue, green, red.
        Bgr8 = 3 "bgr8",
        /// Two bytes a pixel: Y₀ U Y₁ V for each pair of pixels.
        Yuyv = 4 "yuyv",
        /// A plane of Y, then at half the size a plane of U V pairs with the same stride.
        Nv12 = 5 "nv12",
        /// Two bytes a pixel: U Y₀ V Y₁ for each pair of pixels.
        Uyvy = 6 "uyvy",
        /// Four bytes a pixel: blue, green, red, and one that is not looked at.
        Bgra8 = 7 "bgra8",
        /// Two bytes of luminance a pixel, in the machine's own order: 0 is black, 65535 white.
        Gray16 = 8 "gray16",
        /// One byte a pixel, behind a mosaic of colour filters: R G in the first row, G B in the second, and so on.
        BayerRggb8 = 9 "bayer_rggb8",
        /// The same of B G and G R.
        BayerBggr8 = 10 "bayer_bggr8",
        /// The same of G R and B G.
        BayerGrbg8 = 11 "bayer_grbg8",
        /// The same of G B and R G.
        BayerGbrg8 = 12 "bayer_gbrg8",
    }
}

/// How the bytes of a pixel format lie: pixels in a row share them in groups, and half as many rows of color may follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Layout {
    /// How many pixels share a group of bytes.
    pixels: usize,
    /// How many bytes that is.
    bytes: usize,
    /// Whether a second plane follows, of half as many rows.
    has_color_plane: bool,
}

impl PixelFormat {
    const fn layout(self) -> Layout {
        let (pixels, bytes) = match self {
            Self::Gray8 | Self::Nv12 => (1, 1),
            Self::BayerRggb8 | Self::BayerBggr8 | Self::BayerGrbg8 | Self::BayerGbrg8 => (1, 1),
            Self::Gray16 => (1, 2),
            Self::Rgb8 | Self::Bgr8 => (1, 3),
            Self::Bgra8 => (1, 4),
            Self::Yuyv | Self::Uyvy => (2, 4),
        };
        Layout {
            pixels,
            bytes,
            has_color_plane: matches!(self, Self::Nv12),
        }
    }

    /// Bytes of one row without padding.
    pub const fn row_bytes(self, width: u32) -> usize {
        let Layout { pixels, bytes, .. } = self.layout();
        bytes * (width as usize).div_ceil(pixels)
    }

    /// Rows of bytes that an image of this height has.
    pub const fn rows(self, height: u32) -> usize {
        let height = height as usize;
        if self.layout().has_color_plane {
            height + height.div_ceil(2)
        } else {
            height
        }
    }

    /// Bytes of a whole image whose rows are `stride` bytes apart.
    pub const fn image_bytes(self, stride: u32, height: u32) -> usize {
        stride as usize * self.rows(height)
    }
}

codes! {
    /// What kind of source a frame came from.
    SourceKind {
        /// A rope drawn by lariat, with known truth.
        Rendered = 1 "rendered",
        /// Picture files.
        Files = 2 "files",
        /// A video file.
        Video = 3 "video",
        /// A camera.
        Camera = 4 "camera",
    }
}

codes! {
    /// What is known of a rope in this frame.
    Status {
        /// Seen whole.
        Ok = 1 "ok",
        /// A part of it is covered.
        Partial = 2 "partial",
        /// Not seen now: the curve is the last known shape.
        Lost = 3 "lost",
        /// Seen whole, but it may be no rope: a shadow, a pen, an edge.
        Doubtful = 4 "doubtful",
    }
}

codes! {
    /// Whether a descriptor's curve lies on the points that it was fitted to.
    FitQuality {
        /// The writer did not look.
        NotJudged = 0 "not judged",
        /// The curve lies on its points, within the tolerance that the chain was started with.
        Good = 1 "good",
        /// It does not, as a curve with too few control points for the rope's bends. The points themselves are right.
        Coarse = 2 "coarse",
    }
}

codes! {
    /// The functions a descriptor's control points weigh.
    Basis {
        /// Bernstein polynomials of this `degree`.
        Bezier = 1 "bezier",
        /// Clamped B-spline of this `degree`; its inner knots are in the message.
        BSpline = 2 "bspline",
        /// Rational Bernstein functions of this `degree`.
        RationalBezier = 3 "rational",
        /// A truncated Fourier series of `degree` harmonics, for closed shapes: the control points are its coefficients
        /// `a₀, a₁, b₁, a₂, b₂, …` of `1, cos 2πρ, sin 2πρ, cos 4πρ, …`.
        Fourier = 4 "fourier",
        /// Points of the centerline at even steps of arc length, joined by straight lines: no curve.
        FeaturePoints = 5 "points",
        /// The mean of all points, as one control point: no curve.
        CenterOfMass = 6 "mass",
    }
}

codes! {
    /// What descriptors are measured in.
    Unit {
        /// Pixels of the image as it is.
        Pixel = 1 "px",
        /// Millimetres on a plane.
        Millimeter = 2 "mm",
        /// Pixels that the same camera would see without its lens's distortion.
        IdealPixel = 3 "ideal px",
    }
}

codes! {
    /// Whether it is known where in space a rope is, or why not.
    Place {
        /// It is measured.
        Known = 1 "known",
        /// The colour image does not show it now: it is where it was.
        Before = 2 "before",
        /// Too little of it has a depth: it is out of the other camera's range, or not seen by it.
        Unmeasured = 3 "unmeasured",
        /// It is thinner than three pixels of the depth image.
        Thin = 4 "thin",
        /// Nothing came beside this frame: no depth image, or nothing from the second camera that is near enough in time.
        NoPartner = 5 "no partner",
        /// What came beside this frame, or a calibration, is not what it should be: the chain says what.
        Unreadable = 6 "unreadable",
    }
}

codes! {
    /// From where, and along which axes, points in space are measured.
    Axes {
        /// The colour camera's: x to the right, y down, z ahead, from its optical center.
        Camera = 1 "camera",
        /// The robot's, by the camera's pose that the chain was given.
        Robot = 2 "robot",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_has_its_number_and_its_name() {
        macro_rules! check {
            ($($type:ident from $first:literal),+) => {$(
                for (place, known) in $type::ALL.into_iter().enumerate() {
                    assert_eq!(known as usize, place + $first);
                    assert_eq!($type::from_code(known as u32), Some(known));
                    assert_eq!($type::from_name(known.name()), Some(known));
                    assert_eq!($type::word(known as u32), known.name());
                }
                for code in [$type::ALL.len() as u32 + $first, u32::MAX] {
                    assert_eq!($type::from_code(code), None);
                    assert_eq!($type::word(code), code.to_string());
                }
            )+};
        }
        check!(PixelFormat from 1, SourceKind from 1, Status from 1, FitQuality from 0, Basis from 1, Unit from 1, Place from 1, Axes from 1);
        assert_eq!(PixelFormat::from_name("RGB8"), Some(PixelFormat::Rgb8));
    }
}
