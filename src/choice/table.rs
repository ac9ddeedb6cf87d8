//! The choice and its reasons, for people and for programs.

use super::{
    cost::{Cost, RESOURCES, SLACK, pressure, weighted},
    judge::{Judged, Target},
    solve::{Choice, Picked, Problem},
};
use crate::certify::{grouped, rounded};
use serde::Serialize;
use std::collections::BTreeMap;

/// Costs by their names, as whole numbers.
pub type Named = BTreeMap<&'static str, u64>;

/// A certificate of a choice.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Table {
    pub verdict: &'static str,
    pub sentence: String,
    pub summary: Vec<String>,
    pub target: Target,
    pub weights: BTreeMap<&'static str, f64>,
    pub budget: Named,
    pub triangles: u64,
    pub texels: u64,
    pub memory_bytes: u64,
    pub draw_calls: u64,
    /// The weighted sum of these four.
    pub cost: f64,
    pub original_triangles: u64,
    pub original_texels: u64,
    pub original_memory_bytes: u64,
    pub original_draw_calls: u64,
    pub original_cost: f64,
    /// The largest share of a budget that is taken; 0 without budgets.
    pub budget_taken: f64,
    /// No choice within the budgets costs less; none where there is none.
    pub lower_bound: Option<f64>,
    /// It is certain that no choice within the budgets costs less, or that none is within them.
    pub proved: bool,
    /// Objects by what stands for them.
    pub by_stand_in: BTreeMap<String, u64>,
    /// What the scene costs where each method alone is used wherever it is good enough, and originals elsewhere.
    pub alone: BTreeMap<String, Alone>,
    pub groups: Vec<Row>,
    pub objects: Vec<Row>,
}

/// One method alone.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Alone {
    /// For how many objects it is good enough.
    pub objects: u64,
    pub cost: f64,
    pub budget_taken: f64,
}

/// What was decided about an object, or of which candidates a group is made.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    pub name: String,
    pub chosen: String,
    pub why: String,
    pub candidates: Vec<Offer>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Offer {
    pub name: String,
    /// Weighted, with its share of what others use too.
    pub cost: f64,
    #[serde(flatten)]
    pub costs: Named,
    #[serde(flatten)]
    pub judged: Option<Judged>,
}

/// The name of what is kept as it is.
pub const ORIGINAL: &str = "original";

/// What was judged: of each object its candidates, and each group.
pub struct Judgements<'a> {
    pub target: Target,
    pub objects: &'a [Vec<Judged>],
    pub groups: &'a [Judged],
}

/// The table of a choice.
pub fn table(problem: &Problem, choice: &Choice, judgements: &Judgements) -> Table {
    let originals = problem.total(&vec![Picked::Original; problem.items.len()], None);
    let within = choice.pressure <= SLACK;
    let mut by_stand_in: BTreeMap<String, u64> = BTreeMap::new();
    let users = problem.users(&choice.picks);
    let row = |i| object(problem, choice, &users, judgements, i);
    let objects: Vec<Row> = (0..problem.items.len()).map(row).collect();
    for row in &objects {
        *by_stand_in.entry(row.chosen.clone()).or_default() += 1;
    }
    let group = |(g, judged): (usize, &Judged)| {
        let of = &problem.groups[g];
        let taken = choice.group == Some(g);
        let why = match (taken, of.meets) {
            (true, _) => format!("it stands for {} objects and costs least with what is left", of.members.len()),
            (false, false) => judged.misses.join("; "),
            (false, true) => "another way costs less, or is nearer to the budgets".to_owned(),
        };
        let offer = offer(&of.name, &of.cost, problem, Some(judged.clone()));
        let chosen = if taken { "yes" } else { "no" };
        Row { name: of.name.clone(), chosen: chosen.to_owned(), why, candidates: vec![offer] }
    };
    let groups = judgements.groups.iter().enumerate().map(group).collect();
    let counts = |cost: &Cost| cost.map(|c| c.round() as u64);
    let ([triangles, texels, memory_bytes, draw_calls], before) = (counts(&choice.total), counts(&originals));
    let original_cost = weighted(&originals, &problem.weights);
    let budgets = problem.budget.iter().zip(RESOURCES);
    let mut summary = Vec::new();
    for (r, name) in RESOURCES.iter().enumerate() {
        let most = problem.budget[r].map_or(String::new(), |most| format!(", budget {}", grouped(most.round() as u64)));
        let name = name.replace('_', " ");
        summary.push(format!(
            "{name} {} → {}{most}",
            grouped(originals[r].round() as u64),
            grouped(choice.total[r].round() as u64)
        ));
    }
    let list = by_stand_in.iter().map(|(name, n)| format!("{n} {name}")).collect::<Vec<_>>().join(", ");
    summary.push(format!("objects by what stands for them: {list}"));
    if within && choice.bound.is_finite() && !choice.proved {
        let gap = 100.0 * (choice.cost - choice.bound) / choice.cost.max(f64::MIN_POSITIVE);
        summary.push(format!("no choice costs less than {} ({gap:.1} % below)", grouped(choice.bound.round() as u64)));
    }
    let saves = format!(
        "it costs {} where the scene costs {}",
        grouped(choice.cost.round() as u64),
        grouped(original_cost.round() as u64)
    );
    let sentence = match (within, choice.proved) {
        (true, true) => format!("The cheapest choice that meets the target: {saves}."),
        (true, false) => format!("A choice that meets the target: {saves}."),
        (false, true) => format!("No choice is within the budgets. The nearest that was found: {saves}."),
        (false, false) => format!("No choice within the budgets was found. The nearest: {saves}."),
    };
    Table {
        verdict: if within { "within budget" } else { "over budget" },
        sentence,
        summary,
        target: judgements.target,
        weights: RESOURCES.iter().copied().zip(problem.weights).collect(),
        budget: budgets.filter_map(|(most, name)| Some((name, (*most)? as u64))).collect(),
        triangles,
        texels,
        memory_bytes,
        draw_calls,
        cost: rounded(choice.cost, 3),
        original_triangles: before[0],
        original_texels: before[1],
        original_memory_bytes: before[2],
        original_draw_calls: before[3],
        original_cost: rounded(original_cost, 3),
        budget_taken: rounded(choice.pressure.min(1e12), 6),
        lower_bound: choice.bound.is_finite().then(|| rounded(choice.bound, 3)),
        proved: choice.proved,
        by_stand_in,
        alone: alone(problem),
        groups,
        objects,
    }
}

fn offer(name: &str, cost: &Cost, problem: &Problem, judged: Option<Judged>) -> Offer {
    let costs = RESOURCES.iter().copied().zip(cost.map(|c| c.round() as u64)).collect();
    let cost = rounded(weighted(cost, &problem.weights), 3);
    Offer { name: name.to_owned(), cost, costs, judged }
}

/// `users`: how many objects use each shared thing now.
fn object(problem: &Problem, choice: &Choice, users: &[f64], judgements: &Judgements, i: usize) -> Row {
    let item = &problem.items[i];
    let here = item.paid(choice.picks[i]).1;
    let sharing = |s: usize| if here.contains(&s) { users[s] } else { users[s] + 1.0 };
    let full = |pick: Picked| item.priced(pick, &problem.shared, sharing);
    let mut candidates: Vec<Offer> = Vec::with_capacity(item.candidates.len() + 1);
    for (j, candidate) in item.candidates.iter().enumerate() {
        let judged = judgements.objects[i].get(j).cloned();
        candidates.push(offer(&candidate.name, &full(Picked::Candidate(j)), problem, judged));
    }
    candidates.push(offer(ORIGINAL, &full(Picked::Original), problem, None));
    let good = |at: &usize| item.candidates.get(*at).is_none_or(|c| c.meets);
    let at = match choice.picks[i] {
        Picked::Group => None,
        Picked::Candidate(j) => Some(j),
        Picked::Original => Some(item.candidates.len()),
    };
    let cheapest =
        (0..candidates.len()).filter(good).min_by(|a, b| candidates[*a].cost.total_cmp(&candidates[*b].cost));
    let (chosen, why) = match at {
        None => {
            let group = choice.group.map_or("", |g| &problem.groups[g].name);
            (group.to_owned(), "it is part of what this stands for".to_owned())
        }
        Some(at) => {
            let chosen = candidates[at].name.clone();
            let why = if !item.candidates.iter().any(|c| c.meets) {
                "no stand-in meets the target".to_owned()
            } else if cheapest.is_some_and(|best| candidates[best].cost < candidates[at].cost * (1.0 - 1e-9)) {
                "a cheaper one takes too much of a budget, or of what it shares with others".to_owned()
            } else {
                "the cheapest that meets the target".to_owned()
            };
            (chosen, why)
        }
    };
    Row { name: item.name.clone(), chosen, why, candidates }
}

/// Each method alone.
fn alone(problem: &Problem) -> BTreeMap<String, Alone> {
    let mut all = BTreeMap::new();
    let mut add = |name: &str, picks: Vec<Picked>, group: Option<usize>| {
        let total = problem.total(&picks, group);
        let objects = picks.iter().filter(|p| **p != Picked::Original).count() as u64;
        let cost = rounded(weighted(&total, &problem.weights), 3);
        let budget_taken = rounded(pressure(&total, &problem.budget).min(1e12), 6);
        all.insert(name.to_owned(), Alone { objects, cost, budget_taken });
    };
    let names: std::collections::BTreeSet<&str> =
        problem.items.iter().flat_map(|i| &i.candidates).map(|c| c.name.as_str()).collect();
    for name in names {
        let pick = |item: &super::solve::Item| {
            let found = item.candidates.iter().position(|c| c.name == name && c.meets);
            found.map_or(Picked::Original, Picked::Candidate)
        };
        add(name, problem.items.iter().map(pick).collect(), None);
    }
    for (g, group) in problem.groups.iter().enumerate().filter(|(_, group)| group.meets) {
        let mut picks = vec![Picked::Original; problem.items.len()];
        group.members.iter().for_each(|i| picks[*i] = Picked::Group);
        add(&group.name, picks, Some(g));
    }
    all
}

impl Table {
    /// A row for each object and candidate, comma-separated, with a header.
    ///
    /// # Errors
    /// None is expected: it is written to memory.
    pub fn csv(&self) -> Result<Vec<u8>, csv::Error> {
        let mut out = csv::Writer::from_writer(Vec::new());
        let own = ["verdict", "deviation_px", "psnr_db", "misses"];
        out.write_record(["object", "candidate", "chosen", "cost"].iter().chain(&RESOURCES).chain(&own))?;
        for row in self.groups.iter().chain(&self.objects) {
            for offer in &row.candidates {
                let chosen = row.chosen == offer.name || row.chosen == "yes";
                let judged = offer.judged.as_ref();
                let text = |f: &dyn Fn(&Judged) -> String| judged.map_or(String::new(), f);
                let mut fields = vec![row.name.clone(), offer.name.clone(), if chosen { "yes" } else { "" }.to_owned()];
                fields.push(offer.cost.to_string());
                fields.extend(RESOURCES.iter().map(|r| offer.costs[r].to_string()));
                fields.push(text(&|j| j.verdict.clone()));
                fields.push(text(&|j| j.deviation_px.to_string()));
                fields.push(text(&|j| j.psnr_db.to_string()));
                fields.push(text(&|j| j.misses.join("; ")));
                out.write_record(&fields)?;
            }
        }
        out.into_inner().map_err(|e| e.into_error().into())
    }
}
