//! A page on which a picture's points are clicked: one file, with the picture in it, that needs no network.

use anyhow::{Context, Result};
use base64::prelude::{BASE64_STANDARD, Engine as _};
use lariat_chain::bounded;
use std::path::Path;

/// More than any camera takes.
const LARGEST_PICTURE: u64 = 1 << 30;
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
    let bytes = bounded::read(image, LARGEST_PICTURE)
        .with_context(|| format!("cannot read {}", image.display()))?;
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
            &format!(
                "data:image/{kind};base64,{}",
                BASE64_STANDARD.encode(&bytes)
            ),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_picture_is_in_the_page() {
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
