//! What a Y4M video says of itself: its first line, and the line before each frame.

use crate::ahead::Layout;
use crate::yuv::Chroma;

/// How a video begins.
pub(crate) const MAGIC: &[u8] = b"YUV4MPEG2 ";
/// A line is no longer, in bytes.
pub(crate) const LINE_BYTES: usize = 1024;
/// How the line before a frame begins, and mostly all of it.
pub(crate) const FRAME: &[u8] = b"FRAME\n";
/// Wider or higher is more likely a broken head than a camera.
pub(crate) const LARGEST_SIDE: u64 = 16384;

/// The first line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Head {
    pub(crate) chroma: Chroma,
    /// How its frames travel.
    pub(crate) layout: Layout,
    /// Frames a second, if it says any.
    pub(crate) fps: Option<f64>,
}

impl Head {
    /// Reads the line, from the beginning to its end of line, of the beginning of a video.
    ///
    /// # Errors
    /// What it says cannot be shown: a sentence's end.
    pub(crate) fn of(begin: &[u8]) -> Result<Self, &'static str> {
        if begin.is_empty() {
            return Err("the file is empty");
        }
        let Some(line) = begin.strip_prefix(MAGIC) else {
            return Err("it does not begin with `YUV4MPEG2`, as a Y4M video does");
        };
        let Some(end) = line.iter().position(|&c| c == b'\n') else {
            return Err("its first line does not end");
        };
        let words = || line[..end].split(|&c| c == b' ');
        // The last of several counts.
        let word = |name: u8| {
            let word = words().rfind(|word| word.first() == Some(&name));
            word.map(|word| &word[1..])
        };
        let side = |name| {
            let side = number(word(name)?)?;
            (1..=LARGEST_SIDE).contains(&side).then_some(side as u32)
        };
        let width = side(b'W').ok_or("its first line says no width from 1 to 16384")?;
        let height = side(b'H').ok_or("its first line says no height from 1 to 16384")?;
        let fps = match word(b'F') {
            None => None,
            Some(rate) => {
                let rate = rate_of(rate).ok_or("its first line is not that of a Y4M video")?;
                (rate[0] > 0 && rate[1] > 0).then(|| rate[0] as f64 / rate[1] as f64)
            }
        };
        let full_range = words().any(|word| word == b"XCOLORRANGE=FULL");
        let chroma = match word(b'C') {
            None | Some(b"420" | b"420jpeg" | b"420paldv" | b"420mpeg2") => Chroma::Half,
            Some(b"mono") => Chroma::Mono,
            Some(b"422") => Chroma::HalfWidth,
            Some(b"444") => Chroma::Full { full_range },
            Some(_) => {
                return Err("its pixels are none of 8-bit 4:2:0, 4:2:2, 4:4:4 and mono \
                     (convert it with `ffmpeg -i IN -pix_fmt yuv420p OUT.y4m`)");
            }
        };
        let layout = chroma.layout(width, height);
        Ok(Self {
            chroma,
            layout,
            fps,
        })
    }

    /// Bytes of a frame's planes.
    pub(crate) fn plane_bytes(&self) -> usize {
        let Layout { width, height, .. } = self.layout;
        self.chroma.plane_bytes(width as usize, height as usize)
    }

    /// Writes a frame's planes as they travel.
    pub(crate) fn write(&self, planes: &[u8], pixels: &mut [u8]) {
        let Layout { width, height, .. } = self.layout;
        let luma = width as usize * height as usize;
        let (y, color) = planes.split_at(luma);
        let (u, v) = color.split_at(color.len() / 2);
        self.chroma.write(&self.layout, [y, u, v], pixels);
    }
}

/// Whether a line, with its end, is that before a frame.
pub(crate) fn begins_frame(line: &[u8]) -> bool {
    line == FRAME || (line.starts_with(b"FRAME ") && line.ends_with(b"\n"))
}

fn number(digits: &[u8]) -> Option<u64> {
    std::str::from_utf8(digits).ok()?.parse().ok()
}

/// `30000:1001`.
fn rate_of(rate: &[u8]) -> Option<[u64; 2]> {
    let colon = rate.iter().position(|&c| c == b':')?;
    Some([number(&rate[..colon])?, number(&rate[colon + 1..])?])
}
