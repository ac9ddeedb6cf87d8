//! One reading of a scene: which folder it may see, what it has used of its limits, which images it already has.

use super::{Files, FormatError, Limits, files, gltf, obj, picture, ply, scene_toml};
use crate::{
    array::Bytes,
    math::Stop,
    scene::{Image, Object},
};
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Arc,
};

/// What [`Limits::bytes`] bounds.
pub const DECODING: &str = "bytes to decode all images";

/// State shared by the readers of all files of one scene.
pub(super) struct Loader<'a> {
    files: &'a dyn Files,
    pub limits: &'a Limits,
    pub stop: &'a Stop,
    warn: &'a mut dyn FnMut(String),
    /// The outermost file, and its folder.
    root: PathBuf,
    folder: PathBuf,
    texels: u64,
    /// Bytes of the decoded images that are kept.
    image_bytes: u64,
    vertices: u64,
    triangles: u64,
    objects: u64,
    images: BTreeMap<[u8; 32], Arc<Image>>,
    loaded: BTreeMap<PathBuf, Vec<Object>>,
    /// Scene files being read, the outermost first.
    open: Vec<PathBuf>,
    /// What is said of many places: by file and text, the first place and how many more.
    notes: Vec<Note>,
}

struct Note {
    file: PathBuf,
    what: String,
    place: String,
    more: usize,
}

/// An encoded image and what to call it.
pub(super) struct Picture {
    pub name: String,
    /// Where the file names it.
    pub place: String,
    pub bytes: Bytes,
    pub range: std::ops::Range<usize>,
}

impl<'a> Loader<'a> {
    pub fn new(
        path: &Path,
        files: &'a dyn Files,
        limits: &'a Limits,
        stop: &'a Stop,
        warn: &'a mut dyn FnMut(String),
    ) -> Self {
        let folder = path.parent().map(Path::to_owned).unwrap_or_default();
        let (images, loaded) = Default::default();
        let (open, notes) = Default::default();
        Self {
            files,
            limits,
            stop,
            warn,
            root: path.to_owned(),
            folder,
            texels: 0,
            image_bytes: 0,
            vertices: 0,
            triangles: 0,
            objects: 0,
            images,
            loaded,
            open,
            notes,
        }
    }

    pub fn warn(&mut self, file: &Path, what: impl std::fmt::Display) {
        (self.warn)(format!("{}: {what}", file.display()));
    }

    /// A warning about one of many places, such as `materials[3]`. Of equal ones the first is told, with how many more there are.
    pub fn note(&mut self, file: &Path, place: &str, what: &str) {
        match self.notes.iter_mut().find(|n| n.what == what && n.file == file) {
            Some(note) => note.more += 1,
            None => {
                let (file, what, place) = (file.to_owned(), what.to_owned(), place.to_owned());
                self.notes.push(Note { file, what, place, more: 0 });
            }
        }
    }

    /// Tells what was noted.
    pub fn tell(&mut self) {
        for Note { file, what, place, more } in std::mem::take(&mut self.notes) {
            let more = if more > 0 { format!("; {more} more like it") } else { String::new() };
            self.warn(&file, format_args!("{place}: {what}{more}"));
        }
    }

    /// The objects of the file at `path`; a file that is placed twice is read once.
    pub fn objects(&mut self, path: &Path) -> Result<Vec<Object>, FormatError> {
        self.stop.check()?;
        if let Some(objects) = self.loaded.get(path) {
            return Ok(objects.clone());
        }
        if self.open.iter().any(|p| p == path) {
            return Err(FormatError::invalid(path, "scene file", "includes itself"));
        }
        let bytes = self.read(path)?;
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
        self.open.push(path.to_owned());
        let objects = match extension.as_str() {
            "glb" | "gltf" => gltf::read(self, path, bytes),
            "obj" => obj::read(self, path, bytes),
            "toml" => scene_toml::read(self, path, bytes),
            "ply" => ply::read(self, path, bytes),
            _ => Err(FormatError::Kind { file: path.to_owned() }),
        };
        self.open.pop();
        let objects = objects?;
        self.loaded.insert(path.to_owned(), objects.clone());
        Ok(objects)
    }

    /// How many files are being read: the outermost one and those that it includes.
    pub fn includes(&self) -> usize {
        self.open.len()
    }

    pub fn read(&self, path: &Path) -> Result<Bytes, FormatError> {
        self.find(path)?.ok_or_else(|| FormatError::Missing { file: path.to_owned() })
    }

    /// The bytes of the file at `path`, if there is one.
    pub fn find(&self, path: &Path) -> Result<Option<Bytes>, FormatError> {
        self.stays_inside(path)?;
        self.files.read(path)
    }

    /// Fails where `path` passes a symbolic link that leads out of the scene's folder. The outermost file is named by
    /// the user and may lie anywhere.
    fn stays_inside(&self, path: &Path) -> Result<(), FormatError> {
        if self.limits.allow_outside || path == self.root {
            return Ok(());
        }
        let here = if self.folder.as_os_str().is_empty() { Path::new(".") } else { &self.folder };
        let (Some(to), Some(folder)) = (self.files.real(path), self.files.real(here)) else { return Ok(()) };
        if to.starts_with(&folder) {
            return Ok(());
        }
        Err(FormatError::Link { file: path.to_owned(), to, folder: self.folder.clone() })
    }

    /// The path of the file that `file` calls `target`, relative to its own folder.
    pub fn resolve(&self, file: &Path, target: &str) -> Result<PathBuf, FormatError> {
        let own = file.parent().unwrap_or(Path::new(""));
        let joined = own.join(target);
        if self.limits.allow_outside {
            return Ok(files::normal(&joined).unwrap_or(joined));
        }
        let folder = files::normal(&self.folder).unwrap_or_else(|| self.folder.clone());
        match files::normal(&joined) {
            Some(path) if path.starts_with(&folder) => Ok(path),
            _ => Err(FormatError::Outside { file: file.to_owned(), target: target.to_owned(), folder }),
        }
    }

    /// Counts vertices about to be read.
    pub fn count_vertices(&mut self, file: &Path, place: &str, count: u64) -> Result<(), FormatError> {
        let limit = self.limits.vertices;
        Self::count(&mut self.vertices, count, limit, "vertices", file, place)
    }

    /// Counts an object of so many triangles about to be made.
    pub fn count_object(&mut self, file: &Path, place: &str, triangles: u64) -> Result<(), FormatError> {
        let (objects, limit) = (self.limits.objects, self.limits.triangles);
        Self::count(&mut self.objects, 1, objects, "objects", file, place)?;
        Self::count(&mut self.triangles, triangles, limit, "triangles", file, place)
    }

    fn count(
        used: &mut u64,
        count: u64,
        limit: u64,
        what: &'static str,
        file: &Path,
        place: &str,
    ) -> Result<(), FormatError> {
        *used = used.saturating_add(count);
        if *used <= limit {
            return Ok(());
        }
        Err(FormatError::Limit { file: file.to_owned(), place: place.to_owned(), what, found: *used, limit })
    }

    /// Decodes images, in parallel; the same bytes give the same `Arc`. As many are decoded at once as fit the limit of bytes.
    pub fn pictures(&mut self, file: &Path, pictures: &[Picture]) -> Result<Vec<Arc<Image>>, FormatError> {
        let hash = |p: &Picture| *blake3::hash(p.encoded()).as_bytes();
        let hashes: Vec<_> = pictures.iter().map(hash).collect();
        let mut new = BTreeMap::new();
        for (p, h) in pictures.iter().zip(&hashes) {
            if self.images.contains_key(h) || new.contains_key(h) {
                continue;
            }
            let claim = picture::claim(p.encoded()).map_err(|e| p.fault(file, e))?;
            let place = format!("{}, {} × {}", p.place, claim.width, claim.height);
            let limit = self.limits.texels;
            Self::count(&mut self.texels, claim.texels(), limit, "texels in all images", file, &place)?;
            let (kept, limit) = (self.image_bytes, self.limits.bytes);
            let found = kept.saturating_add(claim.bytes);
            if found > limit {
                let file = file.to_owned();
                return Err(FormatError::Limit { file, place, what: DECODING, found, limit });
            }
            self.image_bytes += claim.texels() * 4;
            new.insert(*h, (p, claim));
        }
        let mut rest: Vec<_> = new.into_iter().collect();
        // What is kept of all, and beside it what decoding takes of those in work.
        let spare = self.limits.bytes - self.image_bytes.min(self.limits.bytes);
        while !rest.is_empty() {
            let mut taken = 0u64;
            let fits = |(_, (_, claim)): &&(_, (&Picture, picture::Claim))| {
                taken = taken.saturating_add(claim.bytes - claim.texels() * 4);
                taken <= spare
            };
            let n = rest.iter().take_while(fits).count().max(1);
            use rayon::prelude::*;
            let decoded = rest.par_drain(..n).map(|(h, (p, _))| {
                self.stop.check()?;
                let image = picture::decode(p.encoded(), &p.name, self.limits.bytes).map_err(|e| p.fault(file, e))?;
                Ok((h, Arc::new(image)))
            });
            let decoded = decoded.collect::<Result<Vec<_>, FormatError>>()?;
            self.images.extend(decoded);
        }
        Ok(hashes.iter().map(|h| self.images[h].clone()).collect())
    }
}

impl Picture {
    fn encoded(&self) -> &[u8] {
        &(*self.bytes).as_ref()[self.range.clone()]
    }

    fn fault(&self, file: &Path, what: String) -> FormatError {
        FormatError::invalid(file, &self.place, what)
    }
}
