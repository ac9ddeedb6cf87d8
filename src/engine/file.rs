//! What leaves the engine: files, and bundles of them.

use super::{
    artifact::{Artifact, DecodeError, Decoder, Encoder},
    publish::names,
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Bytes that leave the engine as a file. `[files]` publishes values of this type.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct File {
    /// Such as `model/gltf-binary`.
    pub media_type: String,
    pub bytes: Vec<u8>,
}

impl Artifact for File {
    const TYPE: &'static str = "File";
    const FORMAT: u32 = 1;
    fn encode(&self, out: &mut Encoder) {
        out.json("media_type", &self.media_type);
        out.bytes("bytes", self.bytes.clone());
    }
    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        Ok(Self { media_type: data.json("media_type")?, bytes: data.bytes("bytes")?.to_vec() })
    }
}

/// A stand-in as files, with paths below a folder of its own. `[files]` publishes it by `"folder/" = "node.bundle"`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bundle {
    main: String,
    files: BTreeMap<String, File>,
}

impl Bundle {
    /// `main` is the path of the file that programs open first. The error says which path cannot be published.
    pub fn new(main: impl Into<String>, files: BTreeMap<String, File>) -> Result<Self, String> {
        let main = main.into();
        if !files.contains_key(&main) {
            return Err(format!("a bundle without its main file `{main}`"));
        }
        if let Some((path, what)) = files.keys().find_map(|p| Some((p, names::bad_path(p)?))) {
            return Err(format!("the path `{path}` in a bundle: {what}"));
        }
        match names::collision(files.keys().map(String::as_str)) {
            Some((a, b)) => Err(format!("`{a}` and `{b}` in one bundle collide")),
            None => Ok(Self { main, files }),
        }
    }

    /// The path of the file that programs open first.
    pub fn main(&self) -> &str {
        &self.main
    }

    /// By path, with `/`.
    pub fn files(&self) -> &BTreeMap<String, File> {
        &self.files
    }

    /// Bytes of all files together.
    pub fn size(&self) -> u64 {
        self.files.values().map(|f| f.bytes.len() as u64).sum()
    }
}

#[derive(Serialize, Deserialize)]
struct Index {
    main: String,
    /// Path and media type.
    files: Vec<(String, String)>,
}

impl Artifact for Bundle {
    const TYPE: &'static str = "Bundle";
    const FORMAT: u32 = 1;

    fn encode(&self, out: &mut Encoder) {
        let files = self.files.iter().map(|(path, file)| (path.clone(), file.media_type.clone())).collect();
        out.json("index", &Index { main: self.main.clone(), files });
        for (i, file) in self.files.values().enumerate() {
            out.bytes(format!("file {i}"), file.bytes.clone());
        }
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        let index: Index = data.json("index")?;
        let mut files = BTreeMap::new();
        for (i, (path, media_type)) in index.files.into_iter().enumerate() {
            files.insert(path, File { media_type, bytes: data.bytes(&format!("file {i}"))?.to_vec() });
        }
        Self::new(index.main, files).map_err(|what| DecodeError::section("index", what))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::artifact::{from_bytes, to_bytes};
    use std::sync::Arc;

    fn files(paths: &[&str]) -> BTreeMap<String, File> {
        let file = |p: &&str| ((*p).to_owned(), File { media_type: "text/plain".into(), bytes: p.as_bytes().to_vec() });
        paths.iter().map(file).collect()
    }

    #[test]
    fn a_bundle_is_stored_whole() {
        let bundle = Bundle::new("a.json", files(&["a.json", "meshes/x.glb", "meshes/y.glb"])).unwrap();
        assert_eq!(bundle.size(), 6 + 12 + 12);
        assert_eq!(from_bytes::<Bundle>(Arc::new(to_bytes(&bundle))), Ok(bundle));
    }

    #[test]
    fn paths_that_cannot_be_published_are_refused() {
        for (main, paths, what) in [
            ("b", &["a"][..], "main file `b`"),
            ("a", &["a", "../x"], "leads out"),
            ("a", &["a", "A"], "collide"),
            ("a", &["a", "a/b"], "collide"),
            ("run.json", &["run.json"], "written by farfield"),
        ] {
            assert!(Bundle::new(main, files(paths)).unwrap_err().contains(what), "{main} {paths:?}");
        }
    }
}
