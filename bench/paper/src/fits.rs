//! Figure 2 of the paper: fits of its four orders over the picture.

use lariat_fit::{Basis, Fit};
use lariat_plot::words::{list, px};

use crate::PaperError;
use crate::Picture;
use crate::csv::Csv;
use crate::curves::{PAPERS, fitter, sampled};
use crate::figure::Figure;
use crate::orders::Orders;
use crate::overlay::{self, Drawn, Panel, Stroke};
use crate::shapes::{Shape, Shapes};

/// Makes the figure from the pictured rope with the most typical error at order 8. Returns `None`
/// if no picture was kept.
pub(crate) fn figure(shapes: &Shapes, orders: &Orders) -> Result<Option<Figure>, PaperError> {
    let Some(shape) = orders.typical(shapes).map(|index| &shapes.all[index]) else {
        return Ok(None);
    };
    let Some(picture) = shape.picture.map(|kept| &shapes.pictures[kept]) else {
        return Ok(None);
    };
    let mut fits = Vec::new();
    for order in PAPERS {
        let mut fitter = fitter(Basis::Bezier { order })?;
        fits.push((order, fitter.fit(shape.points())?.clone()));
    }
    let mut panels = Vec::new();
    for (order, fit) in &fits {
        panels.push(panel(*order, fit)?);
    }
    let columns = if picture.height > picture.width { 4 } else { 2 };
    let view = overlay::around(picture, 0.18);
    Ok(Some(Figure {
        number: 2,
        title: "Fits of order 2, 4, 6 and 8".to_owned(),
        svg: overlay::draw("fits", &[picture], &panels, columns, view)?,
        shows: "Bezier curves (orange) fitted to the points that the extractor found in the picture, with their control \
                points (rings) and control polygons (dashed). Of the shown ropes the one whose error at order 8 is nearest \
                to the median."
            .to_owned(),
        found: finding(shape, picture, &fits),
        parameters: format!("n = {}", list(&PAPERS.map(|n| n.to_string()))),
        table: None,
        csv: csv(&fits),
    }))
}

fn panel(order: usize, fit: &Fit) -> Result<Panel, PaperError> {
    let stroke = |points: &[[f64; 2]], color, width, dashes, drawn| Stroke {
        points: points.to_vec(),
        color,
        width,
        dashes,
        drawn,
    };
    let polygon = &fit.control_points[..];
    let curve = sampled(fit, 200)?;
    Ok(Panel {
        title: format!("n = {order}: {} off", px(fit.rms_px)),
        picture: 0,
        strokes: vec![
            stroke(polygon, "#fff", 3.0, "", Drawn::Line),
            stroke(polygon, "#0072B2", 1.3, "5 3", Drawn::Line),
            stroke(&curve, "#fff", 5.0, "", Drawn::Line),
            stroke(&curve, "#D55E00", 2.6, "", Drawn::Line),
            stroke(polygon, "#0072B2", 7.0, "", Drawn::Rings),
        ],
    })
}

fn finding(shape: &Shape, picture: &Picture, fits: &[(usize, Fit)]) -> String {
    let told: Vec<String> = fits
        .iter()
        .map(|(order, fit)| format!("{} for n = {order}", px(fit.rms_px)))
        .collect();
    let size = [picture.width as f64, picture.height as f64];
    let is_outside = |p: &&[f64; 2]| (0..2).any(|k| p[k] < 0.0 || p[k] > size[k]);
    let points = fits.last().map(|(_, fit)| &fit.control_points[..]);
    let outside = points.map_or(0, |points| points.iter().filter(is_outside).count());
    let place = match outside {
        0 => "All control points of order 8 lie within the picture.".to_owned(),
        1 => "At order 8, one of the nine control points lies outside the picture.".to_owned(),
        n => format!(
            "At order 8, {n} of the nine control points lie outside the picture: they are not points on the rope."
        ),
    };
    format!(
        "On this rope ({}) the error is {}. {place}",
        shape.name,
        list(&told)
    )
}

fn csv(fits: &[(usize, Fit)]) -> Csv {
    let header = ["order", "control_point", "x_px", "y_px", "residual_rms_px"];
    let mut csv = Csv::new("figure-2-fits.csv", &header);
    for (order, fit) in fits {
        for (j, [x, y]) in fit.control_points.iter().enumerate() {
            csv.row(&[
                (*order).into(),
                j.into(),
                (*x).into(),
                (*y).into(),
                fit.rms_px.into(),
            ]);
        }
    }
    csv
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_points_outside_the_picture_are_counted() {
        let shape = Shape {
            name: "a rope".to_owned(),
            kind: "drawn",
            reference: Vec::new(),
            dense: Vec::new(),
            seen: None,
            width_px: 8.0,
            picture: Some(0),
        };
        let picture = Picture {
            name: String::new(),
            width: 100,
            height: 100,
            rgb: Vec::new(),
        };
        let mut fit = fitter(Basis::Bezier { order: 8 }).unwrap().last().clone();
        let told = |fit: &Fit| finding(&shape, &picture, &[(8, fit.clone())]);
        assert!(told(&fit).ends_with("All control points of order 8 lie within the picture."));
        fit.control_points[3] = [50.0, -4.0];
        assert!(told(&fit).contains("one of the nine control points lies outside"));
        fit.control_points[4] = [101.0, 4.0];
        assert!(told(&fit).contains("2 of the nine control points lie outside"));
    }
}
