//! `classify-points`: which points of a set lie in which solids.

use super::{
    json_file,
    values::Sprite,
    volumes::{self, SpritePlace},
};
use crate::{
    engine::{
        node::{Ctx, List, Node, NodeError},
        plan::File,
    },
    image::srgb,
    math::{Aabb, Sequence},
    ports,
    scene::{Material, Mesh, Object, Part, Scene},
    sprite::Volume,
};
use glam::{DVec3, Mat4, Vec3};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::sync::Arc;

/// Tests a set of points against depth sprites: the vertices of a scene, or points spread over the bounds of all sprites. Gives how
/// many lie in which, and a scene that shows the points as small octahedra: those outside of all in one object, those inside of
/// each sprite in one of its own. Source: Trapp and Döllner 2008, section 3.3.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Where sprites are put; [] leaves each where its solid was, under its own name.
    pub places: Vec<SpritePlace>,
    /// Points that are spread where no scene gives any, 1 to 1,000,000.
    #[schemars(range(min = 1, max = 1_000_000), extend("x-unit" = "points"))]
    pub count: u32,
    /// Seed of the sequence of points.
    pub seed: u64,
    /// From the middle of an octahedron to its corners, as a share of the points' diagonal, more than 0 and at most 1.
    #[schemars(range(max = 1.0), extend("exclusiveMinimum" = 0.0))]
    pub dot: f64,
}

impl Default for Params {
    fn default() -> Self {
        Self { places: Vec::new(), count: 4000, seed: 1, dot: 0.004 }
    }
}

ports! {
    pub struct In {
        /// Whose vertices are the points.
        points: Option<Arc<Scene>>,
        /// The sprites, by name.
        sprites: List<Sprite>,
    }
}

ports! {
    pub struct Out {
        /// How many points lie in each sprite, JSON.
        report: Arc<File>,
        /// The points as octahedra: the object `outside`, and for each sprite `inside NAME`; a point in several is in the first.
        dots: Arc<Scene>,
    }
}

pub struct ClassifyPoints;

/// Colours of the points inside the first, second, … sprite; sRGB.
const COLORS: [[u8; 3]; 6] =
    [[230, 60, 50], [50, 110, 230], [40, 160, 80], [240, 160, 30], [150, 70, 200], [20, 170, 180]];
const OUTSIDE: [u8; 3] = [150, 155, 160];

impl Node for ClassifyPoints {
    const KIND: &'static str = "classify-points";
    const VERSION: u32 = 2;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(params: &Params, sizes: &[u64]) -> u64 {
        // An octahedron takes 168 bytes.
        (16 << 20) + sizes.iter().sum::<u64>().saturating_mul(16) + u64::from(params.count) * 400
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        volumes::check(&params.places)
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let volumes = volumes::volumes(&params.places, &inputs.sprites)?;
        let points = match &inputs.points {
            Some(scene) => vertices(scene),
            None => spread(&volumes, params),
        };
        if points.is_empty() {
            return Err(NodeError::Failed("there are no points: the scene has no vertices".into()));
        }
        ctx.stop.check()?;
        let held = |p: &DVec3| volumes.iter().map(|(_, v)| v.contains(*p)).collect::<Vec<_>>();
        let held: Vec<Vec<bool>> = points.par_iter().map(held).collect();
        let bounds: Aabb = points.iter().copied().collect();
        let size = (params.dot * bounds.diagonal()).max(f64::from(f32::MIN_POSITIVE)) as f32;
        let dots = |name: String, color: [u8; 3], wanted: &dyn Fn(&[bool]) -> bool| {
            let some = points.iter().zip(&held).filter(|(_, h)| wanted(h)).map(|(p, _)| p.as_vec3());
            object(name, color, octahedra(some, size))
        };
        let mut objects = Vec::new();
        for (i, (name, _)) in volumes.iter().enumerate() {
            let first = move |h: &[bool]| h.iter().position(|h| *h) == Some(i);
            objects.push(dots(format!("inside {name}"), COLORS[i % COLORS.len()], &first));
        }
        objects.push(dots("outside".into(), OUTSIDE, &|h| !h.contains(&true)));
        objects.retain(|o| o.triangle_count() > 0);
        objects.sort_by(|a, b| a.name.cmp(&b.name));
        let count = |i: usize| held.iter().filter(|h| h[i]).count();
        let of_sprites: serde_json::Map<_, _> =
            volumes.iter().enumerate().map(|(i, (name, _))| (name.clone(), json!(count(i)))).collect();
        let report = json!({
            "points": points.len(),
            "inside": of_sprites,
            "inside_several": held.iter().filter(|h| h.iter().filter(|h| **h).count() > 1).count(),
            "outside": held.iter().filter(|h| !h.contains(&true)).count(),
        });
        Ok(Out { report: json_file(&report)?, dots: Arc::new(Scene { objects }) })
    }
}

/// The vertices of a scene in the world; those at one place count once.
fn vertices(scene: &Scene) -> Vec<DVec3> {
    let mut all: Vec<DVec3> = Vec::new();
    for object in &scene.objects {
        for part in &object.parts {
            all.extend(
                part.mesh.positions.iter().map(|p| object.transform.transform_point3(Vec3::from(*p)).as_dvec3()),
            );
        }
    }
    all.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)));
    all.dedup();
    all
}

fn spread(volumes: &[(String, Volume)], params: &Params) -> Vec<DVec3> {
    let bounds = volumes.iter().map(|(_, v)| v.bounds()).reduce(|a, b| a.union(b));
    let Some(bounds) = bounds else { return Vec::new() };
    let sequence = Sequence::<3>::new(params.seed);
    (0..params.count).map(|i| bounds.min + bounds.size() * DVec3::from(sequence.point(i))).collect()
}

fn octahedra(points: impl Iterator<Item = Vec3>, size: f32) -> Mesh {
    const FACES: [[u32; 3]; 8] =
        [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for p in points {
        let first = positions.len() as u32;
        let axes = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
        positions.extend(axes.map(|a| (p + a * size).to_array()));
        triangles.extend(FACES.map(|f| f.map(|i| i + first)));
    }
    Mesh { positions: positions.into(), triangles: triangles.into(), ..Mesh::default() }
}

fn object(name: String, color: [u8; 3], mesh: Mesh) -> Object {
    let [r, g, b] = color.map(srgb::to_linear);
    let material = Material { name: name.clone(), base_color: [r, g, b, 1.0], ..Material::default() };
    let part = Part { mesh: Arc::new(mesh), material: Arc::new(material) };
    Object { name, transform: Mat4::IDENTITY, parts: vec![part] }
}
