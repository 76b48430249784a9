//! Hashes of fits: every basis, solver and weighting, the filter, and curves on a plane behind a
//! lens.

use lariat_camera::{Camera, Lens, Mapping, Plane};
use lariat_drawn::moving::{Film, Story};
use lariat_extract::{Extractor, Image, PixelFormat};
use lariat_fit::{
    Basis, Filter, FilterOptions, Fit, Fitter, Knots, MAX_CONTROL_POINTS, MatRef, Noise, Options,
    Resampler, Rho, Solver, Weights,
};

use super::Told;
use super::hash::Hash;

const FRAMES: u64 = 12;
const SIZE: [u32; 2] = [360, 270];

pub(crate) type Line = Vec<[f64; 2]>;

/// The centerlines of a writhing rope.
pub(crate) fn lines() -> Vec<Line> {
    let [width, height] = SIZE.map(|side| side as usize);
    let mut film = Film::new(Story::Writhing, 5, SIZE[0], SIZE[1]);
    let mut extractor = Extractor::new(lariat_extract::Options::default()).expect("valid options");
    let mut rgb = Vec::new();
    let mut lines = Vec::new();
    for _ in 0..FRAMES {
        film.next(&mut rgb);
        let image = Image::new(&rgb, width, height, 3 * width, PixelFormat::Rgb8);
        let scene = extractor.extract(&image.expect("a whole image"));
        let points = scene.curves[0].points.iter();
        lines.push(points.map(|point| point.map(f64::from)).collect());
    }
    lines
}

fn cases() -> Vec<(&'static str, Options)> {
    let spline = |knots| Basis::BSpline {
        degree: 3,
        control_points: 11,
        knots,
    };
    let of = |basis| Options::default().basis(basis);
    let by = |solver| Options::bezier(9).solver(solver);
    vec![
        ("pinv", by(Solver::Pinv)),
        ("cholesky", by(Solver::Cholesky)),
        ("qr", by(Solver::Qr)),
        ("high order", Options::bezier(20)),
        ("ridge", by(Solver::Pinv).ridge(0.01)),
        ("ridge by qr", by(Solver::Qr).ridge(0.01)),
        ("pins", by(Solver::Pinv).pin_ends(true)),
        ("pins by cholesky", by(Solver::Cholesky).pin_ends(true)),
        ("pins by qr", by(Solver::Qr).pin_ends(true)),
        ("size", Options::bezier(12).choose_size(true)),
        ("weights", Options::bezier(8).weights(Weights::Given)),
        ("robust", Options::bezier(8).weights(Weights::Robust)),
        ("measured", Options::bezier(8).rho(Rho::Measured)),
        (
            "all at once",
            of(spline(Knots::Averaged))
                .rho(Rho::Measured)
                .weights(Weights::Robust)
                .ridge(0.1)
                .pin_ends(true),
        ),
        ("spline", of(spline(Knots::Uniform))),
        ("spline, averaged", of(spline(Knots::Averaged))),
        ("rational", of(Basis::RationalBezier { order: 5 })),
        ("fourier", of(Basis::Fourier { harmonics: 4 })),
        (
            "fourier, measured",
            of(Basis::Fourier { harmonics: 4 }).rho(Rho::Measured),
        ),
        ("feature points", of(Basis::FeaturePoints { count: 9 })),
        ("mass", of(Basis::CenterOfMass)),
    ]
}

fn hash(fit: &Fit) -> Hash {
    Hash::new()
        .doubles(fit.control_points.as_flattened())
        .doubles(&fit.weights)
        .doubles(&fit.knots)
        .doubles(&[fit.rms_px, fit.max_px, fit.residual_variance, fit.condition])
        .doubles(&whole(fit.covariance_factor.as_ref()))
}

/// The elements of a matrix, row by row.
fn whole(matrix: MatRef<'_, f64>) -> Vec<f64> {
    matrix
        .row_iter()
        .flat_map(|row| row.iter().copied())
        .collect()
}

pub(crate) fn fits(told: &mut Told, lines: &[Line]) {
    for (case, options) in cases() {
        let mut fitter = Fitter::new(options).expect("a fitter of good options");
        for row in fitter.matrix().row_iter() {
            let row: Vec<f64> = row.iter().copied().collect();
            told.frame(case, "matrix", Hash::new().doubles(&row));
        }
        for line in lines {
            let fitted = if options.weights == Weights::Given {
                // Some points are hidden, and some have half the weight.
                let weights: Vec<f64> = (0..line.len())
                    .map(|i| [1.0, 0.5, 1.0, 0.0, 1.0][i / 7 % 5])
                    .collect();
                fitter.fit_weighted(line, &weights)
            } else {
                fitter.fit(line)
            };
            told.frame(
                case,
                "fit",
                hash(fitted.expect("a line that can be fitted")),
            );
        }
    }
    filter(told, lines);
    plane(told, lines);
}

fn filter(told: &mut Told, lines: &[Line]) {
    let mut fitter = Fitter::new(Options::bezier(8)).expect("a fitter of good options");
    let space = fitter.curve_space().expect("a space of good curves");
    for covariance in [false, true] {
        let case = if covariance {
            "filter, covariance"
        } else {
            "filter"
        };
        let mut filter = Filter::<2>::new(9, FilterOptions::default()).expect("good options");
        for (i, line) in lines.iter().enumerate() {
            let fit = fitter.fit(line).expect("a line that can be fitted");
            let variance_px2 = fit.residual_variance;
            let whole: Vec<f64> = (whole(fit.covariance_factor.as_ref()).iter())
                .map(|c| variance_px2 * c)
                .collect();
            let noise = if covariance {
                Noise::Covariance(&whole)
            } else {
                Noise::Even { variance_px2 }
            };
            let now = (i as u64 + 1) * 33_000_000;
            let step = filter.update(now, &space, &fit.control_points, noise);
            let step = format!("{:?}", step.expect("a good shape"));
            let ahead = filter.predict(now + 20_000_000).expect("near enough");
            let hash = Hash::new()
                .bytes(step.as_bytes())
                .doubles(ahead.control_points.as_flattened())
                .doubles(ahead.velocities_px_s.as_flattened())
                .doubles(&ahead.covariance_px2)
                .doubles(&ahead.velocity_covariance_px2_s2);
            told.frame(case, "prediction", hash);
        }
    }
}

fn plane(told: &mut Told, lines: &[Line]) {
    let brown = [
        -0.2, 0.05, 1e-3, -2e-3, 0.01, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.01, -0.02,
    ];
    let lenses = [
        ("brown", Lens::brown_conrady(&brown)),
        ("fisheye", Lens::fisheye([-0.02, 0.01, -3e-3, 1e-3])),
    ];
    for (case, lens) in lenses {
        let lens = lens.expect("a lens that sees");
        let camera = Camera::new([300.0, 305.0], [181.0, 133.0], lens, Some(SIZE));
        let camera = camera.expect("a camera that can be");
        let table = Plane::from_pose([0.3, -0.2, 0.1], [-20.0, 10.0, 500.0], &camera);
        let table = table.expect("a plane that is seen");
        let mapping = Mapping::new(Some(&camera), Some(&table), SIZE).expect("images of one size");
        let mut resampler = Resampler::new();
        let mut fitter = Fitter::new(Options::bezier(8)).expect("a fitter of good options");
        for line in lines {
            let mut placed = Vec::new();
            let mut squares = Vec::new();
            for &pixel in line {
                let place = mapping.place(pixel).expect("a place on the table");
                let [a, b] = place.jacobian;
                let dot = |p: [f64; 2], q: [f64; 2]| p[0] * q[0] + p[1] * q[1];
                placed.push(place.point);
                squares.push([[dot(a, a), dot(a, b)], [dot(a, b), dot(b, b)]]);
                let back = mapping.pixel(place.point).expect("it is seen");
                placed.push(back);
            }
            let back: Line = placed.iter().skip(1).step_by(2).copied().collect();
            let placed: Line = placed.iter().step_by(2).copied().collect();
            told.frame(case, "places", Hash::new().doubles(placed.as_flattened()));
            told.frame(case, "pixels", Hash::new().doubles(back.as_flattened()));
            let even = resampler.resample(&placed, false).expect("a line");
            let fitted = hash(fitter.fit(even).expect("a line that can be fitted"));
            told.frame(case, "fit", fitted);
            let mut covariances = [[[0.0; 2]; 2]; MAX_CONTROL_POINTS];
            let variance = fitter.propagate(&resampler, &squares, &mut covariances);
            let hash = Hash::new().doubles(&[variance]).doubles(
                covariances
                    .map(|[[xx, xy], [_, yy]]| [xx, xy, yy])
                    .as_flattened(),
            );
            told.frame(case, "covariance", hash);
        }
    }
}
