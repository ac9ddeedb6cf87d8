//! `choose`: which stand-in each object gets.

use crate::{
    certify::Verdict as Word,
    choice::{
        self, Candidate, Choice, Group, Item, Judged, Judgements, NOTHING, ORIGINAL, Picked, Problem, Shared, Target,
    },
    engine::{
        node::{Ctx, List, Measure, Node, NodeError},
        plan::{File, Relation},
    },
    nodes::json_file,
    ports,
    scene::{Object, Scene},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

/// What an eye would say, as `evaluate` says it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Nobody tells it from the original at its resolution.
    Indistinguishable,
    /// It passes for the original; side by side there are small differences.
    Good,
    /// Differences are seen without a comparison.
    Visible,
}

impl Verdict {
    fn word(self) -> &'static str {
        match self {
            Self::Indistinguishable => Word::Indistinguishable.word(),
            Self::Good => Word::Good.word(),
            Self::Visible => Word::Visible.word(),
        }
    }
}

/// What one unit of each resource counts, 0 or more.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Weights {
    /// A triangle.
    #[schemars(range(min = 0.0))]
    pub triangles: f64,
    /// A texel of a base level.
    #[schemars(range(min = 0.0))]
    pub texels: f64,
    /// A byte of vertices, indices and uncompressed texels.
    #[schemars(range(min = 0.0))]
    pub memory_bytes: f64,
    /// A draw call.
    #[schemars(range(min = 0.0))]
    pub draw_calls: f64,
}

impl Default for Weights {
    fn default() -> Self {
        // 2 million triangles, 256 million texels and 2,000 draw calls are each about what a frame of a game is given.
        Self { triangles: 1.0, texels: 1.0 / 128.0, memory_bytes: 0.0, draw_calls: 1000.0 }
    }
}

/// What the whole scene may take at most, 0 where there is no limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Budget {
    /// Triangles.
    pub triangles: u64,
    /// Texels of base levels.
    pub texels: u64,
    /// Bytes of vertices, indices and uncompressed texels.
    pub memory_bytes: u64,
    /// Draw calls.
    pub draw_calls: u64,
}

/// Chooses for each object of a scene the cheapest of several stand-ins that is good enough by its certificate, within budgets for the whole scene. The object itself is
/// among them. Cost is a weighted sum of triangles, texels, bytes and draw calls; textures and meshes that several objects use count once. The choice is found by Lagrangian
/// relaxation and, for scenes that are small enough, proved by branch and bound. Where nothing is within the budgets, the nearest that was found is given, and
/// `budget_taken` of its certificate is above 1.
///
/// Groups are stand-ins for many objects at once, such as a textured depth mesh of all that is far away. At most one of them is taken.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// How far outlines may move, pixels of the certificates' pictures. No limit where there is none.
    #[schemars(range(min = 0.0), extend("x-unit" = "px"))]
    pub deviation_px: Option<f64>,
    /// How well colours must match: luminance over the object's pixels, mean over the views. No limit where there is none.
    #[schemars(extend("x-unit" = "dB"))]
    pub psnr_db: Option<f64>,
    /// The least verdict.
    pub verdict: Verdict,
    /// What a unit of each resource counts.
    pub weights: Weights,
    /// What the whole scene may take at most.
    pub budget: Budget,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            deviation_px: Some(1.5),
            psnr_db: Some(30.0),
            verdict: Verdict::Good,
            weights: Weights::default(),
            budget: Budget::default(),
        }
    }
}

ports! {
    pub struct In {
        /// The originals; the choice is about its objects.
        scene: Arc<Scene>,
        /// Certificates of stand-ins for single objects, each list under the name of its method, `{ impostor = "judge.certificate" }`; elements have the names of objects.
        certificates: Option<List<File, true>>,
        /// Objects as simpler meshes, of methods that have certificates, under the same names. What is chosen of them shares textures with what is kept, so it is weighed, and
        /// given, with that.
        meshes: Option<List<Scene, true>>,
        /// Certificates of stand-ins for many objects, each under the name of its group.
        groups: Option<List<File, true>>,
        /// The objects that each group stands for, under the same names.
        members: Option<List<Scene, true>>,
    }
}

ports! {
    pub struct Out {
        /// The choice, JSON: totals, what each method alone would cost, and for each object its candidates, what was chosen and why.
        certificate: Arc<File>,
        /// The same for each object and candidate, CSV.
        table: Arc<File>,
        /// What is drawn as meshes: objects that are kept, and chosen ones of `meshes`. May be empty.
        scene: Arc<Scene>,
        /// Which stand-in was chosen, by object; that of groups under no name. For `take-chosen`.
        chosen: Arc<Relation>,
    }
}

pub struct Choose;

const MEASURES: [(&str, &str); 7] = [
    ("budget_taken", "largest share of a budget that the choice takes; above 1 where none is within them"),
    ("cost", "weighted cost of the choice"),
    ("triangles", "triangles of the choice"),
    ("texels", "texels of the choice"),
    ("memory_bytes", "bytes of vertices, indices and uncompressed texels of the choice"),
    ("draw_calls", "draw calls of the choice"),
    ("original_cost", "weighted cost of the scene as it is"),
];

impl Node for Choose {
    const KIND: &'static str = "choose";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        (16 << 20) + sizes.iter().fold(0_u64, |s, n| s.saturating_add(*n)).saturating_mul(3)
    }

    fn measures() -> Vec<Measure> {
        MEASURES.iter().map(|(path, about)| Measure::new(path, about, "")).collect()
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        let Weights { triangles, texels, memory_bytes, draw_calls } = params.weights;
        if [triangles, texels, memory_bytes, draw_calls].iter().all(|w| *w == 0.0) {
            return Err(("weights", "all are 0: nothing costs anything".into()));
        }
        Ok(())
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let made = build(params, &inputs)?;
        ctx.stop.check()?;
        let chosen = choice::choose(&made.problem);
        let judgements = Judgements { target: target(params), objects: &made.objects, groups: &made.groups };
        let table = choice::table(&made.problem, &chosen, &judgements);
        let csv = table.csv().map_err(|e| NodeError::from_error(&e))?;
        let certificate = serde_json::to_value(&table).map_err(|e| NodeError::from_error(&e))?;
        Ok(Out {
            certificate: json_file(&certificate)?,
            table: Arc::new(File { media_type: "text/csv".into(), bytes: csv }),
            scene: Arc::new(kept(&inputs, &made, &chosen)),
            chosen: Arc::new(relation(&made, &chosen)),
        })
    }
}

fn target(params: &Params) -> Target {
    Target { deviation_px: params.deviation_px, psnr_db: params.psnr_db, verdict: Some(params.verdict.word()) }
}

/// The problem, and the certificates that it was made from.
struct Made {
    problem: Problem,
    objects: Vec<Vec<Judged>>,
    groups: Vec<Judged>,
}

/// What a list has, if it is there; sorted by name.
fn all<A>(list: &Option<List<A, true>>) -> &[(String, Arc<A>)] {
    list.as_ref().map_or(&[], |list| &list.0)
}

/// The mesh of the name, which is that of its certificate.
fn mesh<'a>(meshes: &'a [(String, Arc<Scene>)], name: &str) -> Option<&'a Scene> {
    meshes.binary_search_by(|(of, _)| of.as_str().cmp(name)).ok().map(|at| &*meshes[at].1)
}

/// A certificate, whose place in the lists is `name`.
fn judged(name: &str, file: &File, target: &Target) -> Result<Judged, NodeError> {
    let wrong = |what: String| NodeError::Failed(format!("the certificate of `{name}`: {what}"));
    let json: Value = serde_json::from_slice(&file.bytes).map_err(|e| wrong(e.to_string()))?;
    choice::judge(&json, target).map_err(wrong)
}

fn build(params: &Params, inputs: &In) -> Result<Made, NodeError> {
    let target = target(params);
    let scene = &inputs.scene;
    let number: BTreeMap<&str, usize> = scene.objects.iter().enumerate().map(|(i, o)| (o.name.as_str(), i)).collect();
    let unknown = |what: &str, name: &str| {
        NodeError::Failed(format!("{what} `{name}`: the scene has no such object ({} objects)", scene.objects.len()))
    };
    let mut shared = Shared::default();
    let mut items = Vec::with_capacity(scene.objects.len());
    for object in &scene.objects {
        let (own, shares) = shared.weigh(object);
        items.push(Item { name: object.name.clone(), own, shares, candidates: Vec::new() });
    }
    let meshes = all(&inputs.meshes);
    let mut objects: Vec<Vec<Judged>> = vec![Vec::new(); items.len()];
    let certified = all(&inputs.certificates);
    for (name, file) in certified {
        let Some((method, object)) = name.split_once('/') else {
            return Err(NodeError::Failed(format!(
                "the certificate `{name}` does not say its method; write certificates = {{ METHOD = \"…\" }}"
            )));
        };
        if method == ORIGINAL {
            return Err(NodeError::Failed(format!(
                "`{ORIGINAL}` is what stays as it is; give the method another name"
            )));
        }
        let at = *number.get(object).ok_or_else(|| unknown("the certificate", name))?;
        let judged = judged(name, file, &target)?;
        let (mut cost, mut shares) = (judged.cost, Vec::new());
        if let Some(simple) = mesh(meshes, name) {
            cost = NOTHING;
            for object in &simple.objects {
                let (own, uses) = shared.weigh(object);
                cost = choice::plus(cost, own);
                shares.extend(uses);
            }
            shares.sort_unstable();
            shares.dedup();
        }
        items[at].candidates.push(Candidate { name: method.to_owned(), cost, shares, meets: judged.misses.is_empty() });
        objects[at].push(judged);
    }
    if let Some((name, _)) =
        meshes.iter().find(|(name, _)| certified.binary_search_by(|(other, _)| other.cmp(name)).is_err())
    {
        return Err(NodeError::Failed(format!(
            "the mesh `{name}` has no certificate; `certificates` and `meshes` have the same names"
        )));
    }
    let (groups, of_groups) = groups(inputs, &number, &target)?;
    let weights = params.weights;
    let budget = params.budget;
    let some = |n: u64| (n > 0).then_some(n as f64);
    let problem = Problem {
        items,
        groups,
        shared: shared.costs,
        weights: [weights.triangles, weights.texels, weights.memory_bytes, weights.draw_calls],
        budget: [some(budget.triangles), some(budget.texels), some(budget.memory_bytes), some(budget.draw_calls)],
    };
    Ok(Made { problem, objects, groups: of_groups })
}

fn groups(
    inputs: &In,
    number: &BTreeMap<&str, usize>,
    target: &Target,
) -> Result<(Vec<Group>, Vec<Judged>), NodeError> {
    let members = all(&inputs.members);
    let certificates = all(&inputs.groups);
    let of: BTreeSet<&str> = members.iter().map(|m| m.0.as_str()).collect();
    let with: BTreeSet<&str> = certificates.iter().map(|c| c.0.as_str()).collect();
    if let Some(lonely) = of.symmetric_difference(&with).next() {
        let message = "is in one of `groups` and `members`; give both its certificate and its objects";
        return Err(NodeError::Failed(format!("the group `{lonely}` {message}")));
    }
    let (mut groups, mut all) = (Vec::new(), Vec::new());
    for ((name, file), (_, scene)) in certificates.iter().zip(members) {
        let judged = judged(name, file, target)?;
        let member = |o: &Object| {
            number.get(o.name.as_str()).copied().ok_or_else(|| {
                NodeError::Failed(format!("`members.{name}` has `{}`, which is not in the scene", o.name))
            })
        };
        let members = scene.objects.iter().map(member).collect::<Result<Vec<usize>, NodeError>>()?;
        groups.push(Group { name: name.clone(), members, cost: judged.cost, meets: judged.misses.is_empty() });
        all.push(judged);
    }
    Ok((groups, all))
}

/// What is drawn as meshes.
fn kept(inputs: &In, made: &Made, chosen: &Choice) -> Scene {
    let meshes = all(&inputs.meshes);
    let objects = |(i, pick): (usize, &Picked)| match pick {
        Picked::Original => inputs.scene.objects[i..=i].to_vec(),
        Picked::Candidate(j) => {
            let item = &made.problem.items[i];
            let name = format!("{}/{}", item.candidates[*j].name, item.name);
            mesh(meshes, &name).map_or_else(Vec::new, |scene| scene.objects.clone())
        }
        Picked::Group => Vec::new(),
    };
    Scene { objects: chosen.picks.iter().enumerate().flat_map(objects).collect() }
}

/// Which stand-in was chosen, by object.
fn relation(made: &Made, chosen: &Choice) -> Relation {
    let mut by_object = BTreeMap::new();
    for (item, pick) in made.problem.items.iter().zip(&chosen.picks) {
        if let Picked::Candidate(j) = pick {
            by_object.insert(item.name.clone(), vec![item.candidates[*j].name.clone()]);
        }
    }
    let group = chosen.group.map(|g| made.problem.groups[g].name.clone());
    by_object.insert(String::new(), group.into_iter().collect());
    Relation(by_object)
}

#[cfg(test)]
mod tests;
