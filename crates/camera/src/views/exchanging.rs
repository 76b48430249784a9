//! Strands that a view takes for each other where they touch: the other view tells which goes on as which.
//!
//! Where strands lie along each other in one view, it may have them cross once too often there, or once too few. The rope is then another one
//! behind that contact, up to where it comes back to it: that part is passed the other way round. Or, where strands touch twice, as a twist does, each
//! is on the other's place between. Such a curve goes less well with that of the other view; so it is tried whether they go together better with
//! its parts turned at one or two of its contacts.

use super::curve::Curve;
use super::matching::{Matching, ROWS};
use super::pair::ViewPair;

/// Parts are turned if the pair's chain lacks no more than this share of what it lacked, and by this less, of 1 that a chain has at most. Of 72 drawn
/// ropes it is 0.2 at most where that is right, and 0.65 at least elsewhere.
const LACKING: f64 = 0.4;
const BETTER: f64 = 0.01;
/// Strands touch where their axes are nearer to each other than so many of the mean of their widths, if along the rope there are so many between.
const NEAR: f64 = 1.5;
const LEAST_LOOP: f64 = 3.0;
/// Contacts of a curve, at most.
const MOST_CONTACTS: usize = 6;

/// A curve's two places at a contact: after which of its points.
type Contact = [usize; 2];

/// Room.
#[derive(Debug, Clone, Default)]
pub(super) struct Exchanging {
    /// Of each point how far the nearest other strand is, in widths and squared, and where.
    near: Vec<(f64, usize)>,
    contacts: Vec<Contact>,
}

impl Exchanging {
    /// Turns parts of a pair's curves, if that makes them go together far better. Says whether the second one's points come in the opposite
    /// order then, and takes what it does off the steps that are `left`.
    pub(super) fn exchange(
        &mut self,
        cameras: &ViewPair,
        curves: [&mut Curve; 2],
        (is_backward, score): (bool, f64),
        (matching, left): (&mut Matching, &mut usize),
    ) -> bool {
        let [first, second] = curves;
        // No chain is better than 1.
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

    /// Finds where a curve touches itself: where its strands are nearest to each other.
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

/// How a pair goes together.
enum Judged {
    /// By this score, and whether the second one's points come in the opposite order.
    Better(f64, bool),
    NoBetter,
    /// Too few steps are left to say so.
    TooMuch,
}

/// Whether a pair goes together better than by this score.
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

/// Turns a curve's parts between the two places of each of these.
fn turn(curve: &mut Curve, contacts: [Option<Contact>; 2]) {
    for [from, to] in contacts.into_iter().flatten() {
        curve.sights[from + 1..=to].reverse();
        curve.hidden[from + 1..=to].reverse();
    }
}

/// Where a contact is once a curve was turned at another.
fn after([from, to]: Contact, other: Contact) -> Contact {
    let mut moved = other.map(|at| match (from..=to).contains(&at) {
        true => from + to - at,
        false => at,
    });
    moved.sort_unstable();
    moved
}
