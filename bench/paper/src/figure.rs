//! A figure as the page shows it: drawing, words, table, and the numbers behind it.

use crate::Csv;

/// A part of the page.
#[derive(Debug, Clone)]
pub(crate) struct Section {
    pub(crate) heading: &'static str,
    /// What it is about, and what the paper says of it.
    pub(crate) text: String,
    pub(crate) figures: Vec<Figure>,
}

/// One figure.
#[derive(Debug, Clone)]
pub(crate) struct Figure {
    /// The paper's number for the first three.
    pub(crate) number: usize,
    pub(crate) title: String,
    pub(crate) svg: String,
    /// What is drawn, in words.
    pub(crate) shows: String,
    /// What was found: made from the numbers of this run.
    pub(crate) found: String,
    pub(crate) table: Option<Table>,
    /// What its numbers depend on beside the parameters of the whole page.
    pub(crate) parameters: String,
    pub(crate) csv: Csv,
}

/// A table: the first column names the row, the others are numbers or words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Table {
    pub(crate) head: Vec<String>,
    pub(crate) rows: Vec<Vec<String>>,
}

impl Table {
    pub(crate) fn new(head: &[&str]) -> Self {
        Self {
            head: head.iter().map(|&cell| cell.to_owned()).collect(),
            rows: Vec::new(),
        }
    }

    pub(crate) fn row(&mut self, cells: Vec<String>) {
        self.rows.push(cells);
    }
}
