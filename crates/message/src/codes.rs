//! Enumerations of the messages. They travel as numbers, because a number that this version does
//! not know must still be a valid message.

use std::borrow::Cow;

/// The values of an enumeration.
#[derive(Debug)]
#[non_exhaustive]
pub struct Codes {
    /// Name of the enumeration, such as `Status`.
    pub name: &'static str,
    /// Its values.
    pub all: &'static [Code],
}

/// One value of an enumeration.
#[derive(Debug)]
#[non_exhaustive]
pub struct Code {
    /// Number in messages.
    pub number: u32,
    /// Name in Rust.
    pub variant: &'static str,
    /// Name in flags, settings and output.
    pub name: &'static str,
    /// Meaning, from its documentation.
    pub about: &'static str,
}

impl Codes {
    /// Returns the name of a number, or the number itself if this version does not know it.
    pub fn word(&self, number: u32) -> Cow<'static, str> {
        let known = self.all.iter().find(|code| code.number == number);
        known.map_or_else(|| number.to_string().into(), |code| code.name.into())
    }
}

/// Declares an enumeration: each value has a number and a name in flags, settings and output.
macro_rules! codes {
    ($(#[$about:meta])* $type:ident { $($(#[doc = $each:literal])+ $variant:ident = $code:literal $name:literal,)+ }) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[repr(u32)]
        pub enum $type {
            $($(#[doc = $each])+ $variant = $code,)+
        }

        impl $type {
            /// All values, in the order of their numbers.
            pub const ALL: [Self; [$($code),+].len()] = [$(Self::$variant),+];

            /// The table of all values.
            pub const CODES: Codes = Codes {
                name: stringify!($type),
                all: &[$(Code {
                    number: $code,
                    variant: stringify!($variant),
                    name: $name,
                    about: concat!($($each),+),
                }),+],
            };

            /// Returns the value of a message's number, if this version knows it.
            pub const fn from_code(code: u32) -> Option<Self> {
                match code {
                    $($code => Some(Self::$variant),)+
                    _ => None,
                }
            }

            /// Name in flags, settings and output.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)+
                }
            }

            /// Returns the value with this [name](Self::name), in upper or lower case.
            pub fn from_name(name: &str) -> Option<Self> {
                Self::ALL.into_iter().find(|known| known.name().eq_ignore_ascii_case(name))
            }

            /// Returns the name of a message's number, or the number itself if this version does
            /// not know it.
            pub fn word(code: u32) -> Cow<'static, str> {
                Self::CODES.word(code)
            }
        }
    };
}

codes! {
    /// Pixel format of a frame.
    PixelFormat {
        /// 8-bit luminance.
        Gray8 = 1 "gray8",
        /// Three bytes per pixel: red, green, blue.
        Rgb8 = 2 "rgb8",
        /// Three bytes per pixel: blue, green, red.
        Bgr8 = 3 "bgr8",
        /// Two bytes per pixel: Y₀ U Y₁ V for each pair.
        Yuyv = 4 "yuyv",
        /// A Y plane, then a half-resolution plane of U V pairs with the same stride.
        Nv12 = 5 "nv12",
        /// Two bytes per pixel: U Y₀ V Y₁ for each pair.
        Uyvy = 6 "uyvy",
        /// Four bytes per pixel: blue, green, red, ignored.
        Bgra8 = 7 "bgra8",
        /// 16-bit luminance in native byte order: 0 black, 65535 white.
        Gray16 = 8 "gray16",
        /// One byte per pixel, Bayer mosaic: rows alternate R G and G B.
        BayerRggb8 = 9 "bayer_rggb8",
        /// Bayer mosaic: B G and G R.
        BayerBggr8 = 10 "bayer_bggr8",
        /// Bayer mosaic: G R and B G.
        BayerGrbg8 = 11 "bayer_grbg8",
        /// Bayer mosaic: G B and R G.
        BayerGbrg8 = 12 "bayer_gbrg8",
    }
}

/// Byte layout of a pixel format: pixels of a row form groups, and a second plane with half as many
/// rows may follow for color.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Layout {
    /// Pixels per group of bytes.
    pixels: usize,
    /// Bytes per group.
    bytes: usize,
    /// True if a second plane with half as many rows follows.
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

    /// Number of byte rows in an image of this height.
    pub const fn rows(self, height: u32) -> usize {
        let height = height as usize;
        if self.layout().has_color_plane {
            height + height.div_ceil(2)
        } else {
            height
        }
    }

    /// Bytes of an image whose rows are `stride` bytes apart.
    pub const fn image_bytes(self, stride: u32, height: u32) -> usize {
        stride as usize * self.rows(height)
    }
}

codes! {
    /// Kind of source that a frame came from.
    SourceKind {
        /// A rope rendered by lariat, with ground truth.
        Rendered = 1 "rendered",
        /// Image files.
        Files = 2 "files",
        /// A video file.
        Video = 3 "video",
        /// A camera.
        Camera = 4 "camera",
    }
}

codes! {
    /// Visibility of a rope in a frame.
    Status {
        /// Fully visible.
        Ok = 1 "ok",
        /// Partly covered.
        Partial = 2 "partial",
        /// Not visible; the curve is the last known shape.
        Lost = 3 "lost",
        /// Fully visible, but possibly not a rope: a shadow, a pen, an edge.
        Doubtful = 4 "doubtful",
    }
}

codes! {
    /// Result of comparing a descriptor's curve with the points that it was fitted to.
    FitQuality {
        /// Not checked by the writer.
        NotJudged = 0 "not judged",
        /// The curve is within the chain's tolerance of its points.
        Good = 1 "good",
        /// The curve deviates, for example with too few control points; the points are correct.
        Coarse = 2 "coarse",
    }
}

codes! {
    /// Basis functions that are weighted by a descriptor's control points.
    Basis {
        /// Bernstein polynomials of this `degree`.
        Bezier = 1 "bezier",
        /// Clamped B-spline of this `degree`; the message has its inner knots.
        BSpline = 2 "bspline",
        /// Rational Bernstein functions of this `degree`.
        RationalBezier = 3 "rational",
        /// Fourier series of `degree` harmonics, for closed shapes. Control points are coefficients
        /// `a₀, a₁, b₁, a₂, b₂, …` of `1, cos 2πρ, sin 2πρ, cos 4πρ, …`.
        Fourier = 4 "fourier",
        /// Centerline points at equal arc length, joined by straight lines.
        FeaturePoints = 5 "points",
        /// The mean of all points, as one control point.
        CenterOfMass = 6 "mass",
    }
}

codes! {
    /// Unit of descriptors.
    Unit {
        /// Pixels of the original image.
        Pixel = 1 "px",
        /// Millimeters on a plane.
        Millimeter = 2 "mm",
        /// Pixels of the same camera without lens distortion.
        IdealPixel = 3 "ideal px",
    }
}

codes! {
    /// State of a rope's position in space: known, or the reason why not.
    Place {
        /// Measured.
        Known = 1 "known",
        /// Not visible in the color image; last known position.
        Before = 2 "before",
        /// Too few depths: out of the other camera's range or view.
        Unmeasured = 3 "unmeasured",
        /// Thinner than three pixels of the depth image.
        Thin = 4 "thin",
        /// No depth image, or no second image near enough in time.
        NoPartner = 5 "no partner",
        /// Invalid depth image, second image or calibration; the chain reports why.
        Unreadable = 6 "unreadable",
    }
}

codes! {
    /// Coordinate frame of points in space.
    Axes {
        /// The color camera's: x right, y down, z forward, from its optical center.
        Camera = 1 "camera",
        /// The robot's, by the chain's camera pose.
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
