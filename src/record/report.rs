//! Messages of a recorder: a sentence when it starts to keep the last seconds, and one for each
//! recording.

use std::path::Path;
use std::time::Duration;

use lariat_record::{Drops, Flushed, Losses, Topic, Written};

use lariat_chain::settings::Recording;

const MB: f64 = 1e6;

/// Says how much of the past is kept.
pub(super) fn ring(record: &Recording, file: &Path) -> String {
    let longest = record.ring.unwrap_or_default();
    format!(
        "keeping the last {} s in memory, {} MB at most (--ring-memory); SIGUSR1 to process {} or `lariat record --flush` \
         writes them to {}-….mcap",
        longest.as_secs_f64(),
        record.ring_bytes / 1_000_000,
        std::process::id(),
        file.with_extension("").display(),
    )
}

/// Says what was written from the ring.
pub(super) fn flushed(flushed: &Flushed) -> String {
    let Flushed {
        path,
        time,
        written,
        fault,
    } = flushed;
    match fault {
        Some(fault) => format!("{fault}; recording goes on"),
        None => format!(
            "wrote the last {:.1} s to {}: {}",
            time.as_secs_f64(),
            path.display(),
            contents(written)
        ),
    }
}

/// Says what became of the file if there was nothing to record.
pub(super) fn nothing(file: &Path, written: &Written) -> String {
    let then = match written.kept_old {
        true => "the recording that is there stays as it was",
        false => "no file was made",
    };
    format!(
        "nothing came to be recorded into {}: {then}",
        file.display()
    )
}

/// Says what a recording contains, and what is missing.
pub(super) fn recorded(
    file: &Path,
    written: &Written,
    lasted: Duration,
    drops: Drops,
    losses: &Losses,
) -> String {
    format!(
        "recorded {} in {:.1} s into {}; {}; {}",
        contents(written),
        lasted.as_secs_f64(),
        match file == Path::new("-") {
            true => "standard output".to_owned(),
            false => file.display().to_string(),
        },
        dropped(drops),
        lost(losses)
    )
}

fn contents(written: &Written) -> String {
    let frames = written.messages[Topic::Frames as usize];
    let messages: u64 = written.messages.iter().sum();
    let megabytes = written.bytes as f64 / MB;
    let plural = if frames == 1 { "" } else { "s" };
    format!("{frames} frame{plural} ({messages} messages, {megabytes:.1} MB)")
}

/// Says what the recorder missed or had no room for.
fn dropped(drops: Drops) -> String {
    let counts = [
        (drops.frames, "frames"),
        (drops.centerlines, "centerlines"),
        (drops.descriptors, "descriptors"),
        (drops.truth, "true centerlines"),
        (drops.masks, "masks"),
        (drops.depths, "depth images"),
        (drops.descriptors3, "descriptors in space"),
    ];
    listed(counts).map_or("nothing was dropped".to_owned(), |list| {
        format!("dropped for lack of room or time: {list}")
    })
}

/// Says what the chain lost.
fn lost(losses: &Losses) -> String {
    let counts = [
        (losses.source, "at the source"),
        (losses.capture, "between capture and extract"),
        (losses.extract, "between extract and fit"),
        (losses.bridge, "over the bridge"),
        (losses.fit, "after fit"),
    ];
    listed(counts).map_or("the chain lost no frame".to_owned(), |list| {
        format!("frames lost by the chain: {list}")
    })
}

/// Lists the counts that are not 0; `None` if all are.
fn listed<const N: usize>(counts: [(u64, &str); N]) -> Option<String> {
    let some = counts.iter().filter(|(count, _)| *count > 0);
    let words: Vec<_> = some
        .map(|(count, what)| format!("{count} {what}"))
        .collect();
    (!words.is_empty()).then(|| words.join(", "))
}

/// Formats seconds of Unix time as `20261122T063000Z`.
pub(super) fn utc(unix_s: u64) -> String {
    let (days, second) = (unix_s / 86_400, unix_s % 86_400);
    let (year, month, day) = date(days);
    format!(
        "{year:04}{month:02}{day:02}T{:02}{:02}{:02}Z",
        second / 3600,
        second / 60 % 60,
        second % 60
    )
}

/// Year, month and day, from days since 1970 (H. Hinnant, "chrono-compatible low-level date
/// algorithms": years begin in March, so that the leap day is the last).
fn date(days: u64) -> (u64, u64, u64) {
    let days = days + 719_468;
    let (era, day_of_era) = (days / 146_097, days % 146_097);
    let year_of_era =
        (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 {
        month_from_march + 3
    } else {
        month_from_march - 9
    };
    let year = year_of_era + 400 * era + u64::from(month <= 2);
    (year, month, day)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_named_by_their_date() {
        // `date -u -d @N`
        for (unix_s, expected) in [
            (0, "19700101T000000Z"),
            (951_827_696, "20000229T123456Z"),
            (1_709_251_199, "20240229T235959Z"),
            (1_795_328_999, "20261122T062959Z"),
            (4_102_444_800, "21000101T000000Z"),
        ] {
            assert_eq!(utc(unix_s), expected);
        }
    }

    #[test]
    fn what_is_not_in_a_recording_is_said() {
        let mut written = Written {
            bytes: 1_500_000,
            ..Written::default()
        };
        written.messages[Topic::Frames as usize] = 2;
        written.messages[Topic::Image as usize] = 1;
        let said = |drops, losses| {
            let lasted = Duration::from_millis(1500);
            recorded(Path::new("run.mcap"), &written, lasted, drops, &losses)
        };
        assert_eq!(
            said(Drops::default(), Losses::default()),
            "recorded 2 frames (3 messages, 1.5 MB) in 1.5 s into run.mcap; nothing was dropped; the chain lost no frame"
        );
        let drops = Drops {
            frames: 1,
            truth: 3,
            ..Drops::default()
        };
        let losses = Losses {
            extract: 2,
            ..Losses::default()
        };
        let said = said(drops, losses);
        assert!(
            said.contains("for lack of room or time: 1 frames, 3 true centerlines"),
            "{said}"
        );
        assert!(
            said.ends_with("frames lost by the chain: 2 between extract and fit"),
            "{said}"
        );
    }
}
