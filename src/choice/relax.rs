//! Lagrangian relaxation of one choice per object under budgets: min Σ w·c(i, j_i) with Σ c(i, j_i) ≤ B.
//!
//! With a price λ_r ≥ 0 on each share of a budget, L(λ) = Σ_i min_j (w + λ/B)·c(i, j) − Σ_r λ_r bounds every choice within the budgets from below, and its minimum per
//! object is a choice to go on from.

use super::cost::{Cost, SLACK, exchanged, plus, pressure, weighted};

/// Steps of the search for prices.
const STEPS: usize = 300;

/// One choice per object: objects, and of each what its candidates cost. None is empty.
#[derive(Clone, Debug)]
pub struct Linear<'a> {
    pub items: &'a [Vec<Cost>],
    /// What is paid in any case.
    pub fixed: Cost,
    pub weights: Cost,
    pub budget: [Option<f64>; 4],
}

/// A choice and what is known of all others.
#[derive(Clone, Debug, PartialEq)]
pub struct Relaxed {
    /// Of each object the number of its candidate.
    pub picks: Vec<usize>,
    /// The largest share of a budget that it takes; above 1 where it is only the nearest that was found.
    pub pressure: f64,
    /// Its weighted cost.
    pub cost: f64,
    /// No choice within the budgets costs less.
    pub bound: f64,
    /// No choice takes a smaller largest share of a budget.
    pub least_pressure: f64,
    /// Prices of the budgets at which `bound` was found.
    pub prices: Cost,
}

impl Linear<'_> {
    pub fn total(&self, picks: &[usize]) -> Cost {
        picks.iter().zip(self.items).fold(self.fixed, |sum, (pick, item)| plus(sum, item[*pick]))
    }

    pub fn pressure(&self, picks: &[usize]) -> f64 {
        pressure(&self.total(picks), &self.budget)
    }

    pub fn cost(&self, picks: &[usize]) -> f64 {
        weighted(&self.total(picks), &self.weights)
    }

    /// Of each object the candidate that costs least at `prices`, the first of equals, and what all of them cost.
    fn cheapest(&self, prices: &Cost) -> (Vec<usize>, f64) {
        let mut sum = weighted(&self.fixed, prices);
        let least = |item: &Vec<Cost>| {
            let mut best = (0, f64::INFINITY);
            for (j, cost) in item.iter().enumerate() {
                let cost = weighted(cost, prices);
                if cost < best.1 {
                    best = (j, cost);
                }
            }
            sum += best.1;
            best.0
        };
        let picks = self.items.iter().map(least).collect();
        (picks, sum)
    }

    /// What a share of each budget costs at `lambda`, on top of the weights, for each unit of the resource.
    fn priced(&self, lambda: &Cost) -> Cost {
        std::array::from_fn(|r| self.weights[r] + self.budget[r].filter(|b| *b > 0.0).map_or(0.0, |b| lambda[r] / b))
    }
}

/// The cheapest choice within the budgets that relaxation finds, or the nearest to them.
pub fn relax(linear: &Linear) -> Relaxed {
    let (picks, bound) = linear.cheapest(&linear.weights);
    let free = Relaxed {
        pressure: linear.pressure(&picks),
        cost: linear.cost(&picks),
        picks,
        bound,
        least_pressure: 0.0,
        prices: linear.weights,
    };
    if free.pressure <= SLACK {
        return free;
    }
    let mut best = fit(linear, free);
    if best.pressure <= SLACK {
        save(linear, &mut best);
        prices(linear, &mut best);
        save(linear, &mut best);
    }
    best
}

/// Lowers the largest share of a budget: the two players of a game, of whom one prices the budgets that are exceeded most (multiplicative
/// weights, Arora et al. 2012) and the other answers with what is cheapest.
fn fit(linear: &Linear, from: Relaxed) -> Relaxed {
    let mut best = from;
    let kinds = linear.budget.iter().flatten().count() as f64;
    let mut share: Cost = std::array::from_fn(|r| if linear.budget[r].is_some() { 1.0 / kinds } else { 0.0 });
    for step in 0..STEPS {
        let unit =
            |r: usize| linear.budget[r].map_or(0.0, |most| if most > 0.0 { share[r] / most } else { share[r] * 1e12 });
        let (picks, sum) = linear.cheapest(&std::array::from_fn(unit));
        best.least_pressure = best.least_pressure.max(sum);
        let total = linear.total(&picks);
        let found = pressure(&total, &linear.budget);
        let cost = weighted(&total, &linear.weights);
        if (found, cost) < (best.pressure, best.cost) {
            (best.picks, best.pressure, best.cost) = (picks, found, cost);
        }
        if best.pressure <= SLACK {
            break;
        }
        let speed = 1.0 / (1.0 + step as f64).sqrt();
        for r in 0..share.len() {
            let Some(most) = linear.budget[r] else { continue };
            let taken = if most > 0.0 { total[r] / most } else { found.min(1e12) };
            let relative =
                if found.is_finite() && found > 0.0 { taken / found } else { f64::from(u8::from(total[r] > 0.0)) };
            share[r] *= libm::exp(speed * (relative - 1.0));
        }
        let sum: f64 = share.iter().sum();
        share.iter_mut().for_each(|s| *s /= sum);
    }
    if best.pressure > SLACK {
        ease(linear, &mut best);
    }
    best
}

/// Exchanges single picks as long as that lowers the largest share of a budget.
fn ease(linear: &Linear, best: &mut Relaxed) {
    let mut total = linear.total(&best.picks);
    for _ in 0..8 {
        let before = best.pressure;
        for (i, item) in linear.items.iter().enumerate() {
            for (j, cost) in item.iter().enumerate() {
                let moved = exchanged(&total, &item[best.picks[i]], cost);
                let found = pressure(&moved, &linear.budget);
                if found < best.pressure {
                    (best.picks[i], best.pressure, total) = (j, found, moved);
                }
            }
            if best.pressure <= SLACK {
                best.cost = weighted(&total, &linear.weights);
                return;
            }
        }
        if best.pressure >= before {
            break;
        }
    }
    best.cost = weighted(&total, &linear.weights);
}

/// The prices at which the bound is highest, by subgradients with Polyak's step; keeps what is within the budgets and cheaper than `best`.
fn prices(linear: &Linear, best: &mut Relaxed) {
    let mut lambda: Cost = [0.0; 4];
    let (mut scale, mut stalled) = (1.5, 0);
    for _ in 0..STEPS {
        let prices = linear.priced(&lambda);
        let (picks, sum) = linear.cheapest(&prices);
        let bound = sum - lambda.iter().sum::<f64>();
        if bound > best.bound {
            (best.bound, best.prices, stalled) = (bound, prices, 0);
        } else {
            stalled += 1;
            if stalled > 10 {
                (scale, stalled) = (scale * 0.6, 0);
            }
        }
        let total = linear.total(&picks);
        let cost = weighted(&total, &linear.weights);
        let found = pressure(&total, &linear.budget);
        if found <= SLACK && cost < best.cost {
            (best.picks, best.pressure, best.cost) = (picks, found, cost);
        }
        let slope: Cost =
            std::array::from_fn(|r| linear.budget[r].filter(|b| *b > 0.0).map_or(0.0, |b| total[r] / b - 1.0));
        let length: f64 = slope.iter().map(|g| g * g).sum();
        let gap = (best.cost - bound).max(1e-6 * best.cost.abs());
        if length < 1e-18 || best.cost - best.bound <= 1e-12 * best.cost.abs() {
            break;
        }
        for r in 0..lambda.len() {
            lambda[r] = (lambda[r] + scale * gap / length * slope[r]).max(0.0);
        }
    }
}

/// Exchanges single picks for cheaper ones as long as all stays within the budgets; the greatest saving first.
fn save(linear: &Linear, best: &mut Relaxed) {
    let mut total = linear.total(&best.picks);
    loop {
        let mut moves: Vec<(f64, usize, usize)> = Vec::new();
        for (i, item) in linear.items.iter().enumerate() {
            let now = weighted(&item[best.picks[i]], &linear.weights);
            let saving = item.iter().enumerate().map(|(j, cost)| (now - weighted(cost, &linear.weights), i, j));
            moves.extend(saving.filter(|m| m.0 > 1e-12 * now.abs()));
        }
        moves.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
        let mut changed = vec![false; linear.items.len()];
        for (_, i, j) in moves {
            let item = &linear.items[i];
            let moved = exchanged(&total, &item[best.picks[i]], &item[j]);
            if !changed[i] && pressure(&moved, &linear.budget) <= SLACK {
                (best.picks[i], total, changed[i]) = (j, moved, true);
            }
        }
        if !changed.contains(&true) {
            break;
        }
    }
    best.cost = weighted(&linear.total(&best.picks), &linear.weights);
    best.pressure = linear.pressure(&best.picks);
}
