//! A page on which a picture's points are clicked: one file, with the picture in it, that needs no network.

use anyhow::{Context, Result};
use std::path::Path;

const PAGE: &str = include_str!("page.html");

/// The page of a picture of this size; the command that it shows names the calibration.
///
/// # Errors
/// The picture cannot be read.
pub(super) fn of(
    image: &Path,
    [width, height]: [u32; 2],
    calibration: Option<&Path>,
) -> Result<String> {
    let bytes = std::fs::read(image).with_context(|| format!("cannot read {}", image.display()))?;
    let kind = if bytes.starts_with(b"\x89PNG") {
        "png"
    } else {
        "jpeg"
    };
    let rest = calibration.map_or(String::new(), |path| {
        format!(" --calibration {}", quoted(&path.to_string_lossy()))
    });
    // Text in a script: no end tag may stand in it.
    let rest = serde_json::to_string(&rest)?.replace('<', "\\u003c");
    Ok(PAGE
        .replace("@WIDTH@", &width.to_string())
        .replace("@HEIGHT@", &height.to_string())
        .replace("@REST@", &rest)
        .replace(
            "@IMAGE@",
            &format!("data:image/{kind};base64,{}", base64(&bytes)),
        ))
}

/// As a shell takes it for one word.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// RFC 4648, with padding.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let byte = |i: usize| u32::from(three.get(i).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for digit in 0..4 {
            text.push(match digit <= three.len() {
                true => char::from(DIGITS[(bits >> (18 - 6 * digit) & 63) as usize]),
                false => '=',
            });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_picture_is_in_the_page() {
        // The examples of RFC 4648.
        for (bytes, text) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
        let folder = tempfile::tempdir().unwrap();
        let picture = folder.path().join("a.png");
        std::fs::write(&picture, b"\x89PNG\r\n\x1a\n").unwrap();
        let page = of(&picture, [640, 480], Some(Path::new("it's </script>.yaml"))).unwrap();
        assert!(page.contains("data:image/png;base64,iVBORw0KGgo="));
        assert!(page.contains("const size = [640, 480]"));
        assert!(!page.contains("'s </script>"), "the script would end there");
        assert!(!page.contains('@'));
        assert!(!page.contains("http"), "nothing is fetched");
    }
}
