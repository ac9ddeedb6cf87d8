//! From a subject's windows and meshes to its stand-in: surface, weights, collapse, textures.

use super::{
    collapse::{Cost, Goal, Mesh, collapse},
    faces::{Facing, surface},
    levels::Levels,
    parallax::parallax,
    pixels::Steps,
    simplified::Simplified,
    subject::{Subject, Views},
    texture::{Textured, Texturing, texture},
    weights::{SLACK, Windows, weights},
};
use crate::{
    math::{Stop, Stopped},
    mesh::simplify::compact,
};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What a collapse is judged by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CostKind {
    /// The paper's (1.5 − n_i·n_j)^e · l · (w_i + w_j), compared with `t_l`.
    Paper,
    /// How far the picture moves as the eye does, in pixels, compared with `tolerance`.
    #[default]
    Parallax,
}

/// How a stand-in is simplified.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Simplifying {
    pub cost: CostKind,
    pub facing: Facing,
    pub steps: Steps,
    /// e.
    pub exponent: f64,
    /// T_l, pixels.
    pub t_l: f64,
    /// Pixels.
    pub tolerance: f64,
    /// By how many pixels the mesh that it starts from may differ from the original.
    pub start: f64,
    /// Triangles at which the collapse ends; 0 for none.
    pub triangles: usize,
}

/// How much the distance from outlines counts beside that from faces, per pixel of length.
const OUTLINE: f64 = 4.0;
/// How much faces count that no view sees.
const UNSEEN: f64 = 0.05;

/// Simplifies `subject`, whose members' meshes are `levels`, as `windows` show it. No triangles are left where no face looks at the cell.
///
/// # Errors
/// Where it is stopped.
pub fn simplify(
    subject: &Subject,
    levels: &[&Levels],
    windows: &Windows,
    how: &Simplifying,
    stop: &Stop,
) -> Result<Simplified, Stopped> {
    let Some(first) = windows.0.first() else {
        return Ok(Simplified::default());
    };
    let nearest = (subject.outline.nearest() - subject.cell.radius()).max(0.0);
    let metres = nearest / subject.focal;
    let eyes: Vec<DVec3> = windows.0.iter().map(|w| w.view.eye).collect();
    let seen = |p: DVec3| {
        windows.0.iter().any(|w| {
            let z = (p - w.view.eye).dot(w.view.forward);
            w.sees(p, SLACK * 0.25 * w.pixel() * z).is_some()
        })
    };
    let facing = if subject.views == Views::Multi { Facing::Cell } else { how.facing };
    let surface = surface(subject, levels, facing, how.start * metres, &eyes, &seen);
    let weights = weights(&surface, windows, &how.steps);
    let place = |p: &DVec3| parallax(&first.view, *p, subject.focal, subject.cell.radius()).unwrap_or(DVec3::ZERO);
    let screen: Vec<DVec3> = surface.positions.iter().map(place).collect();
    let mesh = Mesh {
        positions: &surface.positions,
        screen: &screen,
        normals: &surface.normals,
        weight: &weights.weight,
        views: &weights.views,
        triangles: &surface.triangles,
    };
    let multi = subject.views == Views::Multi;
    let mut corners = vec![DVec3::ZERO];
    if multi {
        corners.extend(subject.cell.corners());
    }
    let (cost, tolerance) = match how.cost {
        CostKind::Paper => (Cost::Paper { exponent: how.exponent, eyes: &corners, focal: subject.focal }, how.t_l),
        CostKind::Parallax => (Cost::Parallax { outline: OUTLINE, hidden: UNSEEN }, how.tolerance),
    };
    let goal = Goal { tolerance, triangles: how.triangles, shared_views: multi };
    let left = collapse(&mesh, cost, &goal, stop)?;
    let (used, triangles) = compact(surface.positions.len(), &left);
    let used = || used.iter().map(|v| *v as usize);
    Ok(Simplified {
        positions: used().map(|v| surface.positions[v]).collect(),
        colors: used().map(|v| surface.colors[v]).collect(),
        views: used().map(|v| weights.views[v]).collect(),
        triangles,
        error: surface.error,
        before: surface.triangles.len() as u64,
    })
}

/// The stand-in of what [`simplify`] gave, which moved the surface by at most `tolerance` pixels of parallax.
pub fn textured(subject: &Subject, simplified: &Simplified, windows: &Windows, tolerance: f64) -> Textured {
    if simplified.triangles.is_empty() {
        return Textured::default();
    }
    let texturing = Texturing { moved: tolerance, radius: subject.cell.radius() };
    let single = subject.views == Views::Single;
    texture(simplified, windows, single, &texturing)
}
