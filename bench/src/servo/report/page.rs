//! The page: table, plots and film in one self-contained file.

use std::fmt::Write;

use base64::prelude::{BASE64_STANDARD, Engine as _};
use lariat_plot::{PlotError, escaped};

use super::summary::Summary;
use super::table::{HEAD, cells, meaning};
use super::{Group, Row, Study, by_value, charts, findings};

/// Returns the page as HTML. `film` is the animated picture, a GIF.
///
/// # Errors
/// Fails if the plotting library does.
pub(crate) fn page(study: &Study, film: Option<&[u8]>) -> Result<String, PlotError> {
    let mut html = format!(
        "<h1>{}</h1>\n<p class=\"lead\">Ropes driven to the target {} by what the camera sees. Every sentence below that \
         states a finding was made from the numbers of this run.</p>\n",
        escaped(&study.title),
        escaped(&study.target)
    );
    if let Some(gif) = film {
        write_film(&mut html, study, gif);
    }
    html.push_str("<h2>In short</h2>\n<ul class=\"short\">\n");
    for (group, _) in study.groups() {
        let _ = writeln!(
            html,
            "<li><a href=\"#{}\">{}.</a> {}</li>",
            id(group),
            capital(group.title()),
            escaped(&findings::finding(study, group))
        );
    }
    html.push_str("</ul>\n");
    write_table(&mut html, study);
    for (group, rows) in study.groups() {
        write_group(&mut html, study, group, &rows)?;
    }
    write_parameters(&mut html, study);
    Ok(lariat_plot::page(&study.title, &html))
}

fn write_film(html: &mut String, study: &Study, gif: &[u8]) {
    let side = match study.unit {
        "mm" => "the same from the side, with the true rope, and ",
        _ => "",
    };
    let _ = writeln!(
        html,
        "<figure>\n<img alt=\"The rope on its way to the target\" style=\"width:100%;max-width:640px\" \
         src=\"data:image/gif;base64,{}\"/>\n<figcaption>One rope on its way: the target (green, dashed), the curve that the \
         controller was given with its control points (orange), and the velocities it asked of the grippers (arrows). Below, \
         {side}the error against time; the line is {}.</figcaption>\n</figure>",
        BASE64_STANDARD.encode(gif),
        study.in_unit("5 px")
    );
}

fn write_table(html: &mut String, study: &Study) {
    html.push_str("<h2>All rows</h2>\n<table>\n<thead><tr><th></th>");
    for cell in HEAD {
        let cell = study.in_unit(cell);
        let _ = write!(html, "<th scope=\"col\">{cell}</th>");
    }
    html.push_str("</tr></thead>\n");
    for (group, rows) in study.groups() {
        html.push_str("<tbody>\n");
        if group != Group::AsItIs {
            let _ = writeln!(
                html,
                "<tr><th scope=\"rowgroup\" colspan=\"{}\" style=\"text-align:left;padding-top:12px\">{}</th></tr>",
                HEAD.len() + 1,
                group.title()
            );
        }
        for row in rows {
            write_row(html, row);
        }
        html.push_str("</tbody>\n");
    }
    let _ = writeln!(
        html,
        "</table>\n<p class=\"source\">{}</p>",
        escaped(&study.in_unit(&meaning()))
    );
}

fn write_row(html: &mut String, row: &Row) {
    let _ = write!(html, "<tr><th scope=\"row\">{}</th>", escaped(&row.name));
    for cell in cells(&Summary::of(row)) {
        let _ = write!(html, "<td>{cell}</td>");
    }
    html.push_str("</tr>\n");
}

fn write_group(
    html: &mut String,
    study: &Study,
    group: Group,
    rows: &[&Row],
) -> Result<(), PlotError> {
    let (svg, shows) = match (group, rows) {
        (Group::AsItIs, [first, ..]) => (
            charts::errors(study, first)?,
            "Each thin line is a rope: its mean distance from the target, image by image.",
        ),
        _ if by_value(rows).is_some() => (
            charts::group(study, group)?,
            "Ropes that are at the target in the end (left), and the time within which half of all ropes came there (right; no \
             point where fewer came). The level line is the rope as it is.",
        ),
        _ => (
            charts::group(study, group)?,
            "The time that those took that came to the target: median, quartiles, and nine tenths of them.",
        ),
    };
    let _ = writeln!(
        html,
        "<section id=\"{0}\">\n<h2>{1}</h2>\n<p>{2}</p>\n<figure>\n\
         <div class=\"drawing\" role=\"img\" aria-label=\"{1}\">{svg}</div>\n\
         <figcaption>{shows} <span class=\"found\">{3}</span></figcaption>\n</figure>\n</section>",
        id(group),
        capital(group.title()),
        group.about(),
        escaped(&findings::finding(study, group))
    );
    Ok(())
}

fn write_parameters(html: &mut String, study: &Study) {
    html.push_str("<section class=\"parameters\">\n<h2>Parameters</h2>\n<table>\n<tbody>\n");
    let command = ("command", study.command.clone());
    for (name, value) in study.parameters.iter().chain([&command]) {
        let _ = writeln!(
            html,
            "<tr><th scope=\"row\">{}</th><td>{}</td></tr>",
            escaped(name),
            escaped(value)
        );
    }
    html.push_str("</tbody>\n</table>\n</section>\n");
}

fn id(group: Group) -> String {
    group.title().replace(' ', "-")
}

fn capital(words: &str) -> String {
    let mut letters = words.chars();
    let first = letters.next().map(char::to_uppercase);
    first.into_iter().flatten().chain(letters).collect()
}
