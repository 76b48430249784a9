//! The page that contains the charts: one file, readable on screen and on paper, without scripts or
//! external resources.

mod tags;

pub use tags::check_tags;

const STYLE: &str = include_str!("page/page.css");

/// Returns a page with this title. `body` is HTML and is inserted unchanged.
pub fn page(title: &str, body: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n{body}</main>\n</body>\n</html>\n",
        escaped(title)
    )
}

/// Escapes text for HTML and SVG.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[test]
fn a_page_is_whole() {
    let page = page("a < b", "<p>c</p>\n");
    check_tags(&page).unwrap();
    assert!(page.contains("<title>a &lt; b</title>") && page.contains("<main>\n<p>c</p>\n</main>"));
}
