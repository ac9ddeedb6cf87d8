//! Branch and bound: closes the gap that relaxation leaves, where the scene is small enough.

use super::{
    cost::{Cost, SLACK, plus, pressure, weighted},
    relax::{Linear, Relaxed},
};

/// Partial choices that are looked at, at most.
const MOST: usize = 400_000;
/// Objects, at most: with more of them the tree is too deep to be looked through.
const OBJECTS: usize = 1000;

struct Search<'a> {
    linear: &'a Linear<'a>,
    /// Objects in the order in which they are decided: those first for which it matters most.
    order: Vec<usize>,
    /// Of each object its candidates, the cheapest at the prices first.
    ranked: Vec<Vec<usize>>,
    prices: Cost,
    /// From each place of `order` on: what all that is left costs at the prices at least, and of each resource at least.
    rest: Vec<(f64, Cost)>,
    /// What the prices give back: Σλ.
    refund: f64,
    visited: usize,
    picks: Vec<usize>,
    best: Option<(f64, Vec<usize>)>,
    limit: f64,
}

/// Replaces what `relaxed` found by the cheapest choice within the budgets. `false` where there are too many to tell.
pub fn search(linear: &Linear, relaxed: &mut Relaxed) -> bool {
    let found = relaxed.pressure <= SLACK;
    if found && relaxed.cost - relaxed.bound <= 1e-9 * relaxed.cost.abs() {
        return true;
    }
    if linear.items.len() > OBJECTS {
        return false;
    }
    let prices = relaxed.prices;
    let price = |i: usize, j: usize| weighted(&linear.items[i][j], &prices);
    let ranked: Vec<Vec<usize>> = (0..linear.items.len())
        .map(|i| {
            let mut of: Vec<usize> = (0..linear.items[i].len()).collect();
            of.sort_by(|a, b| price(i, *a).total_cmp(&price(i, *b)).then(a.cmp(b)));
            of
        })
        .collect();
    let spread = |i: usize| ranked[i].get(1).map_or(0.0, |second| price(i, *second) - price(i, ranked[i][0]));
    let mut order: Vec<usize> = (0..linear.items.len()).collect();
    order.sort_by(|a, b| spread(*b).total_cmp(&spread(*a)).then(a.cmp(b)));
    let mut rest = vec![(0.0, [0.0; 4]); order.len() + 1];
    for (at, i) in order.iter().enumerate().rev() {
        let least = std::array::from_fn(|r| linear.items[*i].iter().map(|c| c[r]).fold(f64::INFINITY, f64::min));
        rest[at] = (rest[at + 1].0 + price(*i, ranked[*i][0]), plus(rest[at + 1].1, least));
    }
    let refund = (0..4).map(|r| (prices[r] - linear.weights[r]) * linear.budget[r].unwrap_or(0.0)).sum();
    let mut search = Search {
        linear,
        order,
        ranked,
        prices,
        rest,
        refund,
        visited: 0,
        picks: vec![0; linear.items.len()],
        best: None,
        limit: if found { relaxed.cost } else { f64::INFINITY },
    };
    let whole = search.go(0, linear.fixed, weighted(&linear.fixed, &prices));
    if let Some((cost, picks)) = search.best {
        relaxed.pressure = linear.pressure(&picks);
        (relaxed.cost, relaxed.picks) = (cost, picks);
    }
    if whole && relaxed.pressure <= SLACK {
        relaxed.bound = relaxed.cost;
    }
    whole
}

impl Search<'_> {
    /// Decides the objects from place `at` on. `false` where it gave up.
    fn go(&mut self, at: usize, used: Cost, priced: f64) -> bool {
        self.visited += 1;
        if self.visited > MOST {
            return false;
        }
        let Some(&i) = self.order.get(at) else {
            let cost = weighted(&used, &self.linear.weights);
            if cost < self.limit * (1.0 - 1e-12) || self.limit == f64::INFINITY {
                (self.limit, self.best) = (cost, Some((cost, self.picks.clone())));
            }
            return true;
        };
        let mut whole = true;
        for k in 0..self.ranked[i].len() {
            let j = self.ranked[i][k];
            let cost = self.linear.items[i][j];
            let (next, price) = (plus(used, cost), priced + weighted(&cost, &self.prices));
            let (least, needs) = self.rest[at + 1];
            if price + least - self.refund >= self.limit * (1.0 - 1e-12) {
                // The candidates after it are dearer.
                break;
            }
            if pressure(&plus(next, needs), &self.linear.budget) <= SLACK {
                self.picks[i] = j;
                whole &= self.go(at + 1, next, price);
                if !whole {
                    return false;
                }
            }
        }
        whole
    }
}
