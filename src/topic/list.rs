//! `lariat topic list`: the rigs of this machine, their channels, and the processes at the ends of
//! each.

use std::process::ExitCode;

use anyhow::{Result, bail};
use lariat_wire::{ChannelState, Domain, Member, members};
use serde::Serialize;

use lariat_chain::output::print;

use super::{ListArgs, nothing_runs};
use crate::versioned::Versioned;
use lariat_chain::layout::{self, Column, Table, hanging};

#[derive(Serialize)]
struct List<'a> {
    rigs: Vec<RigEntry<'a>>,
}

#[derive(Serialize)]
struct RigEntry<'a> {
    rig: &'a str,
    lossless: bool,
    channels: Vec<Entry<'a>>,
}

/// A channel, for scripts.
#[derive(Serialize)]
struct Entry<'a> {
    channel: &'static str,
    /// Type and version of its messages.
    message: &'a str,
    version: Option<u32>,
    /// True if this release can read it. Otherwise the following fields are unknown.
    readable: bool,
    writer: Option<Process<'a>>,
    readers: Option<Vec<Process<'a>>>,
    most_readers: usize,
    /// Number of messages that can wait for a reader.
    buffer: usize,
    /// Number of messages that there is room for, and size of the largest one in bytes.
    slots: Option<usize>,
    message_bytes: Option<usize>,
    /// Total size in shared memory.
    shared_bytes: Option<u64>,
}

#[derive(Serialize)]
struct Process<'a> {
    /// Name of the stage, if the process is one.
    stage: Option<&'a str>,
    pid: u32,
}

/// Runs `lariat topic list`.
pub(super) fn run(args: &ListArgs) -> Result<ExitCode> {
    let domain = Domain::open()?;
    let all = domain.channels()?;
    let members = members()?;
    if let Some(rig) = &args.rig
        && !all.is_empty()
        && all.iter().all(|state| state.rig != *rig)
        && !args.json
    {
        let mut rigs: Vec<&str> = all.iter().map(|state| state.rig.as_str()).collect();
        rigs.dedup();
        bail!("there is no rig {rig} here: there is {}", rigs.join(", "));
    }
    let shown: Vec<ChannelState> = all
        .into_iter()
        .filter(|state| args.rig.as_ref().is_none_or(|rig| state.rig == *rig))
        .collect();
    let text = if args.json {
        let list = List {
            rigs: rigs(&shown, &members),
        };
        serde_json::to_string_pretty(&Versioned::first(list))? + "\n"
    } else if shown.is_empty() {
        return Err(nothing_runs(""));
    } else {
        as_table(&rigs(&shown, &members))
    };
    print(&text)?;
    // As with `devices`, scripts can recognize an empty list by the status.
    Ok(match shown.is_empty() {
        true => ExitCode::FAILURE,
        false => ExitCode::SUCCESS,
    })
}

fn rigs<'a>(states: &'a [ChannelState], members: &'a [Member]) -> Vec<RigEntry<'a>> {
    let of_one_rig = states.chunk_by(|a, b| a.rig == b.rig);
    of_one_rig
        .map(|states| RigEntry {
            rig: states[0].rig.as_str(),
            lossless: states.iter().any(|state| state.lossless),
            channels: states
                .iter()
                .map(|state| Entry::of(state, members))
                .collect(),
        })
        .collect()
}

impl<'a> Entry<'a> {
    fn of(state: &'a ChannelState, members: &'a [Member]) -> Self {
        let ends = state.ends.as_ref();
        let writer = ends.and_then(|ends| ends.writer.as_ref());
        let usual = match state.channel {
            "frames" | "truth" => "capture",
            "centerlines" => "extract",
            // A controller is not a stage.
            "commands" => "",
            _ => "fit",
        };
        let process = |pid: u32, usual: &str| Process {
            stage: stage_of(pid, state.rig.as_str(), usual, members),
            pid,
        };
        let (message, version) = name_and_version(&state.message);
        Self {
            channel: state.channel,
            message,
            version,
            readable: state.message == state.ours,
            writer: writer.map(|writer| process(writer.pid, usual)),
            readers: ends.map(|ends| ends.readers.iter().map(|&pid| process(pid, "")).collect()),
            most_readers: state.most_readers,
            buffer: state.buffer,
            slots: writer.map(|writer| writer.slots),
            message_bytes: writer.map(|writer| writer.message_bytes),
            shared_bytes: writer.map(|writer| writer.shared_bytes),
        }
    }
}

/// Stage of a process on a rig. A process with several stages (`--fuse`) counts as the usual stage
/// for its end of the channel.
fn stage_of<'a>(pid: u32, rig: &str, usual: &str, members: &'a [Member]) -> Option<&'a str> {
    let of_process = || {
        members
            .iter()
            .filter(|one| one.pid == pid && one.rig == rig)
    };
    let mut stages = of_process().map(|one| one.stage.as_str());
    let usual = stages.clone().find(|stage| *stage == usual);
    match (usual, stages.next(), stages.next()) {
        (Some(usual), ..) => Some(usual),
        (None, Some(only), None) => Some(only),
        (None, Some(_), Some(_)) => Some("run --fuse"),
        (None, None, _) => None,
    }
}

/// Splits a type name: `u8 with lariat.FrameHeader.v1` is `lariat.FrameHeader`, version 1.
fn name_and_version(types: &str) -> (&str, Option<u32>) {
    let name = types.rsplit(' ').next().unwrap_or(types);
    match name.rsplit_once(".v") {
        Some((name, version)) => (name, version.parse().ok()),
        None => (name, None),
    }
}

fn as_table(rigs: &[RigEntry]) -> String {
    let width = layout::width();
    let mut text = String::new();
    for rig in rigs {
        let delivery = if rig.lossless { " (lossless)" } else { "" };
        text += &format!("rig {}{delivery}\n", rig.rig);
        let columns = vec![
            Column::words("  channel"),
            Column::words("writer"),
            Column::figures("readers"),
            Column::words("message").rank(2),
            Column::figures("slots").rank(1),
            Column::figures("MB shared"),
        ];
        let rows: Vec<_> = rig.channels.iter().map(row).collect();
        let table = Table::text(columns, &rows, width);
        let mut lines = table.split_inclusive('\n');
        text.extend(lines.next());
        for (line, entry) in lines.zip(&rig.channels) {
            text += line;
            text += &below(entry, width);
        }
    }
    text
}

fn name(process: &Process) -> String {
    match process.stage {
        Some(stage) => format!("{stage} {}", process.pid),
        None => format!("process {}", process.pid),
    }
}

fn row(entry: &Entry) -> Vec<String> {
    let writer = match (&entry.readers, &entry.writer) {
        (None, _) => "?".to_owned(),
        (_, None) => "none".to_owned(),
        (_, Some(writer)) => name(writer),
    };
    let readers = entry.readers.as_ref();
    let readers = readers.map_or("?".to_owned(), |readers| readers.len().to_string());
    let version = entry
        .version
        .map_or(String::new(), |version| format!(" v{version}"));
    let or_dash = |text: Option<String>| text.unwrap_or("–".to_owned());
    vec![
        format!("  {}", entry.channel),
        writer,
        format!("{readers} of {:<2}", entry.most_readers),
        format!("{}{version}", entry.message),
        or_dash(entry.slots.map(|slots| slots.to_string())),
        or_dash(
            entry
                .shared_bytes
                .map(|bytes| format!("{:.1}", bytes as f64 / 1e6)),
        ),
    ]
}

/// Remarks below a channel's row.
fn below(entry: &Entry, width: usize) -> String {
    let mut text = String::new();
    let mut add = |sentence: &str| text += &format!("    {}\n", hanging(sentence, 4, width));
    if !entry.readable {
        add(
            "of another release: use the same lariat for every process on a rig (`lariat doctor` names them)",
        );
    }
    if let Some(readers) = entry.readers.as_ref().filter(|readers| !readers.is_empty()) {
        let names: Vec<String> = readers.iter().map(name).collect();
        add(&format!("read by {}", names.join(", ")));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_type_is_told_as_name_and_version() {
        let frames = "u8 with lariat.FrameHeader.v1";
        assert_eq!(name_and_version(frames), ("lariat.FrameHeader", Some(1)));
        let shapes = name_and_version("lariat.Descriptors.v12");
        assert_eq!(shapes, ("lariat.Descriptors", Some(12)));
        assert_eq!(name_and_version("f64"), ("f64", None));
    }

    #[test]
    fn a_process_is_known_by_its_stage_and_a_fused_one_by_its_end_of_the_channel() {
        let member = |stage: &str, pid| Member {
            rig: "left".into(),
            stage: stage.into(),
            pid,
            version: String::new(),
            folder: "/".into(),
            settings: String::new(),
        };
        let members = [
            member("capture", 7),
            member("extract", 7),
            member("sink", 8),
        ];
        let stage = |pid, rig, usual| stage_of(pid, rig, usual, &members);
        assert_eq!(stage(7, "left", "extract"), Some("extract"));
        assert_eq!(stage(7, "left", ""), Some("run --fuse"));
        assert_eq!(stage(8, "left", ""), Some("sink"));
        assert_eq!(stage(8, "right", ""), None);
    }
}
