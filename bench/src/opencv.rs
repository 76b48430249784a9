//! Color ranges in OpenCV's units.

use lariat_extract::HsvRange;

/// Returns the lowest and highest hue (0 to 179), saturation and value (0 to 255) of a range in
/// OpenCV's units. Returns two ranges if the hue wraps through 0.
pub fn opencv_bounds(range: &HsvRange) -> Vec<[[u8; 3]; 2]> {
    let byte = |share: f32| (255.0 * share + 0.5) as u8;
    let hue = |degrees: f32| ((degrees / 2.0) as u8).min(179);
    let [from, to] = range.hue_deg.map(hue);
    let spans = if range.hue_deg[0] > range.hue_deg[1] {
        vec![[from, 179], [0, to]]
    } else {
        vec![[from, to]]
    };
    let bound = |hue: u8, end: usize| [hue, byte(range.saturation[end]), byte(range.value[end])];
    let spans = spans.into_iter();
    spans
        .map(|[from, to]| [bound(from, 0), bound(to, 1)])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_that_wraps_through_red_is_two_of_opencvs() {
        let range = |hue_deg| HsvRange {
            hue_deg,
            saturation: [0.2, 1.0],
            value: [0.0, 0.5],
        };
        let blue = opencv_bounds(&range([200.0, 240.0]));
        assert_eq!(blue, [[[100, 51, 0], [120, 255, 128]]]);
        let red = opencv_bounds(&range([340.0, 20.0]));
        assert_eq!(red.len(), 2);
        assert_eq!([red[0][0][0], red[0][1][0]], [170, 179]);
        assert_eq!([red[1][0][0], red[1][1][0]], [0, 10]);
        assert_eq!(opencv_bounds(&range([0.0, 360.0]))[0][1][0], 179);
    }
}
