//! A clustering does not allocate once it has seen pixels of a size.

use lariat_clustering::{FuzzyMeans, KMeans, Mixture, Pixels, Run, Som, Start};
use lariat_test_support::allocations;

#[test]
fn no_clustering_allocates_once_warm() {
    // A bar that turns, and then fewer pixels than centers.
    let frames: Vec<Pixels> = (0..12u16)
        .map(|frame| {
            let mut pixels = Pixels::default();
            for y in 0..if frame == 11 { 1 } else { 180 } {
                let from = 40 + y * frame / 12;
                let to = from + 20 + frame;
                pixels.push(Run { y, from, to });
            }
            pixels
        })
        .collect();
    let mut kmeans = KMeans::default();
    let (mut som, mut mixture) = (Som::default(), Mixture::default());
    let mut fuzzy = FuzzyMeans::default();
    let mut centers = vec![[0.0; 2]; 120];
    let mut run = || {
        for pixels in &frames {
            kmeans.run(pixels, Start::Seeded(1), &mut centers);
        }
        // With all centers in one place, all but one have no pixels.
        centers.fill([100.0, 100.0]);
        for pixels in &frames {
            kmeans.run(pixels, Start::Given, &mut centers);
        }
        for pixels in [&frames[5], &frames[11], &frames[7]] {
            for start in [Start::Seeded(1), Start::Given] {
                som.run(pixels, start, &mut centers);
                mixture.run(pixels, start, &mut centers);
            }
            fuzzy.run(pixels, Start::Given, &mut centers);
        }
        fuzzy.run(&frames[11], Start::Seeded(1), &mut centers);
    };
    run();
    let before = allocations();
    run();
    assert_eq!(allocations() - before, 0);
}
