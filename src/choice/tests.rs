use super::{
    cost::{Cost, NOTHING, SLACK, pressure, weighted},
    relax::{Linear, relax},
    search::search,
    solve::{Candidate, Group, Item, Picked, Problem, choose},
};
use proptest::prelude::*;

/// All ways to pick one of each.
fn ways(counts: &[usize]) -> Vec<Vec<usize>> {
    counts.iter().fold(vec![Vec::new()], |ways, count| {
        let longer = |way: &Vec<usize>| {
            let way = way.clone();
            (0..*count).map(move |j| way.iter().copied().chain([j]).collect::<Vec<_>>()).collect::<Vec<_>>()
        };
        ways.iter().flat_map(longer).collect()
    })
}

fn costs() -> impl Strategy<Value = Cost> {
    proptest::array::uniform4(0_u32..40).prop_map(|c| c.map(f64::from))
}

fn budget() -> impl Strategy<Value = [Option<f64>; 4]> {
    proptest::array::uniform4(proptest::option::of((5_u32..160).prop_map(f64::from)))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn what_is_found_is_the_best_of_all(
        items in proptest::collection::vec(proptest::collection::vec(costs(), 1..4), 1..7),
        weights in costs(),
        budget in budget(),
    ) {
        let linear = Linear { items: &items, fixed: NOTHING, weights, budget };
        let all = ways(&items.iter().map(Vec::len).collect::<Vec<_>>());
        let within = all.iter().filter(|way| linear.pressure(way) <= SLACK).map(|way| linear.cost(way));
        let cheapest = within.fold(f64::INFINITY, f64::min);
        let least = all.iter().map(|way| linear.pressure(way)).fold(f64::INFINITY, f64::min);
        let mut found = relax(&linear);
        // The bounds hold before anything is searched.
        prop_assert!(found.bound <= cheapest + 1e-6, "{} of {cheapest}", found.bound);
        prop_assert!(found.least_pressure <= least + 1e-6);
        prop_assert!((linear.cost(&found.picks) - found.cost).abs() < 1e-6);
        prop_assert!((linear.pressure(&found.picks) - found.pressure).abs() < 1e-9);
        prop_assert!(search(&linear, &mut found));
        if cheapest.is_finite() {
            prop_assert!(found.pressure <= SLACK && (found.cost - cheapest).abs() < 1e-6, "{} of {cheapest}", found.cost);
            prop_assert!((found.bound - found.cost).abs() < 1e-6);
        } else {
            // The nearest: single exchanges leave little.
            prop_assert!(found.pressure > SLACK);
            prop_assert!(found.pressure <= 2.0 * least + 1e-9, "{} of {least}", found.pressure);
        }
    }

    #[test]
    fn groups_and_shared_things_count_once(
        own in proptest::collection::vec((costs(), proptest::collection::btree_set(0_usize..3, 0..3), costs(), any::<bool>()), 1..6),
        shared in proptest::collection::vec(costs(), 3),
        group in (costs(), any::<bool>(), 0_usize..3),
        weights in costs(),
        budget in budget(),
    ) {
        let item = |(n, (own, shares, cost, meets)): (usize, &(Cost, std::collections::BTreeSet<usize>, Cost, bool))| Item {
            name: n.to_string(),
            own: *own,
            shares: shares.iter().copied().collect(),
            candidates: vec![Candidate { name: "a".into(), cost: *cost, shares: vec![n % 3], meets: *meets }],
        };
        let items: Vec<Item> = own.iter().enumerate().map(item).collect();
        let members = (group.2.min(items.len())..items.len()).collect();
        let groups = vec![Group { name: "far".into(), members, cost: group.0, meets: group.1 }];
        let problem = Problem { items, groups, shared, weights, budget };
        let found = choose(&problem);
        // What it says of itself.
        let total = problem.total(&found.picks, found.group);
        prop_assert_eq!(total, found.total);
        prop_assert_eq!(pressure(&total, &budget), found.pressure);
        prop_assert_eq!(weighted(&total, &weights), found.cost);
        for (i, pick) in found.picks.iter().enumerate() {
            let covered = found.group.is_some_and(|g| problem.groups[g].members.contains(&i));
            prop_assert_eq!(*pick == Picked::Group, covered);
            prop_assert!(*pick != Picked::Candidate(0) || problem.items[i].candidates[0].meets);
        }
        prop_assert!(found.group.is_none() || group.1);
        // Against all others.
        let mut cheapest = f64::INFINITY;
        for group in std::iter::once(None).chain(group.1.then_some(Some(0))) {
            for way in ways(&vec![2; problem.items.len()]) {
                let pick = |(i, j): (usize, &usize)| match j {
                    _ if group.is_some_and(|g: usize| problem.groups[g].members.contains(&i)) => Picked::Group,
                    0 if problem.items[i].candidates[0].meets => Picked::Candidate(0),
                    _ => Picked::Original,
                };
                let picks: Vec<Picked> = way.iter().enumerate().map(pick).collect();
                let total = problem.total(&picks, group);
                if pressure(&total, &budget) <= SLACK {
                    cheapest = cheapest.min(weighted(&total, &weights));
                }
            }
        }
        prop_assert!(found.bound.min(1e300) <= cheapest + 1e-6, "{} of {cheapest}", found.bound);
        prop_assert!(!found.proved || found.pressure > SLACK || found.cost <= cheapest + 1e-6, "{} of {cheapest}", found.cost);
        prop_assert!(!found.proved || found.pressure <= SLACK || cheapest == f64::INFINITY);
    }
}

fn simple(own: f64, stand_in: f64, meets: bool) -> Item {
    let cost = |c: f64| [c, 0.0, 0.0, 0.0];
    let candidates = vec![Candidate { name: "a".into(), cost: cost(stand_in), shares: Vec::new(), meets }];
    Item { name: "o".into(), own: cost(own), shares: Vec::new(), candidates }
}

#[test]
fn the_cheapest_that_is_good_enough_is_taken() {
    let items = vec![simple(100.0, 10.0, true), simple(100.0, 1.0, false), simple(5.0, 10.0, true)];
    let problem = Problem { items, weights: [1.0, 0.0, 0.0, 0.0], ..Problem::default() };
    let found = choose(&problem);
    assert_eq!(found.picks, [Picked::Candidate(0), Picked::Original, Picked::Original]);
    assert!(found.cost == 115.0 && found.bound == 115.0 && found.proved && found.pressure == 0.0);
}

#[test]
fn a_budget_that_nothing_meets_gives_the_nearest() {
    let items = vec![simple(100.0, 10.0, true), simple(50.0, 20.0, true)];
    let problem =
        Problem { items, weights: [0.0, 0.0, 0.0, 1.0], budget: [Some(15.0), None, None, None], ..Problem::default() };
    let found = choose(&problem);
    assert_eq!(found.picks, [Picked::Candidate(0); 2]);
    assert!(found.proved && found.pressure == 2.0);
}

#[test]
fn a_texture_of_all_is_kept_by_all_or_none() {
    // Each alone would gain by a stand-in of 30 against 10 and a texture of 100; all ten together do not.
    let mut items = vec![simple(10.0, 30.0, true); 10];
    items.iter_mut().for_each(|item| item.shares = vec![0]);
    let shared = vec![[100.0, 0.0, 0.0, 0.0]];
    let problem = Problem { items, shared, weights: [1.0, 0.0, 0.0, 0.0], ..Problem::default() };
    let found = choose(&problem);
    assert!(found.cost == 200.0 && found.proved, "{found:?}");
    assert_eq!(found.picks, [Picked::Original; 10]);
}

#[test]
fn many_objects_are_chosen_for_near_their_bound() {
    let mut state = 7_u64;
    let mut next = |n: u64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) % n) as f64
    };
    let items: Vec<Vec<Cost>> =
        (0..2000).map(|_| (0..4).map(|_| [next(1000), next(5000), next(9000), 1.0]).collect()).collect();
    let weights = [1.0, 0.02, 0.0, 0.0];
    let free = relax(&Linear { items: &items, fixed: NOTHING, weights, budget: [None; 4] });
    let total = items.iter().zip(&free.picks).fold(NOTHING, |s, (i, p)| std::array::from_fn(|r| s[r] + i[*p][r]));
    let budget = [None, Some(total[1] * 0.6), Some(total[2] * 0.7), None];
    let mut found = relax(&Linear { items: &items, fixed: NOTHING, weights, budget });
    assert!(found.pressure <= SLACK && found.cost - found.bound < 0.002 * found.cost, "{} {}", found.cost, found.bound);
    search(&Linear { items: &items, fixed: NOTHING, weights, budget }, &mut found);
    assert!(found.pressure <= SLACK && found.bound <= found.cost);
}
