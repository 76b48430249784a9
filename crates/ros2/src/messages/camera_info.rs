//! `sensor_msgs/CameraInfo`.

use lariat_record::{Cdr, Encoder};
use lariat_wire::FrameHeader;

use super::Header;

/// Writes the size of the pictures. `K` is 0, which is ROS's word for a camera that is not calibrated.
pub(crate) fn camera_info(frame: &FrameHeader, header: &Header, into: &mut Vec<u8>) {
    let to = &mut Encoder::new(into);
    header.put(to);
    frame.height.put(to);
    frame.width.put(to);
    to.string("");
    to.byte_count(0);
    let (k, r, p) = ([0.0_f64; 9], [0.0_f64; 9], [0.0_f64; 12]);
    k.put(to);
    r.put(to);
    p.put(to);
    // Binning, then a region that is all of it, and is not rectified.
    [0_u32; 6].put(to);
    0_u8.put(to);
}
