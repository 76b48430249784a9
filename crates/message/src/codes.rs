//! What the numbers in the messages stand for. They travel as numbers, because a number that this version does not know
//! must be no more than that.

/// How the bytes of a frame make pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum PixelFormat {
    /// One byte of luminance a pixel.
    Gray8 = 1,
    /// Three bytes a pixel: red, green, blue.
    Rgb8 = 2,
    /// Three bytes a pixel: blue, green, red.
    Bgr8 = 3,
    /// Two bytes a pixel: Y₀ U Y₁ V for each pair of pixels.
    Yuyv = 4,
    /// A plane of Y, then at half the size a plane of U V pairs with the same stride.
    Nv12 = 5,
    /// Two bytes a pixel: U Y₀ V Y₁ for each pair of pixels.
    Uyvy = 6,
    /// Four bytes a pixel: blue, green, red, and one that is not looked at.
    Bgra8 = 7,
    /// Two bytes of luminance a pixel, in the machine's own order: 0 is black, 65535 white.
    Gray16 = 8,
    /// One byte a pixel, behind a mosaic of colour filters: R G in the first row, G B in the second, and so on.
    BayerRggb8 = 9,
    /// The same of B G and G R.
    BayerBggr8 = 10,
    /// The same of G R and B G.
    BayerGrbg8 = 11,
    /// The same of G B and R G.
    BayerGbrg8 = 12,
}

impl PixelFormat {
    /// Every format, in the order of their numbers, which begin at 1.
    pub const ALL: [Self; 12] = [
        Self::Gray8,
        Self::Rgb8,
        Self::Bgr8,
        Self::Yuyv,
        Self::Nv12,
        Self::Uyvy,
        Self::Bgra8,
        Self::Gray16,
        Self::BayerRggb8,
        Self::BayerBggr8,
        Self::BayerGrbg8,
        Self::BayerGbrg8,
    ];

    /// The format a header's number stands for, if it stands for one.
    pub const fn from_code(code: u32) -> Option<Self> {
        match code as usize {
            code @ 1..=12 => Some(Self::ALL[code - 1]),
            _ => None,
        }
    }

    /// What it is called in flags, settings and output.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Gray8 => "gray8",
            Self::Rgb8 => "rgb8",
            Self::Bgr8 => "bgr8",
            Self::Yuyv => "yuyv",
            Self::Nv12 => "nv12",
            Self::Uyvy => "uyvy",
            Self::Bgra8 => "bgra8",
            Self::Gray16 => "gray16",
            Self::BayerRggb8 => "bayer_rggb8",
            Self::BayerBggr8 => "bayer_bggr8",
            Self::BayerGrbg8 => "bayer_grbg8",
            Self::BayerGbrg8 => "bayer_gbrg8",
        }
    }

    /// The format of this [name](Self::name), in small letters or large ones.
    pub fn from_name(name: &str) -> Option<Self> {
        let is_it = |format: &Self| format.name().eq_ignore_ascii_case(name);
        Self::ALL.into_iter().find(is_it)
    }

    /// Bytes of one row without padding.
    pub const fn row_bytes(self, width: u32) -> usize {
        let width = width as usize;
        match self {
            Self::Gray8 | Self::Nv12 => width,
            Self::Rgb8 | Self::Bgr8 => 3 * width,
            Self::Yuyv | Self::Uyvy => 4 * width.div_ceil(2),
            Self::Bgra8 => 4 * width,
            Self::Gray16 => 2 * width,
            Self::BayerRggb8 | Self::BayerBggr8 | Self::BayerGrbg8 | Self::BayerGbrg8 => width,
        }
    }

    /// Bytes of a whole image whose rows are `stride` bytes apart.
    pub const fn image_bytes(self, stride: u32, height: u32) -> usize {
        let (stride, height) = (stride as usize, height as usize);
        match self {
            Self::Nv12 => stride * (height + height.div_ceil(2)),
            _ => stride * height,
        }
    }
}

/// What kind of source a frame came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum SourceKind {
    /// A rope drawn by lariat, with known truth.
    Rendered = 1,
    /// Picture files.
    Files = 2,
    /// A video file.
    Video = 3,
    /// A camera.
    Camera = 4,
}

/// What is known of a rope in this frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum Status {
    /// Seen whole.
    Ok = 1,
    /// A part of it is covered.
    Partial = 2,
    /// Not seen now: the curve is the last known shape.
    Lost = 3,
    /// Seen whole, but it may be no rope: a shadow, a pen, an edge.
    Doubtful = 4,
}

impl Status {
    /// The status a message's number stands for, if it stands for one.
    pub const fn from_code(code: u32) -> Option<Self> {
        Some(match code {
            1 => Self::Ok,
            2 => Self::Partial,
            3 => Self::Lost,
            4 => Self::Doubtful,
            _ => return None,
        })
    }

    /// Its name in text and JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Partial => "partial",
            Self::Lost => "lost",
            Self::Doubtful => "doubtful",
        }
    }
}

/// Whether a descriptor's curve lies on the points that it was fitted to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum FitQuality {
    /// The writer did not look.
    NotJudged = 0,
    /// It lies on them, within the tolerance that the chain was started with.
    Good = 1,
    /// It does not, as a curve with too few control points for the rope's bends. The points themselves are right.
    Coarse = 2,
}

impl FitQuality {
    /// The quality a message's number stands for, if it stands for one.
    pub const fn from_code(code: u32) -> Option<Self> {
        Some(match code {
            0 => Self::NotJudged,
            1 => Self::Good,
            2 => Self::Coarse,
            _ => return None,
        })
    }

    /// Its name in text and JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::NotJudged => "not judged",
            Self::Good => "good",
            Self::Coarse => "coarse",
        }
    }
}

/// The functions a descriptor's control points weigh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum Basis {
    /// Bernstein polynomials of degree `order`.
    Bezier = 1,
    /// Clamped B-spline of degree `order`; its inner knots are in the message.
    BSpline = 2,
    /// Rational Bernstein functions.
    RationalBezier = 3,
    /// A truncated Fourier series of `order` harmonics, for closed shapes: the control points are its coefficients
    /// `a₀, a₁, b₁, a₂, b₂, …` of `1, cos 2πρ, sin 2πρ, cos 4πρ, …`.
    Fourier = 4,
    /// Points of the centerline at even steps of arc length, joined by straight lines.
    FeaturePoints = 5,
    /// The mean of all points: one control point.
    CenterOfMass = 6,
}

impl Basis {
    /// The basis a message's number stands for, if it stands for one.
    pub const fn from_code(code: u32) -> Option<Self> {
        Some(match code {
            1 => Self::Bezier,
            2 => Self::BSpline,
            3 => Self::RationalBezier,
            4 => Self::Fourier,
            5 => Self::FeaturePoints,
            6 => Self::CenterOfMass,
            _ => return None,
        })
    }
}

/// What descriptors are measured in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum Unit {
    /// Pixels of the image as it is.
    Pixel = 1,
    /// Millimetres on a plane.
    Millimeter = 2,
    /// Pixels that the same camera would see without its lens's distortion.
    IdealPixel = 3,
}

impl Unit {
    /// The unit a message's number stands for, if it stands for one.
    pub const fn from_code(code: u32) -> Option<Self> {
        Some(match code {
            1 => Self::Pixel,
            2 => Self::Millimeter,
            3 => Self::IdealPixel,
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::PixelFormat;

    #[test]
    fn every_pixel_format_has_its_number_and_its_name() {
        for (place, format) in PixelFormat::ALL.into_iter().enumerate() {
            assert_eq!(format as usize, place + 1);
            assert_eq!(PixelFormat::from_code(format as u32), Some(format));
            assert_eq!(PixelFormat::from_name(format.name()), Some(format));
        }
        assert_eq!(PixelFormat::from_name("RGB8"), Some(PixelFormat::Rgb8));
        for code in [0, 13, u32::MAX] {
            assert_eq!(PixelFormat::from_code(code), None);
        }
    }
}
