//! Adversarial pictures: the worst-case cost of an extraction, as a multiple of the normal case.

use anyhow::{Context, Result};
use lariat_bench::{Picture, Table, micros, multiple, times};
use lariat_capture::RenderOptions;
use lariat_extract::{HsvRange, Mask, Options, PixelFormat};

use crate::Effort;
use crate::case::{Case, Times, measure};
use lariat_bench::paint::{HEIGHT, Noise, WIDTH, eight_ropes, picture, ten_crossings};

/// Repetitions of the same picture, so that "tracked" is measured too.
const REPEATS: usize = 4;

pub(crate) fn run(effort: &Effort) -> Result<()> {
    let normal = effort.film(RenderOptions::default(), 8)?;
    let mut cases = vec![Case::new("one rope (normal)", normal)?];
    for (name, draw) in PICTURES {
        let film: Result<Vec<Picture>> = (0..REPEATS).map(|_| draw()).collect();
        cases.push(Case::new(name, film?)?);
    }
    for (name, draw, range) in BY_COLOR {
        let film: Result<Vec<Picture>> = (0..REPEATS).map(|_| draw()).collect();
        let by_color = Options::default().mask(Mask::Hsv(vec![range]));
        cases.push(Case::with(name, film?, by_color)?);
    }
    for (name, draw) in WITH_MASKS {
        let film = (0..REPEATS).map(|_| draw()).collect::<Result<Vec<_>>>()?;
        let masks = film.iter().map(dark).collect::<Result<_>>()?;
        cases.push(Case::masked(name, film, masks)?);
    }
    let films = [
        (
            "a sixteenth of one rope's picture",
            effort.film(RenderOptions::default(), 8)?,
        ),
        (
            "a sixteenth of a bare table",
            (0..REPEATS).map(|_| bare()).collect::<Result<_>>()?,
        ),
    ];
    for (name, film) in films {
        let film = film.iter().map(sixteenth).collect::<Result<_>>()?;
        cases.push(Case::new(name, film)?);
    }
    measure(&mut cases, effort.time(14.0))?;
    print(&cases);
    Ok(())
}

type Draw = fn() -> Result<Picture>;

const PICTURES: [(&str, Draw); 17] = [
    ("a bare table", bare),
    ("a disc of 240 px", disc),
    ("an arm", arm),
    ("an arm, black within its sides", rimmed_arm),
    ("a keyboard", keyboard),
    ("a keyboard, dark between its keys", dark_keyboard),
    ("ten crossings", ten_crossings),
    ("eight ropes", eight_ropes),
    ("half is rope", half),
    // The largest area that a mask may cover, and therefore the longest thinning.
    ("a block of 59%", block),
    ("chess board, 1 px", || chess_board(1)),
    ("chess board, 20 px", || chess_board(20)),
    ("salt and pepper, 50%", || salt(50)),
    // The largest number of runs that a mask may have.
    ("salt and pepper, 6%", || salt(6)),
    ("salt and pepper, 1%", || salt(1)),
    // The largest number of strands that fit the width.
    ("stripes, 8 of 18 px", || picture(|x, _| share(x % 18 < 8))),
    ("net, 6 of 36 px", net),
];

/// HSV ranges of the rope's own color (`BLUE`) and of every color (`ALL`).
const BLUE: HsvRange = HsvRange {
    hue_deg: [190.0, 250.0],
    saturation: [0.3, 1.0],
    value: [0.2, 1.0],
};
const ALL: HsvRange = HsvRange {
    hue_deg: [0.0, 360.0],
    saturation: [0.0, 1.0],
    value: [0.0, 1.0],
};

const BY_COLOR: [(&str, Draw, HsvRange); 6] = [
    ("all colors, a bare table", bare, ALL),
    ("by color, half is rope", half, BLUE),
    ("by color, an arm", arm, BLUE),
    ("by color, a keyboard", keyboard, BLUE),
    ("by color, a chess board, 20 px", || chess_board(20), BLUE),
    ("by color, a net", net, BLUE),
];

/// Cases with an external mask that marks everything darker than the table.
const WITH_MASKS: [(&str, Draw); 5] = [
    ("with a mask, a block of 59%", block),
    ("with a mask, a disc of 240 px", disc),
    ("with a mask, an arm", arm),
    ("with a mask, a keyboard", dark_keyboard),
    ("with a mask, a net", net),
];

/// Returns the mask of everything darker than the table, for [`WITH_MASKS`].
fn dark(picture: &Picture) -> Result<Picture> {
    let reds = picture.bytes().iter().step_by(3);
    let levels: Vec<u8> = reds.map(|&red| if red < 133 { 255 } else { 0 }).collect();
    let write = |bytes: &mut [u8]| bytes.copy_from_slice(&levels);
    Picture::new(picture.size(), PixelFormat::Gray8, levels.len(), write).context("a byte a pixel")
}

/// Returns the central sixteenth of a picture.
fn sixteenth(picture: &Picture) -> Result<Picture> {
    let ([width, height], bytes) = (picture.size(), picture.bytes());
    let rows = bytes
        .chunks_exact(3 * width)
        .skip(3 * height / 8)
        .take(height / 4);
    let rgb: Vec<u8> = rows
        .flat_map(|row| &row[3 * (3 * width / 8)..][..3 * (width / 4)])
        .copied()
        .collect();
    Picture::rgb([width / 4, height / 4], &rgb).context("three bytes a pixel are a picture")
}

fn share(is_rope: bool) -> f64 {
    f64::from(u8::from(is_rope))
}

fn bare() -> Result<Picture> {
    picture(|_, _| 0.0)
}

fn half() -> Result<Picture> {
    picture(|x, _| share(x < WIDTH / 2))
}

fn net() -> Result<Picture> {
    picture(|x, y| share(x % 36 < 6 || y % 36 < 6))
}

fn disc() -> Result<Picture> {
    picture(|x, y| (120.5 - (x as f64 - 320.0).hypot(y as f64 - 240.0)).clamp(0.0, 1.0))
}

fn arm() -> Result<Picture> {
    picture(|x, y| depth_in_arm(x, y).clamp(0.0, 1.0))
}

/// Draws the same arm as [`arm`], but with light rims. Only pixels more than ten pixels inside its
/// edges are black.
fn rimmed_arm() -> Result<Picture> {
    picture(depth_in_arm)
}

/// Returns how far a pixel is inside the edge of an arm, in pixels. The arm reaches in from a
/// corner and has a hand and four fingers.
fn depth_in_arm(x: usize, y: usize) -> f64 {
    let within = |half: f64, from: [f64; 2], to: [f64; 2]| {
        let [along, off] = [0, 1].map(|k| (to[k] - from[k], [x, y][k] as f64 - from[k]));
        let length2 = along.0 * along.0 + off.0 * off.0;
        let share = (along.1 * along.0 + off.1 * off.0) / length2;
        let share = share.clamp(0.0, 1.0);
        half + 0.5 - (along.1 - share * along.0).hypot(off.1 - share * off.0)
    };
    let finger = |k: usize| within(14.0, [330.0, 250.0], [430.0, 170.0 + 45.0 * k as f64]);
    let forearm = within(60.0, [-40.0, 500.0], [260.0, 300.0]);
    let hand = within(75.0, [270.0, 290.0], [330.0, 250.0]);
    (0..4).map(finger).fold(forearm.max(hand), f64::max)
}

/// Returns whether a pixel belongs to a keyboard, and whether it belongs to a gap between its keys.
fn on_keyboard(x: usize, y: usize) -> (bool, bool) {
    let is_inside = (60..580).contains(&x) && (140..340).contains(&y);
    let is_between = is_inside && ((x - 60) % 26 < 3 || (y - 140) % 25 < 3);
    (is_inside, is_between)
}

fn keyboard() -> Result<Picture> {
    picture(|x, y| {
        let (is_inside, is_between) = on_keyboard(x, y);
        share(is_inside && !is_between)
    })
}

fn dark_keyboard() -> Result<Picture> {
    picture(|x, y| match on_keyboard(x, y) {
        (false, _) => 0.0,
        (true, false) => 0.6,
        (true, true) => 1.0,
    })
}

fn block() -> Result<Picture> {
    // The block spans √0.59 = 0.768 of each side.
    let inside = |at: usize, side: usize| {
        let margin = (0.116 * side as f64) as usize;
        (margin..side - margin).contains(&at)
    };
    picture(|x, y| share(inside(x, WIDTH) && inside(y, HEIGHT)))
}

fn chess_board(side: usize) -> Result<Picture> {
    picture(|x, y| share((x / side + y / side) % 2 == 1))
}

/// Scatters rope-colored pixels over the table, on `percent` of its area.
fn salt(percent: u64) -> Result<Picture> {
    let mut noise = Noise(7);
    let strewn: Vec<bool> = (0..WIDTH * HEIGHT)
        .map(|_| noise.next_number() % 100 < percent)
        .collect();
    picture(|x, y| share(strewn[y * WIDTH + x]))
}

fn print(cases: &[Case]) {
    let normal = &cases[0];
    let [normal_cold, normal_tracked] = [&normal.cold, &normal.tracked].map(Times::whole_ns);
    let mut table = Table::new(&[
        "hostile, 640×480 RGB",
        "curves",
        "cold, µs",
        "÷ read",
        "÷ normal cold",
        "again, µs",
        "÷ normal tracked",
    ]);
    let mut worst = [0.0f64; 2];
    for case in cases {
        let [cold, tracked] = [&case.cold, &case.tracked].map(Times::whole_ns);
        worst = [worst[0].max(cold), worst[1].max(tracked)];
        table.push([
            case.name.clone(),
            format!("{:.0}", case.ropes.median()),
            micros(cold),
            multiple(case.cold.whole_over_read()),
            times(cold, normal_cold),
            micros(tracked),
            times(tracked, normal_tracked),
        ]);
    }
    println!("{table}");
    println!(
        "the bound: {} the normal case cold, and {} of it when the same picture comes again\n",
        times(worst[0], normal_cold),
        times(worst[1], normal_cold)
    );
}
