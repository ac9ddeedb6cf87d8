//! The choice for a whole scene: groups, and what originals share.

use super::{
    cost::{Cost, NOTHING, SLACK, plus, pressure, weighted},
    relax::{Linear, Relaxed, relax},
    search::search,
};
use std::collections::BTreeSet;

/// A stand-in of an object.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    pub name: String,
    /// What it costs, but for what it shares.
    pub cost: Cost,
    /// Numbers in [`Problem::shared`], each once.
    pub shares: Vec<usize>,
    /// Whether it is good enough.
    pub meets: bool,
}

/// An object.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    pub name: String,
    /// What the object itself costs, but for what it shares. It is always good enough.
    pub own: Cost,
    pub shares: Vec<usize>,
    pub candidates: Vec<Candidate>,
}

/// A stand-in for several objects.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    pub name: String,
    /// Numbers of objects.
    pub members: Vec<usize>,
    pub cost: Cost,
    pub meets: bool,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Problem {
    pub items: Vec<Item>,
    pub groups: Vec<Group>,
    /// Costs of textures and meshes that several objects may use.
    pub shared: Vec<Cost>,
    pub weights: Cost,
    pub budget: [Option<f64>; 4],
}

/// What stands for an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Picked {
    Original,
    /// One of its candidates.
    Candidate(usize),
    /// The group that was taken.
    Group,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// Number of the group that is taken.
    pub group: Option<usize>,
    /// One for each object.
    pub picks: Vec<Picked>,
    pub total: Cost,
    /// Weighted total.
    pub cost: f64,
    /// The largest share of a budget that it takes; above 1 where it is the nearest that was found.
    pub pressure: f64,
    /// No choice within the budgets costs less.
    pub bound: f64,
    /// It is certain that no choice within the budgets costs less, or that none is within them.
    pub proved: bool,
}

/// How often the costs of what is shared are split anew.
const ROUNDS: usize = 6;

impl Item {
    /// What it costs with `pick`, but for what is shared, and what of that it uses.
    pub(super) fn paid(&self, pick: Picked) -> (Cost, &[usize]) {
        match pick {
            Picked::Original => (self.own, &self.shares),
            Picked::Candidate(j) => (self.candidates[j].cost, &self.candidates[j].shares),
            Picked::Group => (NOTHING, &[]),
        }
    }

    /// What it costs with `pick`, where `users` share each thing.
    pub(super) fn priced(&self, pick: Picked, shared: &[Cost], users: impl Fn(usize) -> f64) -> Cost {
        let (own, shares) = self.paid(pick);
        shares.iter().fold(own, |sum, s| plus(sum, shared[*s].map(|c| c / users(*s).max(1.0))))
    }
}

impl Problem {
    /// How many objects use each shared thing with `picks`.
    pub(super) fn users(&self, picks: &[Picked]) -> Vec<f64> {
        let mut users = vec![0.0; self.shared.len()];
        for (item, pick) in self.items.iter().zip(picks) {
            item.paid(*pick).1.iter().for_each(|s| users[*s] += 1.0);
        }
        users
    }

    /// What the scene costs with `picks`: each shared thing once.
    pub fn total(&self, picks: &[Picked], group: Option<usize>) -> Cost {
        let group = group.map_or(NOTHING, |g| self.groups[g].cost);
        let own = self.items.iter().zip(picks).fold(group, |sum, (item, pick)| plus(sum, item.paid(*pick).0));
        let used = self.shared.iter().zip(self.users(picks)).filter(|(_, users)| *users > 0.0);
        used.fold(own, |sum, (cost, _)| plus(sum, *cost))
    }

    fn choice(&self, picks: Vec<Picked>, group: Option<usize>) -> Choice {
        let total = self.total(&picks, group);
        let (cost, pressure) = (weighted(&total, &self.weights), pressure(&total, &self.budget));
        Choice { group, picks, total, cost, pressure, bound: 0.0, proved: false }
    }
}

/// The cheapest choice within the budgets, or the nearest to them that was found. Equal choices are decided by the order of groups, objects and candidates.
pub fn choose(problem: &Problem) -> Choice {
    let groups = (0..problem.groups.len()).filter(|g| problem.groups[*g].meets).map(Some);
    let mut best: Option<Choice> = None;
    let (mut bound, mut proved) = (f64::INFINITY, true);
    for group in std::iter::once(None).chain(groups) {
        let found = with_group(problem, group);
        (bound, proved) = (bound.min(found.bound), proved && found.proved);
        if best.as_ref().is_none_or(|b| better(&found, b)) {
            best = Some(found);
        }
    }
    let best = best.expect("one of the ways is without a group");
    // A bound on choices within the budgets says nothing of one that is not.
    let bound = if best.pressure <= SLACK { bound.min(best.cost) } else { bound };
    Choice { bound, proved, ..best }
}

fn better(a: &Choice, b: &Choice) -> bool {
    match (a.pressure <= SLACK, b.pressure <= SLACK) {
        (true, true) => a.cost < b.cost,
        (false, false) => (a.pressure, a.cost) < (b.pressure, b.cost),
        (within, _) => within,
    }
}

fn with_group(problem: &Problem, group: Option<usize>) -> Choice {
    let mut covered = vec![false; problem.items.len()];
    group.into_iter().flat_map(|g| &problem.groups[g].members).for_each(|i| covered[*i] = true);
    let open: Vec<usize> = (0..problem.items.len()).filter(|i| !covered[*i]).collect();
    // Of each object which of its candidates are allowed; the object itself comes last, so that of equal costs a stand-in is taken.
    let allowed: Vec<Vec<usize>> = open
        .iter()
        .map(|i| {
            let candidates = &problem.items[*i].candidates;
            (0..candidates.len()).filter(|j| candidates[*j].meets).collect()
        })
        .collect();
    let pick = |allowed: &[usize], at: usize| allowed.get(at).map_or(Picked::Original, |j| Picked::Candidate(*j));
    let picked = |relaxed: &Relaxed| {
        let mut picks = vec![Picked::Group; problem.items.len()];
        for ((i, allowed), at) in open.iter().zip(&allowed).zip(&relaxed.picks) {
            picks[*i] = pick(allowed, *at);
        }
        picks
    };
    let solve = |users: &[f64]| {
        let costs = |(i, allowed): (&usize, &Vec<usize>)| {
            let one = |at| problem.items[*i].priced(pick(allowed, at), &problem.shared, |s| users[s]);
            (0..=allowed.len()).map(one).collect::<Vec<Cost>>()
        };
        let items: Vec<Vec<Cost>> = open.iter().zip(&allowed).map(costs).collect();
        let fixed = group.map_or(NOTHING, |g| problem.groups[g].cost);
        let linear = Linear { items: &items, fixed, weights: problem.weights, budget: problem.budget };
        let mut relaxed = relax(&linear);
        let whole = search(&linear, &mut relaxed);
        (relaxed, whole)
    };
    // Where all that could share do, each part is smallest: what is found then bounds the rest.
    let mut users = vec![0.0; problem.shared.len()];
    for (i, allowed) in open.iter().zip(&allowed) {
        let all = (0..=allowed.len()).flat_map(|at| problem.items[*i].paid(pick(allowed, at)).1);
        let each: BTreeSet<usize> = all.copied().collect();
        each.into_iter().for_each(|s| users[s] += 1.0);
    }
    let (first, whole) = solve(&users);
    let impossible = first.least_pressure > SLACK || (whole && first.pressure > SLACK);
    let mut best = problem.choice(picked(&first), group);
    let mut last = best.picks.clone();
    for round in 0..ROUNDS {
        users = problem.users(&last);
        if round + 1 == ROUNDS {
            // Each pays for all that it uses: what is within the budgets then is so in truth.
            users.fill(1.0);
        }
        let (relaxed, _) = solve(&users);
        let found = problem.choice(picked(&relaxed), group);
        let same = found.picks == last;
        last.clone_from(&found.picks);
        if better(&found, &best) {
            best = found;
        }
        if same && best.pressure <= SLACK {
            break;
        }
    }
    // Certain where the bound is met, or where not even the cheapest way to share is within the budgets.
    let met = best.pressure <= SLACK && best.cost - first.bound <= 1e-9 * best.cost.abs();
    let bound = if impossible { f64::INFINITY } else { first.bound };
    Choice { bound, proved: met || impossible, ..best }
}
