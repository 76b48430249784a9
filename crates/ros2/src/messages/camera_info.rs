//! `sensor_msgs/CameraInfo`.

use lariat_camera::Camera;
use lariat_record::{Cdr, Encoder};
use lariat_wire::FrameHeader;

use super::Header;

/// Writes the size of the images and the calibration of their camera. Without a calibration, or
/// with one for other images, `K` is 0, which means uncalibrated in ROS.
pub(crate) fn camera_info(
    frame: &FrameHeader,
    camera: Option<&Camera>,
    header: &Header,
    into: &mut Vec<u8>,
) {
    let to = &mut Encoder::new(into);
    header.put(to);
    frame.height.put(to);
    frame.width.put(to);
    let camera = camera.and_then(|camera| camera.scaled_to([frame.width, frame.height]).ok());
    let (mut k, mut r, mut p) = ([0.0_f64; 9], [0.0_f64; 9], [0.0_f64; 12]);
    match camera {
        None => {
            to.string("");
            to.byte_count(0);
        }
        Some(camera) => {
            let ([fx, fy], [cx, cy]) = (camera.focal_px(), camera.center_px());
            // A single camera without rotation: the same matrix describes its undistorted image.
            k = [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0];
            r = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
            p = [fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0];
            let (model, coefficients) = camera.lens().model();
            to.string(model);
            to.byte_count(coefficients.len());
            coefficients.iter().for_each(|c| c.put(to));
        }
    }
    k.put(to);
    r.put(to);
    p.put(to);
    // Binning, then the whole image as region, not rectified.
    [0_u32; 6].put(to);
    0_u8.put(to);
}
