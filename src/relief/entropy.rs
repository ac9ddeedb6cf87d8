//! How much of an object a direction of view shows: viewpoint entropy (Vázquez et al. 2003; Andújar et al. 2007, section 3.1).
//!
//! H = −Σ (Aᵢ/Aₜ)·log₂(Aᵢ/Aₜ) over the faces i and the background 0; Aᵢ is the area of face i that the picture shows. Aₜ is that of a square around the object's bounding
//! sphere, the same for all directions.
//!
//! Areas that are counts of pixels saturate: where faces are smaller than pixels, as many faces are seen as there are pixels, and which ones is chance. So faces
//! below [`SMALL`] pixels are seen whole or not at all: with the area of their projection, where a pixel shows them or their centroid is not
//! hidden by what its pixel shows. Larger faces have the area of their pixels.

use crate::{
    math::{Aabb, Stop, Stopped},
    raster::{Backend, Camera, Cutout, Geometry, Holes, NOTHING, Options, nearest},
    view::{View, directions},
};
use glam::{DVec3, Vec3};

/// Faces with a smaller projection, in pixels, are seen whole or not at all.
const SMALL: f32 = 16.0;

/// Faces that are turned less towards the eye, as the cosine of the angle between their normal and it, are seen edge-on: not at all.
const EDGE_ON: f32 = 1e-4;

/// How far a centroid may lie behind the plane of the face that its pixel shows and still count as seen, where both turn the same side to the eye, pixels.
const BEHIND: f32 = 0.5;

/// What a direction of view shows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sight {
    /// Faces that are seen, ascending triangle numbers of the [`Geometry`], with Aᵢ/Aₜ > 0.
    pub faces: Vec<(u32, f32)>,
}

impl Sight {
    /// Viewpoint entropy in bits; 0 where nothing is seen.
    pub fn entropy(&self) -> f64 {
        let covered: f64 = self.faces.iter().map(|f| f64::from(f.1)).sum();
        self.faces.iter().map(|f| information(f.1)).sum::<f64>() + information((1.0 - covered).max(0.0) as f32)
    }

    /// Area of the faces, as a share of Aₜ, that are seen here and not in the view that `seen` are the faces of.
    pub fn beyond(&self, seen: &Seen) -> f64 {
        self.faces.iter().filter(|f| !seen.has(f.0)).map(|f| f64::from(f.1)).sum()
    }
}

/// −p·log₂ p, 0 for p = 0.
pub fn information(p: f32) -> f64 {
    if p > 0.0 { -f64::from(p * libm::log2f(p)) } else { 0.0 }
}

/// A set of faces, a bit each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Seen(Vec<u64>);

impl Seen {
    /// No face of `count`.
    pub fn none(count: u32) -> Self {
        Self(vec![0; (count as usize).div_ceil(64)])
    }

    pub fn add(&mut self, sight: &Sight) {
        sight.faces.iter().for_each(|f| self.0[f.0 as usize / 64] |= 1 << (f.0 % 64));
    }

    pub fn has(&self, face: u32) -> bool {
        self.0[face as usize / 64] >> (face % 64) & 1 == 1
    }

    pub fn count(&self) -> usize {
        self.0.iter().map(|w| w.count_ones() as usize).sum()
    }
}

/// A face in units of the bounding sphere's radius, about its centre.
#[derive(Clone, Copy, Debug)]
struct Face {
    centroid: Vec3,
    /// Outwards, as long as the face's area.
    normal: Vec3,
    /// Its projection, where it is seen edge-on, is not larger.
    edge_on: f32,
    /// Both sides are drawn.
    both: bool,
    /// The centroid is no hole.
    solid: bool,
}

/// Looks at a scene from all sides.
pub struct Probe<'a> {
    backend: &'a dyn Backend,
    geometry: &'a Geometry,
    faces: Vec<Face>,
    centre: DVec3,
    radius: f64,
    ids: u32,
}

impl<'a> Probe<'a> {
    /// `points` are the scene's vertices, metres; pictures of `ids` × `ids` pixels. `None` where there is no point.
    pub fn new(backend: &'a dyn Backend, geometry: &'a Geometry, points: &[DVec3], ids: u32) -> Option<Self> {
        let bounds: Aabb = points.iter().copied().collect();
        if bounds.is_empty() {
            return None;
        }
        let centre = bounds.centre();
        let radius = points.iter().map(|p| p.distance(centre)).fold(1e-9, f64::max);
        Some(Self { backend, geometry, faces: faces(geometry, centre, radius), centre, radius, ids })
    }

    /// Number of faces; instances count.
    pub fn face_count(&self) -> u32 {
        self.geometry.triangle_count()
    }

    fn view(&self, direction: DVec3) -> View {
        directions::look_along_sphere(self.centre, self.radius, direction, self.ids, 0.0)
    }

    /// What is seen from the side where `direction` (unit, from the object to the eye) points.
    pub fn sight(&self, direction: DVec3, stop: &Stop) -> Result<Sight, Stopped> {
        let view = self.view(direction);
        let shown = nearest(self.backend, self.geometry, &view, &Options::default(), stop)?.triangle;
        let mut counts = vec![0_u32; self.faces.len()];
        shown.iter().filter(|t| **t != NOTHING).for_each(|t| counts[*t as usize] += 1);
        let ids = self.ids as f32;
        let pixel = 2.0 / ids;
        let towards = direction.as_vec3();
        let (right, down) = (view.right.as_vec3(), -view.up.as_vec3());
        let hidden = |face: &Face| {
            let (x, y) = (face.centroid.dot(right), face.centroid.dot(down));
            let at = |v: f32| (((v + 1.0) / pixel) as u32).min(self.ids - 1) as usize;
            match shown[at(y) * self.ids as usize + at(x)] {
                NOTHING => false,
                front => {
                    let front = &self.faces[front as usize];
                    // Beside a silhouette the far side of a solid is no neighbour of what its pixel shows.
                    let same_side = (front.normal.dot(towards) < 0.0) == (face.normal.dot(towards) < 0.0);
                    front.hides(face.centroid, towards, if same_side { BEHIND * pixel } else { 0.0 })
                }
            }
        };
        let mut seen = Vec::new();
        for (i, (face, count)) in self.faces.iter().zip(&counts).enumerate() {
            let cos = face.normal.dot(towards);
            let area = if face.both { cos.abs() } else { cos };
            // Written so that a NaN counts as unseen.
            if !(area > face.edge_on) {
                continue;
            }
            let share = area * 0.25;
            if share * ids * ids >= SMALL {
                if *count > 0 {
                    seen.push((i as u32, *count as f32 / (ids * ids)));
                }
            } else if *count > 0 || (face.solid && !hidden(face)) {
                seen.push((i as u32, share));
            }
        }
        Ok(Sight { faces: seen })
    }
}

impl Face {
    /// Whether a point lies behind this face's plane, as seen from `towards`, by more than `slack`.
    fn hides(&self, point: Vec3, towards: Vec3, slack: f32) -> bool {
        let outwards = if self.normal.dot(towards) < 0.0 { -self.normal } else { self.normal };
        outwards.dot(self.centroid - point) > slack * outwards.length()
    }
}

fn faces(geometry: &Geometry, centre: DVec3, radius: f64) -> Vec<Face> {
    let camera = Camera::new(&directions::look_along_sphere(centre, radius, DVec3::Z, 4, 0.0));
    let mut holes = Holes::seen_by(geometry, camera);
    let mut faces = Vec::with_capacity(geometry.triangle_count() as usize);
    for draw in geometry.draws() {
        let masked = matches!(draw.cutout, Cutout::Masked(_));
        for local in 0..draw.mesh.triangles.len() as u32 {
            let number = draw.first + local;
            let [a, b, c] = geometry.positions(number).map(|p| (p - centre) / radius);
            // What is never drawn has no area.
            let normal = if draw.cutout == Cutout::Hidden { DVec3::ZERO } else { (b - a).cross(c - a) * 0.5 };
            let (normal, centroid) = (normal.as_vec3(), ((a + b + c) / 3.0).as_vec3());
            let solid = !masked || holes.solid_at(number, [1.0 / 3.0; 3]);
            let edge_on = normal.length() * EDGE_ON;
            faces.push(Face { centroid, normal, edge_on, both: draw.material.double_sided, solid });
        }
    }
    faces
}
