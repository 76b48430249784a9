//! The rivals that the paper names and the curves that it allows, at an equal number of parameters.

use lariat_plot::words::{digits, list, px, time};
use lariat_plot::{Axis, Chart, LineStyle, Mark, Spread, spread::median};

use crate::cost::median_us;
use crate::csv::Csv;
use crate::family::{Family, Fitting, PAPERS_NUMBERS};
use crate::figure::{Figure, Table};
use crate::random::of_stream;
use crate::shapes::{GENTLE, Shapes};
use crate::{Effort, PaperError};

/// Range of the number of parameters of a curve.
const NUMBERS: std::ops::RangeInclusive<usize> = 2..=32;

/// Ratio of two times below which a fit counts as faster. Times below a microsecond vary from run
/// to run.
const FASTER: f64 = 0.8;

/// A family at one size.
#[derive(Debug, Clone, PartialEq)]
struct Size {
    numbers: usize,
    off: Spread,
}

/// A family at the paper's size.
#[derive(Debug, Clone, PartialEq)]
struct Entry {
    family: Family,
    numbers: usize,
    off_px: f64,
    /// Error on gently bent ropes, if there are any.
    gentle_px: f64,
    /// Error with noise of 1 px on every coordinate.
    noisy_px: f64,
    /// Displacement of the family's least certain point per pixel of noise, px.
    gain: f64,
    fit_us: f64,
}

/// Errors of all families by number of parameters.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Rivals {
    rows: Vec<(Family, Vec<Size>)>,
    entries: Vec<Entry>,
    shapes: usize,
}

impl Rivals {
    pub(crate) fn run(shapes: &Shapes, seed: u64, effort: &Effort) -> Result<Self, PaperError> {
        let (mut rows, mut entries) = (Vec::new(), Vec::new());
        for family in Family::ALL {
            let mut sizes: Vec<Size> = Vec::new();
            for numbers in NUMBERS {
                let Some(mut fitting) = Fitting::of(family, numbers)? else {
                    continue;
                };
                if sizes
                    .last()
                    .is_some_and(|size| size.numbers == fitting.numbers)
                {
                    continue;
                }
                let mut off = Vec::new();
                for shape in &shapes.all {
                    fitting.fit(&shape.reference)?;
                    off.push(fitting.off_px(&shape.reference)?);
                }
                sizes.push(Size {
                    numbers: fitting.numbers,
                    off: Spread::of(off),
                });
            }
            rows.push((family, sizes));
            if let Some(fitting) = Fitting::of(family, PAPERS_NUMBERS)? {
                entries.push(Entry::run(fitting, shapes, seed, effort)?);
            }
        }
        Ok(Self {
            rows,
            entries,
            shapes: shapes.all.len(),
        })
    }

    fn finding(&self) -> String {
        let Some(bezier) = self.entries.iter().find(|e| e.family == Family::Bezier) else {
            return String::new();
        };
        let rivals = || self.entries.iter().filter(|e| e.family.is_rival());
        let better = |of: fn(&Entry) -> f64, margin: f64| -> Vec<String> {
            let by = rivals().filter(|rival| of(rival) <= margin * of(bezier));
            by.map(|rival| rival.family.name().to_owned()).collect()
        };
        let accurate = better(|e| e.off_px, 1.0);
        let noisy = better(|e| e.noisy_px, 1.0);
        let quick = better(|e| e.fit_us, FASTER);
        let claim = |what: &str, beaten_by: &[String]| {
            if beaten_by.is_empty() {
                format!("in {what} no rival that the paper names is ahead of it")
            } else {
                format!("in {what} it is behind {}", list(beaten_by))
            }
        };
        let mut allowed: Vec<&Entry> = self
            .entries
            .iter()
            .filter(|e| !e.family.is_rival())
            .collect();
        allowed.sort_by(|a, b| a.off_px.total_cmp(&b.off_px));
        let told: Vec<String> = allowed
            .iter()
            .map(|e| format!("the {} {}", e.family.name(), px(e.off_px)))
            .collect();
        format!(
            "With nine control points the Bezier curve is {} off; {}; {}; {}. Of the curves that the paper allows besides, \
             {} off.",
            px(bezier.off_px),
            claim("accuracy", &accurate),
            claim("accuracy under noise of 1 px", &noisy),
            claim("speed", &quick),
            list(&told),
        )
    }

    pub(crate) fn figure(&self) -> Result<Figure, PaperError> {
        let of_lines = || {
            self.rows
                .iter()
                .filter(|(family, _)| *family != Family::CenterOfMass)
        };
        let all = self
            .rows
            .iter()
            .flat_map(|(_, sizes)| sizes.iter().map(|s| s.off.median));
        let mut chart = Chart::new(
            Axis::linear("numbers that describe the curve", [1.0, 33.0], 4.0),
            Axis::log_around("distance from the rope, px", all),
        );
        chart.height_px = 300;
        chart.marks.push(Mark::Rule {
            x: PAPERS_NUMBERS as f64,
            text: "n = 8".to_owned(),
        });
        for (i, (family, sizes)) in of_lines().enumerate() {
            let line = sizes.iter().map(|s| [s.numbers as f64, s.off.median]);
            chart.line(family.name(), LineStyle::nth(i), line.collect());
        }
        let mass = self
            .rows
            .iter()
            .find(|(family, _)| *family == Family::CenterOfMass);
        if let Some(size) = mass.and_then(|(_, sizes)| sizes.first()) {
            let at = [size.numbers as f64, size.off.median];
            let look = LineStyle::nth(of_lines().count());
            chart.line(Family::CenterOfMass.name(), look, vec![at]);
        }
        Ok(Figure {
            number: 9,
            title: "Against its rivals, at an equal number of parameters".to_owned(),
            svg: lariat_plot::draw("figure 9", &[chart], 1)?,
            shows: format!(
                "Median distance, over {} ropes, between the rope and the curve fitted to its exact points, by how many \
                 numbers the curve takes: two a control point, and one a weight. The table is at the size of the paper's \
                 order 8; the noise gain says how far a pixel of noise moves the least certain point or coefficient.",
                self.shapes
            ),
            found: self.finding(),
            parameters: format!(
                "{} to {} numbers; table: {PAPERS_NUMBERS}; noise 1 px",
                NUMBERS.start(),
                NUMBERS.end()
            ),
            table: Some(self.table()),
            csv: self.csv(),
        })
    }

    fn csv(&self) -> Csv {
        let mut csv = Csv::new(
            "figure-9-rivals.csv",
            &[
                "family",
                "numbers",
                "p5_px",
                "p25_px",
                "median_px",
                "p75_px",
                "p95_px",
            ],
        );
        for (family, sizes) in &self.rows {
            for Size { numbers, off } in sizes {
                csv.row(&[
                    family.name().into(),
                    (*numbers).into(),
                    off.p5.into(),
                    off.p25.into(),
                    off.median.into(),
                    off.p75.into(),
                    off.p95.into(),
                ]);
            }
        }
        csv
    }

    fn table(&self) -> Table {
        let has_gentle = self.entries.iter().any(|entry| entry.gentle_px.is_finite());
        let mut head = vec![
            "curve",
            "numbers",
            "off, px",
            "with noise of 1 px",
            "noise gain",
            "a fit takes",
        ];
        if has_gentle {
            head.insert(3, "on gentle ropes");
        }
        let mut table = Table::new(&head);
        for entry in &self.entries {
            let mut row = vec![
                entry.family.name().to_owned(),
                entry.numbers.to_string(),
                digits(entry.off_px),
                digits(entry.noisy_px),
                digits(entry.gain),
                time(entry.fit_us),
            ];
            if has_gentle {
                row.insert(3, digits(entry.gentle_px));
            }
            table.row(row);
        }
        table
    }
}

impl Entry {
    fn run(
        mut fitting: Fitting,
        shapes: &Shapes,
        seed: u64,
        effort: &Effort,
    ) -> Result<Self, PaperError> {
        let [mut off, mut gentle, mut noisy, mut gains] = [(); 4].map(|()| Vec::new());
        for (i, shape) in shapes.all.iter().enumerate() {
            gains.push(fitting.fit(&shape.reference)?.noise_gain());
            off.push(fitting.off_px(&shape.reference)?);
            if shape.kind == GENTLE {
                gentle.push(fitting.off_px(&shape.reference)?);
            }
            let mut random = of_stream(seed, 60_000 + i as u64);
            let points: Vec<[f64; 2]> = (shape.reference.iter())
                .map(|p| p.map(|c| c + random.normal()))
                .collect();
            fitting.fit(&points)?;
            noisy.push(fitting.off_px(&shape.reference)?);
        }
        let points = &shapes.all[0].reference;
        let fit_us = median_us(effort.rounds, || fitting.fit_again(points).map(|_| ()))?;
        Ok(Self {
            family: fitting.family,
            numbers: fitting.numbers,
            off_px: median(off),
            gentle_px: median(gentle),
            noisy_px: median(noisy),
            gain: median(gains),
            fit_us,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rivals(points_px: f64, points_us: f64) -> Rivals {
        let entry = |family, off_px, fit_us| Entry {
            family,
            numbers: 18,
            off_px,
            gentle_px: off_px,
            noisy_px: off_px + 0.5,
            gain: 1.0,
            fit_us,
        };
        Rivals {
            rows: Vec::new(),
            entries: vec![
                entry(Family::Bezier, 1.0, 2.0),
                entry(Family::BSpline, 0.8, 2.0),
                entry(Family::FeaturePoints, points_px, points_us),
            ],
            shapes: 1,
        }
    }

    #[test]
    fn the_sentence_follows_the_numbers() {
        let found = rivals(5.0, 9.0).finding();
        assert!(found.contains("in accuracy no rival"), "{found}");
        assert!(found.contains("in speed no rival"), "{found}");
        assert!(
            found.contains("the cubic B-spline 0.800 px and the Bezier 1.00 px off"),
            "{found}"
        );
        let found = rivals(0.5, 0.1).finding();
        assert!(
            found.contains("in accuracy it is behind feature points"),
            "{found}"
        );
        assert!(
            found.contains("in speed it is behind feature points"),
            "{found}"
        );
    }
}
