//! Measures a servo on a simulated rope: from many starts to each target, in simulated time.
//!
//! `cargo run --release -p lariat-control --example rope -- [NAME=VALUE …]`, with the names in
//! `set`.

#[path = "../tests/rope/chain.rs"]
#[allow(dead_code)] // Parts are used only by the tests.
mod chain;
#[path = "../tests/support/mod.rs"]
mod support;

use chain::{Case, Chain, Outcome, Sight};
use lariat_control::{Estimator, Options};
use lariat_simulation::TargetShape;

struct Study {
    seeds: u64,
    seconds: f64,
    each: bool,
    targets: Vec<(&'static str, TargetShape)>,
    sight: Sight,
    options: Options,
}

fn main() {
    let mut study = Study {
        seeds: 40,
        seconds: 25.0,
        each: false,
        targets: vec![
            ("u", TargetShape::U),
            ("s", TargetShape::S),
            ("line", TargetShape::Line),
        ],
        sight: Sight::default(),
        options: Options::default().gain(3.0).tolerance_px(1.5),
    };
    for argument in std::env::args().skip(1) {
        let Some((name, value)) = argument.split_once('=') else {
            return eprintln!("`{argument}` is not NAME=VALUE");
        };
        if !set(&mut study, name, value) {
            return eprintln!("`{argument}`: no such name, or no such value");
        }
    }
    println!("target  reached  median s  worst s  explored s  arrived  final px: median, worst");
    for (name, shape) in &study.targets {
        let outcomes = run(&study, *shape);
        summary(name, &outcomes);
        if study.each {
            for (seed, outcome) in outcomes.iter().enumerate() {
                println!("  {}: {outcome:?}", seed + 1);
            }
        }
    }
}

fn set(study: &mut Study, name: &str, value: &str) -> bool {
    if name == "target" {
        study.targets.retain(|(name, _)| *name == value);
        return !study.targets.is_empty();
    }
    let Ok(number) = value.parse::<f64>() else {
        return false;
    };
    let Study { sight, options, .. } = study;
    match name {
        "seeds" => study.seeds = number as u64,
        "seconds" => study.seconds = number,
        "each" => study.each = number > 0.0,
        "order" => sight.order = number as usize,
        "frames" => sight.frames_per_s = number,
        "delay_ms" => sight.delay_ms = number as u64,
        "noise_px" => sight.noise_px = number,
        "gain" => options.gain = number,
        "damping" => options.damping = number,
        "tolerance_px" => options.tolerance_px = number,
        "look_ahead" => options.look_ahead = number > 0.0,
        "ramp_s" => options.ramp_s = number,
        "speed" => options.robot.speeds = [number, number, number / 100.0],
        "lever_px" => options.robot.lever_px = number,
        "robot_delay_s" => options.robot.delay_s = number,
        "drift" => options.estimator = Estimator::Kalman { drift: number },
        "broyden" => options.estimator = Estimator::Broyden { share: number },
        "least_step_px" => options.learning.least_step_px = number,
        "longest_pair_s" => options.learning.longest_pair_s = number,
        "reach_px" => options.exploring.reach_px = number,
        "explore_speed" => options.exploring.speed_px_s = number,
        "stalled_s" => options.exploring.stalled_s = number,
        "again" => options.exploring.again = number as u32,
        _ => return false,
    }
    true
}

/// Runs all seeds on two threads. Each run depends only on its seed.
fn run(study: &Study, shape: TargetShape) -> Vec<Outcome> {
    let half = |odd: u64| -> Vec<(u64, Outcome)> {
        let seeds = (1..=study.seeds).filter(|seed| seed % 2 == odd);
        let run = |seed| {
            let case = Case::new(shape, seed);
            let mut chain = Chain::new(&case, study.sight, study.options.clone());
            (seed, chain.run(study.seconds))
        };
        seeds.map(run).collect()
    };
    let mut outcomes = std::thread::scope(|scope| {
        let other = scope.spawn(|| half(1));
        let mut outcomes = half(0);
        outcomes.extend(other.join().expect("a run does not panic"));
        outcomes
    });
    outcomes.sort_by_key(|(seed, _)| *seed);
    outcomes.into_iter().map(|(_, outcome)| outcome).collect()
}

fn summary(name: &str, outcomes: &[Outcome]) {
    let sorted = |of: fn(&Outcome) -> f64| {
        let mut numbers: Vec<f64> = outcomes.iter().map(of).collect();
        numbers.sort_by(f64::total_cmp);
        numbers
    };
    let (middle, last) = (outcomes.len() / 2, outcomes.len() - 1);
    let reached = sorted(|outcome| outcome.reached_s.unwrap_or(f64::INFINITY));
    let explored = sorted(|outcome| outcome.explored_s);
    let left = sorted(|outcome| outcome.final_px);
    println!(
        "{name:6}  {:3}/{:3}  {:8.2}  {:7.2}  {:10.2}  {:7}  {:8.2}, {:.2}",
        reached.iter().filter(|s| s.is_finite()).count(),
        outcomes.len(),
        reached[middle],
        reached[last],
        explored[middle],
        outcomes.iter().filter(|o| o.arrived_s.is_some()).count(),
        left[middle],
        left[last],
    );
}
