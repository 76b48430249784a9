//! Compares the filter with the textbook's, which is written in control points, with inverses, full
//! matrices and Joseph's form.

use crate::dense::{Dense, normals};
use lariat_fit::{CurveSpace, Filter, FilterOptions, FilterStep, Noise};
use lariat_portable::SplitMix64;
use proptest::prelude::*;

/// The textbook's filter in control points, one column of the state per axis.
struct Textbook {
    state: Dense,
    covariance: Dense,
    /// `N/m (BᵀB)⁻¹`.
    shapes: Dense,
    q: f64,
}

impl Textbook {
    fn new(b: &Dense, positions: &Dense, noise: &Dense, options: &FilterOptions) -> Self {
        let m = b.columns;
        let gram = b.transposed().times(b).scaled(m as f64 / b.rows as f64);
        let shapes = gram.inverse();
        let none = Dense::from_fn(m, m, |_, _| 0.0);
        let speeds = shapes.scaled(options.speed_px_s.powi(2));
        Self {
            state: Dense::from_fn(2 * m, positions.columns, |i, j| {
                if i < m { positions[(i, j)] } else { 0.0 }
            }),
            covariance: Dense::of_blocks([[noise, &none], [&none, &speeds]]),
            shapes,
            q: options.spectral_density(),
        }
    }

    fn predict(&mut self, h: f64) {
        let one = Dense::identity(self.shapes.rows);
        let (moved, none) = (one.scaled(h), one.scaled(0.0));
        let f = Dense::of_blocks([[&one, &moved], [&none, &one]]);
        let [third, half, whole] =
            [h.powi(3) / 3.0, h * h / 2.0, h].map(|factor| self.shapes.scaled(self.q * factor));
        self.state = f.times(&self.state);
        self.covariance = f
            .times(&self.covariance)
            .times(&f.transposed())
            .plus(1.0, &Dense::of_blocks([[&third, &half], [&half, &whole]]));
    }

    fn update(&mut self, measured: &Dense, noise: &Dense) -> f64 {
        let m = measured.rows;
        let h = Dense::from_fn(m, 2 * m, |i, j| if i == j { 1.0 } else { 0.0 });
        let s = self
            .covariance
            .block((0, 0), m, m)
            .plus(1.0, noise)
            .inverse();
        let gain = self.covariance.times(&h.transposed()).times(&s);
        let innovation = measured.plus(-1.0, &h.times(&self.state));
        let kept = Dense::identity(2 * m).plus(-1.0, &gain.times(&h));
        self.state = self.state.plus(1.0, &gain.times(&innovation));
        self.covariance = kept
            .times(&self.covariance)
            .times(&kept.transposed())
            .plus(1.0, &gain.times(noise).times(&gain.transposed()));
        let nis = innovation.transposed().times(&s).times(&innovation);
        (0..nis.rows).map(|axis| nis[(axis, axis)]).sum()
    }
}

/// A random covariance of `m` control points without structure, of about this variance.
fn any_covariance(m: usize, variance: f64, random: &mut SplitMix64) -> Dense {
    let drawn = normals(random, m * 2 * m);
    let factor = Dense::from_fn(m, 2 * m, |i, j| drawn[i * 2 * m + j]);
    factor
        .times(&factor.transposed())
        .scaled(variance / (2 * m) as f64)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn it_is_the_textbooks_filter(m in 1usize..=7, extra in 0usize..30, seed in 0u64..1000) {
        let random = &mut SplitMix64::new(seed);
        let b = Dense::bezier(m - 1, (m + extra).max(2));
        let space = CurveSpace::new(b.matrix()).unwrap();
        let options = FilterOptions::default().gate_sigma(f64::INFINITY);
        let mut filter = Filter::<3>::new(m, options).unwrap();
        let mut textbook: Option<Textbook> = None;
        let mut t_ns = 0;
        for _ in 0..8 {
            let gap_ns = 1_000_000 + (50e6 * random.unit()) as u64;
            t_ns += gap_ns;
            let drawn = normals(random, 3 * m);
            let measured: Vec<[f64; 3]> =
                drawn.as_chunks().0.iter().map(|p: &[f64; 3]| p.map(|c| 20.0 * c)).collect();
            let matrix = Dense::from_fn(m, 3, |i, j| measured[i][j]);
            let mut noise = any_covariance(m, 0.3, random);
            let step = filter
                .update(t_ns, &space, &measured, Noise::Covariance(&noise.numbers))
                .unwrap();
            // The minimum noise is 1e-4 px in curve coordinates.
            let gram = b.transposed().times(&b).scaled(m as f64 / b.rows as f64);
            noise = noise.plus(1e-8, &gram.inverse());
            match &mut textbook {
                None => {
                    prop_assert_eq!(step, FilterStep::Began);
                    textbook = Some(Textbook::new(&b, &matrix, &noise, &options));
                }
                Some(textbook) => {
                    textbook.predict(gap_ns as f64 * 1e-9);
                    let expected = textbook.update(&matrix, &noise);
                    let FilterStep::Updated { nis } = step else {
                        return Err(TestCaseError::fail(step.to_string()));
                    };
                    prop_assert!((nis / expected - 1.0).abs() < 1e-8, "{nis} {expected}");
                }
            }
        }
        let Some(textbook) = &mut textbook else { unreachable!("eight shapes were given") };
        textbook.predict(0.07);
        let found = filter.predict(t_ns + 70_000_000).unwrap();
        let x = Dense::from_fn(m, 3, |i, j| found.control_points[i][j]);
        let v = Dense::from_fn(m, 3, |i, j| found.velocities_px_s[i][j]);
        let of_x = Dense::from_fn(m, m, |i, j| found.covariance_px2[i * m + j]);
        let of_v = Dense::from_fn(m, m, |i, j| found.velocity_covariance_px2_s2[i * m + j]);
        prop_assert!(x.difference(&textbook.state.block((0, 0), m, 3)) < 1e-8);
        prop_assert!(v.difference(&textbook.state.block((m, 0), m, 3)) < 1e-8);
        prop_assert!(of_x.difference(&textbook.covariance.block((0, 0), m, m)) < 1e-8);
        prop_assert!(of_v.difference(&textbook.covariance.block((m, m), m, m)) < 1e-8);
    }

    /// The same curves with other control points (here: any combinations of Bezier's) are filtered
    /// to the same curves.
    #[test]
    fn the_curve_does_not_depend_on_the_basis(m in 1usize..=9, seed in 0u64..1000) {
        let random = &mut SplitMix64::new(seed);
        let b = Dense::bezier(m - 1, 60);
        // A lower triangle with ones on its diagonal has an inverse.
        let drawn = normals(random, m * m);
        let mix = Dense::from_fn(m, m, |i, j| match i.cmp(&j) {
            std::cmp::Ordering::Less => 0.0,
            std::cmp::Ordering::Equal => 1.0,
            std::cmp::Ordering::Greater => 0.5 * drawn[i * m + j],
        });
        let unmix = mix.lower_inverse();
        let bases = [b.clone(), b.times(&unmix)];
        let spaces = bases.each_ref().map(|b| CurveSpace::new(b.matrix()).unwrap());
        let mut filters = [0, 1].map(|_| Filter::<2>::new(m, FilterOptions::default()).unwrap());
        for frame in 1..10u64 {
            let drawn = normals(random, 2 * m);
            let control_points: Vec<[f64; 2]> = drawn.as_chunks().0.to_vec();
            let covariance = any_covariance(m, 0.5, random);
            let of_mixed = mix.times(&covariance).times(&mix.transposed());
            let mixed: Vec<[f64; 2]> = (0..m)
                .map(|i| [0, 1].map(|a| (0..m).map(|j| mix[(i, j)] * control_points[j][a]).sum()))
                .collect();
            for (k, (points, noise)) in
                [(&control_points, &covariance), (&mixed, &of_mixed)].into_iter().enumerate()
            {
                filters[k]
                    .update(frame * 20_000_000, &spaces[k], points, Noise::Covariance(&noise.numbers))
                    .unwrap();
            }
        }
        let curves = [0, 1].map(|k| {
            let found = filters[k].predict(200_000_000).unwrap();
            bases[k].times(&Dense::from_fn(m, 2, |i, j| found.control_points[i][j]))
        });
        prop_assert!(curves[0].difference(&curves[1]) < 1e-6);
    }
}
