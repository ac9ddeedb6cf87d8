//! `manifest.json`: what was published, of what, and with which settings. Which files below an output folder are ours
//! to replace and to delete is what it says, and what the list of a publication under way says.

use super::{Wanted, guard::identity};
use crate::engine::plan::Plan;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::{collections::BTreeMap, fs, io, path::Path};

pub const MANIFEST: &str = "manifest.json";

/// The list of a publication under way, in the form of a manifest: a killed bake's files are known by it.
pub const PENDING: &str = ".farfield-pending.json";

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Manifest {
    pub pipeline: String,
    /// The scenes and other files that the pipeline was given, each with its folder's name.
    #[serde(default)]
    pub sources: Vec<String>,
    /// The knobs' values.
    #[serde(default)]
    pub params: Map<String, Value>,
    /// By path.
    pub files: BTreeMap<String, Entry>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Entry {
    pub blake3: String,
    pub bytes: u64,
}

impl Manifest {
    pub fn new(plan: &Plan, wanted: &[Wanted]) -> Self {
        let entry = |w: &Wanted| (w.path.clone(), Entry { blake3: w.file.hex(), bytes: w.size });
        Self {
            pipeline: plan.name.clone(),
            sources: plan.sources.clone(),
            params: plan.knobs.clone(),
            files: wanted.iter().map(entry).collect(),
        }
    }

    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = serde_json::to_vec_pretty(self).unwrap_or_default();
        out.push(b'\n');
        out
    }
}

/// What lies at a manifest's place.
#[derive(Debug, Default)]
pub enum Found {
    #[default]
    Nothing,
    Ours(Manifest),
    /// Something that is no manifest of ours.
    Foreign,
    Unreadable(io::Error),
}

impl Found {
    pub fn read(path: &Path) -> Self {
        match fs::symlink_metadata(path) {
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Self::Nothing,
            Err(e) => return Self::Unreadable(e),
            Ok(meta) if !meta.is_file() => return Self::Foreign,
            Ok(_) => {}
        }
        match fs::read(path) {
            Ok(bytes) => serde_json::from_slice(&bytes).map_or(Self::Foreign, Self::Ours),
            Err(e) => Self::Unreadable(e),
        }
    }

    pub fn ours(self) -> Option<Manifest> {
        match self {
            Self::Ours(manifest) => Some(manifest),
            _ => None,
        }
    }
}

/// What of a folder is ours.
#[derive(Debug)]
pub struct Ours {
    pub manifest: Found,
    pub pending: Option<Manifest>,
}

impl Ours {
    pub fn read(folder: &Path) -> Self {
        // In this order: a publication under way removes its list when the manifest is there.
        let pending = Found::read(&folder.join(PENDING)).ours();
        let manifest = Found::read(&folder.join(MANIFEST));
        Self { manifest, pending }
    }

    /// The manifest, and the list of a publication that did not come to its end.
    pub fn lists(&self) -> impl Iterator<Item = &Manifest> {
        let manifest = if let Found::Ours(manifest) = &self.manifest { Some(manifest) } else { None };
        manifest.into_iter().chain(&self.pending)
    }

    /// Whether a list of ours names `path`, in this spelling or, where the system takes both for one file, in another.
    pub fn names(&self, folder: &Path, path: &str) -> bool {
        if self.lists().any(|m| m.files.contains_key(path)) {
            return true;
        }
        let low = path.to_lowercase();
        let id = |path: &str| identity(&fs::symlink_metadata(folder.join(path)).ok()?);
        let same = |other: &String| other.to_lowercase() == low && (!cfg!(unix) || id(other) == id(path));
        self.lists().flat_map(|m| m.files.keys()).any(same)
    }
}
