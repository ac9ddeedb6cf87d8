//! What is paid for.

/// The resources, in the order of [`Cost`]: as certificates name them.
pub const RESOURCES: [&str; 4] = ["triangles", "texels", "memory_bytes", "draw_calls"];

/// How much of each resource: triangles; texels of base levels; bytes of vertices, indices and uncompressed texels; draw calls. Fractions come from what is shared.
pub type Cost = [f64; 4];

pub const NOTHING: Cost = [0.0; 4];

pub fn plus(a: Cost, b: Cost) -> Cost {
    std::array::from_fn(|r| a[r] + b[r])
}

/// `total` where `new` takes the place of `old`.
pub fn exchanged(total: &Cost, old: &Cost, new: &Cost) -> Cost {
    std::array::from_fn(|r| total[r] - old[r] + new[r])
}

/// The sum of all resources, each times its weight.
pub fn weighted(cost: &Cost, weights: &Cost) -> f64 {
    (0..cost.len()).map(|r| cost[r] * weights[r]).sum()
}

/// The largest share of a budget that `cost` takes; 0 without budgets. A budget of nothing is exceeded by anything.
pub fn pressure(cost: &Cost, budget: &[Option<f64>; 4]) -> f64 {
    let share = |r: usize| {
        budget[r].map_or(0.0, |most| match (cost[r] > 0.0, most > 0.0) {
            (false, _) => 0.0,
            (true, true) => cost[r] / most,
            (true, false) => f64::INFINITY,
        })
    };
    (0..cost.len()).map(share).fold(0.0, f64::max)
}

/// Totals of whole numbers, made of fractions, may miss their budget by rounding alone.
pub const SLACK: f64 = 1.0 + 1e-9;
