//! The reader of calibrations neither panics nor hangs on any text. With any lens that it accepts,
//! the ray of a pixel projects back to that pixel.
#![no_main]

use lariat_camera::{Camera, Mapping};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let Ok(camera) = Camera::from_yaml(text) else {
        return;
    };
    for size in [[640, 480], [1280, 720]] {
        let Ok(mapping) = Mapping::new(Some(&camera), None, size) else {
            continue;
        };
        let [right, bottom] = size.map(|side| f64::from(side - 1));
        for pixel in [
            [0.0, 0.0],
            [0.5 * right, 0.5 * bottom],
            [right, bottom],
            [0.3 * right, bottom],
        ] {
            let Ok(ideal) = mapping.place(pixel) else {
                continue;
            };
            assert!(ideal.point.iter().all(|c| c.is_finite()));
            let seen = mapping
                .pixel(ideal.point)
                .expect("a place that a pixel has is seen");
            let away = (seen[0] - pixel[0]).hypot(seen[1] - pixel[1]);
            let focal = camera.focal_px().into_iter().fold(1.0, f64::max);
            // The position of a ray is known to 10⁻¹³ of the focal length and of its distance from
            // the middle. The scaled camera is at most 8192 times as large as the calibration's.
            let reach = focal
                + camera
                    .center_px()
                    .into_iter()
                    .fold(right, |most, c| most.max(c.abs()));
            assert!(
                away < 1e-7 * reach.max(1.0),
                "{pixel:?} comes back as {seen:?}"
            );
        }
    }
});
