//! No text makes the reader of calibrations panic or hang, and no lens that it reads gives a ray that is not seen where it was
//! asked for.
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
            // A ray's place is known to 10⁻¹³ of the focal length and of how far from the middle it is seen; the scaled camera's
            // is at most 8192 times the calibration's.
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
