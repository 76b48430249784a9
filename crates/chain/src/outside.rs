//! Keeps the tables of `docs/outside.md`, which list what the code reads, in step with the code.

use std::path::Path;

/// Formats a table.
fn table<const N: usize>(head: [&str; N], rows: &[[&str; N]]) -> String {
    let line = |cells: &[&str; N]| format!("| {} |\n", cells.join(" | "));
    let rows: String = rows.iter().map(line).collect();
    format!("{}{}{rows}", line(&head), line(&["---"; N]))
}

/// Replaces the text between a mark and the next end mark in a document.
fn with(document: &str, mark: &str, text: &str) -> String {
    let begin = format!("<!-- read: {mark} -->\n");
    let (before, rest) = document
        .split_once(&begin)
        .expect("the mark is in the document");
    let (_, behind) = rest
        .split_once("<!-- end -->")
        .expect("each mark has an end");
    format!("{before}{begin}\n{text}\n<!-- end -->{behind}")
}

#[test]
fn the_tables_of_the_document_are_what_the_code_reads() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/outside.md");
    let document = std::fs::read_to_string(&path).expect("the document is there");
    let encodings = lariat_record::ENCODINGS
        .map(|name| format!("`{name}`"))
        .join(", ");
    let mut right = document.clone();
    for (mark, text) in [
        (
            "recordings",
            table(["", "what is read"], &lariat_record::READ),
        ),
        ("encodings", format!("{encodings}\n")),
        (
            "depth",
            table(["", "what is read"], &lariat_capture::DEPTH_IMAGES),
        ),
        (
            "calibrations",
            table(
                ["who writes it", "names", "lenses"],
                &lariat_camera::CALIBRATIONS,
            ),
        ),
    ] {
        right = with(&right, mark, &text);
    }
    if std::env::var_os("LARIAT_MAKE_READ").is_some() {
        std::fs::write(&path, &right).expect("the document can be written");
    }
    assert!(
        document == right || std::env::var_os("LARIAT_MAKE_READ").is_some(),
        "docs/outside.md is not what the code reads: LARIAT_MAKE_READ=1 cargo test --lib outside writes it"
    );
}
