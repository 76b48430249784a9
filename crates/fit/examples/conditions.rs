//! Prints the condition number and noise gain of each basis, by the number of control points:
//! `cargo run --release -p lariat-fit --example conditions [POINTS]`.

use lariat_fit::{Basis, Fitter, FitterError, Knots, Options};

fn main() {
    let points = match std::env::args().nth(1).map(|text| text.parse()) {
        None => 120,
        Some(Ok(points)) => points,
        Some(Err(_)) => {
            eprintln!("the number of points is a whole number, such as 120");
            std::process::exit(2);
        }
    };
    println!("{points} points: condition number / noise gain");
    println!(
        "{:>14} {:>18} {:>18} {:>18}",
        "control points", "Bezier", "cubic B-spline", "Fourier"
    );
    for control_points in [3, 5, 7, 9, 11, 13, 17, 21, 25, 32] {
        let cells = [
            Some(Basis::Bezier {
                order: control_points - 1,
            }),
            (control_points > 3).then_some(Basis::BSpline {
                degree: 3,
                control_points,
                knots: Knots::Uniform,
            }),
            (control_points % 2 == 1).then_some(Basis::Fourier {
                harmonics: control_points / 2,
            }),
        ]
        .map(|basis| basis.map_or(String::new(), |basis| cell(basis, points)));
        println!(
            "{control_points:>14} {:>18} {:>18} {:>18}",
            cells[0], cells[1], cells[2]
        );
    }
}

fn cell(basis: Basis, points: usize) -> String {
    let options = Options::default().basis(basis).points(points);
    match Fitter::new(options) {
        Ok(fitter) => {
            let fit = fitter.last();
            format!("{:.3e} / {:.2}", fit.condition, fit.noise_gain())
        }
        Err(FitterError::IllConditioned { condition, .. }) => format!("{condition:.1e}: refused"),
        Err(_) => "-".to_owned(),
    }
}
