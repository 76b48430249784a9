//! Control polygons that Foxglove draws over the image.

use lariat_record::Decoder;
use lariat_wire::Centerlines;

/// Points of each line and of its markers, in lariat's pixels.
fn polygons(cdr: &[u8]) -> Vec<Vec<[f64; 2]>> {
    let mut from = Decoder::new(cdr).expect("a message");
    assert_eq!(from.value::<u32>(), Ok(0), "circles");
    let count: u32 = from.value().expect("a count");
    let polygon = |_| {
        from.value::<[u32; 2]>().expect("a time");
        from.value::<u8>().expect("a kind");
        let count: u32 = from.value().expect("a count");
        let point = |_| from.value::<[f64; 2]>().expect("a point");
        let points: Vec<_> = (0..count).map(point).collect();
        from.value::<[f64; 4]>().expect("a color");
        assert_eq!(from.value::<u32>(), Ok(0), "colors of segments");
        from.value::<[f64; 5]>().expect("a color and a thickness");
        points.iter().map(|p| p.map(|c| c - 0.5)).collect()
    };
    (0..count).map(polygon).collect()
}

/// Checks that each rope's polygon exists, and begins and ends where its centerline does.
pub(crate) fn assert_polygons_end_where_ropes_do(cdr: &[u8], seen: &Centerlines) {
    let polygons = polygons(cdr);
    assert!(!polygons.is_empty());
    assert_eq!(polygons.len(), 2 * seen.curves().len());
    for (polygon, rope) in polygons.chunks(2).zip(seen.curves()) {
        let ends = |points: &[[f64; 2]]| [points[0], points[points.len() - 1]];
        let line: Vec<_> = rope.points().iter().map(|p| p.map(f64::from)).collect();
        for points in polygon {
            for ([x, y], [u, v]) in ends(points).into_iter().zip(ends(&line)) {
                assert!((x - u).hypot(y - v) < 8.0, "{polygon:?}: {:?}", ends(&line));
            }
        }
    }
}
