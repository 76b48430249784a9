//! Sets a camera's format, size and rate, then checks and reports what the driver made of them.

use super::device::Device;
use super::error::CameraError;
use super::negotiate::{Choice, Request, Wanted, negotiate};
use super::offers::{FourCc, Interval};
use super::sys;
use crate::color_range::ColorRange;
use lariat_message::PixelFormat;

/// A camera's actual settings.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Setup {
    /// The pixel format.
    pub(crate) code: FourCc,
    /// Pixels in a row.
    pub(crate) width: u32,
    /// Rows.
    pub(crate) height: u32,
    /// Bytes from one row's start to the next; 0 for compressed frames.
    pub(crate) stride: u32,
    /// Size of each plane's memory as the driver reports it, in bytes.
    pub(crate) plane_bytes: Vec<u32>,
    /// Interval between frames, if the driver reports it.
    pub(crate) interval: Option<Interval>,
    /// The range of Y, U and V that the driver reports.
    pub(crate) range: ColorRange,
    /// Sentences for the user about differences from the request.
    pub(crate) told: Vec<String>,
}

impl Setup {
    /// The pixel format of messages; `None` for compressed frames.
    pub(crate) fn pixel_format(&self) -> Option<PixelFormat> {
        pixel_format(self.code)
    }

    /// A short summary: `YUYV 640x480 at 30 frames/s`.
    pub(crate) fn summary(&self) -> String {
        let rate = match self.interval {
            Some(interval) => format!("at {} frames/s", shown(interval.fps())),
            None => "at a rate that its driver does not tell".to_owned(),
        };
        format!("{} {}x{} {rate}", self.code, self.width, self.height)
    }
}

fn pixel_format(code: FourCc) -> Option<PixelFormat> {
    Some(match code.0 {
        sys::PIX_YUYV => PixelFormat::Yuyv,
        sys::PIX_UYVY => PixelFormat::Uyvy,
        sys::PIX_NV12 => PixelFormat::Nv12,
        sys::PIX_GREY => PixelFormat::Gray8,
        sys::PIX_RGB3 => PixelFormat::Rgb8,
        sys::PIX_BGR3 => PixelFormat::Bgr8,
        sys::PIX_AR24 | sys::PIX_XR24 | sys::PIX_BGR4 => PixelFormat::Bgra8,
        // All 16 bits are assumed to be used. `Y10 ` and `Y12 `, with values up to 1023 and 4095,
        // would be nearly black.
        sys::PIX_Y16 | sys::PIX_Z16 => PixelFormat::Gray16,
        sys::PIX_RGGB => PixelFormat::BayerRggb8,
        sys::PIX_BA81 => PixelFormat::BayerBggr8,
        sys::PIX_GRBG => PixelFormat::BayerGrbg8,
        sys::PIX_GBRG => PixelFormat::BayerGbrg8,
        _ => return None,
    })
}

/// Range of a driver's Y, U and V. If the driver does not report it, the kernel's rule
/// (`V4L2_MAP_QUANTIZATION_DEFAULT`) applies.
fn range_of(pixelformat: u32, colorspace: u32, quantization: u32) -> ColorRange {
    let is_yuv = matches!(pixelformat, sys::PIX_YUYV | sys::PIX_UYVY | sys::PIX_NV12);
    match quantization {
        _ if !is_yuv => ColorRange::Full,
        sys::QUANTIZATION_FULL => ColorRange::Full,
        sys::QUANTIZATION_LIMITED => ColorRange::Limited,
        _ if colorspace == sys::COLORSPACE_JPEG => ColorRange::Full,
        _ => ColorRange::Limited,
    }
}

/// A rate with as many digits as a person would write.
pub(super) fn shown(fps: f64) -> String {
    let rounded = (fps * 100.0).round() / 100.0;
    format!("{rounded}")
}

/// The contents of either kind of `v4l2_format`, in one form.
struct Answer {
    code: FourCc,
    size: [u32; 2],
    field: u32,
    stride: u32,
    plane_bytes: Vec<u32>,
    range: ColorRange,
}

impl Device {
    /// Sets the camera to what is requested, or the best available, by the rule of
    /// [`negotiate`](super::negotiate), and checks the answer. Format and rate are always set,
    /// because another program may have changed both.
    ///
    /// # Errors
    /// There is no common format, another program is streaming, or the driver sets something that
    /// it did not list.
    pub(crate) fn set_up(&self, request: &Request) -> Result<Setup, CameraError> {
        let offers = self.offers(request.near(), |code: FourCc| {
            request.wanted.formats().contains(&code.0)
        });
        let choice = negotiate(&offers, request).map_err(|why| CameraError::NoCommonFormat {
            path: self.path().to_owned(),
            why,
        })?;
        let answer = self.set_format(&choice)?;
        let mut told = self.check(request, &choice, &answer)?;
        let interval = self.set_rate(choice.interval.or(request.fps.map(Interval::of_fps)))?;
        if let (Some(asked), Some(got)) = (request.fps, interval)
            && (got.fps() / asked - 1.0).abs() > 0.02
        {
            told.push(format!(
                "{} gives {} frames/s at {}x{} in {}, not the {} that were asked for",
                self.path().display(),
                shown(got.fps()),
                answer.size[0],
                answer.size[1],
                answer.code,
                shown(asked),
            ));
        }
        Ok(Setup {
            code: answer.code,
            width: answer.size[0],
            height: answer.size[1],
            stride: answer.stride,
            plane_bytes: answer.plane_bytes,
            interval,
            range: answer.range,
            told,
        })
    }

    fn set_format(&self, choice: &Choice) -> Result<Answer, CameraError> {
        let mut format = sys::Format::of(self.buffer_type());
        sys::get_format(self, &mut format)
            .map_err(|errno| self.refusal("say its format (VIDIOC_G_FMT)", errno))?;
        let mut format = self.with(&format, choice);
        sys::set_format(self, &mut format)
            .map_err(|errno| self.refusal("be set to a format (VIDIOC_S_FMT)", errno))?;
        Ok(self.answer(&format))
    }

    /// Returns the present format, changed to the chosen one. If that format is already set, the
    /// row length is kept, in case another program has chosen longer rows on purpose.
    fn with(&self, present: &sys::Format, choice: &Choice) -> sys::Format {
        let [width, height] = choice.size;
        let FourCc(pixelformat) = choice.code;
        if self.has_planes() {
            let pix = present.pix_planes();
            let is_same = (pix.width, pix.height, pix.pixelformat) == (width, height, pixelformat);
            let mut wanted = sys::PixFormatPlanes {
                width,
                height,
                pixelformat,
                field: sys::FIELD_NONE,
                num_planes: 1,
                ..Default::default()
            };
            if is_same {
                wanted.planes[0].bytesperline = pix.planes[0].bytesperline;
            }
            sys::Format::planes(self.buffer_type(), &wanted)
        } else {
            let pix = present.pix();
            let is_same = (pix.width, pix.height, pix.pixelformat) == (width, height, pixelformat);
            let wanted = sys::PixFormat {
                width,
                height,
                pixelformat,
                field: sys::FIELD_NONE,
                bytesperline: if is_same { pix.bytesperline } else { 0 },
                ..Default::default()
            };
            sys::Format::single(self.buffer_type(), wanted)
        }
    }

    fn answer(&self, format: &sys::Format) -> Answer {
        if self.has_planes() {
            let pix = format.pix_planes();
            let count = usize::from(pix.num_planes).clamp(1, pix.planes.len());
            Answer {
                code: FourCc(pix.pixelformat),
                size: [pix.width, pix.height],
                field: pix.field,
                stride: pix.planes[0].bytesperline,
                plane_bytes: pix.planes[..count].iter().map(|p| p.sizeimage).collect(),
                range: range_of(pix.pixelformat, pix.colorspace, pix.quantization.into()),
            }
        } else {
            let pix = format.pix();
            Answer {
                code: FourCc(pix.pixelformat),
                size: [pix.width, pix.height],
                field: pix.field,
                stride: pix.bytesperline,
                plane_bytes: vec![pix.sizeimage],
                range: range_of(pix.pixelformat, pix.colorspace, pix.quantization),
            }
        }
        .with_whole_rows()
    }

    /// Checks that the settings can be used. Returns sentences about differences that the user may
    /// not expect.
    fn check(
        &self,
        request: &Request,
        choice: &Choice,
        answer: &Answer,
    ) -> Result<Vec<String>, CameraError> {
        let other = |remedy: String| CameraError::OtherFormat {
            path: self.path().to_owned(),
            asked: words(choice.code, choice.size),
            got: words(answer.code, answer.size),
            remedy,
        };
        let [width, height] = answer.size;
        // JPEG and MJPG are two names for the same bytes.
        if !request.wanted.formats().contains(&answer.code.0)
            || (request.format.is_some() && answer.code != choice.code)
        {
            return Err(other(
                "ask for a format that it has, as `lariat devices` lists them".to_owned(),
            ));
        }
        if request.size.is_some_and(|asked| asked != answer.size) {
            return Err(other(match request.wanted {
                Wanted::Pictures => format!("ask for --size {width}x{height}"),
                Wanted::Depth => format!("name a calibration for {width}x{height}"),
            }));
        }
        if let Some(format) = pixel_format(answer.code) {
            let needed = format.image_bytes(answer.stride, height);
            let has: u64 = answer
                .plane_bytes
                .iter()
                .map(|&bytes| u64::from(bytes))
                .sum();
            if (answer.stride as usize) < format.row_bytes(width) || has < needed as u64 {
                return Err(other(format!(
                    "rows of {} bytes in {has} bytes hold no such picture, so its driver is at fault; ask for another \
                     size or format",
                    answer.stride
                )));
            }
        }
        let mut told = Vec::new();
        if answer.size != choice.size || answer.code != choice.code {
            told.push(format!(
                "{} was asked for {} and set {}",
                self.path().display(),
                words(choice.code, choice.size),
                words(answer.code, answer.size)
            ));
        }
        if !matches!(answer.field, sys::FIELD_ANY | sys::FIELD_NONE) {
            told.push(format!(
                "{} gives interlaced pictures: every other row is older, and ropes that move have combed edges",
                self.path().display()
            ));
        }
        Ok(told)
    }

    /// Sets the frame interval and returns the actual one; `None` if the driver does not have one.
    fn set_rate(&self, wanted: Option<Interval>) -> Result<Option<Interval>, CameraError> {
        let mut parameters = sys::StreamParameters::of(self.buffer_type());
        if sys::get_parameters(self, &mut parameters).is_err() {
            return Ok(None);
        }
        let can_be_set = parameters.capability & sys::CAP_TIMEPERFRAME != 0;
        if let Some(interval) = wanted.filter(|_| can_be_set) {
            parameters.timeperframe = [interval.numerator, interval.denominator];
            sys::set_parameters(self, &mut parameters)
                .map_err(|errno| self.refusal("be set to a rate (VIDIOC_S_PARM)", errno))?;
        }
        // A driver without a rate of its own may return anything, including 0/0. For example,
        // v4l2loopback has the rate of whatever is fed into it.
        Ok(Interval::new(parameters.timeperframe))
    }
}

impl Answer {
    /// Replaces a row length of 0, which some drivers leave, by that of rows without padding.
    fn with_whole_rows(mut self) -> Self {
        if let (0, Some(format)) = (self.stride, pixel_format(self.code)) {
            self.stride = format.row_bytes(self.size[0]) as u32;
        }
        self
    }
}

fn words(code: FourCc, [width, height]: [u32; 2]) -> String {
    format!("{code} {width}x{height}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_driver_tells_the_range_or_its_colorspace_does() {
        const SRGB: u32 = 8;
        for (format, colorspace, quantization, range) in [
            (sys::PIX_YUYV, SRGB, 0, ColorRange::Limited),
            (sys::PIX_NV12, sys::COLORSPACE_JPEG, 0, ColorRange::Full),
            (
                sys::PIX_UYVY,
                SRGB,
                sys::QUANTIZATION_FULL,
                ColorRange::Full,
            ),
            (
                sys::PIX_YUYV,
                sys::COLORSPACE_JPEG,
                sys::QUANTIZATION_LIMITED,
                ColorRange::Limited,
            ),
            (sys::PIX_GREY, SRGB, 0, ColorRange::Full),
            (
                sys::PIX_RGB3,
                SRGB,
                sys::QUANTIZATION_LIMITED,
                ColorRange::Full,
            ),
        ] {
            assert_eq!(range_of(format, colorspace, quantization), range);
        }
    }
}
