//! lariat
fn main() {}
