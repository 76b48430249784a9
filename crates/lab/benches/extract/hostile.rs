//! Pictures made to be slow: what an extraction costs at most, as a multiple of the normal case.

use std::f64::consts::PI;

use anyhow::Result;
use lariat_capture::RenderOptions;
use lariat_extract::{HsvRange, Mask, Options};
use lariat_lab::{Picture, Table, micros, multiple, times};

use crate::Effort;
use crate::case::{Case, Times, measure};
use crate::paint::{HEIGHT, Noise, WIDTH, picture, ropes};

/// The same picture again and again, so that "tracked" is measured too.
const REPEATS: usize = 4;

pub(crate) fn run(effort: &Effort) -> Result<()> {
    let normal = effort.film(RenderOptions::default(), 8)?;
    let mut cases = vec![Case::new("one rope (normal)", normal)?];
    for (name, draw) in PICTURES {
        let film: Result<Vec<Picture>> = (0..REPEATS).map(|_| draw()).collect();
        cases.push(Case::new(name, film?)?);
    }
    let ones = (0..REPEATS).map(|_| picture(|_, _| 0.0));
    let everything = Options {
        mask: Mask::Hsv(vec![HsvRange {
            hue_deg: [0.0, 360.0],
            saturation: [0.0, 1.0],
            value: [0.0, 1.0],
        }]),
        ..Options::default()
    };
    let ones = ones.collect::<Result<_>>()?;
    cases.push(Case::with("a mask of all ones", ones, everything)?);
    measure(&mut cases, effort.time(14.0));
    print(&cases);
    Ok(())
}

type Draw = fn() -> Result<Picture>;

const PICTURES: [(&str, Draw); 11] = [
    ("ten crossings", ten_crossings),
    ("eight ropes", eight_ropes),
    ("half is rope", || picture(|x, _| share(x < WIDTH / 2))),
    // As much as a mask may cover; the longest thinning.
    ("a block of 59%", block),
    ("chess board, 1 px", || chess_board(1)),
    ("chess board, 20 px", || chess_board(20)),
    ("salt and pepper, 50%", || salt(50)),
    // As many runs as a mask may have.
    ("salt and pepper, 6%", || salt(6)),
    ("salt and pepper, 1%", || salt(1)),
    // As many strands as the width holds.
    ("stripes, 8 of 18 px", || picture(|x, _| share(x % 18 < 8))),
    ("net, 6 of 36 px", || {
        picture(|x, y| share(x % 36 < 6 || y % 36 < 6))
    }),
];

fn share(is_rope: bool) -> f64 {
    f64::from(u8::from(is_rope))
}

/// The Chebyshev curve x = T₅, y = T₆: open, with (5 − 1)(6 − 1) / 2 crossings.
fn ten_crossings() -> Result<Picture> {
    let line = |t: f64| {
        [
            0.5 * WIDTH as f64 + 290.0 * (5.0 * PI * t).cos(),
            0.5 * HEIGHT as f64 + 210.0 * (6.0 * PI * t).cos(),
        ]
    };
    ropes(&[&line], 12.0)
}

fn eight_ropes() -> Result<Picture> {
    let lines: [_; 8] = std::array::from_fn(|k| {
        move |t: f64| {
            let wave = 12.0 * (2.0 * PI * (2.0 * t + k as f64 / 8.0)).sin();
            [40.0 + 560.0 * t, 30.0 + 60.0 * k as f64 + wave]
        }
    });
    let lines: Vec<&dyn Fn(f64) -> [f64; 2]> = lines.iter().map(|line| line as _).collect();
    ropes(&lines, 12.0)
}

fn block() -> Result<Picture> {
    // √0.59 = 0.768 of each side.
    let inside = |at: usize, side: usize| {
        let margin = (0.116 * side as f64) as usize;
        (margin..side - margin).contains(&at)
    };
    picture(|x, y| share(inside(x, WIDTH) && inside(y, HEIGHT)))
}

fn chess_board(side: usize) -> Result<Picture> {
    picture(|x, y| share((x / side + y / side) % 2 == 1))
}

/// Pixels of rope strewn over the table.
fn salt(percent: u64) -> Result<Picture> {
    let mut noise = Noise(7);
    let strewn: Vec<bool> = (0..WIDTH * HEIGHT)
        .map(|_| noise.next() % 100 < percent)
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
