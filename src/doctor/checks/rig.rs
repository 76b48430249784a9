//! Findings about the chains on this machine: what dead ones left, who owns the files, and which
//! releases run.

use std::collections::BTreeMap;

use lariat_wire::{ChannelState, Leftover, Member};

use super::{Finding, better, ok};

/// Judges what dead processes left. `kept`: files that could not be removed, each with the cause;
/// `None` if nothing was to be removed. `others`: name, number of files and bytes of other users,
/// whose domains this user cannot inspect.
pub(in crate::doctor) fn leftover(
    left: &[Leftover],
    kept: Option<&[String]>,
    others: &[(String, usize, u64)],
) -> Finding {
    const NAME: &str = "leftovers";
    let what = described(left);
    let with_others = |found: &str| match others {
        [] => found.to_owned(),
        others => format!(
            "{found}; {}: whether that is in use, `sudo lariat doctor` tells",
            of_others(others)
        ),
    };
    match kept {
        Some([]) if left.is_empty() => ok(NAME, with_others("nothing was left to clean up")),
        Some([]) => ok(NAME, with_others(&format!("removed: {what}"))),
        Some(kept @ [first, ..]) => better(
            NAME,
            format!("{} files could not be removed: {first}", kept.len()),
            "`sudo lariat doctor --clean`",
        ),
        None if left.is_empty() => ok(NAME, with_others("no dead process has left shared memory")),
        None => better(
            NAME,
            with_others(&format!("left: {what}")),
            "`lariat doctor --clean`",
        ),
    }
}

/// Describes what was left, and where.
fn described(left: &[Leftover]) -> String {
    let files: usize = left.iter().map(|of| of.files).sum();
    let bytes: u64 = left.iter().map(|of| of.bytes).sum();
    let mut parts = Vec::new();
    if files > 0 {
        let megabytes = bytes as f64 / 1e6;
        parts.push(format!(
            "{files} files of {megabytes:.1} MB in /dev/shm, of killed processes{}",
            in_domains(left)
        ));
    }
    if left.iter().any(|of| of.domain.is_none()) {
        parts.push("/tmp/iceoryx2, the folder of an older lariat".to_owned());
    }
    parts.join(", and ")
}

fn in_domains(left: &[Leftover]) -> String {
    let mut names: Vec<&str> = left.iter().filter_map(|of| of.domain.as_deref()).collect();
    names.sort_unstable();
    match names.as_slice() {
        [one] => format!(" in the domain {one}"),
        [first, rest @ ..] => format!(" in the domain {first} and {} more", rest.len()),
        [] => String::new(),
    }
}

fn of_others(others: &[(String, usize, u64)]) -> String {
    let each = others.iter().map(|(user, files, bytes)| {
        let megabytes = *bytes as f64 / 1e6;
        format!("{files} files of {megabytes:.1} MB are {user}'s")
    });
    each.collect::<Vec<_>>().join(", ")
}

/// Judges the ownership of the domain's files. `others`: names of the owners other than this user,
/// and the number of files of each.
pub(in crate::doctor) fn rights(
    user: &str,
    own: usize,
    others: &BTreeMap<String, usize>,
) -> Finding {
    const NAME: &str = "rights";
    let Some((other, files)) = others.iter().max_by_key(|(_, files)| **files) else {
        return match own {
            0 => ok(NAME, "nothing of lariat's is here yet"),
            own => ok(NAME, format!("all {own} files of the domain are {user}'s")),
        };
    };
    better(
        NAME,
        format!(
            "{files} files of the domain are {other}'s, and this is {user}: one of the two cannot take part"
        ),
        format!(
            "run every process of a rig as one user (`sudo -u {other} lariat …`), take another domain (`export \
             LARIAT_DOMAIN=NAME`), or, if nothing of {other}'s runs in it any more, `sudo lariat doctor --clean`"
        ),
    )
}

/// Judges which releases run on each rig. `own`: this program's release.
pub(in crate::doctor) fn versions(
    members: &[Member],
    channels: &[ChannelState],
    own: &str,
) -> Finding {
    const NAME: &str = "versions";
    const SAME: &str = "stop what runs on the rig and start all of it with the same lariat: `lariat --version` tells which \
                        one this is";
    let stranger = channels.iter().find(|state| state.message != state.ours);
    if let Some(ChannelState {
        rig,
        channel,
        message,
        ours,
        ..
    }) = stranger
    {
        let found = format!("rig {rig}: {channel} carries {message}, and this lariat reads {ours}");
        return better(NAME, found, SAME);
    }
    let mut rigs = BTreeMap::<&str, Vec<&Member>>::new();
    for member in members {
        rigs.entry(&member.rig).or_default().push(member);
    }
    let is_mixed =
        |of_rig: &Vec<&Member>| of_rig.iter().any(|one| one.version != of_rig[0].version);
    let is_another = |of_rig: &Vec<&Member>| of_rig.iter().any(|one| one.version != own);
    let told = |(rig, of_rig): (&&str, &Vec<&Member>)| {
        let of_stage = |one: &&Member| format!("{} {}", one.stage, one.version);
        let stages: Vec<String> = of_rig.iter().map(of_stage).collect();
        format!("rig {rig}: {}", stages.join(", "))
    };
    if let Some(mixed) = rigs.iter().find(|(_, of_rig)| is_mixed(of_rig)) {
        return better(NAME, told(mixed), SAME);
    }
    if let Some(another) = rigs.iter().find(|(_, of_rig)| is_another(of_rig)) {
        let found = format!("{}, and this lariat is {own}", told(another));
        return better(NAME, found, SAME);
    }
    let names: Vec<&str> = rigs.keys().copied().collect();
    match names.as_slice() {
        [] => ok(NAME, format!("{own}; no rig runs")),
        names => ok(
            NAME,
            format!("{own} on every rig that runs: {}", names.join(", ")),
        ),
    }
}
