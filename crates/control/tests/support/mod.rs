//! Test ropes that respond to grippers by a formula, and a camera with a delay.
#![allow(dead_code)] // Each test binary uses a part.

use std::collections::VecDeque;

use lariat_control::{Command, Doing, Observation, Servo, Weights};
use lariat_portable::SplitMix64;

pub(crate) type Poses = [[f64; 3]; 2];

/// A rope of 400 px between two grippers, as the seven control points of a Bezier curve: a cubic
/// whose arms lengthen with the slack, raised to order 6. It is smooth, and far from linear in
/// everything but translation.
pub(crate) fn bent(poses: &Poses) -> Vec<f64> {
    const LENGTH_PX: f64 = 400.0;
    let [[ax, ay, at], [bx, by, bt]] = *poses;
    let slack = 1.0 - ((bx - ax).powi(2) + (by - ay).powi(2)).sqrt() / LENGTH_PX;
    let arm = LENGTH_PX / 3.0 * (1.0 + slack);
    let mut points = vec![
        [ax, ay],
        [ax + arm * at.cos(), ay + arm * at.sin()],
        [bx - arm * bt.cos(), by - arm * bt.sin()],
        [bx, by],
    ];
    while points.len() < 7 {
        let n = points.len();
        points = (0..=n)
            .map(|i| {
                let share = i as f64 / n as f64;
                let (before, at) = (points[i.saturating_sub(1)], points[i.min(n - 1)]);
                [0, 1].map(|c| share * before[c] + (1.0 - share) * at[c])
            })
            .collect();
    }
    points.into_flattened()
}

/// Three points that the first gripper moves linearly, each in its own way.
pub(crate) fn linear(poses: &Poses) -> Vec<f64> {
    let [x, y, t] = poses[0];
    vec![
        0.3 * x + 0.1 * y,
        0.2 * y - 20.0 * t,
        0.6 * x - 30.0 * t,
        0.7 * y + 40.0 * t,
        x,
        y,
    ]
}

/// A Bezier curve fitted to points of the rope: `(BᵀB)⁻¹Bᵀ`, and the diagonal of `(BᵀB)⁻¹`.
pub(crate) struct Fit {
    inverse: Vec<Vec<f64>>,
    gains: Vec<f64>,
}

impl Fit {
    pub(crate) fn bezier(order: usize, samples: usize) -> Self {
        let count = order + 1;
        let binomial = |k: usize| (0..k).fold(1.0, |c, i| c * (order - i) as f64 / (i + 1) as f64);
        let row = |i: usize| -> Vec<f64> {
            let rho = i as f64 / (samples - 1) as f64;
            let function =
                |j: usize| binomial(j) * rho.powi(j as i32) * (1.0 - rho).powi((order - j) as i32);
            (0..count).map(function).collect()
        };
        let b: Vec<_> = (0..samples).map(row).collect();
        // Gauss-Jordan elimination on [BᵀB | I | Bᵀ].
        let mut rows: Vec<Vec<f64>> = (0..count)
            .map(|j| {
                let gram = (0..count).map(|k| b.iter().map(|row| row[j] * row[k]).sum());
                let unit = (0..count).map(|k| f64::from(u8::from(j == k)));
                gram.chain(unit).chain(b.iter().map(|row| row[j])).collect()
            })
            .collect();
        for k in 0..count {
            let pivot: Vec<f64> = rows[k].iter().map(|c| c / rows[k][k]).collect();
            for row in &mut rows {
                let factor = row[k];
                row.iter_mut()
                    .zip(&pivot)
                    .for_each(|(c, p)| *c -= factor * p);
            }
            rows[k] = pivot;
        }
        Self {
            gains: (0..count).map(|j| rows[j][count + j]).collect(),
            inverse: rows
                .into_iter()
                .map(|row| row[2 * count..].to_vec())
                .collect(),
        }
    }

    /// Adds the effect of noise in every point to the control points.
    fn disturb(&self, shape: &mut [f64], noise_px: f64, random: &mut SplitMix64) {
        let noise: Vec<[f64; 2]> = self.inverse[0]
            .iter()
            .map(|_| [(); 2].map(|()| noise_px * random.normal()))
            .collect();
        for (point, row) in shape.chunks_mut(2).zip(&self.inverse) {
            for (c, place) in point.iter_mut().enumerate() {
                *place += row.iter().zip(&noise).map(|(r, n)| r * n[c]).sum::<f64>();
            }
        }
    }
}

/// A rope, its grippers and its camera, in steps of 1 ms.
pub(crate) struct World {
    pub(crate) rope: fn(&Poses) -> Vec<f64>,
    pub(crate) poses: Poses,
    pub(crate) period_ms: u64,
    pub(crate) delay_ms: u64,
    /// Standard deviation of each coordinate that the camera sees: of the points of `seen_by`, or
    /// of the shape itself.
    pub(crate) noise_px: f64,
    pub(crate) seen_by: Option<Fit>,
    /// Time constant of the rope's first-order lag behind its grippers, s.
    pub(crate) lag_s: f64,
    followed: Poses,
    pub(crate) random: SplitMix64,
    ms: u64,
    next_ms: u64,
    velocities: Poses,
    images: VecDeque<(u64, Vec<f64>)>,
}

impl World {
    pub(crate) fn new(rope: fn(&Poses) -> Vec<f64>, poses: Poses, period_ms: u64) -> Self {
        Self {
            rope,
            poses,
            period_ms,
            delay_ms: 0,
            noise_px: 0.0,
            seen_by: None,
            lag_s: 0.0,
            followed: poses,
            random: SplitMix64::new(1),
            ms: 0,
            next_ms: 0,
            velocities: [[0.0; 3]; 2],
            images: VecDeque::new(),
        }
    }

    pub(crate) fn now_ns(&self) -> u64 {
        self.ms * 1_000_000
    }

    /// Advances until the next image. Returns its exposure time and its shape.
    pub(crate) fn image(&mut self) -> (u64, Vec<f64>) {
        loop {
            if self.ms == self.next_ms {
                let mut shape = (self.rope)(&self.followed);
                match &self.seen_by {
                    Some(fit) => fit.disturb(&mut shape, self.noise_px, &mut self.random),
                    None => shape
                        .iter_mut()
                        .for_each(|c| *c += self.noise_px * self.random.normal()),
                }
                self.images.push_back((self.ms, shape));
                self.next_ms += self.period_ms;
            }
            let due = |image: &&(u64, Vec<f64>)| image.0 + self.delay_ms <= self.ms;
            if self.images.front().filter(due).is_some() {
                let (exposed_ms, shape) = self.images.pop_front().expect("just seen");
                return (exposed_ms * 1_000_000, shape);
            }
            self.step();
        }
    }

    fn step(&mut self) {
        self.ms += 1;
        for (pose, velocity) in self.poses.iter_mut().zip(self.velocities) {
            for (c, v) in pose.iter_mut().zip(velocity) {
                *c += 1e-3 * v;
            }
        }
        let followed = self.followed.as_flattened_mut().iter_mut();
        for (followed, c) in followed.zip(self.poses.as_flattened()) {
            *followed += (c - *followed) * (1e-3 / self.lag_s.max(1e-3));
        }
    }

    pub(crate) fn obey(&mut self, command: &Command) {
        self.velocities = command.velocities;
    }

    /// Passes the next image to the servo and executes its command.
    pub(crate) fn turn(&mut self, servo: &mut Servo) -> Command {
        let (exposed_ns, shape) = self.image();
        let gains = self.seen_by.as_ref().map(|fit| fit.gains.clone());
        let gains = gains.unwrap_or_else(|| vec![1.0; shape.len() / 2]);
        let variance = self.noise_px.max(1e-3).powi(2);
        let covariances: Vec<_> = gains
            .iter()
            .map(|g| [g * variance, 0.0, g * variance])
            .collect();
        let observation = Observation {
            weights: Weights::Covariances(&covariances),
            ..Observation::new(&shape, exposed_ns)
        };
        let command = servo.see(observation, self.now_ns());
        self.obey(&command);
        command
    }

    /// Runs until the servo has arrived, or this many seconds have passed.
    pub(crate) fn run(&mut self, servo: &mut Servo, seconds: u64) -> Command {
        loop {
            let command = self.turn(servo);
            if command.doing == Doing::Arrived || self.ms > 1000 * seconds {
                return command;
            }
        }
    }
}

/// Root mean square over points.
pub(crate) fn distance(a: &[f64], b: &[f64]) -> f64 {
    let sum: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
    (2.0 * sum / a.len() as f64).sqrt()
}
