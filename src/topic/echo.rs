//! `lariat topic echo`: the messages of a channel as text, or as JSON with every field but a frame's pixels.

mod json;
mod text;

use std::time::Duration;

use anyhow::Result;
use lariat_wire::Rig;

use super::ChannelName;
use super::probe::Any;
use super::watch::Meter;

/// Prints what comes.
pub(super) struct Echo {
    channel: ChannelName,
    json: bool,
    /// How many more are to be printed; `None`: as many as come.
    left: Option<u64>,
}

impl Echo {
    pub(super) fn new(channel: ChannelName, json: bool, most: Option<u64>) -> Self {
        Self {
            channel,
            json,
            left: most,
        }
    }
}

impl Meter for Echo {
    /// A line is to be there when its message is, and a rig that rests wakes nobody.
    fn is_woken(&self) -> bool {
        true
    }

    fn period(&self) -> Option<Duration> {
        None
    }

    fn see(&mut self, message: Any, _now_ns: u64) -> Result<String> {
        if let Some(left) = &mut self.left {
            *left = left.saturating_sub(1);
        }
        if self.json {
            json::line(self.channel.as_str(), message)
        } else {
            Ok(text::paragraph(self.channel.as_str(), message))
        }
    }

    fn is_done(&self) -> bool {
        self.left == Some(0)
    }

    fn report(&mut self, _rig: &Rig, _json: bool) -> Result<String> {
        Ok(String::new())
    }
}

/// What a number of the contract stands for, as users know it; the number itself, if this release does not know it.
fn word<T>(known: Option<T>, name: impl FnOnce(T) -> &'static str, code: u32) -> String {
    known.map_or_else(|| code.to_string(), |value| name(value).to_owned())
}

fn status(code: u32) -> String {
    use lariat_wire::Status;
    word(Status::from_code(code), Status::name, code)
}

fn fit(code: u32) -> String {
    use lariat_wire::FitQuality;
    word(FitQuality::from_code(code), FitQuality::name, code)
}

fn basis(code: u32) -> String {
    use lariat_wire::Basis;
    word(
        Basis::from_code(code),
        |basis| match basis {
            Basis::Bezier => "bezier",
            Basis::BSpline => "bspline",
            Basis::RationalBezier => "rational",
            Basis::Fourier => "fourier",
            Basis::FeaturePoints => "points",
            Basis::CenterOfMass => "mass",
        },
        code,
    )
}

fn unit(code: u32) -> String {
    let unit = lariat_wire::Unit::from_code(code);
    word(unit, crate::descriptor_json::unit_name, code)
}

fn pixel_format(code: u32) -> String {
    use lariat_wire::PixelFormat;
    word(PixelFormat::from_code(code), PixelFormat::name, code)
}

fn source(code: u32) -> String {
    use lariat_wire::SourceKind;
    let kinds = [
        (SourceKind::Rendered, "rendered"),
        (SourceKind::Files, "files"),
        (SourceKind::Video, "video"),
        (SourceKind::Camera, "camera"),
    ];
    let known = kinds.into_iter().find(|(kind, _)| *kind as u32 == code);
    word(known, |(_, name)| name, code)
}

#[cfg(test)]
mod tests;
