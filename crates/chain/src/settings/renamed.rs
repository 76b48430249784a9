//! Renamed settings: tells the user what to write now, and renames the settings of old recordings.

use std::borrow::Cow;
use toml::{Table, Value};

/// Settings of `[fit]` that gave a curve's order, and the settings that replace them by a number of
/// control points. A curve of order n has n + 1 control points.
const ORDERS: [(&str, &str); 2] = [
    ("order", "control_points"),
    ("max_order", "max_control_points"),
];

/// The former flag `--order`, without its dashes.
pub(super) const ORDER: &str = "order";

/// Returns what to write instead of a renamed setting: `control_points = 13`.
pub(super) fn instead(section: &str, name: &str, value: &Value) -> Option<String> {
    let now = renamed(section, name)?;
    Some(format!("{now} = {}", counted(value)))
}

/// Returns the new name of a setting of `[fit]`.
fn renamed(section: &str, name: &str) -> Option<&'static str> {
    let known = ORDERS.iter().find(|(old, _)| *old == name);
    known.filter(|_| section == "fit").map(|(_, now)| *now)
}

/// Returns why a renamed setting in the file is refused.
pub(super) fn refusal(section: &str, name: &str, value: &Value) -> Option<String> {
    let instead = instead(section, name, value)?;
    Some(format!(
        "a curve is named by its control points, one more than its order: write {instead}"
    ))
}

/// Returns why `--order` is refused.
pub(super) fn refused_flag(typed: &str) -> String {
    let value = typed
        .parse()
        .map_or_else(|_| Value::String(typed.to_owned()), Value::Integer);
    let count = match counted(&value).into_owned() {
        Value::String(word) => word,
        number => number.to_string(),
    };
    format!(
        "a curve is named by its control points, one more than its order: write --control-points {count}"
    )
}

/// Renames the settings of an old recording.
pub(crate) fn renew(settings: &mut Table) {
    let Some(fit) = settings.get_mut("fit").and_then(Value::as_table_mut) else {
        return;
    };
    for (old, now) in ORDERS {
        if let Some(value) = fit.remove(old) {
            fit.insert(now.to_owned(), counted(&value).into_owned());
        }
    }
}

/// Converts an order to a number of control points. Anything but an integer stays unchanged.
fn counted(order: &Value) -> Cow<'_, Value> {
    match order {
        Value::Integer(order) => Cow::Owned(Value::Integer(order.saturating_add(1))),
        other => Cow::Borrowed(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_renamed_setting_says_what_to_write_now() {
        let said = refusal("fit", "order", &Value::Integer(12)).unwrap();
        assert_eq!(
            said,
            "a curve is named by its control points, one more than its order: write control_points = 13"
        );
        assert!(refused_flag("12").ends_with("write --control-points 13"));
        assert!(refused_flag("auto").ends_with("write --control-points auto"));
        assert_eq!(refusal("run", "order", &Value::Integer(12)), None);
    }

    #[test]
    fn an_old_recording_s_settings_get_the_names_of_today() {
        let mut settings: Table = "[fit]\norder = \"auto\"\nmax_order = 16\nridge = 0.0\n"
            .parse()
            .unwrap();
        renew(&mut settings);
        let now = "[fit]\ncontrol_points = \"auto\"\nmax_control_points = 17\nridge = 0.0\n";
        assert_eq!(settings, now.parse().unwrap());
    }
}
