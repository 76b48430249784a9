//! Recognizes files that lariat does not read, by their first bytes or their names, and gives the
//! command that converts them.

use std::path::Path;

/// A file that has to be converted first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Foreign {
    /// The kind of file, with its article.
    pub(crate) what: &'static str,
    pub(crate) way: Way,
}

/// The result of the conversion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Way {
    Video,
    /// A numbered sequence of pictures. Also used for a single picture in a format that every
    /// ffmpeg reads.
    Frames,
    /// One picture. Used for formats that only recent versions of ffmpeg read.
    Picture,
    /// No conversion: lariat reads the file under its own name.
    Recording,
}

const fn foreign(what: &'static str, way: Way) -> Foreign {
    Foreign { what, way }
}

const HEIC: Foreign = foreign("a HEIC picture", Way::Picture);
const AVIF: Foreign = foreign("an AVIF picture", Way::Picture);
const JPEG_XL: Foreign = foreign("a JPEG XL picture", Way::Picture);
const JPEG_2000: Foreign = foreign("a JPEG 2000 picture", Way::Frames);
const GIF: Foreign = foreign("a GIF", Way::Frames);
const RAW: Foreign = foreign("a camera's raw picture", Way::Picture);
const MP4: Foreign = foreign("an MP4 or MOV video", Way::Video);
const MATROSKA: Foreign = foreign("a Matroska or WebM video", Way::Video);
const AVI: Foreign = foreign("an AVI video", Way::Video);
const OGG: Foreign = foreign("an Ogg video", Way::Video);
const FLASH: Foreign = foreign("a Flash video", Way::Video);
const MPEG: Foreign = foreign("an MPEG or H.264 stream", Way::Video);
const H264: Foreign = foreign("an H.264 or H.265 stream", Way::Video);
const TRANSPORT: Foreign = foreign("an MPEG transport stream", Way::Video);

/// Offset and bytes that identify each kind. A box of ISO/IEC 14496-12 begins with its length, and
/// its brand follows `ftyp`.
const MARKS: [(usize, &[u8], Foreign); 26] = [
    (0, b"GIF8", GIF),
    (4, b"ftypheic", HEIC),
    (4, b"ftypheix", HEIC),
    (4, b"ftyphevc", HEIC),
    (4, b"ftypmif1", HEIC),
    (4, b"ftypmsf1", HEIC),
    (4, b"ftypavif", AVIF),
    (4, b"ftypavis", AVIF),
    (4, b"ftypcrx ", RAW),
    (4, b"ftyp", MP4),
    (4, b"moov", MP4),
    (4, b"mdat", MP4),
    (4, b"JXL \r\n", JPEG_XL),
    (0, b"\xff\x0a", JPEG_XL),
    (4, b"jP  \r\n", JPEG_2000),
    (0, b"\xff\x4f\xff\x51", JPEG_2000),
    (0, b"\x1a\x45\xdf\xa3", MATROSKA),
    (8, b"AVI ", AVI),
    (0, b"OggS", OGG),
    (0, b"FLV", FLASH),
    (
        0,
        b"\x76\x2f\x31\x01",
        foreign("an OpenEXR picture", Way::Frames),
    ),
    (0, b"8BPS", foreign("a Photoshop file", Way::Frames)),
    (0, b"\x00\x00\x00\x01", H264),
    (0, b"\x00\x00\x01", MPEG),
    (0, b"\x89MCAP", foreign("a recording", Way::Recording)),
    (0, b"\x47\x40", TRANSPORT),
];

/// File name extensions of the same kinds, in lower case.
const ENDINGS: [(&str, Foreign); 27] = [
    ("gif", GIF),
    ("heic", HEIC),
    ("heif", HEIC),
    ("hif", HEIC),
    ("avif", AVIF),
    ("jxl", JPEG_XL),
    ("jp2", JPEG_2000),
    ("exr", foreign("an OpenEXR picture", Way::Frames)),
    ("cr2", RAW),
    ("cr3", RAW),
    ("nef", RAW),
    ("arw", RAW),
    ("dng", RAW),
    ("raf", RAW),
    ("orf", RAW),
    ("rw2", RAW),
    ("mp4", MP4),
    ("m4v", MP4),
    ("mov", MP4),
    ("mkv", MATROSKA),
    ("webm", MATROSKA),
    ("avi", AVI),
    ("ogv", OGG),
    ("flv", FLASH),
    ("mpg", MPEG),
    ("h264", H264),
    ("ts", TRANSPORT),
];

impl Foreign {
    /// Identifies a file by its first bytes.
    pub(crate) fn of(head: &[u8]) -> Option<Self> {
        let tells = |&&(at, mark, _): &&(usize, &[u8], Self)| {
            head.get(at..).is_some_and(|head| head.starts_with(mark))
        };
        MARKS.iter().find(tells).map(|&(.., known)| known)
    }

    /// Identifies a file by its name.
    pub(crate) fn named(path: &Path) -> Option<Self> {
        let ending = path.extension()?;
        let known = |(known, _): &&(&str, Self)| ending.eq_ignore_ascii_case(known);
        ENDINGS.iter().find(known).map(|&(_, known)| known)
    }

    /// End of a sentence that begins with the path: the kind of file, and what to do.
    pub(crate) fn advice(self, path: &Path) -> String {
        let Self { what, way } = self;
        let shown = path.display();
        match way {
            Way::Video => format!(
                "is {what}: convert it first (`ffmpeg -i {shown} -pix_fmt yuv420p out.y4m`)"
            ),
            Way::Frames => {
                format!("is {what}: convert it first (`ffmpeg -i {shown} frame-%03d.png`)")
            }
            Way::Picture => format!(
                "is {what}: convert it first (`ffmpeg -i {shown} out.png`, or `magick {shown} out.png` where ffmpeg cannot)"
            ),
            Way::Recording => format!("is {what}: give its name the ending .mcap"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_bytes_tell_what_a_file_is_and_the_way_out() {
        for (head, what, way) in [
            (&b"GIF89a"[..], "a GIF", "ffmpeg -i x frame-%03d.png"),
            (b"\x00\x00\x00\x18ftypheic", "HEIC", "magick x out.png"),
            (b"\x00\x00\x00\x1cftypavif", "AVIF", "ffmpeg -i x out.png"),
            (b"\x00\x00\x00\x20ftypisom", "MP4", "yuv420p out.y4m"),
            (b"\x1a\x45\xdf\xa3", "Matroska", "yuv420p out.y4m"),
            (b"RIFF\0\0\0\0AVI LIST", "AVI", "yuv420p out.y4m"),
        ] {
            let said = Foreign::of(head)
                .expect("it is known")
                .advice(Path::new("x"));
            assert!(said.contains(what) && said.contains(way), "{said}");
        }
        assert_eq!(Foreign::of(b"RIFF\0\0\0\0WEBP"), None);
        assert_eq!(Foreign::of(b"\x89PNG\r\n\x1a\n"), None);
    }

    #[test]
    fn names_tell_it_too() {
        for (name, what) in [("a.HEIC", HEIC), ("b.gif", GIF), ("c.mp4", MP4)] {
            assert_eq!(Foreign::named(Path::new(name)), Some(what));
        }
        assert_eq!(Foreign::named(Path::new("heic")), None);
    }
}
