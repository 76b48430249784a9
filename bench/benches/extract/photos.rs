//! Photographs, each a scene of its own, next to the times of the mBEST authors' program on the
//! same pictures.

use std::path::Path;

use anyhow::Result;
use lariat_bench::{MBEST_MS, Table, micros, millis, multiple, photographs, times};

use crate::Effort;
use crate::case::{Case, WHOLE, measure};

pub(crate) fn run(effort: &Effort, folder: &Path) -> Result<()> {
    let mut cases = Vec::new();
    let mut counts = Vec::new();
    for mut set in photographs(folder)? {
        if effort.quick {
            set.pictures.truncate(10);
        }
        counts.push(set.pictures.len());
        cases.push(Case::new(set.name, set.pictures)?);
    }
    measure(&mut cases, effort.time(10.0))?;
    let mut table = Table::new(&[
        "photographs, cold",
        "images",
        "read, µs",
        "ms",
        "÷ read",
        "p99, ms",
        "mBEST, ms *",
        "mBEST ÷ lariat",
    ]);
    for (case, count) in cases.iter().zip(counts) {
        let median = case.cold.whole_ns();
        let published = MBEST_MS.iter().find(|(set, _)| *set == case.name);
        table.push([
            case.name.clone(),
            count.to_string(),
            micros(case.read_ns.median()),
            millis(median),
            multiple(case.cold.whole_over_read()),
            millis(case.cold.ns[WHOLE].percentile(0.99)),
            published.map_or("-".into(), |(_, ms)| format!("{ms:.1}")),
            published.map_or("-".into(), |(_, ms)| times(ms * 1e6, median)),
        ]);
    }
    println!(
        "{table}* measured elsewhere, on a core like the one that reads 640×480 RGB in 11 µs; centerlines only"
    );
    Ok(())
}
