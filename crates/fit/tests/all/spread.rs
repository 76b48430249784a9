//! 3-D points with error ellipsoids, and ends with errors along the curve: predicted and empirical
//! covariances of their control points.

use lariat_fit::{Fitter, Line, MAX_CONTROL_POINTS, Options, Resampler, Spread, Square};
use lariat_portable::SplitMix64;

const COUNT: usize = 120;
const TRIALS: usize = 3000;
/// Standard deviations across the line of sight, along it, of each end along the rope, and of all
/// points together along y, mm.
const SIGMAS: [f64; 4] = [0.05, 0.4, 0.6, 0.3];

fn truth(t: f64) -> [f64; 3] {
    [400.0 * t, 60.0 * (2.0 * t).sin(), 500.0 + 80.0 * t * t]
}

/// Points at equal steps of the rope between two values of t.
fn line(from: f64, to: f64) -> Vec<[f64; 3]> {
    let fine: Vec<_> = (0..=4000)
        .map(|i| truth(from + (to - from) * f64::from(i) / 4000.0))
        .collect();
    let mut resampler = Resampler::<3>::in_dimensions();
    let rough: Vec<_> = fine.iter().copied().step_by(4000 / 200).collect();
    let even = resampler.resample(&rough, false).expect("a line").to_vec();
    let mut again = Resampler::<3>::in_dimensions();
    let chosen: Vec<_> = (0..COUNT)
        .map(|k| even[(k * (even.len() - 1)) / (COUNT - 1)])
        .collect();
    again.resample(&chosen, false).expect("a line").to_vec()
}

#[test]
fn covariances_in_space_are_those_of_the_errors() {
    let mut random = SplitMix64::new(5);
    let mut normal = move || {
        let (u, v) = (random.unit().max(1e-12), random.unit());
        (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
    };
    let mut fitter =
        Fitter::<3>::in_dimensions(Options::bezier(4).points(COUNT)).expect("a fitter");
    let [across, along, end, shift] = SIGMAS;
    let square: Square<3> = [
        [across * across, 0.0, 0.0],
        [0.0, across * across, 0.0],
        [0.0, 0.0, along * along],
    ];
    let mut in_common = [[0.0; 3]; 3];
    in_common[1][1] = shift * shift;
    let exact = line(0.0, 1.0);
    let right = fitter.fit(&exact).expect("a fit").control_points.clone();
    // Change of t per millimeter of the rope, at its ends.
    let speed = |t: f64| {
        let (a, b) = (truth(t - 1e-4), truth(t + 1e-4));
        (0..3).map(|k| (b[k] - a[k]).powi(2)).sum::<f64>().sqrt() / 2e-4
    };
    let mut found = vec![[[0.0; 3]; 3]; right.len()];
    let mut foretold = [[[0.0; 3]; 3]; MAX_CONTROL_POINTS];
    for _ in 0..TRIALS {
        let mut points = line(
            end * normal() / speed(0.0),
            1.0 + end * normal() / speed(1.0),
        );
        let shifted = shift * normal();
        for point in &mut points {
            point[1] += shifted;
            for (c, sigma) in point.iter_mut().zip([across, across, along]) {
                *c += sigma * normal();
            }
        }
        let fit = fitter.fit_at(0, &Line::of(&points)).expect("a fit");
        for (sum, (p, q)) in found.iter_mut().zip(fit.control_points.iter().zip(&right)) {
            for a in 0..3 {
                for b in 0..3 {
                    sum[a][b] += (p[a] - q[a]) * (p[b] - q[b]) / TRIALS as f64;
                }
            }
        }
        let spread = Spread {
            squares: &[square; COUNT],
            in_common: &[in_common; COUNT],
            ends: [end; 2],
            alike: 1.0,
        };
        fitter.spread(&points, &spread, &mut foretold);
    }
    for (j, (found, foretold)) in found.iter().zip(&foretold).enumerate() {
        for axis in 0..3 {
            let (found, foretold) = (found[axis][axis].sqrt(), foretold[axis][axis].sqrt());
            let ratio = foretold / found;
            assert!(
                (0.8..1.35).contains(&ratio),
                "{j}, axis {axis}: {found} mm, foretold {foretold}"
            );
        }
    }
}
