//! Parses OpenCV's XML: elements become maps, elements named `_` become lists, and words between
//! elements become numbers.

use super::{DEEPEST, Node};
use crate::calibration::CalibrationError;
use roxmltree::{Document, Node as Element};

pub(super) fn read(text: &str) -> Result<Node, CalibrationError> {
    let document =
        Document::parse(text).map_err(|error| CalibrationError::Xml(error.to_string()))?;
    node(&document, document.root_element(), DEEPEST)
}

fn node(document: &Document, element: Element, deeper: usize) -> Result<Node, CalibrationError> {
    let children: Vec<_> = element.children().filter(Element::is_element).collect();
    if children.is_empty() {
        return Ok(words(element.text().unwrap_or_default()));
    }
    let Some(deeper) = deeper.checked_sub(1) else {
        let line = document.text_pos_at(element.range().start).row;
        return Err(CalibrationError::TooDeep(line as usize));
    };
    let is_list = children.iter().all(|child| child.has_tag_name("_"));
    let values = children.into_iter().map(|child| {
        let value = node(document, child, deeper)?;
        Ok((child.tag_name().name().to_owned(), value))
    });
    let values = values.collect::<Result<Vec<_>, CalibrationError>>()?;
    Ok(match is_list {
        true => Node::List(values.into_iter().map(|(_, value)| value).collect()),
        false => Node::Map(values),
    })
}

/// Several numbers are a list; anything else is a text.
fn words(text: &str) -> Node {
    let scalar = |word: &str| Node::Scalar(word.to_owned());
    let text = text.trim();
    let are_numbers =
        |mut words: std::str::SplitWhitespace| words.all(|word| word.parse::<f64>().is_ok());
    match text.contains(char::is_whitespace) && are_numbers(text.split_whitespace()) {
        true => Node::List(text.split_whitespace().map(scalar).collect()),
        false => scalar(text.trim_matches('"')),
    }
}
