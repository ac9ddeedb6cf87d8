//! The fuzz targets in short: sound inputs, changed at random, go through the functions that cargo-fuzz calls (`fuzz/entries.rs`). What is drawn follows from a
//! seed, so a failure comes again. `FARFIELD_SEEDS=folder cargo test --test torture seeds` writes the sound inputs as corpora for cargo-fuzz.

#[path = "../../fuzz/entries.rs"]
mod entries;

use super::{Bench, cases, ok, plan as small_plan};
use farfield::{
    engine::{
        artifact::from_bytes,
        bake::{Options, Outcome, bake},
        cache::blob::Blobs,
        events::Silent,
        file::Bundle,
        hash::Digest,
        pipeline::{Request, load_text},
    },
    math::Stop,
    nodes,
};
use std::{
    collections::BTreeMap,
    fs,
    panic::{AssertUnwindSafe, catch_unwind},
    path::{Path, PathBuf},
    sync::{Arc, LazyLock},
    time::{Duration, Instant},
};

/// Larger seeds are left out: what is changed in them lies mostly in pixels.
const LARGEST: usize = 64 << 10;
/// No input of a few kilobytes takes so long.
const SLOW: Duration = Duration::from_secs(20);

/// Random numbers that are the same everywhere (splitmix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }
}

/// Numbers at which readers break.
const NUMBERS: [u64; 12] =
    [0, 1, 2, 0x7f, 0xff, 0x7fff, 0xffff, 0x7fff_ffff, 0xffff_ffff, 1 << 40, i64::MAX as u64, u64::MAX];
/// Texts at which parsers break.
const TEXTS: [&str; 12] =
    ["0", "-1", "1e999", "4294967296", "null", "[]", "{}", "\"\"", "0.0", "-0.5", "1e-300", "18446744073709551615"];

/// Changes `data` in one to six places.
fn change(data: &mut Vec<u8>, others: &[Vec<u8>], random: &mut Random) {
    for _ in 0..1 + random.below(6) {
        let at = random.below(data.len());
        let length = 1 + random.below(32);
        let end = (at + length).min(data.len());
        match random.below(9) {
            _ if data.is_empty() => data.push(random.next() as u8),
            0 => data[at] ^= 1 << random.below(8),
            1 => data[at] = random.next() as u8,
            2 => drop(data.drain(at..end)),
            3 => {
                let part = data[at..end].to_vec();
                let to = random.below(data.len());
                data.splice(to..to, part);
            }
            4 => {
                let number = NUMBERS[random.below(NUMBERS.len())].to_le_bytes();
                let size = [1, 2, 4, 8][random.below(4)].min(data.len() - at);
                data[at..at + size].copy_from_slice(&number[..size]);
            }
            5 => {
                // A number in a text, as a whole.
                let is_digit = |b: &u8| b.is_ascii_digit() || b".-eE".contains(b);
                let Some(start) = data[at..].iter().position(u8::is_ascii_digit).map(|i| at + i) else { continue };
                let end = data[start..].iter().position(|b| !is_digit(b)).map_or(data.len(), |i| start + i);
                data.splice(start..end, TEXTS[random.below(TEXTS.len())].bytes());
            }
            6 => data.truncate(at),
            7 => {
                let other = &others[random.below(others.len())];
                let from = random.below(other.len());
                let part = &other[from..(from + length * 4).min(other.len())];
                data.splice(at..end, part.iter().copied());
            }
            _ => {
                let lines: Vec<&[u8]> = data.split(|b| *b == b'\n').collect();
                let line = [lines[random.below(lines.len())], b"\n"].concat();
                data.splice(at..at, line);
            }
        }
    }
}

/// Hands changed seeds to `entry`: `short` of them, or as many as the long form wants.
fn run(name: &str, seeds: &[Vec<u8>], short: usize, entry: impl Fn(&[u8])) {
    assert!(!seeds.is_empty(), "{name}: no seeds");
    let mut random = Random(name.len() as u64);
    let count = cases(short, short * 1000);
    let mut slowest = Duration::ZERO;
    for i in 0..seeds.len() + count {
        // Each seed itself comes first.
        let mut data = seeds.get(i).unwrap_or_else(|| &seeds[random.below(seeds.len())]).clone();
        if i >= seeds.len() {
            change(&mut data, seeds, &mut random);
        }
        let began = Instant::now();
        let done = catch_unwind(AssertUnwindSafe(|| entry(&data)));
        slowest = slowest.max(began.elapsed());
        if done.is_err() || began.elapsed() > SLOW {
            let path = std::env::temp_dir().join(format!("farfield-fuzz-{name}"));
            fs::write(&path, &data).unwrap();
            panic!("{name}: input {i}, {:?}, written to {}", began.elapsed(), path.display());
        }
    }
    println!("{name}: {count} inputs from {} seeds, the slowest took {slowest:?}", seeds.len());
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn pipelines() -> Vec<Vec<u8>> {
    let mut files: Vec<PathBuf> =
        fs::read_dir(root().join("pipelines")).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.push(root().join("tests/golden/kinds.toml"));
    files.sort();
    let mut out: Vec<Vec<u8>> = files.iter().map(|file| fs::read(file).unwrap()).collect();
    let set = b"base = \"tdm\"\n\n--set\nscene=builtin:car\nslices.factor=2\nload=false\n";
    out.push(set.to_vec());
    out
}

/// Values of every type, as a bake of all kinds stores them.
static VALUES: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
    let t = Bench::new();
    let folder = root().join("tests/golden");
    let text = fs::read_to_string(folder.join("kinds.toml")).unwrap();
    let request = Request::new("kinds.toml", &folder, &[]);
    let plan = load_text("kinds.toml", &text, &request, &nodes::registry()).unwrap_or_else(|e| panic!("{e}"));
    let options = Options::new(t.path("cache"), t.path("out"));
    let report = bake(&plan, &options, &Stop::default(), &Silent).unwrap();
    assert_eq!(report.outcome, Outcome::Baked, "{:?}", report.errors);
    let db = rusqlite::Connection::open(t.path("cache").join(entries::INDEX)).unwrap();
    let mut rows = db.prepare("SELECT hash, data FROM value ORDER BY hash").unwrap();
    let rows = rows.query_map([], |r| Ok((r.get::<_, Vec<u8>>(0)?, r.get::<_, Option<Vec<u8>>>(1)?))).unwrap();
    let blobs = Blobs::new(&t.path("cache"));
    let value = |(hash, data): (Vec<u8>, Option<Vec<u8>>)| {
        let hash = Digest(hash.try_into().unwrap());
        data.unwrap_or_else(|| (*blobs.get(&hash, false).unwrap()).as_ref().to_vec())
    };
    rows.map(|row| value(row.unwrap())).collect()
});

/// The smallest values of every type, a few of each.
fn artifacts() -> Vec<Vec<u8>> {
    let mut by_type: BTreeMap<&str, Vec<&Vec<u8>>> = BTreeMap::new();
    for value in VALUES.iter() {
        by_type.entry(entries::type_name(value).unwrap()).or_default().push(value);
    }
    let missing: Vec<_> = entries::TYPES.keys().filter(|name| !by_type.contains_key(*name)).collect();
    assert!(missing.is_empty(), "no value of {missing:?} in the bake of all kinds");
    let mut out = Vec::new();
    for values in by_type.values_mut() {
        values.sort_by_key(|v| v.len());
        let few = values.iter().enumerate().filter(|(i, v)| *i == 0 || *i < 4 && v.len() < LARGEST);
        out.extend(few.map(|(_, v)| (*v).clone()));
    }
    out
}

fn files_of_bundles() -> Vec<Bundle> {
    VALUES.iter().filter_map(|value| from_bytes::<Bundle>(Arc::new(value.clone())).ok()).collect()
}

fn bundles() -> Vec<Vec<u8>> {
    let mut out = Vec::new();
    for bundle in files_of_bundles() {
        let main = bundle.main();
        // Shaders are not read.
        let data = |path: &&String| {
            !["wgsl", "glsl", "vert", "frag", "hlsl", "metal", "spv"].iter().any(|e| path.ends_with(e))
        };
        let others = bundle.files().keys().filter(|path| *path != main).filter(data);
        let paths = std::iter::once(main).chain(others.map(String::as_str));
        let files: Vec<(&str, &[u8])> = paths.map(|path| (path, &bundle.files()[path].bytes[..])).collect();
        out.push(entries::packed(&files));
    }
    out.retain(|bundle| bundle.len() < 4 * LARGEST);
    out
}

/// Files of bundles whose names end so.
fn published(extensions: &[&str]) -> Vec<Vec<u8>> {
    let mut out = Vec::new();
    for bundle in files_of_bundles() {
        for (path, file) in bundle.files() {
            if extensions.iter().any(|e| path.ends_with(e)) && file.bytes.len() < LARGEST {
                out.push(file.bytes.clone());
            }
        }
    }
    out
}

fn index_of_small_bakes() -> Vec<Vec<u8>> {
    let t = Bench::new();
    for variant in 0..2 {
        ok(&t.bake(&small_plan(variant, 2)));
    }
    let index = t.path("cache").join(entries::INDEX);
    let large = fs::read(&index).unwrap();
    let db = rusqlite::Connection::open(&index).unwrap();
    db.execute_batch("PRAGMA journal_mode = DELETE; PRAGMA page_size = 512; VACUUM; PRAGMA journal_mode = WAL;")
        .unwrap();
    drop(db);
    vec![fs::read(&index).unwrap(), large]
}

/// Records without their checksums.
fn records() -> Vec<Vec<u8>> {
    let t = Bench::new();
    ok(&t.bake(&small_plan(1, 2)));
    let db = rusqlite::Connection::open(t.path("cache").join(entries::INDEX)).unwrap();
    let mut rows = db
        .prepare("SELECT record FROM run UNION ALL SELECT record FROM map UNION ALL SELECT record FROM bake")
        .unwrap();
    let rows = rows.query_map([], |r| r.get::<_, Vec<u8>>(0)).unwrap();
    rows.map(|row| row.unwrap()).map(|record| record[..record.len() - 16].to_vec()).collect()
}

const OBJ: &str = "mtllib part.mtl\no a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvn 0 0 1\nusemtl m\nf 1/1/1 2/2/1 3/1/1\nf 1 2 3 4\nf -1 -2 -3\n";
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 255\n1 0 0 0\n0 1 0 9\n3 0 1 2\n";
const SCENE: &str = "[[place]]\nfile = \"part.obj\"\nname = \"north\"\ntranslate = [10.0, 0.0, -3.5]\nrotate_deg = [0.0, 90.0, 0.0]\nscale = 2.0\n\n[[place]]\nfile = \"part.obj\"\nquaternion = [0.0, 0.7, 0.0, 0.7]\nscale = [1.0, 1.3, 1.0]\n";

fn texts(text: &str) -> Vec<Vec<u8>> {
    vec![text.as_bytes().to_vec()]
}

#[test]
fn pipeline_files() {
    run("pipeline", &pipelines(), 400, entries::pipeline);
}

#[test]
fn artifacts_of_every_type() {
    run("artifact", &artifacts(), 3000, entries::artifact);
}

#[test]
fn bundles_of_every_method() {
    run("bundle", &bundles(), 400, entries::bundle);
}

#[test]
fn any_index() {
    let folder = tempfile::tempdir().unwrap();
    run("index", &index_of_small_bakes(), 60, |data| entries::index(&folder.path().join("cache"), data));
}

#[test]
fn records_beyond_their_checksum() {
    run("record", &records(), 4000, entries::record);
}

#[test]
fn scene_files_and_textures() {
    for (name, file, seeds, short) in [
        ("obj", "a.obj", texts(OBJ), 1500),
        ("ply", "a.ply", texts(PLY), 1500),
        ("scene_toml", "a.toml", texts(SCENE), 1500),
        ("glb", "a.glb", published(&["glb"]), 300),
    ] {
        assert!(seeds.iter().all(|seed| entries::scene(file, seed)), "{name}: a seed is no scene");
        run(name, &seeds, short, |data| {
            entries::scene(file, data);
        });
    }
    run("texture", &published(&["ktx2", "dds"]), 300, entries::texture);
}

/// Not a test of its own: writes the corpora.
#[test]
fn seeds() {
    let Some(folder) = std::env::var_os("FARFIELD_SEEDS") else { return };
    for (name, seeds) in [
        ("pipeline", pipelines()),
        ("artifact", artifacts()),
        ("bundle", bundles()),
        ("index", index_of_small_bakes()),
        ("record", records()),
        ("obj", texts(OBJ)),
        ("ply", texts(PLY)),
        ("scene_toml", texts(SCENE)),
        ("glb", published(&["glb"])),
        ("texture", published(&["ktx2", "dds"])),
    ] {
        let folder = Path::new(&folder).join(name);
        fs::create_dir_all(&folder).unwrap();
        for seed in seeds {
            fs::write(folder.join(&Digest::of(&seed).hex()[..16]), seed).unwrap();
        }
    }
}
