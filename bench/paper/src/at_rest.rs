//! Temporal noise: how much the descriptor of a motionless rope jitters, by family and order, with
//! and without the filter.

use lariat_capture::{RenderOptions, Source, open};
use lariat_extract::{Extractor, Image, Options, PixelFormat, Status};
use lariat_fit::{Basis, Filter, FilterOptions, Fitter, Noise};
use lariat_plot::spread::mean;
use lariat_plot::words::{digits, px};
use lariat_plot::{Axis, Chart, LineStyle, Marker, Stroke};

use crate::csv::Csv;
use crate::curves::{bspline, fitter, sampled};
use crate::figure::Figure;
use crate::shapes::POINTS;
use crate::{Effort, PaperError};

/// Numbers of control points in the compared descriptors, as for Bezier curves of order 2, 4, 6, 8,
/// 10 and 12.
const COUNTS: [usize; 6] = [3, 5, 7, 9, 11, 13];
/// Index of order 8 (nine control points) in [`COUNTS`].
const NINE: usize = 3;
/// Number of initial frames that are left out while the extractor and the filter settle.
const SETTLING: usize = 20;
const FRAME_NS: u64 = 1_000_000_000 / 30;
/// Assumed acceleration of a rope that hardly moves, px/s².
const CALM_PX_S2: f64 = 10.0;
/// Number of points along a curve at which its own jitter is measured.
const CURVE_POINTS: usize = 50;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Family {
    Bezier,
    BSpline,
    FeaturePoints,
}

impl Family {
    const ALL: [Self; 3] = [Self::Bezier, Self::BSpline, Self::FeaturePoints];

    fn name(self) -> &'static str {
        match self {
            Self::Bezier => "Bezier",
            Self::BSpline => "B-spline",
            Self::FeaturePoints => "feature points",
        }
    }

    fn basis(self, count: usize) -> Basis {
        match self {
            Self::Bezier => Basis::Bezier { order: count - 1 },
            Self::BSpline => bspline(count),
            Self::FeaturePoints => Basis::FeaturePoints { count },
        }
    }
}

/// Jitter of one family: root mean square distance from the mean position, averaged over ropes, px.
#[derive(Debug, Clone, PartialEq)]
struct Row {
    family: Family,
    /// Jitter of the fitted control points, by entry of [`COUNTS`].
    fitted_px: Vec<f64>,
    /// Jitter of the filtered control points.
    filtered_px: Vec<f64>,
    /// Jitter of the control points when the filter assumes [`CALM_PX_S2`].
    calmed_px: Vec<f64>,
    /// Jitter of the fitted curve itself.
    curve_px: Vec<f64>,
}

/// Jitter of the descriptors of ropes at rest.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct AtRest {
    rows: Vec<Row>,
    ropes: usize,
    frames: usize,
    noise: f64,
}

impl AtRest {
    pub(crate) fn run(seed: u64, effort: &Effort) -> Result<Self, PaperError> {
        let mut films = Vec::new();
        for rope in 0..effort.ropes_at_rest as u64 {
            let film = film(seed.wrapping_mul(1000).wrapping_add(rope), effort)?;
            // A rope that is missing from most frames says nothing about jitter.
            if film.len() > effort.frames_at_rest / 2 && film.len() > SETTLING + 2 {
                films.push(film);
            }
        }
        let mut rows = Vec::new();
        for family in Family::ALL {
            let mut row = Row {
                family,
                fitted_px: Vec::new(),
                filtered_px: Vec::new(),
                calmed_px: Vec::new(),
                curve_px: Vec::new(),
            };
            for count in COUNTS {
                let mut fitter = fitter(family.basis(count))?;
                let mut each = Vec::new();
                for film in &films {
                    each.push(tremble(film, &mut fitter)?);
                }
                let mean_of = |k: usize| mean(each.iter().map(|px: &[f64; 4]| px[k]));
                row.fitted_px.push(mean_of(0));
                row.filtered_px.push(mean_of(1));
                row.calmed_px.push(mean_of(2));
                row.curve_px.push(mean_of(3));
            }
            rows.push(row);
        }
        Ok(Self {
            rows,
            ropes: films.len(),
            frames: effort.frames_at_rest,
            noise: RenderOptions::default().noise,
        })
    }

    fn of(&self, family: Family) -> Option<&Row> {
        self.rows.iter().find(|row| row.family == family)
    }

    fn finding(&self) -> String {
        let (Some(bezier), Some(bspline), Some(points)) = (
            self.of(Family::Bezier),
            self.of(Family::BSpline),
            self.of(Family::FeaturePoints),
        ) else {
            return String::new();
        };
        let verdict = if bezier.fitted_px[NINE] > 2.0 * bspline.fitted_px[NINE] {
            "A rope that lies still has a Bezier descriptor that does not"
        } else {
            "The Bezier descriptor lies as still as the others"
        };
        let by = |filtered_px: f64| {
            let times = bezier.fitted_px[NINE] / filtered_px;
            if times > 1.1 {
                format!("calms it to {} ({} times)", px(filtered_px), digits(times))
            } else {
                format!("hardly calms it ({})", px(filtered_px))
            }
        };
        let filter = format!(
            "The filter, made for ropes that are moved ({} px/s²), {}; told that this one hardly moves ({} px/s²) it {}",
            FilterOptions::default().acceleration_px_s2,
            by(bezier.filtered_px[NINE]),
            CALM_PX_S2,
            by(bezier.calmed_px[NINE]),
        );
        format!(
            "{verdict}: at order 8 its control points tremble by {}, at order 2 by {} and at order 12 by {}, while the curve \
             that they draw trembles by {}. Nine control points of a B-spline tremble by {}, nine feature points by {}. \
             {filter}.",
            px(bezier.fitted_px[NINE]),
            px(bezier.fitted_px[0]),
            px(bezier.fitted_px[COUNTS.len() - 1]),
            px(bezier.curve_px[NINE]),
            px(bspline.fitted_px[NINE]),
            px(points.fitted_px[NINE]),
        )
    }

    pub(crate) fn figure(&self) -> Result<Figure, PaperError> {
        Ok(Figure {
            number: 14,
            title: "A rope at rest".to_owned(),
            svg: lariat_plot::draw("figure 14", &[self.chart()], 1)?,
            shows: format!(
                "{} drawn ropes lie still for {} frames (30 a second) of a camera with noise of {} levels, seen by the \
                 extractor: root mean square distance of the control points from their mean place, the first {SETTLING} \
                 frames left out; as fitted, and filtered.",
                self.ropes, self.frames, self.noise
            ),
            found: self.finding(),
            parameters: format!(
                "control points {COUNTS:?}; noise {} levels; filter: {} and {CALM_PX_S2} px/s²",
                self.noise,
                FilterOptions::default().acceleration_px_s2
            ),
            table: None,
            csv: self.csv(),
        })
    }

    fn chart(&self) -> Chart {
        let lines = || {
            self.rows.iter().enumerate().flat_map(|(i, row)| {
                let look = LineStyle::nth(i);
                let line = |what: &str, stroke| {
                    let name = format!("{}, {what}", row.family.name());
                    (name, look.stroke(stroke))
                };
                let mut lines = vec![
                    (line("fitted", Stroke::Solid), &row.fitted_px),
                    (
                        line("filtered as hardly moving", Stroke::Dashed),
                        &row.calmed_px,
                    ),
                ];
                if row.family == Family::Bezier {
                    lines.insert(1, (line("filtered", Stroke::Dotted), &row.filtered_px));
                }
                lines
            })
        };
        let curve = self.of(Family::Bezier).map(|row| &row.curve_px);
        let all = lines()
            .flat_map(|(_, px)| px)
            .chain(curve.into_iter().flatten());
        let mut chart = Chart::new(
            Axis::linear("control points (n + 1)", [2.5, 13.5], 1.0),
            Axis::log_around("trembling, px", all.copied()),
        );
        let placed = |px: &[f64]| {
            COUNTS
                .iter()
                .zip(px)
                .map(|(&n, &px)| [n as f64, px])
                .collect()
        };
        for ((name, look), px) in lines() {
            chart.line(&name, look, placed(px));
        }
        if let Some(curve_px) = curve {
            let look = LineStyle::nth(6)
                .marker(Marker::None)
                .stroke(Stroke::Dotted);
            chart.line("the Bezier curve itself", look, placed(curve_px));
        }
        chart
    }

    fn csv(&self) -> Csv {
        let mut csv = Csv::new(
            "figure-14-at-rest.csv",
            &[
                "family",
                "control_points",
                "fitted_px",
                "filtered_px",
                "calmed_px",
                "curve_px",
            ],
        );
        for row in &self.rows {
            for (k, count) in COUNTS.into_iter().enumerate() {
                csv.row(&[
                    row.family.name().into(),
                    count.into(),
                    row.fitted_px[k].into(),
                    row.filtered_px[k].into(),
                    row.calmed_px[k].into(),
                    row.curve_px[k].into(),
                ]);
            }
        }
        csv
    }
}

/// Returns the points of a rope at rest as extracted from successive frames.
fn film(seed: u64, effort: &Effort) -> Result<Vec<Vec<[f64; 2]>>, PaperError> {
    let [width, height] = effort.size_px;
    let mut source = open(&Source::Rendered(RenderOptions {
        seed,
        width: width as u32,
        height: height as u32,
        // A fortieth of the picture's height, as in the default size.
        rope_px: (height as f64 / 40.0).max(5.0),
        frame_interval_s: 0.0,
        frames: Some(effort.frames_at_rest as u64),
        ..RenderOptions::default()
    }))?;
    let mut extractor = Extractor::new(Options::default().points(POINTS))?;
    let mut pixels = Vec::new();
    let mut film = Vec::new();
    while let Some(frame) = source.next()? {
        pixels.resize(frame.bytes(), 0);
        source.write(&mut pixels);
        let image = Image::new(
            &pixels,
            width,
            height,
            frame.stride as usize,
            PixelFormat::Rgb8,
        )?;
        let scene = extractor.extract(&image);
        if let [curve] = scene.curves
            && curve.status == Status::Ok
        {
            film.push(curve.points.iter().map(|p| p.map(f64::from)).collect());
        }
    }
    Ok(film)
}

/// Returns the jitter in a film for four things: the fitted control points, those filtered with
/// default options, those filtered with calm options, and the curve.
fn tremble(film: &[Vec<[f64; 2]>], fitter: &mut Fitter) -> Result<[f64; 4], PaperError> {
    let space = fitter.curve_space()?;
    let default = FilterOptions::default();
    let calm = default.acceleration_px_s2(CALM_PX_S2);
    let mut filters = Vec::new();
    for options in [default, calm] {
        filters.push(Filter::<2>::new(space.control_points(), options)?);
    }
    let [mut fitted, mut filtered, mut calmed, mut curve] = [(); 4].map(|()| Vec::new());
    for (k, points) in film.iter().enumerate() {
        let fit = fitter.fit(points)?;
        let now_ns = (k as u64 + 1) * FRAME_NS;
        let noise = Noise::Even {
            variance_px2: fit.residual_variance,
        };
        for (filter, places) in filters.iter_mut().zip([&mut filtered, &mut calmed]) {
            filter.update(now_ns, &space, &fit.control_points, noise)?;
            if k >= SETTLING {
                places.push(filter.predict(now_ns)?.control_points.clone());
            }
        }
        if k >= SETTLING {
            fitted.push(fit.control_points.clone());
            curve.push(sampled(fit, CURVE_POINTS)?);
        }
    }
    Ok([&fitted, &filtered, &calmed, &curve].map(|places| about_mean_px(places)))
}

/// Returns the root mean square distance of points from their mean positions over time.
fn about_mean_px(frames: &[Vec<[f64; 2]>]) -> f64 {
    let count = frames.first().map_or(0, Vec::len);
    let squares = (0..count).flat_map(|j| {
        let middle = [0, 1].map(|axis| mean(frames.iter().map(|points| points[j][axis])));
        frames.iter().map(move |points| {
            let [dx, dy] = [0, 1].map(|axis| points[j][axis] - middle[axis]);
            dx * dx + dy * dy
        })
    });
    mean(squares).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at_rest(bezier_px: f64, filtered_px: f64) -> AtRest {
        let row = |family, fitted_px: f64| Row {
            family,
            fitted_px: vec![fitted_px; COUNTS.len()],
            filtered_px: vec![filtered_px; COUNTS.len()],
            calmed_px: vec![0.5 * filtered_px; COUNTS.len()],
            curve_px: vec![0.02; COUNTS.len()],
        };
        AtRest {
            rows: vec![
                row(Family::Bezier, bezier_px),
                row(Family::BSpline, 0.1),
                row(Family::FeaturePoints, 0.1),
            ],
            ropes: 1,
            frames: 60,
            noise: 2.5,
        }
    }

    #[test]
    fn the_sentence_follows_the_numbers() {
        let found = at_rest(1.0, 0.25).finding();
        assert!(
            found.starts_with("A rope that lies still has a Bezier descriptor"),
            "{found}"
        );
        assert!(
            found.contains("calms it to 0.250 px (4.00 times)"),
            "{found}"
        );
        let found = at_rest(0.1, 0.1).finding();
        assert!(
            found.starts_with("The Bezier descriptor lies as still"),
            "{found}"
        );
        assert!(found.contains("hardly calms it (0.100 px)"), "{found}");
    }

    #[test]
    fn trembling_is_the_distance_from_the_mean_place() {
        let frames = [
            vec![[1.0, 0.0]],
            vec![[-1.0, 0.0]],
            vec![[1.0, 4.0]],
            vec![[-1.0, 4.0]],
        ];
        assert!((about_mean_px(&frames) - 5f64.sqrt()).abs() < 1e-12);
    }
}
