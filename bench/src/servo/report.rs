//! Results of driving ropes in many ways: a table, plots, and one self-contained page.

mod charts;
mod findings;
mod page;
mod summary;
mod table;

pub(super) use page::page;
pub(super) use table::table;

use super::judge::Outcome;

/// Results and all parameters that they depend on.
#[derive(Debug, Clone)]
pub(super) struct Study {
    /// Title of the page.
    pub title: String,
    /// Name of the target.
    pub target: String,
    /// Unit of distances: px, or mm for lifted ropes.
    pub unit: &'static str,
    /// Rows of the table. The first is the reference: [`Group::AsItIs`].
    pub rows: Vec<Row>,
    /// Command that repeats this study.
    pub command: String,
    /// Machine, version, seeds, rope: names and values for the end of the page.
    pub parameters: Vec<(&'static str, String)>,
    /// Time from exposure to descriptor in the default chain, in ms, if it was measured.
    pub own_latency_ms: Option<f64>,
}

/// Ropes driven in one way.
#[derive(Debug, Clone)]
pub(super) struct Row {
    pub group: Group,
    /// Difference from the default, such as "30 ms", "Bezier, 7 control points".
    pub name: String,
    /// The difference as a number in the unit of [`Group::axis`]. A group whose rows all have one
    /// is plotted over it.
    pub value: Option<f64>,
    /// One outcome for each seed.
    pub outcomes: Vec<Outcome>,
}

/// The property that a row varies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Group {
    AsItIs,
    Latency,
    /// Latency for a controller that treats observations as current.
    LatencyTaken,
    FrameRate,
    Occlusion,
    Noise,
    CurveAndBasis,
    Features,
    Estimator,
}

/// The direction in which a group's values get harder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Harder {
    Upwards,
    Downwards,
    /// Not known in advance.
    Neither,
}

impl Group {
    /// All groups in the order of the report.
    const ALL: [Self; 9] = [
        Self::AsItIs,
        Self::Latency,
        Self::LatencyTaken,
        Self::FrameRate,
        Self::Occlusion,
        Self::Noise,
        Self::CurveAndBasis,
        Self::Features,
        Self::Estimator,
    ];

    pub(super) fn title(self) -> &'static str {
        match self {
            Self::AsItIs => "as it is",
            Self::Latency => "latency",
            Self::LatencyTaken => "latency, not looked ahead",
            Self::FrameRate => "frame rate",
            Self::Occlusion => "occlusion",
            Self::Noise => "noise",
            Self::CurveAndBasis => "control points and basis",
            Self::Features => "features",
            Self::Estimator => "estimator",
        }
    }

    /// Returns the label for the group's values, including their unit.
    pub(super) fn axis(self) -> &'static str {
        match self {
            Self::AsItIs => "",
            Self::Latency | Self::LatencyTaken => "added latency, ms",
            Self::FrameRate => "frames/s",
            Self::Occlusion => "time behind a hand, s",
            Self::Noise => "noise of a pixel, levels of 256",
            Self::CurveAndBasis => "control points",
            Self::Features => "numbers in the feature",
            Self::Estimator => "value",
        }
    }

    /// Formats a value for a sentence.
    fn said(self, value: f64) -> String {
        match self {
            Self::Latency | Self::LatencyTaken => format!("{value} ms of added latency"),
            Self::FrameRate => format!("{value} frames/s"),
            Self::Occlusion => format!("{value} s behind a hand"),
            Self::Noise => format!("noise of {value} levels"),
            Self::CurveAndBasis => format!("{value} control points"),
            Self::Features => format!("{value} numbers"),
            Self::AsItIs | Self::Estimator => value.to_string(),
        }
    }

    /// Formats a value for a sentence that has already named the quantity.
    fn said_again(self, value: f64) -> String {
        match self {
            Self::Latency => format!("{value} ms"),
            Self::Occlusion => format!("{value} s"),
            Self::Noise => format!("{value} levels"),
            _ => self.said(value),
        }
    }

    /// Returns a description of the group.
    fn about(self) -> &'static str {
        match self {
            Self::AsItIs => {
                "The rope as the camera sees it, the chain and the controller at their defaults."
            }
            Self::Latency => {
                "Every descriptor comes later than it does: what a slower way from the camera to the controller would cost."
            }
            Self::LatencyTaken => {
                "The same, with a controller that steers by the shape as it was seen instead of the shape that follows from what it has commanded since."
            }
            Self::FrameRate => "The camera takes more or fewer images a second.",
            Self::Occlusion => "A hand covers a part of the rope while it is driven.",
            Self::Noise => {
                "Normal noise is added to each pixel; the value is its standard deviation."
            }
            Self::CurveAndBasis => "The curve that the rope's shape is described by.",
            Self::Features => {
                "The controller's input: the control points of a curve, or points of the centerline itself."
            }
            Self::Estimator => {
                "How the controller learns what a motion of the grippers does to the shape."
            }
        }
    }

    fn harder(self) -> Harder {
        match self {
            Self::Latency | Self::LatencyTaken | Self::Occlusion | Self::Noise => Harder::Upwards,
            Self::FrameRate => Harder::Downwards,
            Self::AsItIs | Self::CurveAndBasis | Self::Features | Self::Estimator => {
                Harder::Neither
            }
        }
    }
}

impl Study {
    /// Replaces "px" in a text by the unit of distances.
    fn in_unit(&self, text: &str) -> String {
        text.replace("px", self.unit)
    }

    /// Returns the row that all others are compared with.
    fn base(&self) -> Option<&Row> {
        self.rows.iter().find(|row| row.group == Group::AsItIs)
    }

    fn of(&self, group: Group) -> Vec<&Row> {
        self.rows.iter().filter(|row| row.group == group).collect()
    }

    /// Returns the groups that have rows.
    fn groups(&self) -> impl Iterator<Item = (Group, Vec<&Row>)> {
        let groups = Group::ALL.into_iter();
        let groups = groups.map(|group| (group, self.of(group)));
        groups.filter(|(_, rows)| !rows.is_empty())
    }
}

/// Returns the rows with their values in ascending order, if all have one. Returns `None` if they
/// cannot be plotted over a value.
fn by_value<'a>(rows: &[&'a Row]) -> Option<Vec<(f64, &'a Row)>> {
    let values: Option<Vec<_>> = (rows.iter())
        .map(|&row| row.value.map(|value| (value, row)))
        .collect();
    let mut values = values?;
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    (values.len() > 1).then_some(values)
}

#[cfg(test)]
mod tests;
