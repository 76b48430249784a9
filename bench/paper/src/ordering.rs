//! Effect of ordering and arc length on the fit: uneven steps, and points in a wrong order.

mod figures;

use lariat_fit::{Basis, Fitter, Options, Rho};
use lariat_plot::words::px;
use lariat_plot::{Spread, spread::median};

use crate::PaperError;
use crate::curves::sampled;
use crate::polyline::{apart_px, at, rms_from_line_px};
use crate::random::{of_stream, shuffle};
use crate::shapes::{POINTS, Shapes};
use lariat_portable::SplitMix64;

/// Ratios of the largest to the smallest step between neighbors.
const RATIOS: [f64; 6] = [1.5, 2.0, 3.0, 5.0, 7.0, 10.0];
/// Index of the ratio that the findings are about.
const A_RATIO: usize = 2;
const BASIS: Basis = Basis::Bezier { order: 8 };

/// Pattern of uneven steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Unevenness {
    /// Steps grow along the rope and shrink again, as for a rope that recedes from the camera or a
    /// clustering that is denser in places.
    Drifting,
    /// Each step is random, as between the centers of a clustering.
    Jittered,
}

impl Unevenness {
    const ALL: [Self; 2] = [Self::Drifting, Self::Jittered];

    fn name(self) -> &'static str {
        match self {
            Self::Drifting => "drifting steps",
            Self::Jittered => "random steps",
        }
    }

    /// Returns the positions of the points along the rope, from 0 to 1.
    fn places(self, ratio: f64, random: &mut SplitMix64) -> Vec<f64> {
        let begin = random.unit();
        let steps: Vec<f64> = (0..POINTS - 1)
            .map(|i| match self {
                Self::Drifting => {
                    let turns = begin + i as f64 / (POINTS - 2) as f64;
                    ratio.powf(0.5 * (std::f64::consts::TAU * turns).sin())
                }
                Self::Jittered => ratio.powf(random.unit() - 0.5),
            })
            .collect();
        let whole: f64 = steps.iter().sum();
        let mut place = 0.0;
        let after = steps.iter().map(|step| {
            place += step / whole;
            place.min(1.0)
        });
        std::iter::once(0.0).chain(after).collect()
    }
}

/// Even and measured ρ.
const RHOS: [(Rho, &str); 2] = [(Rho::Even, "ρ even"), (Rho::Measured, "ρ measured")];

/// Ways to put points in a wrong order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Disorder {
    None,
    Reversed,
    /// Every tenth point is swapped with its neighbor.
    Neighbours,
    /// The middle third is reversed, as can happen to a loop at a crossing.
    LoopBackwards,
    /// The second half comes first.
    HalvesExchanged,
    Shuffled,
}

impl Disorder {
    const ALL: [Self; 6] = [
        Self::None,
        Self::Reversed,
        Self::Neighbours,
        Self::LoopBackwards,
        Self::HalvesExchanged,
        Self::Shuffled,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::None => "right order",
            Self::Reversed => "from the other end",
            Self::Neighbours => "neighbours exchanged",
            Self::LoopBackwards => "middle third backwards",
            Self::HalvesExchanged => "halves exchanged",
            Self::Shuffled => "shuffled",
        }
    }

    fn apply(self, points: &mut [[f64; 2]], random: &mut SplitMix64) {
        let count = points.len();
        match self {
            Self::None => {}
            Self::Reversed => points.reverse(),
            Self::Neighbours => (0..count - 1)
                .step_by(10)
                .for_each(|i| points.swap(i, i + 1)),
            Self::LoopBackwards => points[count / 3..2 * count / 3].reverse(),
            Self::HalvesExchanged => points.rotate_left(count / 2),
            Self::Shuffled => shuffle(points, random),
        }
    }
}

/// Effect of uneven steps and wrong orders.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Ordering {
    /// Unevenness, index into `RHOS`, and errors by ratio.
    steps: Vec<(Unevenness, usize, Vec<Spread>)>,
    /// Disorder, index into `RHOS`, distance of the rope from the curve, and distance of the
    /// control points from those for the right order.
    orders: Vec<(Disorder, usize, Spread, f64)>,
    shapes: usize,
}

fn fitter(rho: Rho) -> Result<Fitter, PaperError> {
    Ok(Fitter::new(
        Options::default().basis(BASIS).points(POINTS).rho(rho),
    )?)
}

impl Ordering {
    pub(crate) fn run(shapes: &Shapes, seed: u64) -> Result<Self, PaperError> {
        let mut steps = Vec::new();
        for unevenness in Unevenness::ALL {
            for (k, (rho, _)) in RHOS.into_iter().enumerate() {
                steps.push((unevenness, k, uneven(shapes, seed, unevenness, rho)?));
            }
        }
        let mut orders = Vec::new();
        for disorder in Disorder::ALL {
            for (k, (rho, _)) in RHOS.into_iter().enumerate() {
                let (off, moved) = disordered(shapes, seed, disorder, rho)?;
                orders.push((disorder, k, off, moved));
            }
        }
        Ok(Self {
            steps,
            orders,
            shapes: shapes.all.len(),
        })
    }

    fn step(&self, unevenness: Unevenness, rho: usize, ratio: usize) -> f64 {
        let row = self
            .steps
            .iter()
            .find(|row| (row.0, row.1) == (unevenness, rho));
        row.map_or(f64::NAN, |row| row.2[ratio].median)
    }

    fn steps_finding(&self) -> String {
        let drift = [0, 1].map(|rho| self.step(Unevenness::Drifting, rho, A_RATIO));
        let jitter = [0, 1].map(|rho| self.step(Unevenness::Jittered, rho, A_RATIO));
        let verdict = if drift[0] > 1.1 * drift[1] {
            "ρ has to be the arc length, as the paper's equation 2 says, and not the point's number"
        } else {
            "Measuring ρ makes no difference here"
        };
        format!(
            "{verdict}: steps that drift along the rope, the largest {} times the least, move the curve by {} with even ρ \
             and by {} with measured. Steps that vary from point to point do less: {} and {}.",
            RATIOS[A_RATIO],
            px(drift[0]),
            px(drift[1]),
            px(jitter[0]),
            px(jitter[1]),
        )
    }

    fn orders_finding(&self) -> String {
        let of = |disorder: Disorder| {
            let row = self
                .orders
                .iter()
                .find(|row| (row.0, row.1) == (disorder, 0));
            row.map_or((f64::NAN, f64::NAN), |row| (row.2.median, row.3))
        };
        let (right_px, _) = of(Disorder::None);
        let (backwards_px, moved_px) = of(Disorder::Reversed);
        let (loop_px, _) = of(Disorder::LoopBackwards);
        let (shuffled_px, _) = of(Disorder::Shuffled);
        let verdict = if loop_px > 1.2 * right_px && shuffled_px > 2.0 * right_px {
            "The order is half of the method, and the paper leaves it out"
        } else {
            "The order hardly matters here"
        };
        let turned = if backwards_px < 1.01 * right_px {
            "Read from the other end the curve is the same, but its descriptor is another"
        } else {
            "Read from the other end the curve is another, and so is its descriptor"
        };
        format!(
            "{verdict}: in the right order the curve is {} off, with the middle third backwards {}, shuffled {}. {turned}: \
             its control points are {} away, so that a controller needs a direction that lasts.",
            px(right_px),
            px(loop_px),
            px(shuffled_px),
            px(moved_px),
        )
    }
}

fn uneven(
    shapes: &Shapes,
    seed: u64,
    unevenness: Unevenness,
    rho: Rho,
) -> Result<Vec<Spread>, PaperError> {
    let mut fitter = fitter(rho)?;
    let mut even = Vec::new();
    for shape in &shapes.all {
        even.push(sampled(fitter.fit(&shape.reference)?, POINTS)?);
    }
    let mut spreads = Vec::new();
    for (k, ratio) in RATIOS.into_iter().enumerate() {
        let mut off = Vec::new();
        for (i, shape) in shapes.all.iter().enumerate() {
            let mut random = of_stream(seed, (80_000 + 1000 * k + i) as u64);
            let places = unevenness.places(ratio, &mut random);
            let points: Vec<[f64; 2]> = places.iter().map(|&u| at(&shape.dense, u)).collect();
            let curve = sampled(fitter.fit(&points)?, 2 * POINTS)?;
            off.push(rms_from_line_px(&even[i], &curve));
        }
        spreads.push(Spread::of(off));
    }
    Ok(spreads)
}

fn disordered(
    shapes: &Shapes,
    seed: u64,
    disorder: Disorder,
    rho: Rho,
) -> Result<(Spread, f64), PaperError> {
    let mut fitter = fitter(rho)?;
    let (mut off, mut moved) = (Vec::new(), Vec::new());
    for (i, shape) in shapes.all.iter().enumerate() {
        let right = fitter.fit(&shape.reference)?.control_points.clone();
        let mut points = shape.reference.clone();
        disorder.apply(&mut points, &mut of_stream(seed, 90_000 + i as u64));
        let fit = fitter.fit(&points)?;
        let apart = right
            .iter()
            .zip(&fit.control_points)
            .map(|(&a, &b)| apart_px(a, b));
        moved.push(median(apart));
        let curve = sampled(fit, 4 * POINTS)?;
        off.push(rms_from_line_px(&shape.reference, &curve));
    }
    Ok((Spread::of(off), median(moved)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ordering(even_px: f64, measured_px: f64, looped_px: f64) -> Ordering {
        let steps = Unevenness::ALL.into_iter().flat_map(|unevenness| {
            [even_px, measured_px]
                .into_iter()
                .enumerate()
                .map(move |(rho, off)| (unevenness, rho, vec![Spread::of([off]); RATIOS.len()]))
        });
        let orders = Disorder::ALL.map(|disorder| {
            let off = match disorder {
                Disorder::LoopBackwards | Disorder::Shuffled => looped_px,
                _ => 1.0,
            };
            (disorder, 0, Spread::of([off]), 70.0)
        });
        Ordering {
            steps: steps.collect(),
            orders: orders.to_vec(),
            shapes: 1,
        }
    }

    #[test]
    fn the_sentences_follow_the_numbers() {
        let bad = ordering(9.0, 1.0, 30.0);
        assert!(
            bad.steps_finding()
                .starts_with("ρ has to be the arc length")
        );
        assert!(
            bad.orders_finding()
                .starts_with("The order is half of the method")
        );
        assert!(
            bad.orders_finding()
                .contains("control points are 70.0 px away")
        );
        let mild = ordering(1.0, 1.0, 1.0);
        assert!(mild.steps_finding().contains("makes no difference"));
        assert!(
            mild.orders_finding()
                .starts_with("The order hardly matters")
        );
    }

    #[test]
    fn steps_are_as_uneven_as_they_are_asked_to_be() {
        for unevenness in Unevenness::ALL {
            let places = unevenness.places(5.0, &mut of_stream(1, 1));
            assert_eq!((places.len(), places[0]), (POINTS, 0.0));
            assert!((places[POINTS - 1] - 1.0).abs() < 1e-9);
            let steps: Vec<f64> = places.windows(2).map(|pair| pair[1] - pair[0]).collect();
            let most = steps.iter().copied().fold(0.0, f64::max);
            let least = steps.iter().copied().fold(1.0, f64::min);
            assert!(
                (4.0..=5.0 + 1e-9).contains(&(most / least)),
                "{}",
                most / least
            );
        }
    }
}
