//! The committed header equals the one generated from the sources.

use std::path::Path;

#[test]
fn the_header_says_what_the_library_has() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(root.join("cbindgen.toml")).expect("settings");
    let made = cbindgen::Builder::new()
        .with_config(config)
        .with_crate(root)
        .generate()
        .expect("a header");
    let mut text = Vec::new();
    made.write(&mut text);
    let made = String::from_utf8(text).expect("text");
    let path = root.join("include/lariat.h");
    if std::env::var_os("LARIAT_MAKE_HEADER").is_some() {
        std::fs::write(&path, &made).expect("writable");
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        committed == made,
        "include/lariat.h is not what src/ makes: LARIAT_MAKE_HEADER=1 cargo test -p lariat-c --test header"
    );
}
