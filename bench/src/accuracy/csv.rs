//! All measurements as comma-separated values (RFC 4180), one line per image.

use std::time::Duration;

use super::causes::Cause;
use super::measure::Measured;

/// Returns the header and a line for each image of each set.
pub(super) fn table(sets: &[(&str, Vec<Measured>)]) -> String {
    let mut head: Vec<String> = "set,image,ropes,curves,crossings,dice,rope_dice,missed,stray,label_px,length_px,width_px,\
                                 mask_ms,skeleton_ms,graph_ms,points_ms,extract_ms,decode_ms,edge_bias_px"
        .split(',')
        .map(str::to_owned)
        .collect();
    for kind in ["lacking", "excess"] {
        head.extend(
            Cause::ALL
                .iter()
                .map(|cause| format!("{kind}_{}_px", cause.name())),
        );
    }
    let mut table = head.join(",") + "\n";
    for (set, images) in sets {
        for image in images {
            table += &(line(set, image).join(",") + "\n");
        }
    }
    table
}

fn line(set: &str, image: &Measured) -> Vec<String> {
    let list = |values: &[f64], digits: usize| {
        let values = values.iter().map(|v| format!("{v:.digits$}"));
        values.collect::<Vec<_>>().join(" ")
    };
    let of_curves = |value: fn(&lariat_extract::Curve) -> f32| {
        list(
            &image
                .curves
                .iter()
                .map(|c| f64::from(value(c)))
                .collect::<Vec<_>>(),
            2,
        )
    };
    let mut line = vec![
        quoted(set),
        quoted(&image.name),
        image.ropes.to_string(),
        image.curves.len().to_string(),
        image.crossings.len().to_string(),
        format!("{:.6}", image.dice),
        list(&image.rope_dice, 6),
        format!("{:.7}", image.coverage.missed),
        format!("{:.7}", image.coverage.stray),
        image.area.to_string(),
        of_curves(|c| c.length_px),
        of_curves(|c| c.width_px),
    ];
    let ms = |time: Duration| format!("{:.4}", 1e3 * time.as_secs_f64());
    line.extend(image.times.steps.map(ms));
    line.extend([ms(image.times.extract()), ms(image.times.decode)]);
    let disagreement = &image.disagreement;
    line.push(format!("{:.4}", disagreement.edge_bias_px()));
    for pixels in [disagreement.lacking, disagreement.excess] {
        line.extend(pixels.map(|n| n.to_string()));
    }
    line
}

/// Returns a name as one field, quoted if necessary.
fn quoted(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::drawing::tests::curve;
    use crate::accuracy::measure::{Bench, tests::picture};

    #[test]
    fn each_line_has_a_value_under_each_head() {
        let rope = curve(&[[30.0, 50.0], [120.0, 54.0], [210.0, 50.0]], 11.0);
        let (photo, label) = picture(&[rope]);
        let mut measured = Bench::new(lariat_extract::Method::Skeleton, crate::mask::Mask::Auto)
            .unwrap()
            .extract(&photo, &label)
            .unwrap();
        measured.name = "bar".into();
        let table = table(&[("one", vec![measured.clone()]), ("two", vec![measured])]);
        let lines: Vec<Vec<&str>> = table.lines().map(|l| l.split(',').collect()).collect();
        assert_eq!(lines.len(), 3);
        assert!(lines.iter().all(|line| line.len() == lines[0].len()));
        assert_eq!(lines[2][..4], ["two", "bar", "1", "1"]);
    }

    #[test]
    fn odd_names_stay_one_field() {
        assert_eq!(quoted("a,\"b\""), "\"a,\"\"b\"\"\"");
        assert_eq!(quoted("img000"), "img000");
    }
}
