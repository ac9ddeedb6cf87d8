//! A DMesh as a stand-in that certificates can judge.

use super::{Blending, Dmesh, Frames, Meshes, Model, select};
use crate::{
    math::{Aabb, Stopped},
    raster::Rendering,
    runtime::{Context, Drawn, Planes, Shot, Size, StandIn, plane},
    view::{Projection, View},
};
use glam::{DVec3, Vec3};
use std::{collections::BTreeSet, sync::Arc};

/// A DMesh, drawn with the meshes that it was baked with or with meshes made for every view.
#[derive(Clone)]
pub struct DmeshStandIn {
    model: Arc<Model>,
    /// What meshes for a view are made from, where they are.
    per_view: Option<Arc<Meshes>>,
    blending: Blending,
    captured: Captured,
    bounds: Aabb,
}

/// What the references saw, where it is known.
#[derive(Clone)]
struct Captured(Option<Arc<(Vec<View>, Frames)>>);

impl DmeshStandIn {
    /// Drawn with its own meshes. `frames` say what the references saw.
    pub fn fixed(model: Model, blending: Blending, frames: Option<&Frames>) -> Self {
        let (captured, bounds) = (Captured::new(model.dmesh(), frames), bounds(model.dmesh()));
        Self { model: Arc::new(model), per_view: None, blending, captured, bounds }
    }

    /// The same, drawn with meshes made for every view.
    pub fn per_view(&self, meshes: Meshes) -> Self {
        Self { per_view: Some(Arc::new(meshes)), ..self.clone() }
    }
}

fn bounds(dmesh: &Dmesh) -> Aabb {
    let points = dmesh.references.iter().flat_map(|r| r.mesh.positions.iter());
    points.map(|p| Vec3::from(*p).as_dvec3()).collect()
}

/// Vertices and indices, and the texels of colours and normals.
fn size(dmesh: &Dmesh) -> Size {
    let mut out = Size::default();
    let mut images = BTreeSet::new();
    for r in &dmesh.references {
        out.triangles += r.mesh.triangles.len() as u64;
        out.draw_calls += u64::from(!r.mesh.triangles.is_empty());
        // Position, normal, texture coordinates and quality.
        out.memory_bytes += (r.mesh.positions.len() * (12 + 12 + 8 + 4) + r.mesh.triangles.len() * 12) as u64;
        for image in [Some(&r.color), r.normal_map.as_ref()].into_iter().flatten() {
            if images.insert(Arc::as_ptr(image)) {
                out.texels += image.texels.len() as u64;
            }
        }
    }
    out.memory_bytes += 4 * out.texels;
    out
}

fn shot(
    model: Arc<Model>,
    view: &View,
    how: &Rendering,
    blending: &Blending,
    context: Context,
) -> Result<Shot<'static>, Stopped> {
    let drawn = model.draw(view, how, blending, context.stop)?;
    let triangles = |r: usize| model.dmesh().references[r].mesh.triangles.len() as u64;
    let of_view = Drawn {
        triangles: drawn.selected.iter().map(|s| triangles(s.reference)).sum(),
        references: drawn.selected.iter().filter(|s| triangles(s.reference) > 0).count() as u32,
    };
    let at = *view;
    let planes: Planes = Box::new(move |surface| plane(&at, model.positions(surface)));
    Ok(Shot { picture: drawn.picture, depth: drawn.depth, surface: drawn.surface, planes, drawn: Some(of_view) })
}

impl StandIn for DmeshStandIn {
    fn bounds(&self) -> Aabb {
        self.bounds
    }

    fn size(&self) -> Size {
        size(self.model.dmesh())
    }

    fn draw(&self, view: &View, how: &Rendering, context: Context) -> Result<Shot<'_>, Stopped> {
        let Some(meshes) = &self.per_view else { return shot(self.model.clone(), view, how, &self.blending, context) };
        context.stop.check()?;
        let selected = select(self.model.dmesh(), view, self.blending.weights);
        let meshes = meshes.for_view(view, &selected);
        // Meshes of a hierarchy always are what drawing relies on.
        let model = self.model.with_meshes(&meshes).expect("meshes of these references");
        shot(Arc::new(model), view, how, &self.blending, context)
    }

    fn saw(&self, point: DVec3) -> bool {
        self.captured.saw(point)
    }
}

/// A point counts as seen where it lies between the depths of the pixels around it, give or take so many texels.
const TEXELS: f64 = 2.0;

impl Captured {
    fn new(dmesh: &Dmesh, frames: Option<&Frames>) -> Self {
        let views = || dmesh.references.iter().map(|r| r.view).collect();
        Self(frames.map(|f| Arc::new((views(), f.clone()))))
    }

    /// Whether a depth image has the point among the four pixels around it. True of all points where there are no
    /// depth images.
    fn saw(&self, point: DVec3) -> bool {
        let Some(captured) = &self.0 else { return true };
        let (views, frames) = &**captured;
        views.iter().zip(&frames.depths).any(|(view, depth)| {
            let (x, y, z) = view.project(point);
            if z <= 0.0 && matches!(view.projection, Projection::Perspective { .. }) {
                return false;
            }
            let (a, b) = (view.unproject(x, y, z), view.unproject(x + 1.0, y, z));
            let slack = TEXELS * a.distance(b);
            let (x0, y0) = ((x - 0.5).floor(), (y - 0.5).floor());
            let inside = |i: f64, n: u32| (0.0..f64::from(n)).contains(&i);
            // On steep surfaces neighbours differ by many texels: what lies between them is seen.
            let (mut nearest, mut farthest) = (f64::INFINITY, f64::NEG_INFINITY);
            for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
                let (i, j) = (x0 + dx, y0 + dy);
                if inside(i, view.width) && inside(j, view.height) {
                    let seen = f64::from(depth[j as usize * view.width as usize + i as usize]);
                    if seen.is_finite() {
                        (nearest, farthest) = (nearest.min(seen), farthest.max(seen));
                    }
                }
            }
            nearest - slack <= z && z <= farthest + slack
        })
    }
}
