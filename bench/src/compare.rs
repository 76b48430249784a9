//! `lariat compare A B`: changes from one summary to the other that exceed the noise.
//!
//! For two benches, the noise is the spread of their rounds. A figure has changed if its medians
//! differ by more than the sum of both spreads and by more than a twentieth. With fewer than five
//! rounds, they must differ by more than one and a half times that sum. The rate of false changes
//! is then 0.02 % after five rounds each, and 0.3 % after three (simulated, with log-normal noise
//! of 5 to 50 %).
//!
//! Single runs consist of one round, so a percentile's noise follows from the run's own
//! distribution: the ranks q n ± 2 √(n q (1 − q)), two standard errors of a binomial count. The
//! change must also exceed a tenth, because two runs differ by more than the chance variation
//! within one.

mod read;
mod verdict;

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Result, bail};
use clap::Args;
use lariat_sink::Figure as Digits;

use lariat_chain::layout::{self, Column, Table, hanging, wrapped};
use lariat_chain::output::print;
use read::{Kind, Measured};
use verdict::{Verdict, verdict};

/// What to compare.
#[derive(Debug, Clone, Args)]
pub(crate) struct CompareArgs {
    /// Earlier summary.json, or its folder
    #[arg(value_name = "A")]
    before: PathBuf,
    /// Later summary.json, or its folder
    #[arg(value_name = "B")]
    now: PathBuf,
}

/// Prints the changes. Returns a failure code if a figure of lariat got worse.
///
/// # Errors
/// A file is not a summary, or the two are of different kinds.
pub(crate) fn run(args: &CompareArgs) -> Result<ExitCode> {
    let (before, now) = (read::summary(&args.before)?, read::summary(&args.now)?);
    if before.kind != now.kind {
        bail!(
            "{} is of {} and {} of {}: compare two of one kind",
            args.before.display(),
            before.kind.name(),
            args.now.display(),
            now.kind.name()
        );
    }
    if before.machine != now.machine {
        let note = format!(
            "! The machines differ: {} and {}.",
            before.machine, now.machine
        );
        print(&(hanging(&note, 2, layout::width()) + "\n"))?;
    }
    let changes = changes(&before.measured, &now.measured);
    print(&table(&changes, now.kind))?;
    let worse = changes
        .iter()
        .any(|change| change.ours && change.verdict == Verdict::Worse);
    Ok(if worse {
        ExitCode::FAILURE
    } else {
        ExitCode::SUCCESS
    })
}

/// A figure that is in both summaries.
struct Change<'a> {
    now: &'a Measured,
    before: f64,
    /// True for a figure of lariat, false for one of the machine or a rival.
    ours: bool,
    verdict: Verdict,
}

fn changes<'a>(before: &[Measured], now: &'a [Measured]) -> Vec<Change<'a>> {
    let pairs = now.iter().filter_map(|now| {
        let same = |one: &&Measured| one.id == now.id && one.figure == now.figure;
        Some((before.iter().find(same)?, now))
    });
    pairs
        .map(|(before, now)| Change {
            now,
            before: before.value,
            ours: now.ours,
            verdict: verdict(before, now),
        })
        .collect()
}

fn table(changes: &[Change], kind: Kind) -> String {
    let columns = vec![
        Column::words("what"),
        Column::figures("before"),
        Column::figures("now"),
        Column::figures("change"),
        Column::words(""),
    ];
    let mut rows = Vec::new();
    let mut push = |change: &Change, word: &str| {
        rows.push(vec![
            format!("{}: {}", change.now.id, change.now.figure),
            Digits(Some(change.before)).to_string(),
            Digits(Some(change.now.value)).to_string(),
            change.percent(),
            word.to_owned(),
        ]);
    };
    for (ours, verdict, word) in [
        (true, Verdict::Worse, "worse"),
        (true, Verdict::Better, "better"),
        (false, Verdict::Worse, "worse, not lariat"),
        (false, Verdict::Better, "better, not lariat"),
    ] {
        for change in changes
            .iter()
            .filter(|change| (change.ours, change.verdict) == (ours, verdict))
        {
            push(change, word);
        }
    }
    let count = |verdict| {
        changes
            .iter()
            .filter(|change| change.ours && change.verdict == verdict)
            .count()
    };
    let [worse, better, same] = [Verdict::Worse, Verdict::Better, Verdict::Same].map(count);
    let figures = if changes.iter().all(|change| change.verdict == Verdict::Same) {
        String::new()
    } else {
        Table::text(columns, &rows, layout::width()) + "\n"
    };
    let counts = format!(
        "{worse} worse, {better} better, {same} within the noise ({})",
        kind.noise()
    );
    format!("{figures}{}\n", wrapped(&counts, layout::width()))
}

impl Change<'_> {
    fn percent(&self) -> String {
        let change = 100.0 * (self.now.value - self.before) / self.before;
        if change.is_finite() {
            format!("{change:+.0} %")
        } else {
            "–".to_owned()
        }
    }
}
