//! `classify-occlusion`: what the stand-ins of a cell are of.

use crate::{
    engine::{
        node::{Ctx, List, Node, NodeError},
        plan::Relation,
    },
    lod::{
        entry::Entry,
        occlusion::Estimate,
        subject::{Classifying, Placement, Subject, classify},
    },
    ports,
    view::HexCell,
};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::{collections::BTreeMap, sync::Arc};

/// Tells the objects around a view cell apart: those that reach into it are drawn as they are; those whose self-occlusion stays small from anywhere in it become
/// meshes of one view, in clusters where that needs smaller textures; the others become meshes of several views. Objects so near that a picture from the cell's
/// centre cannot hold them (more than 126°) are drawn as they are too. Source: Chen et al. 2003, sections 3.1.2 and 3.1.6.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Pixels along a side of the pictures that stand-ins are made for, which show 60°.
    #[schemars(range(min = 16, max = 8192), extend("x-unit" = "px"))]
    pub resolution: u32,
    /// T_s: the largest hole that self-occlusion may open in a mesh of one view. 0 gives all objects meshes of several views.
    #[schemars(range(min = 0.0, max = 1000.0), extend("x-unit" = "px"))]
    pub t_s: f64,
    /// How the hole is estimated.
    pub occlusion: Estimate,
    /// Joins objects of one view into clusters.
    pub clusters: bool,
}

impl Default for Params {
    fn default() -> Self {
        Self { resolution: 1024, t_s: 5.0, occlusion: Estimate::Bound, clusters: true }
    }
}

ports! {
    pub struct In {
        /// The cell.
        cell: Arc<HexCell>,
        /// Where the scene's objects stand.
        placements: List<Placement, true>,
    }
}

ports! {
    pub struct Out {
        /// What stand-ins are of, about the cell's centre: by the name of the object, or that of the first of a cluster and how many more there are.
        stand_ins: List<Subject, true>,
        /// The objects of each stand-in.
        members: Arc<Relation>,
        /// The cell's row of the manifest, without its files.
        entry: Arc<Entry>,
    }
}

pub struct ClassifyOcclusion;

impl Node for ClassifyOcclusion {
    const KIND: &'static str = "classify-occlusion";
    const VERSION: u32 = 2;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        (1 << 20) + sizes.iter().sum::<u64>().saturating_mul(4)
    }

    fn run(params: &Params, inputs: In, _: &Ctx) -> Result<Out, NodeError> {
        let how = Classifying {
            image_res: f64::from(params.resolution),
            t_s: params.t_s,
            estimate: params.occlusion,
            clusters: params.clusters,
        };
        let cell = &inputs.cell;
        let objects: Vec<(String, &Placement)> = inputs.placements.0.iter().map(|(n, p)| (n.clone(), &**p)).collect();
        let centres: Vec<DVec3> = cell.neighbours.iter().map(|n| n.1).collect();
        let found = classify(&cell.prism, &centres, &objects, &how);
        let triangles: BTreeMap<&str, u64> = objects.iter().map(|(n, p)| (n.as_str(), p.triangles)).collect();
        let sum = |names: &mut dyn Iterator<Item = &String>| names.filter_map(|n| triangles.get(n.as_str())).sum();
        let entry = Entry {
            name: cell.name.clone(),
            centre: cell.prism.centre.to_array(),
            neighbours: cell.neighbours.iter().map(|n| n.0.clone()).collect(),
            inside_triangles: sum(&mut found.inside.iter()),
            original_triangles: sum(&mut found.subjects.iter().flat_map(|s| s.1.members.iter().map(|m| &m.0))),
            inside: found.inside,
            ..Entry::default()
        };
        let members = found.subjects.iter().map(|(n, s)| (n.clone(), s.members.iter().map(|m| m.0.clone()).collect()));
        Ok(Out {
            members: Arc::new(Relation(members.collect())),
            entry: Arc::new(entry),
            stand_ins: List(found.subjects.into_iter().map(|(n, s)| (n, Arc::new(s))).collect()),
        })
    }
}
