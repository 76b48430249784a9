//! The page as HTML.

use std::fmt::Write;

use lariat_plot::{escaped, page};

use super::finding;
use crate::figure::{Figure, Section, Table};

const TITLE: &str = "The paper, repeated";

pub(super) fn write(
    sections: &[Section],
    introduction: &str,
    parameters: &[(&'static str, String)],
) -> String {
    let mut html = format!(
        "<h1>{TITLE}</h1>\n<p class=\"lead\">{}</p>\n",
        escaped(introduction)
    );
    html.push_str("<h2>In short</h2>\n<ul class=\"short\">\n");
    for figure in sections.iter().flat_map(|section| &section.figures) {
        let (name, rest) = split_name(&finding(figure));
        let _ = writeln!(
            html,
            "<li><a href=\"#figure-{}\">{}</a> {}</li>",
            figure.number,
            escaped(&name),
            escaped(&rest)
        );
    }
    html.push_str("</ul>\n");
    for section in sections {
        let _ = write!(
            html,
            "<section>\n<h2>{}</h2>\n<p>{}</p>\n",
            section.heading,
            escaped(&section.text)
        );
        for figure in &section.figures {
            write_figure(&mut html, figure);
        }
        html.push_str("</section>\n");
    }
    html.push_str("<section class=\"parameters\">\n<h2>Parameters</h2>\n<table>\n<tbody>\n");
    for (name, value) in parameters {
        let _ = writeln!(
            html,
            "<tr><th scope=\"row\">{}</th><td>{}</td></tr>",
            escaped(name),
            escaped(value)
        );
    }
    html.push_str("</tbody>\n</table>\n<p>Further settings of each figure, and the file next to this page with its numbers:</p>\n<table>\n<tbody>\n");
    for figure in sections.iter().flat_map(|section| &section.figures) {
        let _ = writeln!(
            html,
            "<tr><th scope=\"row\">Figure {}</th><td>{}</td><td>{}</td><td><code>{}</code></td></tr>",
            figure.number,
            escaped(&figure.title),
            escaped(&figure.parameters),
            figure.csv.name
        );
    }
    html.push_str("</tbody>\n</table>\n</section>\n");
    page(TITLE, &html)
}

/// Splits a finding into "Figure 3." and the rest.
fn split_name(finding: &str) -> (String, String) {
    match finding.split_once(". ") {
        Some((name, rest)) => (format!("{name}."), rest.to_owned()),
        None => (finding.to_owned(), String::new()),
    }
}

fn write_figure(html: &mut String, figure: &Figure) {
    let _ = write!(
        html,
        "<figure id=\"figure-{0}\">\n<div class=\"drawing\" role=\"img\" aria-label=\"{1}\">{2}</div>\n\
         <figcaption><b>Figure {0}. {1}.</b> {3} <span class=\"found\">{4}</span> \
         <span class=\"source\">Numbers: <code>{5}</code>.</span></figcaption>\n",
        figure.number,
        escaped(&figure.title),
        figure.svg,
        escaped(&figure.shows),
        escaped(&figure.found),
        figure.csv.name
    );
    if let Some(table) = &figure.table {
        write_table(html, table);
    }
    html.push_str("</figure>\n");
}

fn write_table(html: &mut String, table: &Table) {
    html.push_str("<table>\n<thead><tr>");
    for cell in &table.head {
        let _ = write!(html, "<th scope=\"col\">{}</th>", escaped(cell));
    }
    html.push_str("</tr></thead>\n<tbody>\n");
    for row in &table.rows {
        html.push_str("<tr>");
        for (i, cell) in row.iter().enumerate() {
            let tag = if i == 0 { "th scope=\"row\"" } else { "td" };
            let end = if i == 0 { "th" } else { "td" };
            let _ = write!(html, "<{tag}>{}</{end}>", escaped(cell));
        }
        html.push_str("</tr>\n");
    }
    html.push_str("</tbody>\n</table>\n");
}
