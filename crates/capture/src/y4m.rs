//! Parses the text in a Y4M video: its header, and the line before each frame.

use crate::ahead::Layout;
use crate::color_range::ColorRange;
use crate::yuv::Chroma;

/// First bytes of a video.
pub(crate) const MAGIC: &[u8] = b"YUV4MPEG2 ";
/// Maximum length of a line, in bytes.
pub(crate) const LINE_BYTES: usize = 1024;
/// Start of the line before a frame, and usually the whole line.
pub(crate) const FRAME: &[u8] = b"FRAME\n";
/// Maximum width and height. A larger value more likely comes from a broken header than from a
/// camera.
pub(crate) const LARGEST_SIDE: u64 = 16384;

/// Header of a video (its first line).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Head {
    chroma: Chroma,
    /// Bits per sample. A sample takes one byte for 8 bits and two bytes for more.
    bits: u32,
    /// True if an alpha plane follows.
    has_alpha: bool,
    range: ColorRange,
    /// Layout of the decoded frames.
    pub(crate) layout: Layout,
    /// Frames per second, if the header has a rate.
    pub(crate) fps: Option<f64>,
}

impl Head {
    /// Parses the header at the start of a video.
    ///
    /// # Errors
    /// The header is invalid, or the video cannot be shown. The text is the end of a sentence.
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
        let Some((chroma, bits, has_alpha)) = samples_of(word(b'C').unwrap_or(b"420")) else {
            return Err(
                "its pixels are none of 4:2:0, 4:1:1, 4:2:2, 4:4:4 and mono of 8 to 16 bits \
                 (convert it with `ffmpeg -i IN -pix_fmt yuv420p OUT.y4m`)",
            );
        };
        let says = |said: &[u8]| words().any(|word| word == said);
        // The default is limited. However, ffmpeg writes gray in full range.
        let range = match chroma {
            Chroma::Mono if says(b"XCOLORRANGE=LIMITED") => ColorRange::Limited,
            Chroma::Mono => ColorRange::Full,
            _ if says(b"XCOLORRANGE=FULL") => ColorRange::Full,
            _ => ColorRange::Limited,
        };
        let layout = chroma.layout(width, height);
        Ok(Self {
            chroma,
            bits,
            has_alpha,
            range,
            layout,
            fps,
        })
    }

    /// Bytes of a frame's planes in the file.
    pub(crate) fn plane_bytes(&self) -> usize {
        let Layout { width, height, .. } = self.layout;
        let (width, height) = (width as usize, height as usize);
        let planes = 1 + usize::from(self.has_alpha);
        let samples = planes * width * height + 2 * self.chroma.samples(width, height);
        samples * if self.bits > 8 { 2 } else { 1 }
    }

    /// Converts a frame's planes to pixels. The planes may be changed.
    pub(crate) fn write(&self, planes: &mut [u8], pixels: &mut [u8]) {
        let Layout { width, height, .. } = self.layout;
        let (width, height) = (width as usize, height as usize);
        narrow(self.bits, planes);
        let (y, rest) = planes.split_at(width * height);
        let (u, rest) = rest.split_at(self.chroma.samples(width, height));
        let v = &rest[..u.len()];
        (self.chroma).write(self.range, &self.layout, [y, u, v], pixels);
    }
}

/// Decodes the parameter for samples: chroma sampling, bits, and whether alpha follows.
fn samples_of(word: &[u8]) -> Option<(Chroma, u32, bool)> {
    let known = match word {
        b"420" | b"420jpeg" | b"420paldv" | b"420mpeg2" => (Chroma::Half, 8, false),
        b"411" => (Chroma::QuarterWidth, 8, false),
        b"422" => (Chroma::HalfWidth, 8, false),
        b"444" => (Chroma::Full, 8, false),
        b"444alpha" => (Chroma::Full, 8, true),
        b"mono" => (Chroma::Mono, 8, false),
        _ => {
            let word = std::str::from_utf8(word).ok()?;
            let (chroma, bits) = match (word.strip_prefix("mono"), word.split_once('p')) {
                (Some(bits), _) => (Chroma::Mono, bits),
                (_, Some(("420", bits))) => (Chroma::Half, bits),
                (_, Some(("422", bits))) => (Chroma::HalfWidth, bits),
                (_, Some(("444", bits))) => (Chroma::Full, bits),
                _ => return None,
            };
            let bits = bits.parse().ok().filter(|bits| (9..=16).contains(bits))?;
            (chroma, bits, false)
        }
    };
    Some(known)
}

/// Rounds two-byte little-endian samples to 8 bits, at the start of the same memory.
fn narrow(bits: u32, planes: &mut [u8]) {
    if bits == 8 {
        return;
    }
    let half = 1 << (bits - 9);
    for place in 0..planes.len() / 2 {
        let sample = u16::from_le_bytes([planes[2 * place], planes[2 * place + 1]]);
        planes[place] = ((u32::from(sample) + half) >> (bits - 8)).min(255) as u8;
    }
}

/// Returns whether a line, including its end, is the one before a frame.
pub(crate) fn begins_frame(line: &[u8]) -> bool {
    line == FRAME || (line.starts_with(b"FRAME ") && line.ends_with(b"\n"))
}

fn number(digits: &[u8]) -> Option<u64> {
    std::str::from_utf8(digits).ok()?.parse().ok()
}

/// Parses a rate such as `30000:1001`.
fn rate_of(rate: &[u8]) -> Option<[u64; 2]> {
    let colon = rate.iter().position(|&c| c == b':')?;
    Some([number(&rate[..colon])?, number(&rate[colon + 1..])?])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn head(words: &str) -> Head {
        let line = format!("YUV4MPEG2 W4 H2 {words}\n");
        Head::of(line.as_bytes()).unwrap_or_else(|what| panic!("{words}: {what}"))
    }

    #[test]
    fn video_is_limited_unless_it_says_otherwise() {
        for (words, range) in [
            ("", ColorRange::Limited),
            ("C420jpeg", ColorRange::Limited),
            ("C444 XCOLORRANGE=LIMITED", ColorRange::Limited),
            ("C420jpeg XCOLORRANGE=FULL", ColorRange::Full),
            ("Cmono", ColorRange::Full),
            ("Cmono XCOLORRANGE=LIMITED", ColorRange::Limited),
        ] {
            assert_eq!(head(words).range, range, "{words}");
        }
    }

    #[test]
    fn wide_samples_and_alpha_come_out_as_8_bits_without_them() {
        for (chroma, samples) in [
            ("mono", 8),
            ("420", 8 + 2 * 2),
            ("411", 8 + 2 * 2),
            ("422", 8 + 2 * 4),
            ("444", 8 + 2 * 8),
            ("444alpha", 8 + 3 * 8),
        ] {
            let narrow = head(&format!("C{chroma} XCOLORRANGE=FULL"));
            assert_eq!(narrow.plane_bytes(), samples, "{chroma}");
            let mut planes: Vec<u8> = (0..samples).map(|k| 3 * k as u8 + 100).collect();
            let mut expected = vec![0; narrow.layout.bytes()];
            narrow.write(&mut planes.clone(), &mut expected);
            if chroma.contains(char::is_alphabetic) && chroma != "mono" || chroma == "411" {
                continue;
            }
            let infix = if chroma == "mono" { "" } else { "p" };
            for bits in [9, 10, 12, 14, 16] {
                let wide = head(&format!("C{chroma}{infix}{bits} XCOLORRANGE=FULL"));
                assert_eq!(wide.plane_bytes(), 2 * samples);
                let widen = |&level: &u8| (u16::from(level) << (bits - 8)).to_le_bytes();
                let mut wider: Vec<u8> = planes.iter().flat_map(widen).collect();
                let mut pixels = vec![0; wide.layout.bytes()];
                wide.write(&mut wider, &mut pixels);
                assert_eq!(pixels, expected, "{chroma} of {bits} bits");
            }
            planes.clear();
        }
    }

    #[test]
    fn other_samplings_are_refused_with_the_way_out() {
        for word in ["410", "440", "420p8", "420p17", "monox", "555"] {
            let line = format!("YUV4MPEG2 W4 H2 C{word}\n");
            let said = Head::of(line.as_bytes()).expect_err("it is refused");
            assert!(said.contains("ffmpeg"), "{word}: {said}");
        }
    }
}
