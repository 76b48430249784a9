//! Hidden ways that were taken for each other.
//!
//! Where two strands run into a thing at one place, they may be read the wrong way around, and what is known of them is then wrong for
//! as long as the thing lies there. Once their ends are apart it shows: the ways bend back sharply, and others between the same ends
//! run on.

use super::{Bridger, COVERED, Candidate};
use crate::graph::pairing::bending;
use crate::occlusion::ends::{End, FLAW, Scenery, shown};
use crate::occlusion::way;
use crate::vec2;

/// The share of the bending of two ways under a thing that two others there have, for them to be taken.
const STRAIGHTER: f32 = 0.25;

impl Bridger {
    /// Takes other ways under a thing for those that were chosen, where the former bend back sharply or lead over the bare table and the
    /// others run on: they were taken for each other where both ran in or out at one place.
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

    /// Takes these two ways for two that were chosen, if they are so much straighter.
    fn straighten(&mut self, chosen: [usize; 2], ways: [[usize; 2]; 2], scenery: &Scenery) -> bool {
        let bending = |ways: [[usize; 2]; 2]| -> f32 {
            let bent = ways.map(|[i, j]| bent(&self.ends[i], &self.ends[j]));
            bent.iter().sum()
        };
        let former = chosen.map(|at| self.candidates[at].ends);
        bending(ways) < STRAIGHTER * bending(former) && self.take(chosen, ways, scenery)
    }

    /// Whether a way leads over the bare table.
    fn is_bare(&self, of: &Candidate, scenery: &Scenery) -> bool {
        let [a, b] = of.ends.map(|end| &self.ends[end]);
        let way = of.way.map(|way| (way, scenery.past));
        !a.leaves
            && vec2::distance(a.at, b.at) > FLAW.0 * a.width_px
            && shown(a.at, b.at, scenery) < COVERED
            && way::covered(a, b, way, scenery) < COVERED
    }

    /// Takes a way under a thing for way `k`: between the other ends of both of its lines, or of one.
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

    /// Takes these ways for those that were chosen, if they lie under something in the picture and close no ring. Whether it does.
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

    /// Whether who goes on from one of the chosen ways, along lines and others of these, comes back to it.
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

/// The energy of bending between two ends.
fn bent(a: &End, b: &End) -> f32 {
    let chord_px = vec2::distance(a.at, b.at).max(a.width_px);
    bending(a.at, a.out, b.at, vec2::scale(b.out, -1.0)) / chord_px
}
