//! Sets controls as requested, freezes them, and restores them.

use rustix::io::Errno;

use super::value::{ControlError, meant};
use super::{Control, ControlSettings};
use crate::v4l2::device::Device;
use crate::v4l2::error::CameraError;
use crate::v4l2::sys;

/// A control that automates others: the value that switches it off, and the controls that it sets.
struct Automatic {
    id: u32,
    off: i64,
    steers: &'static [u32],
}

const GAIN: u32 = sys::CID_GAIN;
const WHITE_BALANCE_TEMPERATURE: u32 = 0x0098_091a;
const RED_BALANCE: u32 = 0x0098_090e;
const BLUE_BALANCE: u32 = 0x0098_090f;
const BRIGHTNESS: u32 = 0x0098_0900;
const HUE: u32 = 0x0098_0903;
const FOCUS_ABSOLUTE: u32 = 0x009a_090a;
const ISO_SENSITIVITY: u32 = 0x009a_0917;

/// `V4L2_EXPOSURE_MANUAL`.
const EXPOSURE_MANUAL: i64 = 1;

/// All controls that automate a picture's exposure, white balance, gain and focus.
const AUTOMATIC: [Automatic; 9] = [
    Automatic {
        id: sys::CID_EXPOSURE_AUTO,
        off: EXPOSURE_MANUAL,
        // Automatic exposure also changes the gain, which may lack a switch of its own.
        steers: &[sys::CID_EXPOSURE_ABSOLUTE, sys::CID_EXPOSURE, GAIN],
    },
    Automatic {
        id: sys::CID_EXPOSURE_AUTO_PRIORITY,
        off: 0,
        steers: &[],
    },
    Automatic {
        id: sys::CID_AUTOGAIN,
        off: 0,
        steers: &[GAIN],
    },
    Automatic {
        id: sys::CID_ISO_SENSITIVITY_AUTO,
        off: 0,
        steers: &[ISO_SENSITIVITY],
    },
    Automatic {
        id: sys::CID_AUTO_WHITE_BALANCE,
        off: 0,
        steers: &[WHITE_BALANCE_TEMPERATURE, RED_BALANCE, BLUE_BALANCE],
    },
    Automatic {
        id: sys::CID_AUTO_N_PRESET_WHITE_BALANCE,
        off: 0,
        steers: &[RED_BALANCE, BLUE_BALANCE],
    },
    Automatic {
        id: sys::CID_HUE_AUTO,
        off: 0,
        steers: &[HUE],
    },
    Automatic {
        id: sys::CID_AUTOBRIGHTNESS,
        off: 0,
        steers: &[BRIGHTNESS],
    },
    Automatic {
        id: sys::CID_FOCUS_AUTO,
        off: 0,
        steers: &[FOCUS_ABSOLUTE],
    },
];

/// A control and the value that it was set to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Set {
    id: u32,
    is_64_bit: bool,
    value: i64,
}

/// The changes to a camera's controls, which can be repeated (after it was unplugged) or undone.
#[derive(Debug, Clone, Default)]
pub(crate) struct Adjusted {
    /// Changes in the order in which they were made.
    done: Vec<Set>,
    /// Earlier values, in the same order.
    before: Vec<Set>,
    restore: bool,
}

impl Adjusted {
    /// Sets the requested controls. Those that automate others come first: a camera with automatic
    /// exposure accepts no exposure time.
    ///
    /// # Errors
    /// The control does not exist, does not have the value, or the camera refuses it. Earlier
    /// changes are then undone if that was requested.
    pub(crate) fn new(device: &Device, settings: &ControlSettings) -> Result<Self, CameraError> {
        let mut adjusted = Self {
            restore: settings.restore,
            ..Self::default()
        };
        if settings.values.is_empty() {
            return Ok(adjusted);
        }
        let outcome = adjusted.set_all(device, &settings.values);
        outcome.map_err(|why| {
            adjusted.restore(device);
            CameraError::Control {
                path: device.path().to_owned(),
                why,
            }
        })?;
        Ok(adjusted)
    }

    fn set_all(
        &mut self,
        device: &Device,
        values: &[(String, String)],
    ) -> Result<(), ControlError> {
        let controls = device.controls();
        let mut wanted = Vec::with_capacity(values.len());
        for (name, text) in values {
            let (control, value) = meant(&controls, name, text)?;
            wanted.push((control, value, text));
        }
        wanted.sort_by_key(|(control, ..)| !is_automatic(control.id));
        for (control, value, text) in wanted {
            self.set(device, control, value)
                .map_err(|errno| ControlError::Refused {
                    name: control.name.clone(),
                    value: text.clone(),
                    why: reason(errno),
                })?;
        }
        Ok(())
    }

    /// Freezes exposure, white balance, gain and focus at their current values. Returns a sentence
    /// that names them. Controls that the camera lacks, or that cannot be set, stay unchanged.
    pub(crate) fn lock(&mut self, device: &Device) -> String {
        let controls = device.controls();
        let by_id = |id: u32| {
            let settable = |control: &&Control| control.id == id && !control.read_only;
            controls.iter().find(settable)
        };
        let mut frozen = Vec::new();
        for automatic in &AUTOMATIC {
            let is_on =
                |control: &&Control| control.value.is_some_and(|value| value != automatic.off);
            let Some(switch) = by_id(automatic.id).filter(is_on) else {
                continue;
            };
            if self.set(device, switch, automatic.off).is_err() {
                continue;
            }
            let held: Vec<_> = automatic
                .steers
                .iter()
                .filter_map(|&id| by_id(id))
                // Uses the value from before automation was switched off, because some cameras then
                // jump to another value.
                .filter_map(|control| Some((control, control.value?)))
                .filter(|(control, value)| self.set(device, control, *value).is_ok())
                .map(|(control, value)| format!("{} at {value}", control.name))
                .collect();
            match held.is_empty() {
                true => frozen.push(format!("{} off", switch.name)),
                false => frozen.extend(held),
            }
        }
        if let Some(lock) = by_id(sys::CID_3A_LOCK)
            && self.set(device, lock, lock.maximum).is_ok()
        {
            frozen.push("all three automatics locked".to_owned());
        }
        frozen.dedup();
        match frozen.is_empty() {
            true => format!(
                "{} moves neither exposure nor white balance, gain or focus by itself: there is nothing to lock",
                device.path().display()
            ),
            false => format!(
                "{} is locked: {}",
                device.path().display(),
                frozen.join(", ")
            ),
        }
    }

    fn set(&mut self, device: &Device, control: &Control, value: i64) -> Result<(), Errno> {
        device.set_control_value(control.id, control.is_64_bit, value)?;
        let set = |value| Set {
            id: control.id,
            is_64_bit: control.is_64_bit,
            value,
        };
        self.done.push(set(value));
        // If a control is set twice, its value before the first change counts.
        if let Some(before) = control.value
            && !self.before.iter().any(|set| set.id == control.id)
        {
            self.before.push(set(before));
        }
        Ok(())
    }

    /// Repeats all changes on the same camera, which loses them when it is unplugged. Skips those
    /// that it now refuses, and returns their number.
    pub(crate) fn again(&self, device: &Device) -> usize {
        let refused = |set: &&Set| {
            device
                .set_control_value(set.id, set.is_64_bit, set.value)
                .is_err()
        };
        self.done.iter().filter(refused).count()
    }

    /// Restores the earlier values if requested, the last change first, so that controls are
    /// restored while their automation is off.
    pub(crate) fn restore(&self, device: &Device) {
        if !self.restore {
            return;
        }
        for set in self.before.iter().rev() {
            // A camera that was unplugged has nothing to restore.
            let _ = device.set_control_value(set.id, set.is_64_bit, set.value);
        }
    }
}

fn is_automatic(id: u32) -> bool {
    AUTOMATIC.iter().any(|automatic| automatic.id == id)
}

fn reason(errno: Errno) -> String {
    match errno {
        Errno::BUSY => {
            "another program uses it, or it cannot be changed while pictures are taken".to_owned()
        }
        Errno::ACCESS | Errno::PERM => "it can only be read".to_owned(),
        // USB cameras return these for an exposure time while exposure is automatic.
        Errno::IO | Errno::INVAL | Errno::RANGE => format!(
            "the camera refuses ({}); if another control sets it by itself, switch that off first (exposure_auto=1, \
             white_balance_automatic=off, focus_auto=off)",
            std::io::Error::from(errno)
        ),
        errno => std::io::Error::from(errno).to_string(),
    }
}
