//! Stand-ins as a whole: what they keep, and how they look from their cell.

use super::{
    build::{CostKind, Simplifying, simplify, textured},
    faces::Facing,
    levels::{Levels, levels},
    occlusion::Estimate,
    outline::Outline,
    pixels::{Steps, Unit},
    render,
    subject::{Classifying, Placement, Subject, Views, classify},
    texture::Textured,
    weights::{Window, Windows},
};
use crate::{
    math::{Sequence, Stop},
    raster::{Cpu, Geometry, Nearest, Options, nearest},
    runtime::hybrid_lod::cell_files,
    scene::{Object, Scene, builtin},
    view::{HexGrid, View},
};
use glam::{DAffine3, DVec3, Mat4};

const SIMPLIFYING: Simplifying = Simplifying {
    cost: CostKind::Parallax,
    facing: Facing::Cell,
    steps: Steps { t_c0: 8.0, t_c1: 3.0, unit: Unit::Footprint },
    exponent: 2.0,
    t_l: 4.5,
    tolerance: 0.5,
    start: 0.1,
    triangles: 0,
};

const RESOLUTION: f64 = 128.0;
const T_S: f64 = 4.0;

/// A solid before a cell of size 3.
struct Case {
    original: Scene,
    subject: Subject,
    levels: Levels,
    windows: Windows,
    grid: HexGrid,
}

fn case(name: &str, distance: f32) -> Case {
    let mut scene = builtin::make("solids", 1).unwrap();
    scene.objects.retain(|o| o.name.contains(name));
    let shape = Scene { objects: vec![Object { transform: Mat4::IDENTITY, ..scene.objects[0].clone() }] };
    let grid = HexGrid { origin: DVec3::Y, size: 3.0, half_height: 0.5, columns: 5, rows: 5 };
    let cell = grid.cell(2, 2);
    let centre = cell.centre.as_vec3();
    let place = Mat4::from_translation(glam::Vec3::new(centre.x + distance, 1.0, centre.z + 0.3));
    let original = Scene { objects: vec![Object { transform: place, ..shape.objects[0].clone() }] };
    let o = &original.objects[0];
    let placement =
        Placement { transform: DAffine3::from_mat4(place.as_dmat4()), outline: Outline::of(o), triangles: 1 };
    let how = Classifying { image_res: RESOLUTION, t_s: T_S, estimate: Estimate::Bound, clusters: true };
    let around: Vec<DVec3> = grid.neighbours(2, 2).iter().map(|(c, r)| grid.cell(*c, *r).centre).collect();
    let subject = classify(&cell, &around, &[(o.name.clone(), &placement)], &how).subjects.remove(0).1;
    let captured: Vec<Window> =
        subject.cameras.iter().map(|c| render::window(&Cpu, &c.1, &[&o.parts], 2, &Stop::default()).unwrap()).collect();
    let windows = subject.windows(captured.iter()).unwrap();
    Case { levels: levels(&shape, 11).unwrap(), original, subject, windows, grid }
}

impl Case {
    fn stand_in(&self, how: &Simplifying) -> Textured {
        let simplified = simplify(&self.subject, &[&self.levels], &self.windows, how, &Stop::default()).unwrap();
        textured(&self.subject, &simplified, &self.windows, 0.5)
    }

    fn scene(&self, t: &Textured) -> Scene {
        self.paged(t, 4096)
    }

    fn paged(&self, t: &Textured, page: u32) -> Scene {
        let entry = super::entry::Entry { centre: self.grid.cell(2, 2).centre.to_array(), ..Default::default() };
        cell_files(&entry, &[("a", &self.subject, t)], page).unwrap().scene
    }

    /// What an eye of the cell sees of a scene.
    fn seen(&self, scene: &Scene, i: u32) -> Nearest {
        let eye = self.grid.cell(2, 2).point(Sequence::<3>::new(2).point(i));
        let target = self.original.bounds().centre();
        let n = RESOLUTION as u32;
        let view = View::look_at(eye, target, DVec3::Y, std::f64::consts::FRAC_PI_3, n, n, 0.01, 1e3);
        nearest(&Cpu, &Geometry::new(scene), &view, &Options::default(), &Stop::default()).unwrap()
    }
}

/// The stand-in of a solid so far from its cell's centre, with atlases of pages that are at most so wide.
#[cfg(feature = "gpu")]
pub(crate) fn stand_ins(name: &str, distance: f32, page: u32) -> Scene {
    let case = case(name, distance);
    case.paged(&case.stand_in(&SIMPLIFYING), page)
}

/// Pixels that are still set when the outer ones are taken off `times` times.
fn eroded(mask: &[bool], width: usize, times: u32) -> usize {
    let mut mask = mask.to_vec();
    for _ in 0..times {
        let at = |i: usize| {
            let around = [i.wrapping_sub(1), i + 1, i.wrapping_sub(width), i + width];
            mask[i] && around.iter().all(|j| mask.get(*j).copied().unwrap_or(false))
        };
        mask = (0..mask.len()).map(at).collect();
    }
    mask.iter().filter(|m| **m).count()
}

#[test]
fn no_hole_is_larger_than_the_tolerance_from_anywhere_in_the_cell() {
    for (name, distance, views) in
        [("torus", 60.0, Views::Single), ("torus", 9.0, Views::Multi), ("sphere", 12.0, Views::Multi)]
    {
        let case = case(name, distance);
        assert_eq!(case.subject.views, views, "{name} at {distance}");
        for facing in [Facing::Cell, Facing::Centre] {
            let t = case.stand_in(&Simplifying { facing, ..SIMPLIFYING });
            assert!(
                !t.triangles.is_empty() && t.triangles.len() * 2 < case.levels.levels[0].triangles.len(),
                "{}",
                t.triangles.len()
            );
            let stand_in = case.scene(&t);
            for i in 0..60 {
                let (a, b) = (case.seen(&case.original, i), case.seen(&stand_in, i));
                let holes: Vec<bool> =
                    a.depth.iter().zip(&b.depth).map(|(a, b)| a.is_finite() && !b.is_finite()).collect();
                // What is T_s pixels wide is gone after half as many erosions.
                assert_eq!(eroded(&holes, RESOLUTION as usize, (T_S / 2.0) as u32), 0, "{name} at {distance}, eye {i}");
            }
        }
    }
}

#[test]
fn no_edge_has_more_than_two_faces() {
    for (name, distance) in [("torus", 9.0), ("sphere", 30.0), ("box", 10.0)] {
        let case = case(name, distance);
        for cost in [CostKind::Paper, CostKind::Parallax] {
            let how = Simplifying { cost, ..SIMPLIFYING };
            let simplified = simplify(&case.subject, &[&case.levels], &case.windows, &how, &Stop::default()).unwrap();
            let mut edges = std::collections::BTreeMap::new();
            for t in &simplified.triangles {
                for k in 0..3 {
                    let (a, b) = (t[k], t[(k + 1) % 3]);
                    *edges.entry((a.min(b), a.max(b))).or_insert(0) += 1;
                }
            }
            assert!(edges.values().all(|n| *n <= 2), "{name} {cost:?}");
            // Vertices are the original's.
            let member = case.subject.members[0].1;
            let level: std::collections::BTreeSet<[u64; 3]> = case
                .levels
                .levels
                .iter()
                .flat_map(|l| l.positions.iter())
                .map(|p| member.transform_point3(glam::Vec3::from(*p).as_dvec3()).to_array().map(f64::to_bits))
                .collect();
            assert!(simplified.positions.iter().all(|p| level.contains(&p.to_array().map(f64::to_bits))));
        }
    }
}

#[test]
fn tolerances_and_counts_are_kept() {
    let case = case("torus", 9.0);
    let count = |how: &Simplifying| case.stand_in(how).triangles.len();
    let at = |tolerance| count(&Simplifying { tolerance, ..SIMPLIFYING });
    assert!(at(2.0) < at(0.5) && at(0.5) < at(0.1), "{} {} {}", at(2.0), at(0.5), at(0.1));
    let paper = |t_l| count(&Simplifying { cost: CostKind::Paper, t_l, ..SIMPLIFYING });
    assert!(
        paper(6.0) < paper(1.0) && paper(1.0) <= count(&Simplifying { cost: CostKind::Paper, t_l: 0.0, ..SIMPLIFYING })
    );
    let half = at(0.1) / 2;
    let limited = count(&Simplifying { tolerance: 1e3, triangles: half, ..SIMPLIFYING });
    assert!(limited <= half && limited + 2 >= half, "{limited} of {half}");
}

#[test]
fn textures_show_what_the_windows_saw() {
    let case = case("torus", 9.0);
    let t = case.stand_in(&SIMPLIFYING);
    for (v, patch) in t.patch.iter().enumerate() {
        let patch = &t.patches[*patch as usize];
        let Some(k) = patch.window else { continue };
        let p = glam::Vec3::from(t.positions[v]).as_dvec3();
        let (x, y, z) = case.windows.0[k as usize].view.project(p);
        let [u, w] = t.uv[v];
        assert!((x - f64::from(patch.origin[0]) - f64::from(u)).abs() < 1e-2);
        assert!((y - f64::from(patch.origin[1]) - f64::from(w)).abs() < 1e-2);
        assert!((z - f64::from(t.depth[v])).abs() < 1e-3 * z);
        assert!(u >= 0.0 && w >= 0.0 && u <= patch.width as f32 && w <= patch.height as f32);
    }
    assert!(t.patches.iter().all(|p| p.texels.len() == (p.width * p.height) as usize));
    assert!(
        t.triangles
            .iter()
            .all(|c| t.patch[c[0] as usize] == t.patch[c[1] as usize]
                && t.patch[c[1] as usize] == t.patch[c[2] as usize])
    );
}

#[test]
fn what_looks_away_is_empty() {
    let mut case = case("sphere", 30.0);
    // Inside out, and single-sided: no face looks at the cell but those on the far side, which do.
    case.levels.double_sided = false;
    for level in &mut case.levels.levels {
        level.triangles = level
            .triangles
            .iter()
            .filter(|t| {
                let m = case.subject.members[0].1;
                let [a, b, c] = t.map(|v| m.transform_point3(glam::Vec3::from(level.positions[v as usize]).as_dvec3()));
                (b - a).cross(c - a).dot(a) > 0.0
                    && !super::faces::front((b - a).cross(c - a), a, &case.subject.cell.corners())
            })
            .copied()
            .collect();
    }
    let t = case.stand_in(&SIMPLIFYING);
    assert!(t.triangles.is_empty() && t.patches.is_empty());
    assert!(case.scene(&t).objects.is_empty());
}
