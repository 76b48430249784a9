//! Every speed and accuracy figure that lariat claims.
fn main() {}
