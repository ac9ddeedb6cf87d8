//! Bundles as stand-ins: opened as an engine would, by what their main file says that it is.

use super::{
    SceneStandIn, StandIn,
    bundle::inside,
    clipped::Clipped,
    dmesh::{self, DmeshError, DmeshStandIn, Meshes, Model},
    mix::{self, MixStandIn},
    octahedral::{self, OctahedralError, OctahedralStandIn},
    ori::{self, OriError, OriStandIn, TreeStandIn},
    sprite::SpriteStandIn,
};
use crate::{
    formats::{self, Files, FormatError, Limits},
    raster::Geometry,
    scene::Scene,
    sprite::{ReadError, SPRITE_FORMAT, Volume},
};
use serde_json::Value;
use std::path::Path;

/// A stand-in that was read.
pub enum Opened {
    /// An ordinary mesh file.
    Scene(Box<(Scene, Geometry)>),
    /// Depth-meshes, and the hierarchies of those that can be made for a view.
    Dmesh(Box<OpenedDmesh>),
    /// A relief impostor.
    Ori(Box<OriStandIn>),
    /// Relief impostors of the parts of an object.
    OriTree(Box<TreeStandIn>),
    /// An octahedral impostor.
    Octahedral(Box<OctahedralStandIn>),
    /// A depth sprite.
    Sprite(Box<SpriteStandIn>),
    /// A mesh of which depth sprites hide what lies inside them.
    Clipped(Box<OpenedClipped>),
    /// Several stand-ins that are drawn together.
    Mix(Vec<Opened>),
}

/// A mesh and what clips it.
pub struct OpenedClipped {
    mesh: Opened,
    volumes: Vec<Volume>,
    /// Of the sprites.
    bytes: u64,
}

/// Depth-meshes, ready to be drawn.
pub struct OpenedDmesh {
    fixed: DmeshStandIn,
    per_view: Option<DmeshStandIn>,
}

/// Why a bundle is no stand-in.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    #[error(transparent)]
    Format(#[from] FormatError),
    #[error(transparent)]
    Dmesh(#[from] DmeshError),
    #[error(transparent)]
    Ori(#[from] OriError),
    #[error(transparent)]
    Octahedral(#[from] OctahedralError),
    #[error(transparent)]
    Sprite(#[from] ReadError),
    #[error("{file}: {what}")]
    Unknown { file: String, what: String },
}

/// Opens the stand-in whose main file is `main`: a GLB file, or a JSON manifest whose `format` says what it is.
///
/// # Errors
/// Where a file is missing, damaged, or of a format that is not known.
pub fn open(main: &Path, files: &(dyn Files + Sync), limits: &Limits) -> Result<Opened, OpenError> {
    open_within(main, files, limits, MIXES)
}

/// Mixes of mixes, at most.
const MIXES: u32 = 8;

fn open_within(main: &Path, files: &(dyn Files + Sync), limits: &Limits, mixes: u32) -> Result<Opened, OpenError> {
    let bytes = files.read(main)?.ok_or_else(|| FormatError::Missing { file: main.to_owned() })?;
    let data: &[u8] = (*bytes).as_ref();
    if data.starts_with(b"glTF") {
        let scene = formats::from_glb(main, bytes.clone(), limits)?;
        let geometry = Geometry::new(&scene);
        return Ok(Opened::Scene(Box::new((scene, geometry))));
    }
    let unknown = |what: String| OpenError::Unknown { file: main.display().to_string(), what };
    let manifest: Value = serde_json::from_slice(data)
        .map_err(|e| unknown(format!("expected a GLB file or a JSON manifest of a stand-in ({e})")))?;
    let folder = main.parent().unwrap_or(Path::new(""));
    match manifest.get("format").and_then(Value::as_str) {
        Some(dmesh::FORMAT) => {
            let bundle = dmesh::read(folder, files, limits)?;
            let frames = bundle.frames.as_ref();
            let meshes = frames.map(|f| Meshes::new(&bundle.dmesh, f)).transpose()?;
            let fixed = DmeshStandIn::fixed(Model::new(bundle.dmesh.clone())?, bundle.blending, frames);
            let per_view = meshes.map(|meshes| fixed.per_view(meshes));
            Ok(Opened::Dmesh(Box::new(OpenedDmesh { fixed, per_view })))
        }
        Some(ori::FORMAT) => {
            let bundle = ori::read(folder, files)?;
            Ok(Opened::Ori(Box::new(OriStandIn::new(ori::Model::new(bundle.ori)?, &bundle.textures))))
        }
        Some(ori::TREE_FORMAT) => Ok(Opened::OriTree(Box::new(TreeStandIn::read(folder, files, limits)?))),
        Some(octahedral::FORMAT) => {
            let bundle = octahedral::read(folder, files, limits)?;
            let model = octahedral::Model::new(bundle.impostor, bundle.drawing)?;
            Ok(Opened::Octahedral(Box::new(OctahedralStandIn::new(model))))
        }
        Some(SPRITE_FORMAT) => Ok(Opened::Sprite(Box::new(SpriteStandIn::read(main, &manifest, files)?))),
        Some(mix::FORMAT) if mixes == 0 => Err(unknown(format!("it is a mix below {MIXES} others"))),
        Some(mix::FORMAT) => {
            let part = |part: mix::Part| {
                let main = inside(folder, &part.main).map_err(unknown)?;
                let opened = open_within(&main, files, limits, mixes - 1)?;
                if part.clipped_by.is_empty() {
                    return Ok(opened);
                }
                if !matches!(opened, Opened::Scene(_)) {
                    let what = "a sprite clips meshes, and it is none";
                    return Err(unknown(format!("part `{}`: `clipped_by`: {what}", part.name)));
                }
                let mut clipped = OpenedClipped { mesh: opened, volumes: Vec::new(), bytes: 0 };
                for sprite in &part.clipped_by {
                    let main = inside(folder, sprite).map_err(unknown)?;
                    let Opened::Sprite(sprite) = open_within(&main, files, limits, mixes - 1)? else {
                        return Err(unknown(format!(
                            "part `{}`: `clipped_by`: `{sprite}` is no depth sprite",
                            part.name
                        )));
                    };
                    clipped.bytes += sprite.size().memory_bytes;
                    clipped.volumes.push(sprite.into_volume());
                }
                Ok(Opened::Clipped(Box::new(clipped)))
            };
            let parts = mix::Manifest::read(main, data)?.parts;
            Ok(Opened::Mix(parts.into_iter().map(part).collect::<Result<_, _>>()?))
        }
        Some(other) => Err(unknown(format!(
            "the format `{other}` is not known; expected `{}`, `{}`, `{}`, `{}`, `{}` or `{SPRITE_FORMAT}`",
            dmesh::FORMAT,
            mix::FORMAT,
            octahedral::FORMAT,
            ori::FORMAT,
            ori::TREE_FORMAT
        ))),
        None => Err(unknown("expected a member `format` that says what the stand-in is".into())),
    }
}

impl Opened {
    /// The ways in which it can be drawn, the usual one first. Names are empty where there is only one way.
    pub fn modes(&self) -> Vec<(&'static str, Box<dyn StandIn + '_>)> {
        match self {
            Self::Scene(scene) => vec![("", Box::new(SceneStandIn::new(&scene.0, &scene.1)))],
            Self::OriTree(tree) => vec![("", Box::new(&**tree))],
            Self::Ori(ori) => vec![("", Box::new(&**ori))],
            Self::Octahedral(impostor) => vec![("", Box::new(&**impostor))],
            Self::Sprite(sprite) => vec![("", Box::new(&**sprite))],
            Self::Clipped(clipped) => {
                let OpenedClipped { mesh, volumes, bytes } = &**clipped;
                let clip = |(name, stand_in)| -> (&'static str, Box<dyn StandIn + '_>) {
                    (name, Box::new(Clipped { stand_in, volumes, bytes: *bytes }))
                };
                mesh.modes().into_iter().map(clip).collect()
            }
            Self::Mix(parts) => {
                // Each as it is usually drawn.
                let usual = parts.iter().filter_map(|part| part.modes().into_iter().next());
                vec![("", Box::new(MixStandIn { parts: usual.map(|mode| mode.1).collect() }))]
            }
            Self::Dmesh(dmesh) => {
                let mut modes: Vec<(&'static str, Box<dyn StandIn + '_>)> = vec![("static", Box::new(&dmesh.fixed))];
                if let Some(per_view) = &dmesh.per_view {
                    modes.push(("view_dependent", Box::new(per_view)));
                }
                modes
            }
        }
    }
}
