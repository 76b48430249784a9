//! Puts the ABI version into the shared library's name, so that a program never runs with another
//! version.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,liblariat.so.1");
}
