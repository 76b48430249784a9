//! Names the shared library by its ABI, so that a program is never run with another one's.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,liblariat.so.1");
}
