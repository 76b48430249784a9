//! Writes changes into a settings file, and keeps its order, comments and empty lines.

use super::change;
use super::keys::KEYS;
use anyhow::{Context, Result, bail};
use std::fmt::Write as _;
use toml::{Table, Value};

/// Returns the text of a settings file with changes, each written as `section.name=value`.
///
/// # Errors
/// Returns an error if a change is invalid, or if the text is not TOML. A setting may also be
/// written in a way that cannot be changed here; the error then contains the lines to write by
/// hand.
pub fn with_changes(text: &str, changes: &[String]) -> Result<String> {
    let mut meant: Table = text.parse().context("the settings file is not TOML")?;
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let mut by_hand = String::new();
    for change in changes {
        let (key, value) = change::parse(change)?;
        let (section, name) = (KEYS[key].section, KEYS[key].name);
        let _ = write!(by_hand, "\n[{section}]\n{name} = {value}");
        let table = meant.entry(section).or_insert_with(|| Table::new().into());
        let Some(table) = table.as_table_mut() else {
            bail!("{section} is not a section of the settings file");
        };
        table.insert(name.to_owned(), value.clone());
        put(&mut lines, section, name, &value);
    }
    let mut text = lines.join("\n");
    text.push('\n');
    if text.parse::<Table>().ok().as_ref() != Some(&meant) {
        bail!(
            "the settings file has these settings where they cannot be changed: write them by hand:{by_hand}"
        );
    }
    Ok(text)
}

fn put(lines: &mut Vec<String>, section: &str, name: &str, value: &Value) {
    let header = format!("[{section}]");
    let line = format!("{name} = {value}");
    let is_header =
        |line: &String| line.trim().starts_with('[') && line.contains(']') && !line.contains('=');
    let begin = lines.iter().position(|line| {
        line.trim()
            .split('#')
            .next()
            .is_some_and(|line| line.trim() == header)
    });
    let Some(begin) = begin else {
        if lines.last().is_some_and(|line| !line.trim().is_empty()) {
            lines.push(String::new());
        }
        lines.extend([header, line]);
        return;
    };
    let rest = lines[begin + 1..].iter().position(is_header);
    let end = rest.map_or(lines.len(), |length| begin + 1 + length);
    let names = |line: &String| {
        line.split_once('=')
            .is_some_and(|(before, _)| before.trim() == name)
    };
    if let Some(place) = (begin + 1..end).find(|&place| names(&lines[place])) {
        let (length, comment) = extent(&lines[place..end]);
        lines.splice(place..place + length, [line + &comment]);
        return;
    }
    // Insert after the comment that shows the setting, if there is one, otherwise at the end of the
    // section.
    let shown = |line: &String| {
        let comment = line.trim().strip_prefix('#');
        comment.is_some_and(|line| names(&line.to_owned()))
    };
    let last = (begin..end).rfind(|&place| !lines[place].trim().is_empty());
    let place = (begin + 1..end)
        .find(|&place| shown(&lines[place]))
        .or(last);
    lines.insert(place.unwrap_or(begin) + 1, line);
}

/// Returns the number of lines of a setting that starts on the first of these lines, and the
/// comment after it.
fn extent(lines: &[String]) -> (usize, String) {
    let is_whole = |text: &str| text.parse::<Table>().is_ok();
    let length = (1..=lines.len()).find(|&length| is_whole(&lines[..length].join("\n")));
    let comment = lines[0]
        .match_indices('#')
        .find(|&(place, _)| is_whole(&lines[0][..place]));
    let comment = comment.map_or(String::new(), |(place, _)| {
        format!(" {}", &lines[0][place..])
    });
    (length.unwrap_or(1), comment)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kept(text: &str, changes: &[&str]) -> Result<String> {
        let changes: Vec<String> = changes.iter().map(|change| (*change).to_owned()).collect();
        with_changes(text, &changes)
    }

    #[test]
    fn only_what_changes_changes() {
        let text = "# mine\n[fit]\n# control_points = 9\nfilter = true # smooth\n\n[extract]\nmask = [\n  { hue_deg = [1, 2], saturation = [0, 1], value = [0, 1] },\n]\nropes = 2\n";
        let changes = [
            "fit.control_points=7",
            "fit.filter=false",
            "extract.mask=auto",
            "sink.live=false",
        ];
        assert_eq!(
            kept(text, &changes).unwrap(),
            "# mine\n[fit]\n# control_points = 9\ncontrol_points = 7\nfilter = false # smooth\n\n[extract]\nmask = \"auto\"\nropes = 2\n\n[sink]\nlive = false\n"
        );
    }

    #[test]
    fn a_new_file_has_what_was_changed() {
        let mask =
            "extract.mask=[{ hue_deg = [190, 250], saturation = [0.3, 1], value = [0.2, 1] }]";
        let text = kept("", &[mask, "extract.ropes=3"]).unwrap();
        let settings = crate::settings::Settings::of_text(&text).unwrap();
        assert_eq!(settings.extract.ropes, 3);
        assert!(text.starts_with("[extract]\n"), "{text}");
    }

    #[test]
    fn the_template_takes_every_setting() {
        let template = crate::settings::template();
        let changed = kept(
            &template,
            &[
                "run.deadline_us=20ms",
                "extract.ropes=2",
                "fit.tolerance=0.2",
            ],
        )
        .unwrap();
        assert_eq!(changed.lines().count(), template.lines().count() + 1);
        let settings = crate::settings::Settings::of_text(&changed).unwrap();
        assert_eq!((settings.extract.ropes, settings.fit.tolerance), (2, 0.2));
    }

    #[test]
    fn what_cannot_be_changed_is_said_with_the_lines() {
        let said = kept("fit.control_points = 6\n", &["fit.control_points=7"])
            .unwrap_err()
            .to_string();
        assert!(said.ends_with("\n[fit]\ncontrol_points = 7"), "{said}");
        assert!(kept("fit = 5\n", &["fit.control_points=7"]).is_err());
        assert!(kept("[fit\n", &["fit.control_points=7"]).is_err());
        assert!(kept("", &["fit.odrer=6"]).is_err());
    }
}
