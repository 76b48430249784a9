//! Once warm, recording a frame and its results does not allocate in the thread that reads
//! channels.
use lariat_test_support::allocations;

use super::tests::{centerlines, drain_waiting, head, header, options};
use super::*;

#[test]
fn a_frame_allocates_nothing_once_warm() {
    let (intake, outlet) = queue(16 << 20, 1 << 20);
    let thread = std::thread::spawn(|| Ending {
        written: Written::default(),
        fault: None,
    });
    let mut recorder = Recorder::new(intake, thread, &head(), options(16 << 20, false));
    let pixels = vec![0; 512 * 400];
    let shapes = Box::new(Descriptors::EMPTY);
    let before_any = allocations();
    let mut warm = 0;
    for count in 1..=60 {
        let (seen, truth) = (centerlines(count), centerlines(count));
        if count == 11 {
            warm = allocations();
        }
        let own = allocations();
        recorder.frame(&header(count), &pixels).unwrap();
        recorder.mask(&header(count), &pixels).unwrap();
        recorder.centerlines(&seen).unwrap();
        recorder.truth(&truth).unwrap();
        recorder.descriptors(&shapes, Some).unwrap();
        recorder.losses(&Losses::default()).unwrap();
        // Up to three frames wait in the queue.
        if count % 3 == 0 {
            drain_waiting(&outlet);
        }
        if count > 10 {
            assert_eq!(allocations(), own, "frame {count}");
        }
    }
    assert!(warm > before_any, "nothing is counted");
    assert_eq!(recorder.drops(), Drops::default());
}
