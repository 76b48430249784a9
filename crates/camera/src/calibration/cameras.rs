//! Finds the cameras of a file: the maps that contain a camera matrix, anywhere in the tree.

use super::names::{FX, FY, INTRINSICS, MATRIX, OTHER_SIDES, SIDES, TOPIC};
use super::{find, squeezed};
use crate::document::Node;

/// A camera in a file.
pub(super) struct Found<'a> {
    /// Key of its map, for use in a sentence.
    pub(super) name: String,
    /// Its map, then the enclosing maps, which may contain values common to all cameras.
    scope: Vec<&'a Node>,
    /// Suffix of its keys, if two cameras share a map.
    side: &'static str,
}

impl<'a> Found<'a> {
    /// Returns an entry of its own map.
    pub(super) fn own(&self, names: &[&str]) -> Option<(&'a str, &'a Node)> {
        sided(self.scope[0], names, self.side)
    }

    /// Returns an entry of its own map or of an enclosing map.
    pub(super) fn any(&self, names: &[&str]) -> Option<(&'a str, &'a Node)> {
        self.own(names)
            .or_else(|| self.scope.iter().find_map(|map| find(map, names)))
    }

    pub(super) fn map(&self) -> &'a Node {
        self.scope[0]
    }

    /// Topic of its images, if the file contains it.
    pub(super) fn topic(&self) -> Option<&'a str> {
        match self.own(&TOPIC) {
            Some((_, Node::Scalar(topic))) => Some(topic),
            _ => None,
        }
    }
}

/// Returns all cameras, in the order of the file.
pub(super) fn cameras(file: &Node) -> Vec<Found<'_>> {
    let mut found = Vec::new();
    look("the file's own", file, &mut Vec::new(), &mut found);
    // ORB-SLAM and ost.ini have separate maps for common values.
    let shared = ["camera", "image"].map(|name| find(file, &[name]));
    for (_, map) in shared.into_iter().flatten() {
        found.iter_mut().for_each(|found| found.scope.push(map));
    }
    found
}

fn look<'a>(name: &str, node: &'a Node, around: &mut Vec<&'a Node>, found: &mut Vec<Found<'a>>) {
    if let Some(side) = SIDES.into_iter().find(|side| holds_camera(node, side)) {
        let mut add = |side, name: String| {
            let scope = std::iter::once(node).chain(around.iter().rev().copied());
            found.push(Found {
                name,
                scope: scope.collect(),
                side,
            });
        };
        let mut other = OTHER_SIDES
            .into_iter()
            .filter(|side| holds_camera(node, side));
        match other.next().filter(|_| !side.is_empty()) {
            None => add(side, name.to_owned()),
            Some(other) => {
                add(side, format!("camera {side}"));
                add(other, format!("camera {other}"));
            }
        }
        return;
    }
    match node {
        Node::Scalar(_) => {}
        Node::List(list) => {
            for (index, entry) in list.iter().enumerate() {
                look(&format!("{name} {}", index + 1), entry, around, found);
            }
        }
        Node::Map(entries) => {
            around.push(node);
            for (key, value) in entries {
                look(key, value, around, found);
            }
            around.pop();
        }
    }
}

/// Returns true if a map's own entries describe a camera.
fn holds_camera(map: &Node, side: &str) -> bool {
    let intrinsics = sided(map, &INTRINSICS, side);
    sided(map, &MATRIX, side).is_some()
        || intrinsics.is_some_and(|(_, value)| is_matrix(value))
        || (sided(map, &FX, side).is_some() && sided(map, &FY, side).is_some())
}

/// Returns true if a value looks like a matrix, or like focal lengths and a principal point.
pub(super) fn is_matrix(value: &Node) -> bool {
    match value {
        Node::Scalar(_) => false,
        Node::List(list) => list.first().is_some_and(|entry| match entry {
            Node::List(row) => matches!(row[..], [Node::Scalar(_), ..]),
            entry => matches!(entry, Node::Scalar(_)),
        }),
        Node::Map(_) => find(value, &["data"]).is_some() || find(value, &FX).is_some(),
    }
}

/// Finds the first of these names, with this suffix, in a map.
fn sided<'a>(map: &'a Node, names: &[&str], side: &str) -> Option<(&'a str, &'a Node)> {
    (names.iter()).find_map(|name| {
        // K1 is never a matrix: k1 is a coefficient.
        let is_coefficient = *name == "k" && !side.is_empty();
        let is_it = |key: &str| squeezed(key).eq(name.chars().chain(side.chars()));
        map.get(is_it).filter(|_| !is_coefficient)
    })
}
