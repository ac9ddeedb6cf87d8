//! Impostors of the parts of a large object as a tree (Andújar et al. 2007, section 5).

use super::{
    OriError,
    instances::{Instance, draw_instances},
    manifest::Manifest,
    model::Model,
    read,
};
use crate::{
    formats::{self, Files, Limits},
    image::{Picture, srgb},
    math::{Aabb, Stopped},
    raster::{Geometry, NOTHING, Rendering},
    relief::Strategy,
    runtime::{Context, Drawn, SceneStandIn, Shot, Size, StandIn, bundle::load},
    scene::Scene,
    view::{Projection, View},
};
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};
use std::{collections::BTreeMap, path::Path};

pub const TREE_FORMAT: &str = "farfield ori-tree";
pub const TREE_VERSION: u32 = 1;
/// Name of the manifest of a tree.
pub const TREE_NAME: &str = "ori-tree.json";
/// Regions that a tree may have.
const MOST: usize = 4096;

/// `ori-tree.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TreeManifest {
    /// [`TREE_FORMAT`].
    pub format: String,
    /// [`TREE_VERSION`].
    pub version: u32,
    /// The root first; children after their parents.
    pub regions: Vec<RegionRow>,
    /// Shader files by language; those of all impostors.
    pub shaders: BTreeMap<String, Vec<String>>,
}

/// A region of a tree.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RegionRow {
    pub name: String,
    /// Least and greatest corner of its box, metres.
    pub bounds: [[f64; 3]; 2],
    /// Up to how many pixels along the longer side of its projection the impostor may be used; null: at any size.
    pub plt_px: Option<f64>,
    /// Names of the regions that it is divided into.
    pub children: Vec<String>,
    /// Folder of its impostor, a bundle with an `ori.json`.
    pub folder: String,
    /// GLB of what lies in a region without children, for eyes that are nearer than its impostor bears; null where it was not asked for.
    pub mesh: Option<String>,
}

/// A tree ready to be drawn.
pub struct TreeStandIn {
    regions: Vec<Region>,
    size: Size,
}

struct Region {
    bounds: Aabb,
    plt: f64,
    children: Vec<usize>,
    model: Model,
    mesh: Option<(Scene, Geometry)>,
}

/// What a view is drawn with: numbers of regions.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Front {
    /// Drawn by their impostors.
    pub impostors: Vec<usize>,
    /// Drawn by their meshes.
    pub meshes: Vec<usize>,
}

impl TreeManifest {
    /// # Errors
    /// Where it is no manifest of this format and version, or its regions are no tree.
    pub fn parse(text: &[u8]) -> Result<Self, OriError> {
        let bad = |what: String| OriError::invalid(TREE_NAME, what);
        let manifest: Self = serde_json::from_slice(text).map_err(|e| bad(e.to_string()))?;
        if manifest.format != TREE_FORMAT || manifest.version != TREE_VERSION {
            let (format, version) = (&manifest.format, manifest.version);
            return Err(bad(format!("format `{format}` {version}; expected `{TREE_FORMAT}` {TREE_VERSION}")));
        }
        if !(1..=MOST).contains(&manifest.regions.len()) {
            return Err(bad(format!("{} regions; expected 1 to {MOST}", manifest.regions.len())));
        }
        manifest.children()?;
        Ok(manifest)
    }

    /// The numbers of each region's children. Every region but the first is the child of one that stands before it.
    fn children(&self) -> Result<Vec<Vec<usize>>, OriError> {
        let bad = |what: String| OriError::invalid(TREE_NAME, what);
        let mut number: BTreeMap<&str, usize> = BTreeMap::new();
        for (i, row) in self.regions.iter().enumerate() {
            if number.insert(&row.name, i).is_some() {
                return Err(bad(format!("two regions `{}`", row.name)));
            }
        }
        let mut parents = vec![0_u32; self.regions.len()];
        let mut out = Vec::with_capacity(self.regions.len());
        for (i, row) in self.regions.iter().enumerate() {
            let mut own = Vec::new();
            for child in &row.children {
                match number.get(child.as_str()) {
                    Some(c) if *c > i => {
                        parents[*c] += 1;
                        own.push(*c);
                    }
                    _ => return Err(bad(format!("`{}`: expected its child `{child}` after it", row.name))),
                }
            }
            out.push(own);
        }
        match parents.iter().skip(1).position(|n| *n != 1) {
            Some(i) => Err(bad(format!("`{}`: expected one parent", self.regions[i + 1].name))),
            None => Ok(out),
        }
    }
}

impl TreeStandIn {
    /// Reads the tree whose `ori-tree.json` lies in `folder`.
    ///
    /// # Errors
    /// Where a file is missing or not as it should be.
    pub fn read(folder: &Path, files: &(dyn Files + Sync), limits: &Limits) -> Result<Self, OriError> {
        let manifest = TreeManifest::parse((*load(&folder.join(TREE_NAME), files)?).as_ref())?;
        let children = manifest.children()?;
        let (mut regions, mut size) = (Vec::new(), Size::default());
        for (row, children) in manifest.regions.iter().zip(children) {
            let bundle = read::read(&read::inside(folder, &row.folder)?, files)?;
            let mut ori = bundle.ori;
            // Impostors of several regions meet at their true depths (section 3.3, strategy 5).
            ori.drawing.strategy = Strategy::BiasedDepth;
            size.texels += bundle
                .textures
                .named()
                .map(|(_, a)| u64::from(a.width) * u64::from(a.height) * u64::from(a.layers))
                .sum::<u64>();
            size.memory_bytes += bundle.textures.bytes();
            size.draw_calls += 1;
            size.triangles += super::stand_in::BOX;
            let mesh = match &row.mesh {
                Some(name) => {
                    let path = read::inside(folder, name)?;
                    let scene = formats::from_glb(&path, load(&path, files)?, limits)?;
                    let own = Size::of(&scene);
                    size.memory_bytes += own.memory_bytes;
                    let geometry = Geometry::new(&scene);
                    Some((scene, geometry))
                }
                None => None,
            };
            let [min, max] = row.bounds.map(DVec3::from);
            let bounds = Aabb { min, max };
            if bounds.is_empty() || !(min.is_finite() && max.is_finite()) {
                return Err(OriError::invalid(TREE_NAME, format!("`{}`: expected a box", row.name)));
            }
            let plt = row.plt_px.unwrap_or(f64::INFINITY);
            regions.push(Region { bounds, plt, children, model: Model::new(ori)?, mesh });
        }
        Ok(Self { regions, size })
    }

    /// What a view is drawn with (section 5): a region is drawn where its threshold is larger than its box on the screen; else its children are asked. Regions
    /// without children are drawn by their mesh there, and by their impostor where they have none.
    pub fn front(&self, view: &View) -> Front {
        let mut front = Front::default();
        let mut open = vec![0];
        while let Some(i) = open.pop() {
            let region = &self.regions[i];
            let fits = projected_size(view, &region.bounds) <= region.plt;
            if fits || (region.children.is_empty() && region.mesh.is_none()) {
                front.impostors.push(i);
            } else if region.children.is_empty() {
                front.meshes.push(i);
            } else {
                open.extend(region.children.iter().rev());
            }
        }
        front
    }

    /// Draws a front; [`StandIn::draw`] draws that of the view.
    pub fn draw_front(
        &self,
        front: &Front,
        view: &View,
        how: &Rendering,
        context: Context,
    ) -> Result<Shot<'static>, Stopped> {
        if front.meshes.is_empty() {
            return self.draw_impostors(front, view, how, context);
        }
        // Meshes and impostors meet sample by sample, so that nothing shines through between them.
        let n = how.samples_per_axis.max(1);
        let fine = View { width: view.width * n, height: view.height * n, ..*view };
        let once = Rendering { samples_per_axis: 1, shades_per_axis: 1, ..*how };
        let mut all = self.draw_impostors(front, &fine, &once, context)?;
        let mut centres = self.draw_impostors(front, view, &once, context)?;
        let mut triangles = 0;
        for i in &front.meshes {
            let Some((scene, geometry)) = &self.regions[*i].mesh else { continue };
            triangles += geometry.triangle_count() as u64;
            let mesh = SceneStandIn::new(scene, geometry);
            over(&mut all, mesh.draw(&fine, &once, context)?);
            let shot = mesh.draw(view, &once, context)?;
            let planes = shot.planes;
            let behind = centres.planes;
            let numbers = shot.surface;
            let mut by_pixel = Vec::with_capacity(numbers.len());
            for (p, number) in numbers.iter().enumerate() {
                let nearer = shot.depth[p] < centres.depth[p];
                by_pixel.push(if nearer { planes(*number) } else { DVec3::NAN });
                if nearer {
                    (centres.depth[p], centres.surface[p]) = (shot.depth[p], p as u32);
                }
            }
            centres.planes = Box::new(move |p| {
                let own = by_pixel[p as usize];
                if own.is_nan() { behind(p) } else { own }
            });
        }
        let drawn = Drawn {
            triangles: triangles + super::stand_in::BOX * front.impostors.len() as u64,
            references: centres.drawn.map_or(0, |d| d.references),
        };
        let picture = reduced(&all.picture, n);
        Ok(Shot { picture, depth: centres.depth, surface: centres.surface, planes: centres.planes, drawn: Some(drawn) })
    }

    fn draw_impostors(
        &self,
        front: &Front,
        view: &View,
        how: &Rendering,
        context: Context,
    ) -> Result<Shot<'static>, Stopped> {
        let models: Vec<&Model> = front.impostors.iter().map(|i| &self.regions[*i].model).collect();
        let instances: Vec<Instance> =
            (0..models.len() as u32).map(|model| Instance { model, ..Instance::default() }).collect();
        let shown = draw_instances(&models, &instances, view, how, context.stop)?;
        let surface = (0..).zip(&shown.depth).map(|(i, z)| if z.is_finite() { i } else { NOTHING }).collect();
        let drawn = Drawn { triangles: super::stand_in::BOX * models.len() as u64, references: shown.maps };
        let planes = super::stand_in::planes(*view, shown.depth.clone(), shown.normal);
        Ok(Shot { picture: shown.picture, depth: shown.depth, surface, planes, drawn: Some(drawn) })
    }
}

/// Puts the nearer of two shots of one sample a pixel into the first.
fn over(all: &mut Shot, other: Shot) {
    for i in 0..all.depth.len() {
        if other.depth[i] < all.depth[i] {
            (all.depth[i], all.picture.texels[i]) = (other.depth[i], other.picture.texels[i]);
        }
    }
}

/// The mean of n×n pixels each, in linear light.
fn reduced(picture: &Picture, n: u32) -> Picture {
    let (width, height) = (picture.width / n, picture.height / n);
    let texel = |i: u32| {
        let (x, y) = (i % width * n, i / width * n);
        let sum: Vec3 = (0..n * n)
            .map(|k| {
                let [r, g, b, _] = picture.texels[((y + k / n) * picture.width + x + k % n) as usize];
                Vec3::new(srgb::to_linear(r), srgb::to_linear(g), srgb::to_linear(b))
            })
            .sum();
        let [r, g, b] = (sum / (n * n) as f32).to_array().map(srgb::from_linear);
        [r, g, b, 255]
    };
    Picture { width, height, texels: (0..width * height).map(texel).collect() }
}

/// Pixels along the longer side of the rectangle around a box on the screen; infinite where the box reaches behind the eye.
pub fn projected_size(view: &View, bounds: &Aabb) -> f64 {
    let (mut lo, mut hi) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for corner in bounds.corners() {
        let (x, y, z) = view.project(corner);
        if z <= 0.0 && matches!(view.projection, Projection::Perspective { .. }) {
            return f64::INFINITY;
        }
        (lo, hi) = (lo.min(DVec3::new(x, y, 0.0)), hi.max(DVec3::new(x, y, 0.0)));
    }
    (hi - lo).max_element()
}

impl StandIn for TreeStandIn {
    fn bounds(&self) -> Aabb {
        self.regions[0].model.ori().bounds
    }

    fn size(&self) -> Size {
        self.size
    }

    fn draw(&self, view: &View, how: &Rendering, context: Context) -> Result<Shot<'_>, Stopped> {
        self.draw_front(&self.front(view), view, how, context)
    }
}

/// The threshold that a bundle's `ori.json` states, pixels; infinite where it states none.
///
/// # Errors
/// Where it is no manifest of an impostor.
pub fn stated_threshold(manifest: &[u8]) -> Result<f64, OriError> {
    Ok(Manifest::parse(manifest)?.plt_px.unwrap_or(f64::INFINITY))
}
