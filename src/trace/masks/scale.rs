//! Masks of a different size than their picture, as networks produce them.

use anyhow::{Result, bail};
use image::GrayImage;
use image::imageops::{FilterType, resize};

/// Scales `levels` from one size to another. Also returns a sentence about it.
///
/// A mask with the picture's proportions is assumed to show the same field of view. A square mask
/// is, too, because networks stretch pictures to a square.
///
/// # Errors
/// Returns an error if the mask has other proportions, because the part of the picture that it
/// shows is unknown.
pub(super) fn to(to: [u32; 2], from: [u32; 2], levels: Vec<u8>) -> Result<(Vec<u8>, String)> {
    let shown = |[width, height]: [u32; 2]| format!("{width}×{height}");
    let is_square = from[0] == from[1];
    if !is_square && !is_alike(to, from) {
        bail!(
            "the mask is {} pixels and its image {}: give each image a mask of its own size, or of its proportions",
            shown(from),
            shown(to)
        );
    }
    let Some(mask) = GrayImage::from_raw(from[0], from[1], levels) else {
        bail!("the mask has fewer levels than pixels");
    };
    let how = if is_alike(to, from) {
        ""
    } else {
        ", as if the whole picture had been stretched to a square (cut off borders that were added)"
    };
    let news = format!(
        "the mask is scaled from {} to {}{how}",
        shown(from),
        shown(to)
    );
    let scaled = resize(&mask, to[0], to[1], FilterType::Triangle);
    Ok((scaled.into_raw(), news))
}

/// Returns true if two sizes have the same proportions: one size is the other, scaled and rounded
/// to whole pixels.
fn is_alike(a: [u32; 2], b: [u32; 2]) -> bool {
    let [a, b] = [a, b].map(|size| size.map(u64::from));
    // The cross products differ by a side's length if the other side is a pixel off.
    let off = (a[0] * b[1]).abs_diff(a[1] * b[0]);
    off <= a[0].max(a[1]).max(b[0]).max(b[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mask_of_the_same_field_of_view_is_scaled() {
        let half: Vec<u8> = (0..16)
            .flat_map(|x| [if x < 8 { 0 } else { 255 }; 12])
            .collect();
        // Turned, so that columns are rows: 12 wide, 16 high.
        let (levels, news) = to([24, 32], [12, 16], half).unwrap();
        assert_eq!(levels.len(), 24 * 32);
        assert_eq!((levels[24 * 10], levels[24 * 20]), (0, 255));
        assert_eq!(news, "the mask is scaled from 12×16 to 24×32");
        let (levels, news) = to([32, 24], [16, 16], vec![7; 256]).unwrap();
        assert_eq!(levels, vec![7; 32 * 24]);
        assert!(news.contains("square"));
        assert!(to([1280, 963], [320, 241], vec![0; 320 * 241]).is_ok());
    }

    #[test]
    fn a_mask_of_other_proportions_is_refused() {
        for from in [[20, 10], [480, 640], [640, 400]] {
            let levels = vec![0; (from[0] * from[1]) as usize];
            let said = to([640, 480], from, levels).unwrap_err().to_string();
            assert!(said.contains("its image 640×480"), "{said}");
        }
    }
}
