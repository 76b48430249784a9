//! Settings that had another name: what to write now, and old recordings' settings under the names of today.

use std::borrow::Cow;
use toml::{Table, Value};

/// Settings of `[fit]` that named a curve by its order, each with the one that counts control points. A curve of order n has
/// n + 1 control points.
const ORDERS: [(&str, &str); 2] = [
    ("order", "control_points"),
    ("max_order", "max_control_points"),
];

/// The flag that was `--order`, without its dashes.
pub(super) const ORDER: &str = "order";

/// What a settings file has instead of a setting that has been renamed: `control_points = 13`.
pub(super) fn instead(section: &str, name: &str, value: &Value) -> Option<String> {
    let now = renamed(section, name)?;
    Some(format!("{now} = {}", counted(value)))
}

/// The name that a setting of `[fit]` has now.
fn renamed(section: &str, name: &str) -> Option<&'static str> {
    let known = ORDERS.iter().find(|(old, _)| *old == name);
    known.filter(|_| section == "fit").map(|(_, now)| *now)
}

/// Why a renamed setting of the file is refused.
pub(super) fn refusal(section: &str, name: &str, value: &Value) -> Option<String> {
    let instead = instead(section, name, value)?;
    Some(format!(
        "a curve is named by its control points, one more than its order: write {instead}"
    ))
}

/// Why `--order` is refused.
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

/// Gives the settings of an old recording the names of today.
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

/// An order as a number of control points. What is not a number stays as it is.
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
