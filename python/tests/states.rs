//! Sends any message that a chain may send about a rope, for the tests of the Python package. Reads
//! one word per line from standard input and answers `sent` when the message is out. Ends at the
//! end of the input.
//!
//! The rope is the parabola (100 ρ, 200 ρ (1 − ρ)), fitted to 120 points with σ² = ¼, and moves to
//! the right at 10 px/s.

use std::io::BufRead;

use lariat_fit::{Fitter, Options};
use lariat_wire::{
    Basis, DESCRIPTORS, Delivery, Descriptor, Descriptors, Domain, FitQuality, Rig, Status, Unit,
    Writer, now_ns,
};

/// Time from image to image.
const PERIOD_NS: u64 = 10_000_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let domain = Domain::open()?;
    let rig = Rig::default();
    let create =
        || Writer::<Descriptors>::create(&domain, &rig, &DESCRIPTORS, &Delivery::NewestWins);
    let mut writer = create()?;
    println!("ready");
    let (mut sent, mut exposed_ns) = (0, now_ns());
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        if line == "restart" {
            drop(writer);
            writer = create()?;
            sent = 0;
            println!("ready");
            continue;
        }
        let mut message = writer.slot()?;
        *message = Descriptors::EMPTY;
        sent += 1;
        exposed_ns += PERIOD_NS;
        fill(&mut message, &line)?;
        let trace = &mut message.trace;
        trace.sequence = sent + 100;
        (trace.captured, trace.extracted, trace.fitted) = (sent + 2, sent + 1, sent);
        trace.exposed_ns = exposed_ns.min(now_ns());
        trace.captured_ns = trace.exposed_ns + 1;
        trace.extract_started_ns = trace.exposed_ns + 2;
        trace.extracted_ns = trace.exposed_ns + 3;
        trace.fit_started_ns = trace.exposed_ns + 4;
        trace.fitted_ns = now_ns();
        message.send()?;
        println!("sent");
    }
    Ok(())
}

fn fill(message: &mut Descriptors, what: &str) -> Result<(), Box<dyn std::error::Error>> {
    (message.width, message.height, message.unit) = (640, 480, Unit::Pixel as u32);
    message.count = 1;
    message.curves[0] = rope(7)?;
    // The parabola of its control points as extraction would report it; its middle is covered.
    for (k, line) in message.centerlines[..2].iter_mut().enumerate() {
        line.count = 51;
        line.set_hidden((0..51).map(|i| i == 25));
        for i in 0..51 {
            let x = 2.0 * i as f32;
            line.points[i] = [x, x * (2.0 - 0.02 * x) + 100.0 * k as f32];
            line.widths[i] = 9.0 + 0.01 * i as f32;
        }
    }
    let rope_0 = &mut message.curves[0];
    match what {
        "whole" => {}
        "partial" => (rope_0.status, rope_0.hidden) = (Status::Partial as u32, 30),
        "lost" => (rope_0.status, rope_0.age_ns) = (Status::Lost as u32, 250_000_000),
        "coarse" => (rope_0.fit, rope_0.max) = (FitQuality::Coarse as u32, 15.8),
        "unsure" => rope_0.confidence = 0.42,
        "doubtful" => rope_0.status = Status::Doubtful as u32,
        "unfiltered" => rope_0.filtered = 0,
        "points" => rope_0.basis = Basis::FeaturePoints as u32,
        "nonsense" => rope_0.count = 77,
        "two" => {
            message.count = 2;
            message.curves[1] = rope(8)?;
        }
        "none" => message.count = 0,
        "blank" => (message.count, message.width, message.height) = (0, 0, 0),
        other => return Err(format!("there is no state '{other}'").into()),
    }
    Ok(())
}

fn rope(track: u32) -> Result<Descriptor, Box<dyn std::error::Error>> {
    let fitter = Fitter::new(Options::bezier(2))?;
    let factor = &fitter.last().covariance_factor;
    let mut rope = Descriptor {
        track,
        degree: 2,
        count: 3,
        samples: 120,
        border: 2,
        rms: 0.7,
        max: 1.5,
        residual_variance: 0.25,
        condition: fitter.last().condition,
        length: 147.9,
        width: 9.0,
        confidence: 0.97,
        filtered: 1,
        ..Descriptor::EMPTY
    };
    rope.control_points[..3].copy_from_slice(&[[0.0, 0.0], [50.0, 100.0], [100.0, 0.0]]);
    rope.velocities[..3].fill([10.0, 0.0]);
    for (j, covariance) in rope.covariances[..3].iter_mut().enumerate() {
        *covariance = [0.25 * factor[(j, j)], 0.0, 0.25 * factor[(j, j)]];
    }
    Ok(rope)
}
