//! The chords of sixteen stations at once, each within a short distance of its expected place.
//!
//! Only the pixels are loaded chord by chord. Their positions, and the results, are computed for
//! all stations in parallel. If a rope does not start and end within that distance,
//! [`Reader::chord`] searches farther. Both give the same result for the same chord.

use super::chord::{CORE, Reader};
use super::profile::{BLOCK, Lanes, Stretch, WORD};
use super::station::Station;
use crate::following::{axis, whole};

/// Number of stations in parallel.
pub(super) const SIDE: usize = 16;
/// Distance from its expected place at which the rope's edge is sought, in pixels.
const FAR_PX: f32 = 5.0;

type Floats = [f32; SIDE];
type Ints = [i32; SIDE];

/// Places of the chords, relative to the row or column of each.
struct Places {
    axis: [u8; SIDE],
    /// Expected position of the rope's middle, along and across.
    along: Floats,
    across: Floats,
    /// Normal, along and across.
    normal: [Floats; 2],
    width_px: Floats,
    level: Floats,
    /// Size of the image, along and across.
    size: [Floats; 2],
}

impl Places {
    #[inline(always)]
    fn new(stations: &[Station], size: [f32; 2]) -> Self {
        let mut places = Self {
            axis: [0; SIDE],
            along: [0.0; SIDE],
            across: [0.0; SIDE],
            normal: [[1.0; SIDE]; 2],
            width_px: [1.0; SIDE],
            level: [1.0; SIDE],
            size: [[0.0; SIDE]; 2],
        };
        for (i, station) in stations.iter().enumerate().take(SIDE) {
            let axis = axis(station.normal);
            places.axis[i] = axis as u8;
            (places.along[i], places.across[i]) = (station.at[axis], station.at[1 - axis]);
            places.normal[0][i] = station.normal[axis];
            places.normal[1][i] = station.normal[1 - axis];
            places.width_px[i] = station.width_px + station.bias_px[1];
            places.level[i] = 0.5 * station.contrast;
            (places.size[0][i], places.size[1][i]) = (size[axis], size[1 - axis]);
        }
        places
    }
}

/// The pixels to read.
struct Spans {
    /// Length in blocks.
    blocks: Ints,
    /// The first pixel along the axis, and the row or column.
    from: Ints,
    line: Ints,
    /// Index in the span at which the middle is expected.
    middle: Ints,
    /// Image position of the span's middle.
    x: Floats,
    y: Floats,
    /// True if the span is inside the image.
    holds: [bool; SIDE],
    cut: Ints,
}

impl Spans {
    #[inline(always)]
    fn new(places: &Places) -> Self {
        let mut spans = Self {
            blocks: [0; SIDE],
            from: [0; SIDE],
            line: [0; SIDE],
            middle: [0; SIDE],
            x: [0.0; SIDE],
            y: [0.0; SIDE],
            holds: [false; SIDE],
            cut: [0; SIDE],
        };
        let most = (WORD / BLOCK) as f32;
        for i in 0..SIDE {
            let length_px = places.width_px[i] / places.normal[0][i].abs();
            let blocks = ((length_px + 2.0 * FAR_PX) / BLOCK as f32).ceil();
            let blocks = blocks.clamp(1.0, most);
            let span = blocks * BLOCK as f32;
            // The casts below round to nearest, as `line` and `from` are not negative then.
            let line = places.across[i] + 0.5;
            let from = places.along[i] + 0.5 - 0.5 * span;
            spans.holds[i] = (line >= 0.0)
                & (line < places.size[1][i])
                & (from >= 0.0)
                & (from <= places.size[0][i] - span);
            // Two pixels share their color in some formats.
            let (from, line) = (whole(from) & !1, whole(line));
            spans.middle[i] = whole(places.along[i] - from as f32 + 0.5);
            let middle = from as f32 + 0.5 * span;
            let down = places.axis[i] == 1;
            spans.x[i] = if down { line as f32 } else { middle };
            spans.y[i] = if down { middle } else { line as f32 };
            (spans.blocks[i], spans.from[i], spans.line[i]) = (whole(blocks), from, line);
            spans.cut[i] = whole(places.level[i].ceil().clamp(1.0, 255.0));
        }
        spans
    }
}

/// The runs of rope in the pixels read.
struct Runs {
    first: Ints,
    end: Ints,
    /// Differences of four pixels: before the first, the first, the last, and after the last.
    edges: [Ints; 4],
    found: [bool; SIDE],
}

/// The chords of some stations.
pub(super) struct Found {
    pub(super) aside_px: Floats,
    pub(super) width_px: Floats,
    pub(super) contrast: Floats,
    /// True if a chord was found.
    pub(super) found: [bool; SIDE],
    /// True if a chord may be found farther away.
    pub(super) farther: [bool; SIDE],
}

/// Reads the chords of up to [`SIDE`] stations, where `wanted` is set.
#[inline(always)]
pub(super) fn chords(
    reader: &Reader,
    lanes: impl Lanes,
    stations: &[Station],
    wanted: &[bool; SIDE],
) -> Found {
    let image = reader.image;
    let size = [image.width() as f32, image.height() as f32];
    let places = Places::new(stations, size);
    let spans = Spans::new(&places);
    let mut table = [0u32; SIDE];
    reader.background.at_all(&spans.x, &spans.y, &mut table);
    let mut profiles = [[0u8; WORD]; SIDE];
    let mut runs = Runs {
        first: [1; SIDE],
        end: [2; SIDE],
        edges: [[0; SIDE]; 4],
        found: [false; SIDE],
    };
    for i in 0..stations.len().min(SIDE) {
        if !(wanted[i] && spans.holds[i]) {
            continue;
        }
        let axis = usize::from(places.axis[i] & 1);
        let mut from = [spans.line[i] as usize; 2];
        from[axis] = spans.from[i] as usize;
        let stretch = Stretch {
            image,
            from,
            axis,
            count: BLOCK * spans.blocks[i] as usize,
            tables: [table[i]; _],
            cut: spans.cut[i] as u8,
        };
        let set = lanes.read(&stretch, &mut profiles[i]);
        let (first, end, found) = run(set, stretch.count as u32, spans.middle[i] as u32);
        runs.found[i] = found;
        (runs.first[i], runs.end[i]) = (first as i32, end as i32);
        for (edge, at) in
            runs.edges
                .iter_mut()
                .zip([first.wrapping_sub(1), first, end.wrapping_sub(1), end])
        {
            edge[i] = profiles[i][at as usize % WORD].into();
        }
    }
    measure(lanes, &places, &spans, &runs, &profiles, wanted)
}

/// Computes position, width and contrast of the rope from the runs.
#[inline(always)]
fn measure(
    lanes: impl Lanes,
    places: &Places,
    spans: &Spans,
    runs: &Runs,
    profiles: &[[u8; WORD]; SIDE],
    wanted: &[bool; SIDE],
) -> Found {
    let mut found = Found {
        aside_px: [0.0; SIDE],
        width_px: [0.0; SIDE],
        contrast: [0.0; SIDE],
        found: runs.found,
        farther: [false; SIDE],
    };
    let (mut core_from, mut core_to) = ([0i32; SIDE], [0i32; SIDE]);
    for i in 0..SIDE {
        let [before, first, last, after] = [0, 1, 2, 3].map(|k: usize| runs.edges[k][i] as f32);
        let level = places.level[i];
        let part = |low: f32, high: f32| (high - level) / (high - low).max(1.0);
        let left = runs.first[i] as f32 - part(before, first);
        let right = (runs.end[i] - 1) as f32 + part(after, last);
        let length_px = right - left;
        let middle = spans.from[i] as f32 + 0.5 * (left + right);
        let [along, across] = [places.normal[0][i], places.normal[1][i]];
        found.aside_px[i] =
            (middle - places.along[i]) * along + (spans.line[i] as f32 - places.across[i]) * across;
        found.width_px[i] = length_px * along.abs();
        let (first, end) = (runs.first[i], runs.end[i]);
        let rim = whole(0.5 * (1.0 - CORE) * length_px);
        core_from[i] = (first + rim).min(end - 1);
        core_to[i] = (end - rim).max(first + rim + 1).min(end);
        found.farther[i] = wanted[i] & spans.holds[i] & !runs.found[i];
    }
    let mut sums = [0u32; SIDE];
    for i in 0..SIDE {
        if runs.found[i] {
            sums[i] = lanes.sum(&profiles[i], [core_from[i] as u32, core_to[i] as u32]);
        }
    }
    for i in 0..SIDE {
        let count = (core_to[i] - core_from[i]).max(1);
        found.contrast[i] = sums[i] as i32 as f32 / count as f32;
    }
    found
}

/// The run of set bits that includes bit `at` or is nearest to it, among the first `count` bits:
/// its first bit, the one after its last, and whether it exists and touches neither end.
#[inline(always)]
fn run(set: u64, count: u32, at: u32) -> (u32, u32, bool) {
    const LAST: u32 = WORD as u32 - 1;
    let at = at.min(count - 1);
    let (up, down) = (
        (set >> at).trailing_zeros(),
        (set << (LAST - at)).leading_zeros(),
    );
    let inside = if up <= down {
        at + up
    } else {
        at.wrapping_sub(down)
    } & LAST;
    let end = inside + (!(set >> inside)).trailing_zeros();
    let first = (inside + 1).wrapping_sub((!(set << (LAST - inside))).leading_zeros());
    let within = (first.wrapping_sub(1) < LAST) & (end < count);
    (first, end, (set != 0) & within)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_run_is_the_one_that_holds_the_bit_or_the_nearest(
            bits in prop::collection::vec(prop::bool::weighted(0.6), BLOCK..=WORD), at in 0..WORD,
        ) {
            let (count, at) = (bits.len(), at.min(bits.len() - 1));
            let set = bits.iter().rev().fold(0u64, |set, &bit| set << 1 | u64::from(bit));
            let nearest = (0..count).filter(|&i| bits[i]).min_by_key(|&i| (i.abs_diff(at), i < at));
            let expected = nearest.map(|inside| {
                let first = (0..inside).rev().take_while(|&i| bits[i]).last().unwrap_or(inside);
                let last = (inside..count).take_while(|&i| bits[i]).last().unwrap_or(inside);
                (first, last + 1)
            });
            let expected = expected.filter(|&(first, end)| first > 0 && end < count);
            let (first, end, found) = run(set, count as u32, at as u32);
            let found = found.then_some((first as usize, end as usize));
            prop_assert_eq!(found, expected);
        }
    }
}
