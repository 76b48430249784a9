//! The recording in `tests/recordings`, which `tests/replay` checks.

use super::Making;
use lariat_capture::RenderOptions;
use lariat_record::Compression;
use std::path::Path;

/// A rope that crosses itself, filtered and without noise. The table is the same in all frames, so
/// zstd compresses it well.
#[test]
#[ignore = "it renews tests/recordings/rope.mcap, for when results are meant to change"]
fn renew_the_golden_recording() {
    let made = Making {
        settings: "[extract]\npoints = 60\n\n[fit]\ncontrol_points = 9\nfilter = true\n",
        compression: Compression::Zstd,
        render: RenderOptions {
            width: 144,
            height: 108,
            rope_px: 5.0,
            noise: 0.0,
            frame_interval_s: 0.24,
            truth_points: 60,
            frames: Some(43),
            ..RenderOptions::default()
        },
        ..Making::default()
    };
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/recordings/rope.mcap");
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    made.make_at(&path);
}
