//! Reads whole files up to a size limit. Without the limit, naming a device or a video instead of a
//! settings file would exhaust memory.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Size limit for settings, calibrations, planes and points. The longest of them take a few
/// kilobytes.
pub const LONGEST_TEXT: u64 = 4 << 20;

/// Reads a file of at most `most` bytes.
///
/// # Errors
/// Returns an error if the file cannot be read or is larger.
pub fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        let most_mb = most >> 20;
        return Err(io::Error::other(format!("it is larger than {most_mb} MB")));
    }
    Ok(bytes)
}

/// Reads a text file of at most [`LONGEST_TEXT`] bytes.
///
/// # Errors
/// Returns an error if the file cannot be read, is larger, or is not UTF-8.
pub fn read_text(path: &Path) -> io::Result<String> {
    let bytes = read(path, LONGEST_TEXT)?;
    String::from_utf8(bytes).map_err(|_| io::Error::other("it is not UTF-8 text"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_without_end_is_refused() {
        let refused = read_text(Path::new("/dev/zero")).expect_err("it has no end");
        assert_eq!(refused.to_string(), "it is larger than 4 MB");
        assert_eq!(read_text(Path::new("/dev/null")).expect("empty"), "");
    }
}
