//! Parses a user's text as a control's value, or says why it is invalid.

use super::{Control, ControlKind, find, variable_name};

/// Why a control cannot be set to a value.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ControlError {
    /// The control does not exist.
    #[error("it has no control {name}. {guess}{list}")]
    Unknown {
        /// The requested name.
        name: String,
        /// `Did you mean …? `, or empty.
        guess: String,
        /// The controls that exist.
        list: String,
    },
    /// The control does not have this value.
    #[error("{name} cannot be \"{value}\": {what}")]
    Value {
        /// The control.
        name: String,
        /// The requested value.
        value: String,
        /// The possible values.
        what: String,
    },
    /// The camera refuses.
    #[error("{name} cannot be set to {value}: {why}")]
    Refused {
        /// The control.
        name: String,
        /// The requested value.
        value: String,
        /// The kernel's error, and what to do.
        why: String,
    },
}

/// Returns the control with this name, and the value that `text` stands for.
pub(super) fn meant<'a>(
    controls: &'a [Control],
    name: &str,
    text: &str,
) -> Result<(&'a Control, i64), ControlError> {
    let control = find(controls, name).ok_or_else(|| unknown(controls, name))?;
    match value(control, text.trim()) {
        Ok(value) => Ok((control, value)),
        Err(what) => Err(ControlError::Value {
            name: control.name.clone(),
            value: text.to_owned(),
            what,
        }),
    }
}

fn unknown(controls: &[Control], name: &str) -> ControlError {
    let asked = variable_name(name);
    let is_like = |control: &&Control| {
        !asked.is_empty() && (control.name.contains(&asked) || asked.contains(&control.name))
    };
    let guess = controls.iter().find(is_like).map_or(String::new(), |near| {
        format!("Did you mean {}? ", near.name)
    });
    let names: Vec<_> = controls.iter().map(|control| &control.name[..]).collect();
    ControlError::Unknown {
        name: name.to_owned(),
        guess,
        list: match names.is_empty() {
            true => "It has no controls at all".to_owned(),
            false => format!("Its controls are {}", names.join(", ")),
        },
    }
}

fn value(control: &Control, text: &str) -> Result<i64, String> {
    if control.read_only {
        return Err("it can only be read".to_owned());
    }
    match control.kind {
        ControlKind::Integer => in_range(control, text),
        ControlKind::Boolean => match &text.to_ascii_lowercase()[..] {
            "on" | "true" | "yes" | "1" => Ok(1),
            "off" | "false" | "no" | "0" => Ok(0),
            _ => Err("write on or off".to_owned()),
        },
        ControlKind::Menu | ControlKind::IntegerMenu => item(control, text),
        ControlKind::Bitmask => bits(control, text),
        // Writing any value to a button presses it.
        ControlKind::Button => Ok(1),
        ControlKind::Other => {
            Err("it is neither a number nor a choice, and lariat does not set it".to_owned())
        }
    }
}

fn in_range(control: &Control, text: &str) -> Result<i64, String> {
    let (least, most, step) = (control.minimum, control.maximum, control.step);
    let range = match step {
        1 => format!("it goes from {least} to {most}"),
        _ => format!("it goes from {least} to {most} in steps of {step}"),
    };
    let Ok(value) = text.parse::<i64>() else {
        return Err(format!("it is a whole number, and {range}"));
    };
    let is_step = value
        .checked_sub(least)
        .is_some_and(|over| over % step == 0);
    // The maximum may be off the step grid, but the camera itself reports it.
    if (least..=most).contains(&value) && (is_step || value == most) {
        Ok(value)
    } else {
        Err(range)
    }
}

fn item(control: &Control, text: &str) -> Result<i64, String> {
    let by_index = text.parse::<i64>().ok();
    let found = control
        .items
        .iter()
        .find(|(index, _)| by_index == Some(*index))
        .or_else(|| {
            let asked = variable_name(text);
            let mut named = (control.items.iter())
                .filter(|(_, name)| !asked.is_empty() && variable_name(name) == asked);
            named.next()
        });
    found.map(|(index, _)| *index).ok_or_else(|| {
        let items: Vec<_> = control
            .items
            .iter()
            .map(|(index, name)| format!("{index} ({name})"))
            .collect();
        format!("it is one of {}", items.join(", "))
    })
}

fn bits(control: &Control, text: &str) -> Result<i64, String> {
    let parsed = match text.strip_prefix("0x") {
        Some(digits) => i64::from_str_radix(digits, 16),
        None => text.parse(),
    };
    match parsed {
        Ok(value) if value & !control.maximum == 0 => Ok(value),
        _ => Err(format!(
            "it is a mask of the bits in {:#x}",
            control.maximum
        )),
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Creates a control from 10 to 100.
    pub(in crate::v4l2::controls) fn control(name: &str, kind: ControlKind) -> Control {
        Control {
            id: 1,
            name: name.to_owned(),
            kind,
            minimum: 10,
            maximum: 100,
            step: 1,
            default: 50,
            value: Some(50),
            items: Vec::new(),
            read_only: false,
            inactive: false,
            is_64_bit: false,
        }
    }

    fn set(control: &Control, text: &str) -> Result<i64, String> {
        let controls = std::slice::from_ref(control);
        match meant(controls, &control.name, text) {
            Ok((_, value)) => Ok(value),
            Err(error) => Err(error.to_string()),
        }
    }

    #[test]
    fn a_number_outside_is_answered_with_the_range() {
        let mut gain = control("gain", ControlKind::Integer);
        assert_eq!(set(&gain, " 70 "), Ok(70));
        let complaint = "gain cannot be \"101\": it goes from 10 to 100";
        assert_eq!(set(&gain, "101"), Err(complaint.to_owned()));
        assert!(set(&gain, "high").unwrap_err().contains("a whole number"));

        gain.step = 20;
        assert_eq!(set(&gain, "30"), Ok(30));
        assert_eq!(set(&gain, "100"), Ok(100));
        assert!(set(&gain, "40").unwrap_err().contains("in steps of 20"));
    }

    #[test]
    fn a_menu_takes_numbers_and_names() {
        let mut auto = control("auto_exposure", ControlKind::Menu);
        auto.items = vec![
            (1, "Manual Mode".to_owned()),
            (3, "Aperture Priority Mode".to_owned()),
        ];
        assert_eq!(set(&auto, "3"), Ok(3));
        assert_eq!(set(&auto, "manual mode"), Ok(1));
        assert_eq!(set(&auto, "Aperture_Priority-Mode"), Ok(3));
        let complaint = set(&auto, "2").unwrap_err();
        assert!(
            complaint.contains("1 (Manual Mode), 3 (Aperture Priority Mode)"),
            "{complaint}"
        );
    }

    #[test]
    fn switches_are_on_or_off() {
        let switch = control("autogain", ControlKind::Boolean);
        for (text, value) in [("on", 1), ("OFF", 0), ("true", 1), ("0", 0)] {
            assert_eq!(set(&switch, text), Ok(value));
        }
        assert!(set(&switch, "2").unwrap_err().contains("on or off"));
    }

    #[test]
    fn masks_keep_to_their_bits() {
        let mut mask = control("test_bits", ControlKind::Bitmask);
        mask.maximum = 0x80_0007;
        assert_eq!(set(&mask, "0x800001"), Ok(0x80_0001));
        assert!(set(&mask, "8").unwrap_err().contains("0x800007"));
        assert!(set(&mask, "-1").is_err());
    }

    #[test]
    fn what_can_only_be_read_is_not_set() {
        let mut gain = control("gain", ControlKind::Integer);
        gain.read_only = true;
        assert!(set(&gain, "70").unwrap_err().contains("only be read"));
    }

    #[test]
    fn an_unknown_control_is_answered_with_those_there_are() {
        let controls =
            ["gain", "exposure_time_absolute"].map(|name| control(name, ControlKind::Integer));
        let error = meant(&controls, "exposure", "1").map(|_| ()).unwrap_err();
        assert_eq!(
            error.to_string(),
            "it has no control exposure. Did you mean exposure_time_absolute? Its controls are gain, \
             exposure_time_absolute"
        );
        let error = meant(&[], "gain", "1").map(|_| ()).unwrap_err();
        assert!(error.to_string().ends_with("no controls at all"));
    }

    proptest! {
        #[test]
        fn what_is_taken_is_within_the_range(
            text in "-?[0-9]{1,20}|\\PC{0,8}", least in -50_i64..50, length in 0_i64..90, step in 1_i64..9,
        ) {
            let mut number = control("number", ControlKind::Integer);
            (number.minimum, number.maximum, number.step) = (least, least + length, step);
            if let Ok(value) = set(&number, &text) {
                prop_assert!((least..=least + length).contains(&value));
                prop_assert!((value - least) % step == 0 || value == least + length);
                prop_assert_eq!(Ok(value), text.trim().parse());
            }
        }
    }
}
