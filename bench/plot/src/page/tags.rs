//! A rough check, for tests, that tags of HTML and SVG are closed in the reverse order of opening.

/// Checks that every tag is closed, and that every closing tag has an opening one.
///
/// # Errors
/// Returns a description of the first tag that violates this.
pub fn check_tags(text: &str) -> Result<(), String> {
    const EMPTY: [&str; 2] = ["meta", "br"];
    let mut open: Vec<&str> = Vec::new();
    let mut rest = text;
    while let Some(at) = rest.find('<') {
        rest = &rest[at + 1..];
        let end = rest.find('>').ok_or("a tag without an end")?;
        let (tag, after) = rest.split_at(end);
        if tag.contains('<') {
            return Err(format!("a < in a tag: {tag}"));
        }
        if let Some(name) = tag.strip_prefix('/') {
            match open.pop() {
                Some(last) if last == name => {}
                last => return Err(format!("</{name}> closes {last:?}")),
            }
        } else if !tag.starts_with('!') && !tag.ends_with('/') {
            let name = tag.split_whitespace().next().unwrap_or_default();
            if !EMPTY.contains(&name) {
                open.push(name);
            }
            if tag.matches('"').count() % 2 == 1 {
                return Err(format!("a quote that is not closed: {tag}"));
            }
        }
        rest = &after[1..];
    }
    match open.pop() {
        None => Ok(()),
        Some(tag) => Err(format!("<{tag}> is not closed")),
    }
}

#[test]
fn open_tags_are_found() {
    assert!(check_tags("<!DOCTYPE html><a b=\"c\"><d/></a>").is_ok());
    assert!(check_tags("<a><b></a>").is_err());
    assert!(check_tags("<a>").is_err());
    assert!(check_tags("</a>").is_err());
    assert!(check_tags("<a b=\"c></a>").is_err());
}
