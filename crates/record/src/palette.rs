//! The colors of drawn ropes.

/// One color per rope, distinguishable with color vision deficiencies (Okabe and Ito's set, without
/// black).
const ROPES: [[u8; 3]; 7] = [
    [230, 159, 0],
    [86, 180, 233],
    [0, 158, 115],
    [240, 228, 66],
    [204, 121, 167],
    [213, 94, 0],
    [0, 114, 178],
];

/// Returns the color of a rope, red, green and blue. It depends on the track, so a rope keeps its
/// color.
pub fn rope_color(track: u32) -> [u8; 3] {
    ROPES[track as usize % ROPES.len()]
}
