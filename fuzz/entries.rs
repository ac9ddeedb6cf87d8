//! What is fuzzed. Each function takes any bytes; that it returns is what must hold. The targets of cargo-fuzz call them, and `tests/torture/fuzz.rs` calls
//! them with changed seeds, so that a short form runs with every test on the stable compiler.

use farfield::{
    array::Bytes,
    cli,
    engine::{
        artifact::from_bytes,
        cache,
        hash::Digest,
        node::TypeInfo,
        pipeline::{Request, load_text},
        record::{BakeRecord, MapRecord, RunRecord},
    },
    formats::{Files, FormatError, Limits, load},
    math::Stop,
    nodes,
    nodes::values::Sprite,
    raster::{Cpu, Rendering},
    runtime::{Context, hybrid_lod, open},
    sprite::{Placement, Ray, Volume},
    texture::{TextureArray, dds, ktx2},
    view::View,
};
use glam::DVec3;
use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    sync::{Arc, LazyLock},
};

/// Bounds that make a large allocation a finding.
fn limits() -> Limits {
    Limits {
        texels: 1 << 16,
        bytes: 1 << 22,
        vertices: 1 << 16,
        triangles: 1 << 16,
        objects: 1 << 10,
        implied: 1 << 8,
        ..Limits::default()
    }
}

/// Files in memory.
struct Memory(BTreeMap<PathBuf, Bytes>);

impl Files for Memory {
    fn read(&self, path: &Path) -> Result<Option<Bytes>, FormatError> {
        Ok(self.0.get(path).cloned())
    }

    fn real(&self, _: &Path) -> Option<PathBuf> {
        None
    }
}

/// What a scene file may place or name.
const PARTS: [(&str, &str); 2] = [
    ("part.obj", "mtllib part.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n"),
    ("part.mtl", "newmtl m\nKd 1 0.5 0\nd 0.5\n"),
];

/// A scene file of the given name, beside `part.obj` and `part.mtl`. Gives whether it was read.
pub fn scene(name: &str, data: &[u8]) -> bool {
    let parts = PARTS.map(|(name, text)| (PathBuf::from(name), Arc::new(text.as_bytes().to_vec()) as Bytes));
    let mut files = Memory(BTreeMap::from(parts));
    files.0.insert(PathBuf::from(name), Arc::new(data.to_vec()));
    load(Path::new(name), &files, &limits()).is_ok()
}

/// A pipeline file; what follows a line `--set` is given as `--set`, line by line.
pub fn pipeline(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let (text, set) = text.split_once("\n--set\n").unwrap_or((text, ""));
    let set: Vec<String> = set.lines().take(8).map(str::to_owned).collect();
    let request = Request { set: &set, ..Request::new("fuzz.toml", Path::new("/"), cli::stock::STOCK) };
    static REGISTRY: LazyLock<farfield::engine::registry::Registry> = LazyLock::new(nodes::registry);
    if let Err(problems) = load_text("fuzz.toml", text, &request, &REGISTRY) {
        assert!(!problems.list.is_empty() && !problems.to_string().is_empty());
    }
}

/// Every type that flows on an edge, by name.
pub static TYPES: LazyLock<BTreeMap<&'static str, TypeInfo>> = LazyLock::new(|| {
    let registry = nodes::registry();
    let ports = registry.iter().flat_map(|kind| kind.spec().inputs.iter().chain(&kind.spec().outputs));
    ports.map(|port| (port.ty.name, port.ty)).collect()
});

/// The name of the type that an artifact says it is of.
pub fn type_name(data: &[u8]) -> Option<&str> {
    let length = u32::from_le_bytes(data.get(12..16)?.try_into().ok()?) as usize;
    std::str::from_utf8(data.get(16..)?.get(..length)?).ok()
}

/// An artifact of any type. What was read can be stored, and read again.
pub fn artifact(data: &[u8]) {
    let Some(ty) = type_name(data).and_then(|name| TYPES.get(name)) else { return };
    let bytes: Bytes = Arc::new(data.to_vec());
    let Ok(value) = (ty.decode)(bytes.clone()) else { return };
    let stored = (ty.encode)(&value);
    let again = (ty.decode)(Arc::new(stored.clone())).unwrap_or_else(|e| panic!("{}: {e}", ty.name));
    assert!((ty.encode)(&again) == stored, "{}: it is stored otherwise the second time", ty.name);
    if ty.name == "Sprite" {
        sprite(bytes);
    }
}

/// A sprite that was read can be asked.
fn sprite(bytes: Bytes) {
    let Ok(Sprite { packed, frame }) = from_bytes::<Sprite>(bytes) else { return };
    let volume = Volume::new(packed.unpack(), &frame, &Placement::default());
    let ray = Ray { origin: volume.bounds().min, direction: DVec3::new(0.3, 0.5, 0.7) };
    for span in volume.spans(&ray) {
        volume.normal(&ray, &span.enter);
    }
    packed.contains([0.5, 0.5, 0.5]);
    packed.file();
}

/// Files as [`bundle`] takes them. The first is the main one.
pub fn packed(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut out = Vec::new();
    for (name, bytes) in files {
        out.push(name.len() as u8);
        out.extend(name.as_bytes());
        out.extend((bytes.len() as u32).to_le_bytes());
        out.extend(*bytes);
    }
    out
}

/// A published stand-in: any files. Lengths beyond the end count as up to the end, so that cuts and insertions still give files.
pub fn bundle(data: &[u8]) {
    let (mut rest, mut files, mut main) = (data, BTreeMap::new(), None);
    while let Some((length, after)) = rest.split_first() {
        let (name, after) = after.split_at(usize::from(*length).min(after.len()));
        let (size, after) = after.split_at(4.min(after.len()));
        let size = size.try_into().map_or(usize::MAX, |s| u32::from_le_bytes(s) as usize);
        let (bytes, after) = after.split_at(size.min(after.len()));
        let path = Path::new("b").join(&*String::from_utf8_lossy(name));
        main.get_or_insert_with(|| path.clone());
        files.insert(path, Arc::new(bytes.to_vec()) as Bytes);
        rest = after;
    }
    let Some(main) = main else { return };
    if let Some(bytes) = files.get(&main) {
        let _ = hybrid_lod::Manifest::read((**bytes).as_ref());
    }
    let Ok(opened) = open(&main, &Memory(files), &limits()) else { return };
    let view = View::look_at(DVec3::new(9.0, 7.0, 5.0), DVec3::ZERO, DVec3::Y, 1.0, 8, 8, 0.1, 100.0);
    let (how, stop) = (Rendering { samples_per_axis: 1, shades_per_axis: 1, ..Rendering::default() }, Stop::default());
    for (_, stand_in) in opened.modes() {
        stand_in.bounds();
        stand_in.size();
        let shot = stand_in.draw(&view, &how, Context { backend: &Cpu, stop: &stop });
        assert_eq!(shot.map(|s| s.depth.len()).ok(), Some(64));
    }
}

/// A texture file. What was read can be decoded, written and read again.
pub fn texture(data: &[u8]) {
    let check = |array: &TextureArray, again: Option<TextureArray>| {
        assert_eq!(again.as_ref(), Some(array));
        for level in 0..array.levels.len() as u32 {
            assert!(array.decode(level, array.layers - 1).is_some());
        }
    };
    if let Ok(array) = ktx2::read(data) {
        check(&array, ktx2::write(&array).ok().and_then(|bytes| ktx2::read(&bytes).ok()));
    }
    if let Ok(array) = dds::read(data) {
        check(&array, dds::write(&array).ok().and_then(|bytes| dds::read(&bytes).ok()));
    }
}

/// The bytes of a record with the checksum that belongs to them, so that changed ones are read beyond it.
fn sealed(body: &[u8], place: &[&[u8]]) -> Vec<u8> {
    let mut all = Vec::new();
    for part in place.iter().chain(&[body]) {
        all.extend((part.len() as u64).to_le_bytes());
        all.extend(*part);
    }
    [body, &Digest::of(&all).0[..16]].concat()
}

/// The body of a record of the index. What was read is written as it was.
pub fn record(data: &[u8]) {
    let (key, zero) = (Digest([1; 32]), Digest::default());
    let run = sealed(data, &[b"run", &key.0, &zero.0]);
    if let Some(run) = RunRecord::from_bytes(&run, &key, &zero) {
        let bytes = run.to_bytes(&key);
        assert!(RunRecord::from_bytes(&bytes, &key, &run.variant()).is_some());
    }
    let _ = MapRecord::from_bytes(&sealed(data, &[b"map", &key.0]), &key);
    let bake = sealed(data, &[b"bake", &1i64.to_le_bytes(), b"p", b"f"]);
    if let Some(bake) = BakeRecord::from_bytes(&bake, 1, "p", "f") {
        assert!(BakeRecord::from_bytes(&bake.to_bytes(1, "p", "f"), 1, "p", "f").is_some());
    }
}

/// Any file as the index of the cache in `folder`. Whatever it is, two checks later nothing is wrong, and it can be built anew.
pub fn index(folder: &Path, data: &[u8]) {
    let stop = Stop::default();
    let clear = || {
        let _ = fs::remove_dir_all(folder);
        cache::Cache::open(folder, true).expect("a cache in an empty folder");
        for suffix in ["-wal", "-shm"] {
            let _ = fs::remove_file(folder.join(format!("{INDEX}{suffix}")));
        }
        fs::write(folder.join(INDEX), data).expect("the folder can be written");
    };
    clear();
    let _ = cache::stats(folder);
    let _ = cache::verify(folder, &stop).expect("damage is no error");
    let _ = cache::verify(folder, &stop).expect("damage is no error");
    assert!(cache::verify(folder, &stop).expect("no error").is_none_or(|found| found.is_clean()));
    clear();
    cache::rebuild(folder, &stop).expect("an index can be built anew from any");
    assert!(cache::verify(folder, &stop).expect("no error").is_some_and(|found| found.is_clean()));
}

/// The name of the index file.
pub const INDEX: &str = "index-4.sqlite";
