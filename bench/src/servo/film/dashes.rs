//! Dashed lines.

/// Splits a line into dashes of length `on_px` with gaps of `off_px`.
pub(super) fn dashes(line: &[[f64; 2]], [on_px, off_px]: [f64; 2]) -> Vec<Vec<[f64; 2]>> {
    let mut all = Vec::new();
    let mut dash: Vec<[f64; 2]> = line.first().copied().into_iter().collect();
    let (mut is_on, mut left) = (true, on_px);
    for ends in line.windows(2) {
        let (a, b) = (ends[0], ends[1]);
        let length = ((b[0] - a[0]).powi(2) + (b[1] - a[1]).powi(2)).sqrt();
        let mut done = 0.0;
        while length - done > left {
            done += left;
            let p = [0, 1].map(|k| a[k] + done / length * (b[k] - a[k]));
            if is_on {
                dash.push(p);
                all.push(std::mem::take(&mut dash));
            } else {
                dash = vec![p];
            }
            is_on = !is_on;
            left = if is_on { on_px } else { off_px };
        }
        left -= length - done;
        if is_on {
            dash.push(b);
        }
    }
    if dash.len() > 1 {
        all.push(dash);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dashes_are_as_long_as_they_should_be() {
        let line = [[0.0, 0.0], [7.0, 0.0], [7.0, 20.0]];
        let pieces = dashes(&line, [6.0, 4.0]);
        assert_eq!(pieces[0], [[0.0, 0.0], [6.0, 0.0]]);
        assert_eq!(pieces[1], [[7.0, 3.0], [7.0, 9.0]]);
        assert_eq!(pieces.len(), 3);
        assert_eq!(pieces[2], [[7.0, 13.0], [7.0, 19.0]]);
        assert!(dashes(&[], [6.0, 4.0]).is_empty());
    }
}
