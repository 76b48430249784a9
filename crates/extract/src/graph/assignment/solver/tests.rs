//! The solver against all assignments of small clusters.

use lariat_portable::SplitMix64;
use proptest::prelude::*;

use super::*;

/// Cost of these choices, one for each slot of the cluster, counted as `Problem` says.
fn cost_of(problem: &Problem, choices: &[(u8, Choice)]) -> f32 {
    let count = problem.edges.len();
    let mut next = vec![ENDED; 2 * count];
    let (mut is_leg, mut passes) = (vec![true; count], vec![0; count]);
    let mut cost = 0.0;
    for &(slot, choice) in choices {
        match choice {
            Choice::End => cost += problem.end_costs[usize::from(slot)],
            Choice::NoLeg => is_leg[usize::from(slot / 2)] = false,
            Choice::Join(j) => {
                let join = &problem.joins[j as usize];
                let [a, b] = join.slots;
                (next[usize::from(a)], next[usize::from(b)]) = (b, a);
                cost += join.cost;
                (0..count)
                    .filter(|e| join.passed >> e & 1 == 1)
                    .for_each(|e| passes[e] += 1);
            }
        }
    }
    for e in 0..count {
        let kind = match (is_leg[e], passes[e]) {
            (false, 0) => 0,
            (true, 0) => 1,
            (false, 1) => 3,
            _ => 2,
        };
        cost += problem.edges[e].0[kind];
    }
    // Every leg of a ring comes back to itself.
    let is_ring = |start: u8| {
        let mut slot = start;
        loop {
            match next[usize::from(slot ^ 1)] {
                ENDED => return None,
                on if on == start => return Some(()),
                on => slot = on,
            }
        }
    };
    let mut seen = vec![false; count];
    for e in (0..count).filter(|&e| is_leg[e]) {
        if !seen[e] && is_ring(2 * e as u8).is_some() {
            cost += problem.ring_cost;
            let mut slot = 2 * e as u8;
            while !seen[usize::from(slot / 2)] {
                seen[usize::from(slot / 2)] = true;
                slot = next[usize::from(slot ^ 1)];
            }
        }
    }
    cost
}

/// The least cost of all assignments that continue these choices.
fn least(problem: &Problem, choices: &mut Vec<(u8, Choice)>, decided: u16) -> f32 {
    let is_open = |slot: u8| decided >> slot & 1 == 0;
    let Some(&slot) = problem.order.iter().find(|&&slot| is_open(slot)) else {
        return cost_of(problem, choices);
    };
    let mut options = vec![(Choice::End, 1 << slot)];
    if problem.is_inside[usize::from(slot ^ 1)] && is_open(slot ^ 1) {
        options.push((Choice::NoLeg, 1 << slot | 1 << (slot ^ 1)));
    }
    for (j, join) in problem.joins.iter().enumerate() {
        let [a, b] = join.slots;
        if (a == slot || b == slot) && is_open(a) && is_open(b) {
            options.push((Choice::Join(j as u32), 1 << a | 1 << b));
        }
    }
    let mut best = f32::INFINITY;
    for (choice, slots) in options {
        choices.push((slot, choice));
        best = best.min(least(problem, choices, decided | slots));
        choices.pop();
    }
    best
}

/// A cluster of a few edges with random costs and joins. Some edges leave it.
fn cluster(seed: u64, edges: usize) -> Problem {
    let mut random = SplitMix64::new(seed);
    let mut up_to = |most: f32| most * random.unit_f32();
    let mut problem = Problem::default();
    problem.begin(edges, up_to(4.0));
    for slot in 0..2 * edges as u8 {
        let leaves = slot % 2 == 1 && up_to(1.0) < 0.3;
        if !leaves {
            problem.add_slot(slot, up_to(4.0));
        }
    }
    for _ in 0..edges {
        problem.edges.push(EdgeCosts([(); 4].map(|()| up_to(2.0))));
    }
    let slots = problem.order.clone();
    for (k, &a) in slots.iter().enumerate() {
        for &b in &slots[k + 1..] {
            if up_to(1.0) < 0.6 {
                let may_be_passed = |&e: &usize| {
                    let own = [a / 2, b / 2].contains(&(e as u8));
                    !own && problem.is_inside[2 * e] && problem.is_inside[2 * e + 1]
                };
                let passed = (0..edges).filter(may_be_passed).map(|e| 1 << e);
                let passed = passed
                    .filter(|_| up_to(1.0) < 0.3)
                    .fold(0, |all, e| all | e);
                problem.joins.push(Join {
                    slots: [a, b],
                    cost: up_to(4.0),
                    passed,
                });
            }
        }
    }
    problem
}

proptest! {
    #[test]
    fn the_cheapest_assignment_of_all_is_found(seed in any::<u64>(), edges in 1_usize..5) {
        let problem = cluster(seed, edges);
        let mut solver = Solver::default();
        solver.solve(&problem);
        let outside = (0..2 * edges).filter(|&slot| !problem.is_inside[slot]);
        let decided = outside.fold(0, |all, slot| all | 1 << slot);
        let best = least(&problem, &mut Vec::new(), decided);
        let found = solver.costs().next().expect("every cluster has an assignment");
        prop_assert!((found - best).abs() < 1e-3, "{found} instead of {best}");
    }

    #[test]
    fn each_assignment_costs_what_is_said(seed in any::<u64>(), edges in 1_usize..8) {
        let problem = cluster(seed, edges);
        let mut solver = Solver::default();
        solver.solve(&problem);
        let mut last = f32::NEG_INFINITY;
        for (k, cost) in solver.costs().enumerate() {
            let choices: Vec<_> = solver.choices(k).collect();
            let said = cost_of(&problem, &choices);
            prop_assert!((cost - said).abs() < 1e-3, "{cost}, but its choices cost {said}");
            prop_assert!(cost >= last);
            last = cost;
        }
    }
}
