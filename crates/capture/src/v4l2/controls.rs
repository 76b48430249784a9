//! A camera's controls: which ones it has, and what their names and values mean.
//!
//! Names are those that `v4l2-ctl` shows: the driver's words in lower case, joined by `_`. Kernels
//! have renamed some controls; both names are accepted ([`RENAMED`]).

mod adjust;
mod value;

use std::fmt;

use rustix::io::Errno;

use super::device::{Device, text};
use super::sys;

#[allow(unused_imports, reason = "used by the camera as a source")]
pub(crate) use adjust::Adjusted;
pub use value::ControlError;

/// Requested settings of a camera's controls.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ControlSettings {
    /// Names and values.
    pub values: Vec<(String, String)>,
    /// True to freeze exposure, white balance, gain and focus once the picture has settled.
    pub lock: bool,
    /// True to restore all controls at the end.
    pub restore: bool,
}

/// Kind of a control's value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ControlKind {
    /// An integer in a range.
    Integer,
    /// On or off.
    Boolean,
    /// One of a few named values.
    Menu,
    /// One of a few numbers.
    IntegerMenu,
    /// A bit mask.
    Bitmask,
    /// An action without a value: setting the control triggers it.
    Button,
    /// Text, an array or a structure: shown, but not set.
    Other,
}

impl fmt::Display for ControlKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Integer => "number",
            Self::Boolean => "on/off",
            Self::Menu | Self::IntegerMenu => "menu",
            Self::Bitmask => "bits",
            Self::Button => "button",
            Self::Other => "other",
        })
    }
}

/// A control.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Control {
    /// The kernel's number of the control.
    pub id: u32,
    /// Its name as `v4l2-ctl` shows it.
    pub name: String,
    /// Kind of its value.
    pub kind: ControlKind,
    /// Smallest value.
    pub minimum: i64,
    /// Largest value.
    pub maximum: i64,
    /// Step between values, at least 1.
    pub step: i64,
    /// Value when the camera is new.
    pub default: i64,
    /// Current value; `None` without a value, or if it cannot be read.
    pub value: Option<i64>,
    /// Index and name of each item of a menu.
    pub items: Vec<(i64, String)>,
    /// True if it can never be set.
    pub read_only: bool,
    /// True if setting the control has no effect now, because another control does its work.
    pub inactive: bool,
    is_64_bit: bool,
}

/// Old and new names of the same control. Kernels since 5.13 use the new ones.
const RENAMED: [(&str, &str); 7] = [
    ("exposure_auto", "auto_exposure"),
    ("exposure_absolute", "exposure_time_absolute"),
    ("exposure_auto_priority", "exposure_dynamic_framerate"),
    ("white_balance_temperature_auto", "white_balance_automatic"),
    ("focus_auto", "focus_automatic_continuous"),
    ("hue_auto", "hue_automatic"),
    ("autogain", "gain_automatic"),
];

/// A control's name as `v4l2-ctl` shows it: letters and digits in lower case, and `_` for
/// everything between them.
fn variable_name(name: &str) -> String {
    let words = name.split(|c: char| !c.is_ascii_alphanumeric());
    let words: Vec<_> = words.filter(|word| !word.is_empty()).collect();
    words.join("_").to_ascii_lowercase()
}

/// Finds the control with this name, or with its older or newer name.
fn find<'a>(controls: &'a [Control], name: &str) -> Option<&'a Control> {
    let name = variable_name(name);
    let by = |name: &str| controls.iter().find(|control| control.name == name);
    by(&name).or_else(|| {
        let other = RENAMED.iter().find_map(|&(old, new)| match () {
            () if name == old => Some(new),
            () if name == new => Some(old),
            () => None,
        })?;
        by(other)
    })
}

/// Limit on the number of controls, in case a driver never ends its list.
const MOST: usize = 1024;

impl Device {
    /// Returns all controls with their current values.
    pub(crate) fn controls(&self) -> Vec<Control> {
        let mut controls = Vec::new();
        let mut id = 0;
        while controls.len() < MOST {
            let Some(query) = self.control_after(id) else {
                break;
            };
            // Ends the loop if a driver repeats an earlier answer.
            if query.id <= id {
                break;
            }
            id = query.id;
            if query.flags & sys::CTRL_FLAG_DISABLED == 0 && query.kind != sys::CTRL_TYPE_CLASS {
                controls.push(self.control(&query));
            }
        }
        controls
    }

    fn control_after(&self, id: u32) -> Option<sys::QueryExtendedControl> {
        let mut query = sys::QueryExtendedControl {
            id: id | sys::NEXT_CONTROL,
            ..Default::default()
        };
        match sys::query_extended_control(self, &mut query) {
            Ok(()) => return Some(query),
            Err(Errno::NOTTY) => {}
            Err(_) => return None,
        }
        // For kernels before 3.17, and drivers with an interface of their own.
        let mut query = sys::QueryControl {
            id: id | sys::NEXT_CONTROL,
            ..Default::default()
        };
        sys::query_control(self, &mut query).ok()?;
        Some(sys::QueryExtendedControl {
            id: query.id,
            kind: query.kind,
            name: query.name,
            minimum: query.minimum.into(),
            maximum: query.maximum.into(),
            step: u64::from(query.step.unsigned_abs()),
            default_value: query.default_value.into(),
            flags: query.flags,
            elems: 1,
            ..Default::default()
        })
    }

    fn control(&self, query: &sys::QueryExtendedControl) -> Control {
        let has = |flag: u32| query.flags & flag != 0;
        let kind = if has(sys::CTRL_FLAG_HAS_PAYLOAD) || query.nr_of_dims > 0 {
            ControlKind::Other
        } else {
            match query.kind {
                sys::CTRL_TYPE_INTEGER | sys::CTRL_TYPE_INTEGER64 => ControlKind::Integer,
                sys::CTRL_TYPE_BOOLEAN => ControlKind::Boolean,
                sys::CTRL_TYPE_MENU => ControlKind::Menu,
                sys::CTRL_TYPE_INTEGER_MENU => ControlKind::IntegerMenu,
                sys::CTRL_TYPE_BITMASK => ControlKind::Bitmask,
                sys::CTRL_TYPE_BUTTON => ControlKind::Button,
                _ => ControlKind::Other,
            }
        };
        let has_value = !matches!(kind, ControlKind::Button | ControlKind::Other)
            && !has(sys::CTRL_FLAG_WRITE_ONLY);
        let is_64_bit = query.kind == sys::CTRL_TYPE_INTEGER64;
        // A bit mask is unsigned but is transferred as a signed number.
        let unsigned = |value: i64| match kind {
            ControlKind::Bitmask => value & 0xffff_ffff,
            _ => value,
        };
        Control {
            id: query.id,
            name: variable_name(&text(&query.name)),
            kind,
            minimum: query.minimum,
            maximum: unsigned(query.maximum),
            step: i64::try_from(query.step).unwrap_or(i64::MAX).max(1),
            default: unsigned(query.default_value),
            value: (has_value.then(|| self.control_value(query.id, is_64_bit).ok()))
                .flatten()
                .map(unsigned),
            items: self.items(query, kind),
            read_only: has(sys::CTRL_FLAG_READ_ONLY),
            inactive: has(sys::CTRL_FLAG_INACTIVE),
            is_64_bit,
        }
    }

    fn items(&self, query: &sys::QueryExtendedControl, kind: ControlKind) -> Vec<(i64, String)> {
        if !matches!(kind, ControlKind::Menu | ControlKind::IntegerMenu) {
            return Vec::new();
        }
        let least = query.minimum.max(0);
        let most = query.maximum.min(least + MOST as i64);
        (least..=most)
            .filter_map(|index| {
                let mut item = sys::QueryMenu {
                    id: query.id,
                    index: u32::try_from(index).ok()?,
                    ..Default::default()
                };
                sys::query_menu(self, &mut item).ok()?;
                Some(match kind {
                    ControlKind::IntegerMenu => (index, item.value().to_string()),
                    _ => (index, text(&item.name)),
                })
            })
            .collect()
    }

    fn control_value(&self, id: u32, is_64_bit: bool) -> Result<i64, Errno> {
        let mut control = [sys::ExtendedControl::new(id, is_64_bit, 0)];
        match sys::get_extended_controls(self, &mut control) {
            Err(Errno::NOTTY) if !is_64_bit => {
                let mut control = sys::Control { id, value: 0 };
                sys::get_control(self, &mut control)?;
                Ok(control.value.into())
            }
            other => other.map(|()| control[0].value(is_64_bit)),
        }
    }

    fn set_control_value(&self, id: u32, is_64_bit: bool, value: i64) -> Result<(), Errno> {
        let mut control = [sys::ExtendedControl::new(id, is_64_bit, value)];
        match sys::set_extended_controls(self, &mut control) {
            Err(Errno::NOTTY) if !is_64_bit => {
                let value = value as i32;
                sys::set_control(self, &mut sys::Control { id, value })
            }
            other => other,
        }
    }

    /// Exposure time of a frame in ns, if the camera reports it.
    pub(crate) fn exposure_ns(&self) -> Option<u64> {
        // In units of 100 µs.
        let units = self.control_value(sys::CID_EXPOSURE_ABSOLUTE, false).ok()?;
        u64::try_from(units).ok().map(|units| units * 100_000)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::v4l2::controls::value::tests::control;

    #[test]
    fn names_are_those_of_v4l2_ctl() {
        for (words, name) in [
            ("White Balance, Automatic", "white_balance_automatic"),
            ("Exposure Time, Absolute", "exposure_time_absolute"),
            ("Exposure, Auto", "exposure_auto"),
            ("LED1 Mode", "led1_mode"),
            ("  Pan (Absolute) ", "pan_absolute"),
            ("Inject V4L2_BUF_FLAG_ERROR", "inject_v4l2_buf_flag_error"),
        ] {
            assert_eq!(variable_name(words), name);
        }
    }

    #[test]
    fn a_renamed_control_is_found_by_either_name() {
        for (old, new) in RENAMED {
            for (has, asked) in [(old, new), (new, old), (old, old), (new, new)] {
                let controls = [control(has, ControlKind::Integer)];
                let found = find(&controls, asked).map(|control| &control.name[..]);
                assert_eq!(found, Some(has), "{asked}");
            }
        }
        assert!(find(&[control("gain", ControlKind::Integer)], "exposure").is_none());
    }
}
