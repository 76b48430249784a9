//! The colors of ropes wherever they are drawn.

/// A color a rope, told apart also by those who see fewer colors (Okabe and Ito's set, without the black).
const ROPES: [[u8; 3]; 7] = [
    [230, 159, 0],
    [86, 180, 233],
    [0, 158, 115],
    [240, 228, 66],
    [204, 121, 167],
    [213, 94, 0],
    [0, 114, 178],
];

/// The color of a rope, red, green and blue, by its track: so one keeps its color.
pub fn rope_color(track: u32) -> [u8; 3] {
    ROPES[track as usize % ROPES.len()]
}
