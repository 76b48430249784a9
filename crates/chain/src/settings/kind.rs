//! The kinds of settings: how they are read and shown, and which argument their flag takes.

use crate::settings::meaning::{self, nearest, number, number_value};
use crate::settings::{camera, duration, recording};
use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::time::Duration;
use toml::Value;

/// A kind of setting.
pub(super) trait Kind {
    /// The type of the value.
    type Of;

    /// Reads a value from the file or a flag. The error is a sentence that says what to write.
    fn read(&self, value: &Value) -> Result<Self::Of, String>;

    /// Returns the value as in the file, or `None` if it is not set.
    fn shown(&self, of: &Self::Of) -> Option<Value>;

    /// Returns the kind of argument that the flag takes.
    fn takes(&self) -> Takes;

    /// Returns a value to show if the setting is unset by default.
    fn example(&self) -> &'static str {
        ""
    }

    /// Applies a value, or returns why it is invalid.
    fn set(&self, to: &mut Self::Of, value: &Value) -> Result<(), String> {
        *to = self.read(value)?;
        Ok(())
    }
}

/// A whole number in this range.
pub(super) struct Whole<T>(pub(super) RangeInclusive<T>);

impl<T: Copy + TryFrom<i64> + TryInto<i64>> Kind for Whole<T> {
    type Of = T;

    fn read(&self, value: &Value) -> Result<T, String> {
        let [low, high] = [self.0.start(), self.0.end()].map(|end| integer(*end));
        let number = meaning::whole(value, low, high)?;
        T::try_from(number).map_err(|_| format!("{number} is too large"))
    }

    fn shown(&self, of: &T) -> Option<Value> {
        Some(Value::Integer(integer(*of)))
    }

    fn takes(&self) -> Takes {
        Takes::Whole
    }
}

/// Converts to TOML's integer type, whose range is smaller than that of `u64`.
fn integer(number: impl TryInto<i64>) -> i64 {
    number.try_into().unwrap_or(i64::MAX)
}

/// A number in this range.
pub(super) struct Between(pub(super) RangeInclusive<f64>);

impl Kind for Between {
    type Of = f64;

    fn read(&self, value: &Value) -> Result<f64, String> {
        number(value).filter(|x| self.0.contains(x)).ok_or_else(|| {
            let [low, high] = [self.0.start(), self.0.end()].map(|x| number_value(*x));
            format!("choose a number from {low} to {high}")
        })
    }

    fn shown(&self, of: &f64) -> Option<Value> {
        Some(number_value(*of))
    }

    fn takes(&self) -> Takes {
        Takes::Number
    }
}

/// A duration. The fields are the name of the unit in the file, and the number of units in a
/// second.
pub(super) struct Time(&'static str, f64);

pub(super) const SECONDS: Time = Time("seconds", 1.0);
pub(super) const MICROSECONDS: Time = Time("microseconds", 1e6);

impl Kind for Time {
    type Of = Duration;

    fn read(&self, value: &Value) -> Result<Duration, String> {
        meaning::time(value, 1.0 / self.1, self.0)
    }

    fn shown(&self, of: &Duration) -> Option<Value> {
        Some(number_value(of.as_nanos() as f64 / (1e9 / self.1)))
    }

    fn takes(&self) -> Takes {
        Takes::Time(self.1)
    }
}

/// One of several named values. The first field is the plural that names them together.
pub(super) struct Named<T: 'static>(
    pub(super) &'static str,
    pub(super) &'static [(&'static str, T)],
);

impl<T: Copy + PartialEq> Kind for Named<T> {
    type Of = T;

    fn read(&self, value: &Value) -> Result<T, String> {
        let Self(kind, table) = self;
        let given = value.as_str().unwrap_or_default();
        if let Some((_, meant)) = table.iter().find(|(name, _)| *name == given) {
            return Ok(*meant);
        }
        let names = table.iter().map(|(name, _)| *name);
        let guess = nearest(given, names.clone())
            .map_or(String::new(), |near| format!("Did you mean \"{near}\"? "));
        let quoted: Vec<_> = names.map(|name| format!("\"{name}\"")).collect();
        let (last, others) = quoted.split_last().expect("a list of names is not empty");
        let others = others.join(", ");
        Err(format!("{guess}The {kind} are {others} and {last}"))
    }

    fn shown(&self, of: &T) -> Option<Value> {
        let (name, _) = self.1.iter().find(|(_, other)| other == of)?;
        Some(Value::String((*name).to_owned()))
    }

    fn takes(&self) -> Takes {
        Takes::Name(self.1.iter().map(|(name, _)| *name).collect())
    }
}

/// Names of a camera's controls and their values. A later value replaces an earlier one of the same
/// control.
pub(super) struct Controls;

impl Kind for Controls {
    type Of = BTreeMap<String, String>;

    fn read(&self, value: &Value) -> Result<Self::Of, String> {
        camera::controls(value)
    }

    fn shown(&self, of: &Self::Of) -> Option<Value> {
        camera::controls_value(of)
    }

    fn takes(&self) -> Takes {
        Takes::Control
    }

    fn example(&self) -> &'static str {
        "{ auto_exposure = 1, exposure_time_absolute = 50 }"
    }

    fn set(&self, to: &mut Self::Of, value: &Value) -> Result<(), String> {
        to.extend(self.read(value)?);
        Ok(())
    }
}

/// A setting that may be unset, with an example.
pub(super) struct Maybe<K>(pub(super) &'static str, pub(super) K);

impl<K: Kind> Kind for Maybe<K> {
    type Of = Option<K::Of>;

    fn read(&self, value: &Value) -> Result<Self::Of, String> {
        self.1.read(value).map(Some)
    }

    fn shown(&self, of: &Self::Of) -> Option<Value> {
        self.1.shown(of.as_ref()?)
    }

    fn takes(&self) -> Takes {
        self.1.takes()
    }

    fn example(&self) -> &'static str {
        self.0
    }
}

/// A setting with its own functions to read and show it, and the kind of argument that its flag
/// takes.
pub(super) struct By<T>(
    pub(super) fn(&Value) -> Result<T, String>,
    pub(super) fn(&T) -> Value,
    pub(super) Takes,
);

/// A boolean.
pub(super) const SWITCH: By<bool> = By(
    |value| {
        let yes = value.as_bool();
        yes.ok_or_else(|| "write true or false, without quotes".to_owned())
    },
    |yes| Value::Boolean(*yes),
    Takes::Nothing,
);

/// Any text.
pub(super) const TEXT: By<String> = By(
    |value| meaning::text(value).map(str::to_owned),
    |text| Value::String(text.clone()),
    Takes::Text,
);

/// A file or a folder.
pub(super) const PATH: By<PathBuf> = By(
    |value| meaning::text(value).map(PathBuf::from),
    |path| meaning::path_value(path),
    Takes::Text,
);

/// A number of at least 0.
pub(super) const AT_LEAST_0: By<f64> = By(
    |value| {
        let number = number(value).filter(|x| *x >= 0.0 && x.is_finite());
        number.ok_or_else(|| "choose a number of at least 0".to_owned())
    },
    |x| number_value(*x),
    Takes::Number,
);

/// A number above 0.
pub(super) const ABOVE_0: By<f64> = By(
    |value| {
        let number = number(value).filter(|x| *x > 0.0 && x.is_finite());
        number.ok_or_else(|| "choose a number above 0".to_owned())
    },
    |x| number_value(*x),
    Takes::Number,
);

/// A number of bytes, written in MB in the file.
pub(super) const MEGABYTES: By<usize> = By(
    recording::megabytes,
    |bytes| recording::megabytes_value(*bytes),
    Takes::Size,
);

impl<T> Kind for By<T> {
    type Of = T;

    fn read(&self, value: &Value) -> Result<T, String> {
        (self.0)(value)
    }

    fn shown(&self, of: &T) -> Option<Value> {
        Some((self.1)(of))
    }

    fn takes(&self) -> Takes {
        self.2.clone()
    }
}

/// The argument of a flag.
#[derive(Clone)]
pub(super) enum Takes {
    /// None: the flag switches its setting on.
    Nothing,
    Text,
    /// One of a few names.
    Name(Vec<&'static str>),
    /// A whole number, or a word that the setting accepts.
    Whole,
    /// A number, or a word that the setting accepts.
    Number,
    /// Several numbers, separated by commas.
    Numbers,
    /// Positions `X,Y`, separated by commas or given by repeating the flag.
    Positions,
    /// A duration. The field is the number of the setting's units in a second.
    Time(f64),
    /// A number of bytes, for a setting in MB.
    Size,
    Control,
    /// A value as in the file, or a word.
    Toml,
    /// One or more paths, which can also be given without the flag.
    Paths,
}

impl Takes {
    /// Converts a text to a value as in the file. The setting itself checks its validity later.
    pub(super) fn value(&self, text: &str) -> Result<Value, String> {
        let word = || Value::String(text.to_owned());
        Ok(match self {
            Self::Nothing
            | Self::Text
            | Self::Name(_)
            | Self::Numbers
            | Self::Positions
            | Self::Paths => word(),
            Self::Whole => text.parse().map_or_else(|_| word(), Value::Integer),
            Self::Number => text.parse().map_or_else(|_| word(), Value::Float),
            Self::Time(per_s) => Value::Float(per_s * duration::parse(text)?.as_secs_f64()),
            Self::Size => recording::megabytes_value(recording::size(text)?),
            Self::Control => camera::control(text)?,
            Self::Toml => {
                let table = format!("value = {text}").parse::<toml::Table>();
                let value = table.ok().and_then(|mut table| table.remove("value"));
                value.unwrap_or_else(word)
            }
        })
    }

    /// Formats a value as the flag accepts it.
    pub(super) fn shown(&self, value: &Value) -> String {
        match (self, number(value)) {
            (Self::Time(per_s), Some(number)) if *per_s > 1.0 => format!("{number}us"),
            (Self::Time(_), Some(number)) => format!("{number}s"),
            (Self::Size, Some(number)) => format!("{number}MB"),
            _ => value.to_string(),
        }
    }
}
