//! Checks the filter's covariances. Over 1,000 ropes that move according to its model, its errors
//! match its covariances within statistical bounds (Bar-Shalom, Li, Kirubarajan, 5.4.2).

use crate::dense::{Dense, errors, normalized_squared, normals};
use lariat_fit::{CurveSpace, Filter, FilterOptions, FilterStep, Noise, Point};
use lariat_portable::SplitMix64;

const RUNS: usize = 1000;
const ORDER: usize = 8;
const M: usize = ORDER + 1;
const POINTS: usize = 120;
const SIGMA_PX: f64 = 0.4;

fn options() -> FilterOptions {
    FilterOptions::default()
        .acceleration_px_s2(2000.0)
        .acceleration_lasts_s(0.05)
        .speed_px_s(300.0)
        .noise_scale(1.0)
        .gate_sigma(10.0)
        .longest_gap_s(1.0)
}

/// A rope that moves as documented: accelerations have equal strength in the whole space of curves.
/// They are drawn from `N/m (BᵀB)⁻¹`, so that a point on the rope has variance 1 on average.
struct Rope<const D: usize> {
    /// A factor of that covariance.
    shapes: Dense,
    positions: Dense,
    velocities: Dense,
}

impl<const D: usize> Rope<D> {
    fn new(b: &Dense, random: &mut SplitMix64) -> Self {
        let gram = b.transposed().times(b).scaled(M as f64 / POINTS as f64);
        let l = gram.cholesky().expect("a basis");
        let shapes = l.lower_inverse().transposed();
        let speed = Dense::from_fn(M, D, |_, _| options().speed_px_s);
        let drawn = normals(random, M * D);
        let velocities = Dense::from_fn(M, D, |i, j| speed[(i, j)] * drawn[i * D + j]);
        Self {
            positions: Dense::from_fn(M, D, |i, j| 50.0 * (i + j) as f64),
            velocities: shapes.times(&velocities),
            shapes,
        }
    }

    fn move_on(&mut self, h: f64, random: &mut SplitMix64) {
        // One white noise, integrated once and twice over the time h. The two have the covariance q
        // h²/2.
        let q = options().spectral_density();
        let (once, twice) = (normals(random, M * D), normals(random, M * D));
        let velocity = Dense::from_fn(M, D, |i, j| (q * h).sqrt() * once[i * D + j]);
        let own = (q * h.powi(3) / 12.0).sqrt();
        let position = Dense::from_fn(M, D, |i, j| {
            0.5 * h * velocity[(i, j)] + own * twice[i * D + j]
        });
        self.positions = self
            .positions
            .plus(h, &self.velocities)
            .plus(1.0, &self.shapes.times(&position));
        self.velocities = self.velocities.plus(1.0, &self.shapes.times(&velocity));
    }

    fn points(&self, of: &Dense) -> Vec<[f64; D]> {
        (0..M)
            .map(|i| std::array::from_fn(|j| of[(i, j)]))
            .collect()
    }
}

/// A fit of the rope's noisy points with weight 0 for those in `hidden`: control points,
/// `(BᵀWB)⁻¹`.
fn fit<const D: usize>(
    b: &Dense,
    rope: &Rope<D>,
    hidden: std::ops::Range<usize>,
    random: &mut SplitMix64,
) -> (Vec<[f64; D]>, Dense) {
    let seen = Dense::from_fn(
        POINTS,
        M,
        |i, j| {
            if hidden.contains(&i) { 0.0 } else { b[(i, j)] }
        },
    );
    let covariance = seen.transposed().times(&seen).inverse();
    let errors = normals(random, POINTS * D);
    let noise = Dense::from_fn(POINTS, D, |i, j| SIGMA_PX * errors[i * D + j]);
    let points = b.times(&rope.positions).plus(1.0, &noise);
    let found = covariance.times(&seen.transposed()).times(&points);
    (rope.points(&found), covariance)
}

/// Mean of a normalized squared error over the runs. It differs from its degrees of freedom by more
/// than 3.3 standard deviations once in a thousand.
#[derive(Default)]
struct Mean {
    sum: f64,
    count: usize,
}

impl Mean {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.count += 1;
    }

    fn distance(&self, freedom: usize) -> f64 {
        let spread = (2.0 * freedom as f64 / self.count as f64).sqrt();
        (self.sum / self.count as f64 - freedom as f64) / spread
    }

    #[track_caller]
    fn assert_consistent(&self, freedom: usize, what: &str) {
        let distance = self.distance(freedom);
        assert!(
            distance.abs() < 3.3,
            "{what}: {distance} standard deviations"
        );
    }
}

#[derive(Default)]
struct Means {
    now: Mean,
    now_velocity: Mean,
    ahead: Mean,
    ahead_velocity: Mean,
    back: Mean,
    nis: Mean,
}

/// Follows a rope over some 20 irregular frames. With `hide`, changing parts of it are hidden.
fn run<const D: usize>(seed: u64, b: &Dense, hide: bool, means: &mut Means)
where
    [f64; D]: Point<D>,
{
    let random = &mut SplitMix64::new(seed);
    let space = CurveSpace::new(b.matrix()).unwrap();
    let mut filter = Filter::<D>::new(M, options()).unwrap();
    let mut rope = Rope::new(b, random);
    let mut t_ns = 1_000_000_000;
    let mut before = (t_ns, rope.points(&rope.positions));
    for frame in 0..20 {
        if frame > 0 {
            // Moves for half of the time first, so that the truth between two frames is known.
            let half_ns = 2_000_000 + (10e6 * random.unit()) as u64;
            rope.move_on(half_ns as f64 * 1e-9, random);
            before = (t_ns + half_ns, rope.points(&rope.positions));
            rope.move_on(half_ns as f64 * 1e-9, random);
            t_ns += 2 * half_ns;
        }
        let first = (random.unit() * 90.0) as usize;
        let hidden = if hide { first..first + 30 } else { 0..0 };
        let (found, covariance) = fit(b, &rope, hidden, random);
        let variance_px2 = SIGMA_PX * SIGMA_PX;
        let scaled = covariance.scaled(variance_px2);
        let noise = if hide {
            Noise::Covariance(&scaled.numbers)
        } else {
            Noise::Even { variance_px2 }
        };
        match filter.update(t_ns, &space, &found, noise).unwrap() {
            FilterStep::Updated { nis } => means.nis.add(nis),
            step => assert_eq!((step, frame), (FilterStep::Began, 0)),
        }
    }
    let truth = (rope.points(&rope.positions), rope.points(&rope.velocities));
    let now = filter.predict(t_ns).unwrap();
    means.now.add(normalized_squared(
        &errors(&now.control_points, &truth.0),
        &now.covariance_px2,
    ));
    means.now_velocity.add(normalized_squared(
        &errors(&now.velocities_px_s, &truth.1),
        &now.velocity_covariance_px2_s2,
    ));
    let back = filter.predict(before.0).unwrap();
    means.back.add(normalized_squared(
        &errors(&back.control_points, &before.1),
        &back.covariance_px2,
    ));
    rope.move_on(0.025, random);
    let truth = (rope.points(&rope.positions), rope.points(&rope.velocities));
    let ahead = filter.predict(t_ns + 25_000_000).unwrap();
    means.ahead.add(normalized_squared(
        &errors(&ahead.control_points, &truth.0),
        &ahead.covariance_px2,
    ));
    means.ahead_velocity.add(normalized_squared(
        &errors(&ahead.velocities_px_s, &truth.1),
        &ahead.velocity_covariance_px2_s2,
    ));
}

fn assert_consistent<const D: usize>(hide: bool, first_seed: u64)
where
    [f64; D]: Point<D>,
{
    let b = Dense::bezier(ORDER, POINTS);
    let mut means = Means::default();
    for seed in 0..RUNS as u64 {
        run::<D>(first_seed + seed, &b, hide, &mut means);
    }
    let freedom = M * D;
    means.now.assert_consistent(freedom, "control points");
    means.now_velocity.assert_consistent(freedom, "velocities");
    means
        .ahead
        .assert_consistent(freedom, "control points, ahead");
    means
        .ahead_velocity
        .assert_consistent(freedom, "velocities, ahead");
    means.nis.assert_consistent(freedom, "innovations");
    // Going back is conservative, by less than a factor of about two in standard deviation.
    let back = means.back.sum / means.back.count as f64 / freedom as f64;
    assert!((0.2..1.05).contains(&back), "control points, back: {back}");
}

#[test]
fn over_1000_ropes_the_errors_are_as_large_as_the_filter_says() {
    assert_consistent::<2>(false, 1);
}

#[test]
fn over_1000_ropes_of_which_parts_are_hidden_the_errors_are_as_large_as_the_filter_says() {
    assert_consistent::<2>(true, 100_001);
}

#[test]
fn a_filter_that_is_told_half_the_noise_is_found_out() {
    let b = Dense::bezier(ORDER, POINTS);
    let space = CurveSpace::new(b.matrix()).unwrap();
    for (noise_scale, expected) in [(0.5, 1.0), (1.0, 1.0), (2.0, 1.0)] {
        // A rope known to be at rest, so that all of the innovation is noise. The actual errors are
        // `noise_scale` times the stated ones.
        let options = options()
            .acceleration_px_s2(0.0)
            .speed_px_s(0.0)
            .noise_scale(noise_scale);
        let mut nis = [Mean::default(), Mean::default()];
        let random = &mut SplitMix64::new(7);
        let mut rope = Rope::<2>::new(&b, random);
        rope.velocities = rope.velocities.scaled(0.0);
        let mut filters = [options, options.noise_scale(1.0)]
            .map(|options| Filter::<2>::new(M, options).unwrap());
        for frame in 0..400 {
            let (found, _) = fit(&b, &rope, 0..0, random);
            let variance_px2 = (SIGMA_PX / noise_scale).powi(2);
            for (filter, nis) in filters.iter_mut().zip(&mut nis) {
                let noise = Noise::Even { variance_px2 };
                let step = filter.update(frame * 10_000_000, &space, &found, noise);
                if let Ok(FilterStep::Updated { nis: value }) = step {
                    nis.add(value);
                }
            }
        }
        // With the scale, an over- or underestimated covariance does no harm. Without it, the mean
        // shows it.
        assert_eq!(nis[0].count, 399);
        let ratio = |mean: &Mean| mean.sum / mean.count as f64 / (2 * M) as f64;
        assert!(
            (ratio(&nis[0]) - expected).abs() < 0.06,
            "{}",
            ratio(&nis[0])
        );
        let shows = ratio(&nis[1]) / noise_scale.powi(2);
        assert!((shows - 1.0).abs() < 0.06, "{shows}");
    }
}
