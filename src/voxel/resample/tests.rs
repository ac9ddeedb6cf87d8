use super::*;
use crate::voxel::{
    Voxel,
    testing::{self, speckle},
};
use glam::{DVec2, DVec3, Vec2};
use proptest::prelude::*;

fn run(mesh: &VoxelMesh, settings: &Settings) -> ChartedMesh {
    resample(mesh, &testing::slices(), settings, &Stop::default()).unwrap()
}

/// (first texel, size) of each chart.
fn chart_starts(m: &ChartedMesh) -> Vec<(usize, [u32; 2])> {
    let mut at = 0;
    m.chart_size
        .iter()
        .map(|s| {
            let start = at;
            at += (s[0] * s[1]) as usize;
            (start, *s)
        })
        .collect()
}

/// A wall that faces the cell: each of its pixels is one texel, with the voxel's very bytes.
#[test]
fn aligned_texels_are_the_voxels() {
    let slices = testing::slices();
    let m = run(&testing::wall(&slices), &Settings { n: 1, ..Settings::default() });
    assert_eq!(m.chart_size.len(), 1);
    let [w, h] = m.chart_size[0];
    assert_eq!([w, h], [44, 24]);
    for (i, c) in m.color.iter().enumerate() {
        let clamp = |v: u32, n: u32| v.clamp(2, n - 3) - 2;
        let (x, y) = (clamp(i as u32 % w, w), clamp(i as u32 / w, h));
        let [r, g, b] = speckle(10 + x as u16, 20 + y as u16, 2);
        assert_eq!(*c, [r, g, b, 255], "texel {i}");
    }
}

/// The same wall with colours for the quarters of its voxels: texels of half a side are these, and larger ones their mean.
#[test]
fn aligned_fine_texels_are_the_quarters() {
    let wall = testing::wall(&testing::slices());
    let quarter = |v: &Voxel, q: u16| {
        let [r, g, b] = speckle(2 * v.x + q % 2, 2 * v.y + q / 2, 7);
        [r, g, b, 255]
    };
    let quarters = wall.voxels.iter().map(|v| [0, 1, 2, 3].map(|q| quarter(v, q))).collect();
    let mesh = VoxelMesh { quarters, ..wall };
    for n in [1, 4] {
        let m = run(&mesh, &Settings { n, texel: 0.5, ..Settings::default() });
        let [w, h] = m.chart_size[0];
        let mut compared = 0;
        for (i, c) in m.color.iter().enumerate() {
            // The faces begin and end a quarter of a pixel inside the outermost voxels: half a texel.
            let (x, y) = (i as u32 % w, i as u32 / w);
            if (3..w - 3).contains(&x) && (3..h - 3).contains(&y) {
                let [r, g, b] = speckle(20 + x as u16 - 2, 40 + y as u16 - 2, 7);
                assert_eq!(*c, [r, g, b, 255], "texel {x}, {y} of {w} × {h}");
                compared += 1;
            }
        }
        assert!(compared > 2000, "{compared}");
    }
}

/// A sheet with a window, three layers in front of another sheet, in one mesh. Hidden or not, what lies behind lends no colour to
/// what lies before, nor the reverse. The nearest voxels in three dimensions would: pixels count more than layers there.
#[test]
fn a_sheet_close_behind_lends_no_colour() {
    const RED: [u8; 4] = [200, 10, 10, 255];
    const BLUE: [u8; 4] = [10, 10, 200, 255];
    let (front, back) = (1, 4);
    let sheet = |x0: i32, x1: i32, l: i32| {
        [[x0 * 4 + 1, 81, l], [x0 * 4 + 1, 159, l], [x1 * 4 - 1, 159, l], [x1 * 4 - 1, 81, l]]
    };
    let vertices = [sheet(10, 26, front), sheet(34, 50, front), sheet(10, 50, back)].concat();
    let faces = (0..3).flat_map(|s| [[s * 4, s * 4 + 1, s * 4 + 2], [s * 4, s * 4 + 2, s * 4 + 3]]).collect();
    let columns = |l: i32| (10..50u16).filter(move |x| l == back || !(26..34).contains(x));
    let places =
        [front, back].into_iter().flat_map(|l| columns(l).flat_map(move |x| (20..40).map(move |y| [x, y, l as u16])));
    let mut mesh = testing::mesh(vertices, faces, places);
    let mut voxels = mesh.voxels.to_vec();
    for v in &mut voxels {
        v.color = if i32::from(v.layer) == front { RED } else { BLUE };
    }
    mesh.voxels = voxels.into();
    let at = DVec3::new(20.5, 30.5, f64::from(front));
    let (nearest, _) = Source::new(&mesh.voxels).sample(at, charts::Axis::Layer.weight(), 4);
    assert!(nearest != RED, "the nearest voxels alone would decide wrongly: {nearest:?}");
    let m = run(&mesh, &Settings::default());
    // The sheets' charts by the depth of their vertices.
    let depth = |chart: u32| {
        let corner = (0..m.triangles.len()).find(|t| m.chart_of[*t] == chart).map(|t| m.triangles[t][0]).unwrap();
        -m.positions[corner as usize][2]
    };
    let nearest = (0..m.chart_size.len() as u32).map(depth).fold(f32::INFINITY, f32::min);
    for (chart, (start, [w, h])) in chart_starts(&m).into_iter().enumerate() {
        let expect = if depth(chart as u32) < nearest + 1.0 { RED } else { BLUE };
        // At the outline of a sheet a texel may mix with what lies beside it; the margin continues the outline.
        let inside = (0..w * h).filter(|i| (3..w - 3).contains(&(i % w)) && (3..h - 3).contains(&(i / w)));
        let wrong: Vec<_> = inside.map(|i| m.color[start + i as usize]).filter(|c| *c != expect).collect();
        assert!(wrong.is_empty(), "chart {chart}: {} texels of {w} × {h}, such as {:?}", wrong.len(), wrong[0]);
    }
    assert!(m.color.contains(&RED) && m.color.contains(&BLUE));
}

/// A wall seen edge-on from the centre gets texels along its depth, with the voxels' colours in order.
#[test]
fn walls_have_texels_along_their_depth() {
    let m = run(&testing::edge_on(), &Settings { n: 1, margin: 2, ..Settings::default() });
    let [w, h] = m.chart_size[0];
    assert_eq!(m.chart_size.len(), 1);
    assert!(h >= 40 + 4 && w >= 4 + 2, "{w} × {h}");
    let colours: std::collections::BTreeSet<_> = m.color.iter().copied().collect();
    let voxels: std::collections::BTreeSet<_> = testing::edge_on().voxels.iter().map(|v| v.color).collect();
    assert!(colours.is_subset(&voxels));
    assert!(colours.len() * 10 >= voxels.len() * 3, "{} of {} voxels are seen", colours.len(), voxels.len());
}

#[test]
fn vertices_shared_by_faces_have_the_same_bits() {
    let slices = testing::slices();
    for mesh in testing::all() {
        let map = Reprojection::of(&slices, &mesh).unwrap();
        let mut expected: Vec<_> = mesh
            .faces
            .iter()
            .map(|f| f.map(|v| map.world(mesh.vertices[v as usize]).as_vec3().to_array().map(f32::to_bits)))
            .collect();
        let m = run(&mesh, &Settings::default());
        let mut found: Vec<_> =
            m.triangles.iter().map(|t| t.map(|v| m.positions[v as usize].map(f32::to_bits))).collect();
        expected.sort_unstable();
        found.sort_unstable();
        assert_eq!(expected, found);
    }
}

/// Faces keep their orientation: counter-clockwise on the screen where they are no walls.
#[test]
fn orientation_is_kept() {
    let slices = testing::slices();
    let m = run(&testing::ground(), &Settings::default());
    for t in m.triangles.iter() {
        let p = t.map(|v| DVec3::from(m.positions[v as usize].map(f64::from)) - slices.cell.centre);
        assert!((p[1] - p[0]).cross(p[2] - p[0]).dot(p[0]) < 0.0);
    }
}

#[test]
fn charts_stay_within_their_largest_size() {
    for mesh in testing::all() {
        let m = run(&mesh, &Settings { max_size: 24, ..Settings::default() });
        assert!(m.chart_size.iter().flatten().all(|s| *s <= 24), "{:?}", &m.chart_size[..]);
    }
}

#[test]
fn same_bytes_for_any_thread_count() {
    let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
    for mesh in testing::all() {
        let settings = Settings { normals: true, texel: 0.4, ..Settings::default() };
        assert_eq!(pool(1).install(|| run(&mesh, &settings)), pool(3).install(|| run(&mesh, &settings)));
    }
}

#[test]
fn bound_follows_the_factor() {
    let slices = testing::slices();
    let mesh = testing::ground();
    let g = 19.0 / 17.0;
    assert!((bound_px(&slices, &mesh).unwrap() - (1.0 + 2.0 * g)).abs() < 1e-12);
    assert_eq!(bound_px(&slices, &VoxelMesh { factor: 0.0, ..mesh.clone() }).unwrap(), 1.0);
    let mut close = slices;
    close.cell.half.z = 19.0;
    assert!(matches!(bound_px(&close, &mesh), Err(ResampleError::Near { .. })));
}

#[test]
fn nothing_in_nothing_out() {
    let m = run(&VoxelMesh { cover_start: vec![0].into(), ..VoxelMesh::default() }, &Settings::default());
    assert!(m.triangles.is_empty() && m.chart_size.is_empty());
}

#[test]
fn stops_when_asked() {
    let stop = Stop::default();
    stop.set();
    let slices = testing::slices();
    let result = resample(&testing::wall(&slices), &slices, &Settings::default(), &stop);
    assert!(matches!(result, Err(ResampleError::Stopped(_))));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Random height fields: every texel that bilinear filtering of a point of a face reads lies in the face's own
    /// chart, at least one texel from its rectangle's border, and has a colour of the mesh.
    #[test]
    fn what_filtering_reads_is_filled(
        layers in prop::collection::vec(0..6u16, 12),
        texel in 0.3..1.7f64,
        corner in (0.0..1.0f32, 0.0..1.0f32),
    ) {
        let mesh = hills(&layers);
        let m = run(&mesh, &Settings { texel, n: 1, ..Settings::default() });
        let starts = chart_starts(&m);
        prop_assert_eq!(m.color.len(), starts.iter().map(|(_, s)| (s[0] * s[1]) as usize).sum::<usize>());
        let palette: std::collections::BTreeSet<_> = mesh.voxels.iter().map(|v| v.color).collect();
        prop_assert!(m.color.iter().all(|c| palette.contains(c)));
        for (t, chart) in m.triangles.iter().zip(m.chart_of.iter()) {
            let (_, [w, h]) = starts[*chart as usize];
            let uv = t.map(|v| Vec2::from(m.uv[v as usize]));
            let (s, r) = if corner.0 + corner.1 > 1.0 { (1.0 - corner.0, 1.0 - corner.1) } else { corner };
            for p in uv.into_iter().chain([uv[0] * (1.0 - s - r) + uv[1] * s + uv[2] * r]) {
                let a = (p - 0.5).floor();
                prop_assert!(a.x >= 1.0 && a.y >= 1.0 && a.x + 2.0 < w as f32 && a.y + 2.0 < h as f32, "{p} in {w} × {h}");
            }
        }
    }

    /// No texel's centre lies inside two faces of one chart.
    #[test]
    fn faces_of_a_chart_do_not_overlap(layers in prop::collection::vec(0..6u16, 12)) {
        let m = run(&hills(&layers), &Settings { texel: 0.5, ..Settings::default() });
        for chart in 0..m.chart_size.len() {
            let faces: Vec<_> = (0..m.triangles.len()).filter(|t| m.chart_of[*t] as usize == chart).map(|t| {
                m.triangles[t].map(|v| Vec2::from(m.uv[v as usize]).as_dvec2())
            }).collect();
            for y in 0..m.chart_size[chart][1] {
                for x in 0..m.chart_size[chart][0] {
                    let p = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                    let inside = faces.iter().filter(|f| grid::signed_distance(f, p) < -0.26).count();
                    prop_assert!(inside <= 1);
                }
            }
        }
    }

    #[test]
    fn nearest_known_is_nearest(width in 1..12usize, known in prop::collection::vec(prop::bool::weighted(0.1), 1..100)) {
        let known = &known[..known.len() / width * width];
        prop_assume!(known.iter().any(|k| *k));
        let place = |i: usize| DVec2::new((i % width) as f64, (i / width) as f64);
        for (i, source) in nearest_known(known, width).into_iter().enumerate() {
            prop_assert!(known[source as usize]);
            let best = (0..known.len()).filter(|k| known[*k]).map(|k| place(k).distance(place(i))).fold(f64::INFINITY, f64::min);
            prop_assert!(place(i).distance(place(source as usize)) <= best + 1.0);
        }
    }
}

/// A height field of 4 × 3 vertices, 12 pixels apart, at the given layers, with a voxel per pixel.
fn hills(layers: &[u16]) -> VoxelMesh {
    let at = |i: u16, j: u16| layers[(j * 4 + i) as usize];
    let vertices = (0..3u16).flat_map(|j| (0..4u16).map(move |i| (i, j)));
    let vertices =
        vertices.map(|(i, j)| [i32::from(i) * 48 + 41, i32::from(j) * 48 + 41, i32::from(at(i, j))]).collect();
    let mut faces = Vec::new();
    for j in 0..2u32 {
        for i in 0..3u32 {
            let a = j * 4 + i;
            faces.extend([[a, a + 4, a + 5], [a, a + 5, a + 1]]);
        }
    }
    let places = (0..24u16).flat_map(|y| (0..36u16).map(move |x| [x, y]));
    let places = places.map(|[x, y]| [x + 10, y + 10, at(x / 12, y / 12)]).collect::<Vec<_>>();
    testing::mesh(vertices, faces, places)
}

/// Faces that run two pixels out over a surface's ends: seen from the centre every voxel's pixel is opaque, and nothing beyond
/// its neighbours' middle is.
#[test]
fn alpha_cuts_what_runs_out_over_the_ends() {
    let slices = testing::slices();
    let wall = testing::wall(&slices);
    let wide = |v: &[i32; 3]| {
        let out = |at: i32, low: i32, high: i32| if at == low { low - 8 } else { high + 8 };
        [out(v[0], 41, 199), out(v[1], 81, 159), v[2]]
    };
    let mesh = VoxelMesh { vertices: wall.vertices.iter().map(wide).collect(), alpha: true, ..wall };
    let m = run(&mesh, &Settings::default());
    let [w, h] = m.chart_size[0];
    // The chart begins two pixels and its margin before the first voxel.
    for (i, c) in m.color.iter().enumerate() {
        let (x, y) = ((i as u32 % w) as i32 - 4, (i as u32 / w) as i32 - 4);
        let inside = (0..40).contains(&x) && (0..20).contains(&y);
        assert_eq!(c[3], if inside { 255 } else { 0 }, "texel {x}, {y} of {w} × {h}");
    }
    let opaque = run(&VoxelMesh { alpha: false, ..mesh }, &Settings::default());
    assert!(opaque.color.iter().all(|c| c[3] == 255));
}
