//! The report's folder: `report.html`, `summary.json`, and an `.hgrm` of each timed item.

use std::fmt::Write;

use anyhow::Result;
use lariat_plot::escaped;
use lariat_sink::Figure as Digits;

use super::figures::{Group, Item};
use super::plan::Plan;
use super::plot::{Line, percentiles};
use super::summary::Summary;
use super::table;
use lariat_chain::output::OutputFolder;

const STYLE: &str = "body{font:15px sans-serif;max-width:1120px;margin:2em auto;padding:0 1em;color:#222}\
pre{overflow-x:auto;font-size:12px;line-height:1.35}table{border-collapse:collapse;font-size:13px}\
td,th{padding:2px 10px;text-align:right;border-bottom:1px solid #eee}td:first-child,th:first-child{text-align:left}\
svg{width:100%;height:auto}";

/// Writes all files. The summary comes last, so if it exists, the others do too.
pub(super) fn write(folder: &OutputFolder, plan: &Plan, summary: &Summary) -> Result<()> {
    let put = |name: &str, bytes: &[u8]| folder.write(name, bytes);
    for (item, times) in plan
        .items
        .iter()
        .filter_map(|item| Some((item, item.times.as_ref()?)))
    {
        let mut text = Vec::new();
        times.write_hgrm(&mut text)?;
        put(&format!("{}.hgrm", item.id), &text)?;
    }
    put("report.html", html(plan, summary)?.as_bytes())?;
    let mut json = serde_json::to_vec_pretty(summary)?;
    json.push(b'\n');
    put("summary.json", &json)
}

/// Returns the page, which is self-contained.
fn html(plan: &Plan, summary: &Summary) -> Result<String> {
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/><title>lariat bench</title>\
         <style>{STYLE}</style></head><body>\n<h1>lariat bench</h1>\n<pre>{}</pre>\n",
        escaped(&table::table(plan, summary))
    );
    for (title, lines) in drawings(plan) {
        let _ = write!(
            page,
            "<h2>{}</h2>\n{}",
            escaped(&title),
            percentiles(&lines)?
        );
    }
    page += "<h2>Every figure</h2>\n<table><tr><th>what</th><th>figure</th><th>median</th><th>least</th><th>greatest</th></tr>\n";
    for item in &plan.items {
        for figure in &item.figures {
            let (low, high) = figure.range();
            let _ = writeln!(
                page,
                "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
                escaped(&item.title),
                escaped(&figure.name),
                Digits(Some(figure.median())),
                Digits(Some(low)),
                Digits(Some(high))
            );
        }
    }
    page += "</table>\n<h2>How it was measured</h2>\n<table>\n";
    let machine = &summary.machine;
    let unknown = || "unknown".to_owned();
    let of_machine = [
        ("processor", machine.cpu.clone().unwrap_or_else(unknown)),
        (
            "cores",
            machine.cores.map_or_else(unknown, |n| n.to_string()),
        ),
        (
            "memory, MB",
            machine.memory_mb.map_or_else(unknown, |n| n.to_string()),
        ),
        ("kernel", machine.kernel.clone()),
        ("governor", machine.governor.clone().unwrap_or_else(unknown)),
    ];
    let parameters = summary
        .parameters
        .iter()
        .map(|(&name, value)| (name, value.clone()));
    for (name, value) in of_machine.into_iter().chain(parameters) {
        let _ = writeln!(page, "<tr><td>{name}</td><td>{}</td></tr>", escaped(&value));
    }
    for item in &plan.items {
        let _ = writeln!(
            page,
            "<tr><td>{}</td><td>{}</td></tr>",
            escaped(&item.title),
            escaped(item.note)
        );
    }
    Ok(page + "</table>\n</body></html>\n")
}

/// Returns the plots: the comparison, all chains, and the floor in all its arrangements.
fn drawings(plan: &Plan) -> [(String, Vec<Line<'_>>); 3] {
    let ([width, height], fps) = plan.base;
    let floor = plan.relay_floor(Some(fps), "p50_us").map(|item| &item.id);
    let base = format!("chain.{width}x{height}@{fps}");
    let is_relay = |item: &Item| item.id.starts_with("floor.relay.");
    let compared = |item: &Item| match item.group {
        // Includes variants, and the chain under other conditions.
        Group::Chain => {
            let behind = item.id.strip_prefix(&base[..]);
            behind.is_some_and(|behind| behind.is_empty() || behind.starts_with('.'))
        }
        Group::Floor if is_relay(item) => Some(&item.id) == floor,
        Group::Floor => item.id.starts_with("floor.wake.futex") || item.id == "floor.timer",
        Group::Rival => true,
    };
    let lines = |wanted: &dyn Fn(&Item) -> bool| {
        let items = plan.items.iter().filter(|item| wanted(item));
        let drawn = items.filter_map(|item| {
            Some(Line {
                name: &item.title,
                times: item.times.as_ref()?,
                bold: item.id == base || Some(&item.id) == floor,
            })
        });
        drawn.collect()
    };
    [
        (
            format!("At {width}×{height}, {fps}/s: the chain, its floors, others"),
            lines(&compared),
        ),
        (
            "The chain at every size and rate".to_owned(),
            lines(&|item| item.group == Group::Chain),
        ),
        (
            "Four processes that pass 64 bytes on, in every arrangement".to_owned(),
            lines(&is_relay),
        ),
    ]
}
