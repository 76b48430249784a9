//! The page that charts stand in: one file, readable on a screen and on paper, without scripts and without anything to
//! fetch.

mod tags;

pub use tags::check_tags;

const STYLE: &str = include_str!("page/page.css");

/// A page of this title around a body, which is HTML and goes in as it is.
pub fn page(title: &str, body: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n{body}</main>\n</body>\n</html>\n",
        escaped(title)
    )
}

/// Text as HTML and SVG have it.
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
