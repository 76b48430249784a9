//! Compares readers' predictions with the chain's own filter, which has more data than the message.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use lariat_fit::{CurveSpace, Filter, FilterOptions, Fitter, Noise, Options};
use lariat_wire::*;

/// A filter that has observed a moving, noisy rope at `rate` frames per second, and a reader of its
/// results.
struct Followed {
    filter: Filter<2>,
    reader: Reader,
    writer: Writer<Descriptors>,
    exposed_ns: u64,
    domain: String,
}

impl Followed {
    fn over(frames: u64, rate: f64, noise_px: f64, order: usize) -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let name = format!("p{}-{}", std::process::id(), NEXT.fetch_add(1, Relaxed));
        let rig = Rig::default();
        let reader = Reader::open_in(Domain::named(&name).unwrap(), &rig).unwrap();
        let domain = Domain::named(&name).unwrap();
        let writer =
            Writer::<Descriptors>::create(&domain, &rig, &DESCRIPTORS, &Delivery::NewestWins)
                .unwrap();
        let options = Options::default().basis(lariat_fit::Basis::Bezier { order });
        let points = options.points;
        let mut fitter = Fitter::new(options).unwrap();
        let space = fitter.curve_space().unwrap();
        let filter = Filter::new(order + 1, FilterOptions::default()).unwrap();
        let mut followed = Self {
            filter,
            reader,
            writer,
            // All images are in the past, because one in the future would count as taken on
            // arrival.
            exposed_ns: now_ns().saturating_sub(60_000_000_000),
            domain: name,
        };
        let mut random = 7u64;
        let mut noise = || {
            random = random
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            ((random >> 40) as f64 / f64::from(1u32 << 24) - 0.5) * 12f64.sqrt() * noise_px
        };
        for frame in 1..=frames {
            followed.exposed_ns += (1e9 / rate) as u64;
            let x = 100.0 * frame as f64 / rate;
            let points: Vec<[f64; 2]> = (0..points)
                .map(|i| i as f64 / (points - 1) as f64)
                .map(|t| {
                    [
                        x + 400.0 * t + noise(),
                        200.0 + 60.0 * (3.0 * t).sin() + noise(),
                    ]
                })
                .collect();
            let fit = fitter.fit(&points).unwrap();
            followed.take(frame, &space, &fit.control_points, fit.residual_variance);
        }
        followed
    }

    /// Sends an observation as the fit stage does.
    fn take(&mut self, frame: u64, space: &CurveSpace, measured: &[[f64; 2]], variance_px2: f64) {
        let noise = Noise::Even { variance_px2 };
        self.filter
            .update(self.exposed_ns, space, measured, noise)
            .unwrap();
        let now = self.filter.predict(self.exposed_ns).unwrap();
        let count = measured.len();
        let mut slot = self.writer.slot().unwrap();
        slot.trace = Trace {
            extracted: frame,
            fitted: frame,
            exposed_ns: self.exposed_ns,
            fitted_ns: self.exposed_ns,
            ..Trace::EMPTY
        };
        slot.count = 1;
        let rope = &mut slot.curves[0];
        *rope = Descriptor::EMPTY;
        (rope.degree, rope.count) = (count as u32 - 1, count as u32);
        (rope.samples, rope.filtered, rope.confidence) = (120, 1, 1.0);
        rope.control_points[..count].copy_from_slice(&now.control_points);
        rope.velocities[..count].copy_from_slice(&now.velocities_px_s);
        for j in 0..count {
            let variance = now.covariance_px2[j * (count + 1)];
            rope.covariances[j] = [variance, 0.0, variance];
        }
        slot.send().unwrap();
        self.reader.latest().unwrap();
    }

    fn rope(&mut self) -> Rope<'_> {
        match self
            .reader
            .latest()
            .unwrap()
            .only_rope(std::time::Duration::MAX)
        {
            Seen::Fresh(rope) => rope,
            other => panic!("{other}"),
        }
    }
}

impl Drop for Followed {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(format!("/tmp/lariat-{}", self.domain));
    }
}

#[test]
fn a_prediction_is_the_filters_own_once_it_has_settled() {
    for (rate, noise_px, order) in [
        (30.0, 0.3, 8),
        (30.0, 3.0, 4),
        (120.0, 0.3, 8),
        (1000.0, 0.1, 4),
    ] {
        let mut followed = Followed::over(200, rate, noise_px, order);
        for ahead_ms in [0, 3, 30, 200] {
            let t_ns = followed.exposed_ns + ahead_ms * 1_000_000;
            let truth = followed.filter.predict(t_ns).unwrap().clone();
            let rope = followed.rope();
            let ahead = rope.predict(t_ns).unwrap();
            let shape = ahead.shape();
            let count = order + 1;
            for j in 0..count {
                let (ours, theirs) = (shape.control_points()[j], truth.control_points[j]);
                let apart = (ours[0] - theirs[0]).hypot(ours[1] - theirs[1]);
                assert!(apart < 1e-6, "{rate}: {j} is {apart} px apart");
                // σ² is estimated from each frame's residuals with 220 degrees of freedom, which
                // gives an error of about 10 %.
                let [[variance, _], _] = shape.covariance().block(j, j);
                let ratio = variance / truth.covariance_px2[j * (count + 1)];
                assert!(
                    (0.85..1.18).contains(&ratio),
                    "{rate} Hz, {ahead_ms} ms: {ratio}"
                );
            }
            assert!(shape.covariance().is_exact());
        }
    }
}

#[test]
fn a_prediction_gets_less_sure_with_time() {
    let mut followed = Followed::over(100, 30.0, 0.3, 8);
    let exposed_ns = followed.exposed_ns;
    let rope = followed.rope();
    let variances = [0, 1, 10, 100, 500].map(|ms| {
        let ahead = rope.predict(exposed_ns + ms * 1_000_000).unwrap();
        ahead.shape().covariance_at(0.5)[0]
    });
    assert!(variances.is_sorted_by(|a, b| a < b), "{variances:?}");
    assert_eq!(variances[0], rope.shape().unwrap().covariance_at(0.5)[0]);
}

#[test]
fn what_cannot_be_predicted_says_why() {
    let mut followed = Followed::over(1, 30.0, 0.3, 8);
    let exposed_ns = followed.exposed_ns;
    let why =
        |followed: &mut Followed, t_ns| followed.rope().predict(t_ns).map(|_| ()).unwrap_err();
    assert_eq!(why(&mut followed, exposed_ns), NoPrediction::JustBegun);
    let mut followed = Followed::over(20, 30.0, 0.3, 8);
    let exposed_ns = followed.exposed_ns;
    assert_eq!(why(&mut followed, exposed_ns - 1), NoPrediction::TooFar);
    let far_ns = exposed_ns + FARTHEST.as_nanos() as u64 + 1;
    assert_eq!(why(&mut followed, far_ns), NoPrediction::TooFar);
    let mut rope = *followed.rope().descriptor();
    rope.filtered = 0;
    let mut slot = followed.writer.slot().unwrap();
    slot.count = 1;
    slot.curves[0] = rope;
    slot.send().unwrap();
    assert_eq!(why(&mut followed, exposed_ns), NoPrediction::NotFiltered);
}

#[test]
fn a_rope_that_does_not_accelerate_is_not_less_sure_later() {
    let mut followed = Followed::over(20, 30.0, 0.3, 4);
    followed.reader.expect_motion(Motion {
        acceleration: 0.0,
        ..Motion::default()
    });
    let t_ns = followed.exposed_ns + 100_000_000;
    let rope = followed.rope();
    let ahead = rope.predict(t_ns).unwrap();
    let now = rope.shape().unwrap().covariance_at(0.5);
    assert_eq!(ahead.shape().covariance_at(0.5), now);
}
