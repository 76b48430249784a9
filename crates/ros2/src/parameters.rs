//! The chain's settings as the node's parameters: `ros2 param set` does the same as `lariat set`.
//!
//! The chain knows the current settings. It accepts or refuses a client's change, and changes made
//! elsewhere are polled. A setting without a value is not a parameter.
//!
//! Only settings that the chain can change between two frames are parameters. RustDDS 0.15 cannot
//! send a service response larger than a datagram, and a response with the values of all settings
//! would be larger. (For a message in fragments it writes the response's address with a byte too
//! many: an `Option` instead of its contents.)

use std::collections::BTreeMap;
use std::thread;

use anyhow::{Context, Result, bail, ensure};
use lariat_chain::control::{Asked, ask};
use lariat_chain::settings::version_of;
use lariat_wire::{Rig, members};
use ros2_client::{NodeOptions, ParameterValue};
use toml::{Table, Value};

use crate::graph::Graph;

/// The sections that can change between two frames.
const SECTIONS: [&str; 3] = ["extract", "fit", "camera"];
/// Interval at which changes made elsewhere are polled.
const LOOK_NS: u64 = 5_000_000_000;

/// Makes a client's parameters the chain's settings. The calling thread already knows the current
/// settings, so parameters that it sets itself are not sent to the chain.
pub(crate) fn options(rig: &Rig) -> NodeOptions {
    let (rig, own) = (rig.clone(), thread::current().id());
    NodeOptions::new()
        // The log goes to standard error, and each writer of RustDDS causes wakeups.
        .enable_rosout(false)
        // The chain knows the parameters and their types.
        .allow_undeclared_parameters(true)
        .parameter_set_action(Box::new(move |name, value| {
            if thread::current().id() == own {
                return Ok(());
            }
            set(&rig, name, value).map_err(|cause| format!("{cause:#}"))
        }))
}

/// Changes a setting of the chain.
fn set(rig: &Rig, name: &str, value: &ParameterValue) -> Result<()> {
    let section = name.split_once('.').map_or(name, |(section, _)| section);
    ensure!(
        SECTIONS.contains(&section),
        "the node's parameters are the settings of extract, fit and camera: `lariat set` changes others"
    );
    let change = format!("{name}={}", text(value)?);
    ensure!(
        !change.contains(char::is_control),
        "a setting is one line, such as fit.control_points=7"
    );
    ask(rig.as_str(), &Asked::Set(vec![change]))?;
    Ok(())
}

/// The state at the last update of the node's parameters.
#[derive(Default)]
pub(crate) struct Parameters {
    /// Process ID of fit, and the version of its settings.
    known: Option<(u32, u32)>,
    due_ns: u64,
}

impl Parameters {
    /// Updates the parameters if the current settings have changed.
    pub(crate) fn look(&mut self, rig: &Rig, graph: &Graph, now_ns: u64) {
        if now_ns < self.due_ns {
            return;
        }
        self.due_ns = now_ns + LOOK_NS;
        let members = members().unwrap_or_default();
        let mut stages = members.iter().filter(|stage| stage.rig == rig.as_str());
        let fit = stages.find(|stage| stage.stage == "fit");
        let newest = fit.map(|fit| (fit.pid, version_of(&fit.settings)));
        if newest.is_none() || newest == self.known {
            return;
        }
        // A stage started by hand runs without a chain to ask; a chain that is starting is asked
        // later.
        if let Ok(settings) = holding(rig) {
            graph.set_parameters(settings);
            self.known = newest;
        }
    }
}

/// The current settings, by the names of their parameters.
fn holding(rig: &Rig) -> Result<BTreeMap<String, ParameterValue>> {
    let settings: Table = ask(rig.as_str(), &Asked::Settings)?
        .parse()
        .context("the chain's settings are not TOML")?;
    let of = |section: &'static str| {
        let values = settings.get(section).and_then(Value::as_table);
        let values = values.into_iter().flatten();
        values.map(move |(name, value)| (format!("{section}.{name}"), parameter(value)))
    };
    Ok(SECTIONS.into_iter().flat_map(of).collect())
}

/// Converts a value of the settings file to a parameter. Types that ROS lacks become strings.
fn parameter(value: &Value) -> ParameterValue {
    fn all<T>(values: &[Value], of: impl Fn(&Value) -> Option<T>) -> Option<Vec<T>> {
        let values: Option<Vec<T>> = values.iter().map(of).collect();
        values.filter(|values| !values.is_empty())
    }
    let text = || ParameterValue::String(value.to_string());
    match value {
        Value::Boolean(is_so) => ParameterValue::Boolean(*is_so),
        Value::Integer(number) => ParameterValue::Integer(*number),
        Value::Float(number) => ParameterValue::Double(*number),
        Value::String(text) => ParameterValue::String(text.clone()),
        Value::Array(values) => {
            let whole = all(values, Value::as_integer).map(ParameterValue::IntegerArray);
            let real = || all(values, Value::as_float).map(ParameterValue::DoubleArray);
            whole.or_else(real).unwrap_or_else(text)
        }
        Value::Table(_) | Value::Datetime(_) => text(),
    }
}

/// Formats a parameter for `lariat set`.
///
/// # Errors
/// No setting has this type.
fn text(value: &ParameterValue) -> Result<String> {
    Ok(match value {
        ParameterValue::Boolean(is_so) => is_so.to_string(),
        ParameterValue::Integer(number) => number.to_string(),
        // With a decimal point, even for a whole number.
        ParameterValue::Double(number) => format!("{number:?}"),
        ParameterValue::String(text) => text.clone(),
        ParameterValue::IntegerArray(numbers) => format!("{numbers:?}"),
        ParameterValue::DoubleArray(numbers) => format!("{numbers:?}"),
        ParameterValue::NotSet => bail!("a setting is not deleted: give it another value"),
        ParameterValue::BooleanArray(_)
        | ParameterValue::ByteArray(_)
        | ParameterValue::StringArray(_) => {
            bail!("no setting is of this type: give it as lariat.toml has it, as a text")
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_setting_is_a_parameter_of_its_own_type_and_comes_back_as_it_is_written() {
        let table: Table = "a = true\nb = 6\nc = 1.0\nd = \"auto\"\ne = [1, 2]\nf = [0.5, 2.0]\ng = [{ h = [1, 2] }]\ni = []"
            .parse()
            .expect("TOML");
        let types = [1, 2, 3, 4, 7, 8, 4, 4];
        for ((name, value), expected) in table.iter().zip(types) {
            let made = parameter(value);
            assert_eq!(made.to_parameter_type() as u8, expected, "{name}");
            let written = text(&made).expect("a type of settings");
            let plain = value
                .as_str()
                .map_or_else(|| value.to_string(), str::to_owned);
            assert_eq!(written.replace(' ', ""), plain.replace(' ', ""), "{name}");
        }
        assert!(text(&ParameterValue::NotSet).is_err());
    }
}
