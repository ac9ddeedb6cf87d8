use super::{
    Drawing, Extras, Front, Model, NAME, OriError, TREE_NAME, TreeManifest, TreeStandIn, draw, projected_size, read,
    sample::{impostor, usual},
    write,
};
use crate::{
    array::Bytes,
    formats::{Files, FormatError, Limits},
    math::{Aabb, Stop},
    raster::{Cpu, NOTHING, Rendering},
    relief::{
        DepthBits, ReliefMap, Strategy,
        measure::Selection,
        select::{Choice, Subset},
        textures::{Compression, compress},
    },
    runtime::{BundleFile, Context, StandIn},
    scene::builtin,
    view::View,
};
use glam::DVec3;
use proptest::prelude::*;
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Arc,
};

/// Files of a bundle by their paths.
struct Folder(BTreeMap<String, Vec<u8>>);

impl Folder {
    fn of(files: Vec<BundleFile>) -> Self {
        Self(files.into_iter().map(|f| (f.path, f.bytes)).collect())
    }
}

impl Files for Folder {
    fn read(&self, path: &Path) -> Result<Option<Bytes>, FormatError> {
        Ok(path.to_str().and_then(|p| self.0.get(p)).map(|b| Arc::new(b.clone()) as Bytes))
    }

    fn real(&self, path: &Path) -> Option<PathBuf> {
        Some(path.to_owned())
    }
}

fn solids(bits: DepthBits) -> Model {
    impostor(&builtin::make("solids", 1).unwrap(), 32, bits, usual(), true)
}

/// A bundle of an impostor, its colours as they are where `blocks` is false.
fn bundle(model: &Model, blocks: bool) -> Folder {
    let ori = model.ori();
    let maps: Vec<&ReliefMap> = ori.maps.iter().map(|m| &m.1).collect();
    let textures = compress(&maps, Compression { blocks, levels: 4 }, &Stop::default()).unwrap();
    let selection = Selection {
        size: 64,
        trace: ori.drawing.trace,
        choice: Choice::Best { goal: 0.002, neighbours: 0 },
        maps: ori.maps.iter().map(|m| m.0.clone()).collect(),
        directions: ori.directions.clone(),
        subsets: ori.subsets.iter().map(|m| Subset { maps: m.clone(), missing: 1, extra: 2 }).collect(),
    };
    Folder::of(write(ori, &selection, &textures, Extras { dds: true, shaders: true }).unwrap())
}

#[test]
fn what_was_written_is_read() {
    for bits in [DepthBits::Eight, DepthBits::Sixteen] {
        let model = solids(bits);
        let folder = bundle(&model, false);
        assert_eq!(read(Path::new(""), &folder).unwrap().ori, *model.ori());
        for file in ["color.ktx2", "normal.dds", "depth.ktx2", "emissive.ktx2", "preview.png", "cards.glb", "ori.wgsl"]
        {
            assert!(folder.0.contains_key(file), "{file}");
        }
    }
}

/// Blocks change colours, never what is covered.
#[test]
fn compressed_textures_cover_the_same() {
    let model = solids(DepthBits::Eight);
    let packed = Model::new(read(Path::new(""), &bundle(&model, true)).unwrap().ori).unwrap();
    let view = View::look_at(DVec3::new(3.0, 2.0, 4.0), model.ori().bounds.centre(), DVec3::Y, 0.7, 48, 48, 0.1, 20.0);
    let how = Rendering::default();
    let (a, b) =
        (draw(&model, &view, &how, &Stop::default()).unwrap(), draw(&packed, &view, &how, &Stop::default()).unwrap());
    assert_eq!((&a.depth, &a.map), (&b.depth, &b.map));
    assert!(a.map.iter().any(|m| *m != NOTHING));
}

/// Walls are passed, so the order of maps cannot show what another surface hides.
#[test]
fn all_strategies_draw_the_same_outline() {
    let scene = builtin::make("solids", 1).unwrap();
    let view = View::look_at(DVec3::new(-3.0, 1.0, 3.0), scene.bounds().centre(), DVec3::Y, 0.7, 48, 48, 0.1, 20.0);
    let draw = |strategy| {
        let model = impostor(&scene, 32, DepthBits::Eight, Drawing { strategy, ..usual() }, false);
        draw(&model, &view, &Rendering::default(), &Stop::default()).unwrap()
    };
    let first = draw(Strategy::Direction);
    for strategy in [Strategy::Plane, Strategy::Depth, Strategy::Normal, Strategy::BiasedDepth] {
        let other = draw(strategy);
        let same = first.depth.iter().zip(&other.depth).all(|(a, b)| a.is_finite() == b.is_finite());
        assert!(same, "{strategy:?}");
    }
    let nearest = draw(Strategy::Depth);
    assert!(first.depth.iter().zip(&nearest.depth).all(|(a, b)| b <= a));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn damaged_bundles_are_refused_or_drawn(at in any::<prop::sample::Index>(), byte in any::<u8>(), file in 0..4_usize, cut in any::<bool>()) {
        static WHOLE: std::sync::OnceLock<BTreeMap<String, Vec<u8>>> = std::sync::OnceLock::new();
        let whole = WHOLE.get_or_init(|| bundle(&solids(DepthBits::Eight), true).0);
        let mut files = Folder(whole.clone());
        let name = [NAME, "color.ktx2", "depth.ktx2", "normal.ktx2"][file];
        let bytes = files.0.get_mut(name).unwrap();
        let at = at.index(bytes.len());
        if cut { bytes.truncate(at) } else { bytes[at] = byte }
        if let Ok(Ok(model)) = read(Path::new(""), &files).map(|bundle| Model::new(bundle.ori)) {
            let view = View::look_at(DVec3::new(3.0, 2.0, 4.0), DVec3::ZERO, DVec3::Y, 0.7, 8, 8, 0.1, 20.0);
            let _ = draw(&model, &view, &Rendering::default(), &Stop::default());
        }
    }
}

#[test]
fn what_cannot_be_drawn_is_refused() {
    let good = solids(DepthBits::Eight).ori().clone();
    let mut nothing = good.clone();
    nothing.maps.clear();
    let mut beyond = good.clone();
    beyond.subsets[3] = vec![77];
    let mut short = good.clone();
    short.subsets.pop();
    let mut threshold = good.clone();
    threshold.plt = f64::NAN;
    let mut flat = good.clone();
    flat.bounds = Aabb::EMPTY;
    for (wrong, what) in [
        (nothing, "expected a relief map"),
        (beyond, "names a map that there is not"),
        (short, "a subset of maps for each direction"),
        (threshold, "NaN; expected more than 0 px"),
        (flat, "bounding box"),
    ] {
        let error = Model::new(wrong).err().unwrap().to_string();
        assert!(error.contains(what), "{error}");
    }
}

/// Two regions under a root, with the same impostor.
fn tree() -> Folder {
    let model = solids(DepthBits::Eight);
    let own = bundle(&model, true);
    let b = model.ori().bounds;
    let mut files = BTreeMap::new();
    let mut rows = Vec::new();
    for (name, plt, children) in
        [("root", 40.0, vec!["root.0", "root.1"]), ("root.0", 90.0, vec![]), ("root.1", 90.0, vec![])]
    {
        for (path, bytes) in &own.0 {
            files.insert(format!("{name}/{path}"), bytes.clone());
        }
        rows.push(super::RegionRow {
            name: name.into(),
            bounds: [b.min.to_array(), b.max.to_array()],
            plt_px: Some(plt),
            children: children.into_iter().map(str::to_owned).collect(),
            folder: name.into(),
            mesh: None,
        });
    }
    let glb = crate::formats::write_glb(&builtin::make("solids", 1).unwrap(), &crate::formats::GlbOptions::default())
        .unwrap();
    files.insert("root.1/mesh.glb".into(), glb);
    rows[2].mesh = Some("root.1/mesh.glb".into());
    let manifest = TreeManifest {
        format: super::TREE_FORMAT.into(),
        version: super::TREE_VERSION,
        regions: rows,
        shaders: BTreeMap::new(),
    };
    files.insert(TREE_NAME.into(), serde_json::to_vec(&manifest).unwrap());
    Folder(files)
}

/// Section 5: a region is drawn where its threshold is larger than its box on the screen, else its children; leaves fall back to their mesh.
#[test]
fn thresholds_decide_what_is_drawn() {
    let tree = TreeStandIn::read(Path::new(""), &tree(), &Limits::default()).unwrap();
    let bounds = tree.bounds();
    let look = |away: f64| {
        View::look_at(
            bounds.centre() + DVec3::new(0.3, 0.2, 1.0) * away,
            bounds.centre(),
            DVec3::Y,
            0.7,
            64,
            64,
            0.01,
            1000.0,
        )
    };
    let front =
        |impostors: &[usize], meshes: &[usize]| Front { impostors: impostors.to_vec(), meshes: meshes.to_vec() };
    let mut last = 0.0;
    for away in [60.0, 20.0, 12.0, 8.0, 5.0, 3.0] {
        let view = look(away * 0.7);
        let size = projected_size(&view, &bounds);
        assert!(size > last);
        last = size;
        let expected = match size {
            s if s <= 40.0 => front(&[0], &[]),
            s if s <= 90.0 => front(&[1, 2], &[]),
            _ => front(&[1], &[2]),
        };
        assert_eq!(tree.front(&view), expected, "{away}: {size}");
    }
    assert!(last > 90.0, "{last}");
    // Inside the box.
    let inside = View::look_at(bounds.centre(), bounds.centre() + DVec3::Z, DVec3::Y, 0.7, 64, 64, 0.01, 100.0);
    assert_eq!(projected_size(&inside, &bounds), f64::INFINITY);
    let stop = Stop::default();
    let context = Context { backend: &Cpu, stop: &stop };
    for away in [20.0, 3.0] {
        let shot = tree.draw(&look(away * 0.7), &Rendering::default(), context).unwrap();
        for (p, surface) in shot.surface.iter().enumerate() {
            assert_eq!(*surface == NOTHING, shot.depth[p].is_infinite());
            if *surface != NOTHING {
                let k = (shot.planes)(*surface);
                // 1/depth = k·d holds at the pixel itself.
                let view = look(away * 0.7);
                let d = view.unproject(f64::from(p as u32 % 64) + 0.5, f64::from(p as u32 / 64) + 0.5, 1.0) - view.eye;
                let d = DVec3::new(d.dot(view.right), d.dot(view.up), d.dot(view.forward));
                assert!(!k.is_finite() || (k.dot(d) * f64::from(shot.depth[p]) - 1.0).abs() < 1e-3, "{p}");
            }
        }
        assert!(shot.depth.iter().any(|z| z.is_finite()));
    }
}

#[test]
fn trees_that_are_none_are_refused() {
    let edit = |change: &dyn Fn(&mut TreeManifest)| {
        let mut files = tree();
        let mut manifest = TreeManifest::parse(&files.0[TREE_NAME]).unwrap();
        change(&mut manifest);
        files.0.insert(TREE_NAME.into(), serde_json::to_vec(&manifest).unwrap());
        TreeStandIn::read(Path::new(""), &files, &Limits::default())
            .err()
            .map(|e: OriError| e.to_string())
            .unwrap_or_default()
    };
    let changes: [(&dyn Fn(&mut TreeManifest), &str); 6] = [
        (&|m| m.regions[0].children.push("root.7".into()), "expected its child `root.7` after it"),
        (&|m| m.regions[1].children.push("root.1".into()), "expected one parent"),
        (&|m| m.regions[2].name = "root.0".into(), "two regions `root.0`"),
        (&|m| m.regions[1].folder = "../x".into(), "expected a path inside the bundle"),
        (&|m| m.regions.clear(), "0 regions; expected 1 to"),
        (&|m| m.regions[1].mesh = Some("none.glb".into()), "none.glb: no such file"),
    ];
    for (change, what) in changes {
        let error = edit(change);
        assert!(error.contains(what), "{error}");
    }
}
