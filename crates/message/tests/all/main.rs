//! Files that follow from the messages' declarations: tables in documents, layouts for C and
//! Python. They are committed. To regenerate them: `LARIAT_WRITE_LAYOUTS=1 cargo test -p
//! lariat-message`.

use std::path::Path;

mod c;
mod documents;
mod python;

/// Checks that a committed file equals the generated text, or writes that text if requested.
fn hold(path: &str, made: impl FnOnce(&str) -> String) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .join(path);
    let committed = std::fs::read_to_string(&path).expect("a file");
    let made = made(&committed);
    if std::env::var_os("LARIAT_WRITE_LAYOUTS").is_some() {
        std::fs::write(&path, &made).expect("writable");
    } else {
        assert!(
            committed == made,
            "{} does not say what the messages say: LARIAT_WRITE_LAYOUTS=1 cargo test -p lariat-message",
            path.display()
        );
    }
}

/// Documentation without its links.
fn plain(about: &str) -> String {
    let mut text = String::new();
    let mut rest = about.trim();
    while let Some((before, link)) = rest.split_once('[') {
        text += before;
        let end = link.find(']').unwrap_or(link.len());
        let (name, after) = (&link[..end], link.get(end + 1..).unwrap_or_default());
        // A range or a pair of coordinates is not a link.
        let is_link = name.starts_with('`') || after.starts_with('(');
        text += &if is_link {
            name.to_owned()
        } else {
            format!("[{name}]")
        };
        rest = match (is_link, after.strip_prefix('(')) {
            (true, Some(target)) => target.split_once(')').map_or("", |(_, after)| after),
            _ => after,
        };
    }
    text + rest
}
