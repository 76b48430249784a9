//! Corrects strands that a view confuses where they touch. The other view shows how the strands
//! continue.
//!
//! If strands run along each other in one view, one crossing too many or too few may be seen there.
//! From such a contact on, the rope is then traced in the opposite direction until it returns to
//! the contact. If strands touch twice, as in a twist, each may instead be in the other's place
//! between the contacts. Such a curve matches the other view less well. Reversing its parts at one
//! or two contacts is therefore tried, to see if the match improves.

use super::curve::Curve;
use super::matching::{Matching, ROWS};
use super::pair::ViewPair;

/// Parts are reversed only if the score then rises by at least `BETTER`, and its deficit (1 minus
/// the score) shrinks to at most this share. For 72 drawn ropes, the share is at most 0.2 where
/// reversing is right, and at least 0.65 elsewhere.
const LACKING: f64 = 0.4;
const BETTER: f64 = 0.01;
/// Strands touch if their axes are closer than this, in mean widths, and if at least `LEAST_LOOP`
/// widths of rope are between them.
const NEAR: f64 = 1.5;
const LEAST_LOOP: f64 = 3.0;
/// Maximum number of contacts of a curve.
const MOST_CONTACTS: usize = 6;

/// The two places of a curve that touch at a contact, as the numbers of the points before these
/// places.
type Contact = [usize; 2];

/// Working memory.
#[derive(Debug, Clone, Default)]
pub(super) struct Exchanging {
    /// For each point, the squared distance to the nearest other strand, in widths, and the nearest
    /// point of that strand.
    near: Vec<(f64, usize)>,
    contacts: Vec<Contact>,
}

impl Exchanging {
    /// Reverses parts of a pair's curves if they then match far better. Returns whether the second
    /// curve's points are then in the opposite order. Subtracts its work from the steps that are
    /// `left`.
    pub(super) fn exchange(
        &mut self,
        cameras: &ViewPair,
        curves: [&mut Curve; 2],
        (is_backward, score): (bool, f64),
        (matching, left): (&mut Matching, &mut usize),
    ) -> bool {
        let [first, second] = curves;
        // No score exceeds 1.
        if score + BETTER >= 1.0 {
            return is_backward;
        }
        let least = (1.0 - LACKING * (1.0 - score)).max(score + BETTER);
        let mut best = (least, is_backward, None);
        for view in [1, 0] {
            self.find_contacts([&*first, &*second][view]);
            for (k, &one) in self.contacts.iter().enumerate() {
                let others = self.contacts[k + 1..].iter().map(|&other| Some(other));
                for other in std::iter::once(None).chain(others) {
                    let way = [Some(one), other.map(|other| after(one, other))];
                    turn([&mut *first, &mut *second][view], way);
                    let judged = judge(cameras, [first, second], best.0, (matching, left));
                    turn([&mut *first, &mut *second][view], [way[1], way[0]]);
                    match judged {
                        Judged::Better(score, is_backward) => {
                            best = (score, is_backward, Some((view, way)));
                        }
                        Judged::NoBetter => {}
                        Judged::TooMuch => return is_backward,
                    }
                }
            }
        }
        if let (_, _, Some((view, way))) = best {
            turn([first, second][view], way);
        }
        best.1
    }

    /// Finds where a curve touches itself: where the distance between its strands has a minimum.
    fn find_contacts(&mut self, curve: &Curve) {
        self.near.clear();
        self.contacts.clear();
        if curve.closed {
            return;
        }
        let sights = &curve.sights;
        for (i, one) in sights.iter().enumerate() {
            let mut nearest = (f64::MAX, i);
            let loop_points = (LEAST_LOOP * 2.0 * one.slim / curve.step) as usize;
            let from = i.saturating_add(loop_points.max(2));
            for (j, other) in sights.iter().enumerate().skip(from) {
                let [x, y] = [0, 1].map(|c| one.ray[c] - other.ray[c]);
                let widths = one.slim + other.slim;
                let far2 = (x * x + y * y) / (widths * widths);
                if far2 < nearest.0 {
                    nearest = (far2, j);
                }
            }
            self.near.push(nearest);
        }
        for i in 1..self.near.len().saturating_sub(1) {
            let [(before, _), (far2, at), (after, _)] = [i - 1, i, i + 1].map(|k| self.near[k]);
            let is_contact = far2 < NEAR * NEAR && far2 < before && far2 <= after;
            if is_contact && self.contacts.len() < MOST_CONTACTS {
                self.contacts.push([i, at.min(sights.len() - 2)]);
            }
        }
    }
}

/// Result of matching a pair.
enum Judged {
    /// A better score, and whether the second curve's points are in the opposite order.
    Better(f64, bool),
    NoBetter,
    /// Too few steps are left to find out.
    TooMuch,
}

/// Matches a pair, and compares its score with this one.
fn judge(
    cameras: &ViewPair,
    curves: [&Curve; 2],
    than: f64,
    (matching, left): (&mut Matching, &mut usize),
) -> Judged {
    let every = curves[0].sights.len().div_ceil(ROWS).max(1);
    matching.look(cameras, curves, every);
    if matching.most() <= than {
        return Judged::NoBetter;
    }
    let Some(rest) = left.checked_sub(2 * matching.steps()) else {
        return Judged::TooMuch;
    };
    *left = rest;
    let [forward, backward] = [false, true].map(|way| matching.chain(cameras, curves, way));
    match forward.max(backward) > than {
        true => Judged::Better(forward.max(backward), backward > forward),
        false => Judged::NoBetter,
    }
}

/// Reverses a curve's parts between the two places of each contact.
fn turn(curve: &mut Curve, contacts: [Option<Contact>; 2]) {
    for [from, to] in contacts.into_iter().flatten() {
        curve.sights[from + 1..=to].reverse();
        curve.hidden[from + 1..=to].reverse();
    }
}

/// Returns where a contact is after the curve was reversed at another contact.
fn after([from, to]: Contact, other: Contact) -> Contact {
    let mut moved = other.map(|at| match (from..=to).contains(&at) {
        true => from + to - at,
        false => at,
    });
    moved.sort_unstable();
    moved
}
