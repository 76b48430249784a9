//! Corrects hidden ways that were mistaken for each other.
//!
//! If two strands run into an occluder at one place, their ways may be exchanged. The prior then
//! stays wrong for as long as the occluder is there. Once their ends separate, the error shows: the
//! ways bend back sharply, and other ways between the same ends are straight.

use super::{Bridger, COVERED, Candidate};
use crate::graph::bending::bending;
use crate::occlusion::ends::{End, FLAW, Scenery, shown};
use crate::occlusion::way;
use crate::vec2;

/// Maximum bending of two ways that replace two others under an occluder, as a share of the others'
/// bending.
const STRAIGHTER: f32 = 0.25;

impl Bridger {
    /// Replaces chosen ways by others under an occluder: pairs that bend back sharply by straight
    /// ones, and ways over the bare table by covered ones. This overrules the prior.
    pub(super) fn reassign(&mut self, scenery: &Scenery) {
        for k in 0..self.candidates.len() {
            for l in 0..k {
                let ([a, b], [c, d]) = (self.candidates[l].ends, self.candidates[k].ends);
                let _ = self.straighten([l, k], [[a, c], [b, d]], scenery)
                    || self.straighten([l, k], [[a, d], [b, c]], scenery);
            }
            if self.is_bare(&self.candidates[k], scenery) {
                self.cover(k, scenery);
            }
        }
    }

    /// Replaces two chosen ways by `ways` if these bend less than `STRAIGHTER` times as much, and
    /// `take` accepts them. Bending is per pixel of gap.
    fn straighten(&mut self, chosen: [usize; 2], ways: [[usize; 2]; 2], scenery: &Scenery) -> bool {
        let bending = |ways: [[usize; 2]; 2]| -> f32 {
            let bent = ways.map(|[i, j]| bent(&self.ends[i], &self.ends[j]));
            bent.iter().sum()
        };
        let former = chosen.map(|at| self.candidates[at].ends);
        bending(ways) < STRAIGHTER * bending(former) && self.take(chosen, ways, scenery)
    }

    /// Returns whether a way is longer than a flaw of the mask and leads over the bare table: the
    /// straight line shows too much table, and the way itself is not covered.
    fn is_bare(&self, of: &Candidate, scenery: &Scenery) -> bool {
        let [a, b] = of.ends.map(|end| &self.ends[end]);
        let way = of.way.map(|way| (way, scenery.past));
        !a.leaves
            && vec2::distance(a.at, b.at) > FLAW.0 * a.width_px
            && shown(a.at, b.at, scenery) < COVERED
            && way::covered(a, b, way, scenery) < COVERED
    }

    /// Replaces way `k` by a covered one: between the other ends of both of its lines, or between
    /// one of them and one of its own ends.
    fn cover(&mut self, k: usize, scenery: &Scenery) {
        let [a, b] = self.candidates[k].ends;
        let [c, d] = [a, b].map(|e| self.far(e).filter(|&far| !self.ends[far].used));
        let others = [c.zip(d), Some(a).zip(d), c.zip(Some(b))];
        let mut others = others.into_iter().flatten();
        if let Some((c, d)) = others.find(|&(c, d)| self.take([k], [[c, d]], scenery)) {
            for (former, now) in [a, b].into_iter().zip([c, d]) {
                self.ends[former].used = former == now;
                self.ends[now].used = true;
            }
        }
    }

    /// The other end of an end's line.
    fn far(&self, end: usize) -> Option<usize> {
        let mut ends = (0..self.ends.len()).filter(|&e| self.ends[e].line == self.ends[end].line);
        ends.find(|&e| e != end)
    }

    /// Replaces the chosen ways by these if they are under an occluder, inside the image, and close
    /// no ring. Returns whether it did.
    fn take<const N: usize>(
        &mut self,
        chosen: [usize; N],
        ways: [[usize; 2]; N],
        scenery: &Scenery,
    ) -> bool {
        let mut covered =
            (ways.iter()).map(|&[i, j]| way::covered(&self.ends[i], &self.ends[j], None, scenery));
        let is_within = ways.iter().flatten().all(|&end| !self.ends[end].leaves);
        if !is_within || !covered.all(|share| share >= COVERED) {
            return false;
        }
        let former = chosen.map(|at| self.candidates[at]);
        for (at, ends) in chosen.into_iter().zip(ways) {
            let candidate = &mut self.candidates[at];
            (candidate.ends, candidate.way) = (ends, None);
        }
        let is_ring = chosen.into_iter().any(|at| self.is_ring(at));
        if is_ring {
            for (at, former) in chosen.into_iter().zip(former) {
                self.candidates[at] = former;
            }
        }
        self.is_reassigned |= !is_ring;
        !is_ring
    }

    /// Returns whether the chosen way `start` is part of a ring of lines and chosen ways.
    fn is_ring(&self, start: usize) -> bool {
        let mut at = self.candidates[start].ends[1];
        while let Some(far) = self.far(at) {
            let ways = self.candidates.iter().enumerate();
            let mut ways = ways.filter(|(_, way)| way.ends.contains(&far));
            match ways.next() {
                None => return false,
                Some((way, _)) if way == start => return true,
                Some((_, way)) => at = way.ends[usize::from(way.ends[0] == far)],
            }
        }
        false
    }
}

/// Bending energy between two ends, divided by their distance.
fn bent(a: &End, b: &End) -> f32 {
    let chord_px = vec2::distance(a.at, b.at).max(a.width_px);
    bending(a.at, a.out, b.at, vec2::scale(b.out, -1.0)) / chord_px
}
