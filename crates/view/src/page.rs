//! The page's files, as they are in `page/`.

/// A file of the page: its path, its content type, its bytes.
type File = (&'static str, &'static str, &'static [u8]);

const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const SVG: &str = "image/svg+xml";

macro_rules! files {
    ($($name:literal: $kind:expr),* $(,)?) => {
        &[$(($name, $kind, include_bytes!(concat!("../page/", $name)))),*]
    };
}

const FILES: &[File] = files! {
    "index.html": HTML,
    "style.css": CSS,
    "icon.svg": SVG,
    "main.js": SCRIPT,
    "link.js": SCRIPT,
    "stage.js": SCRIPT,
    "overlay.js": SCRIPT,
    "panel.js": SCRIPT,
    "charts.js": SCRIPT,
    "history.js": SCRIPT,
    "live.js": SCRIPT,
    "film.js": SCRIPT,
    "mask.js": SCRIPT,
    "plane.js": SCRIPT,
    "tuning.js": SCRIPT,
    "words.js": SCRIPT,
};

/// Returns the content type and bytes of the file at a path.
pub(crate) fn at(path: &str) -> Option<(&'static str, &'static [u8])> {
    let path = if path.is_empty() { "index.html" } else { path };
    let found = FILES.iter().find(|(name, _, _)| *name == path);
    found.map(|(_, kind, bytes)| (*kind, *bytes))
}
