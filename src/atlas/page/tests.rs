use super::*;
use glam::Vec2;
use proptest::prelude::*;

/// One triangle per chart, `margin` texels from the chart's border; each chart has its own colour.
fn mesh(sizes: &[[u32; 2]], seed: u8, margin: f32) -> ChartedMesh {
    let mut m = ChartedMesh { bound_px: 3.0, ..ChartedMesh::default() };
    let (mut positions, mut uv, mut triangles, mut color) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (c, [w, h]) in sizes.iter().enumerate() {
        let (x, y) = (*w as f32 - margin, *h as f32 - margin);
        let first = positions.len() as u32;
        for at in [[margin, margin], [margin, y], [x, y]] {
            positions.push([at[0], at[1], c as f32]);
            uv.push(at);
        }
        triangles.push([first, first + 1, first + 2]);
        color.extend(vec![[seed, c as u8, 200, 255]; (w * h) as usize]);
    }
    m.positions = positions.into();
    m.uv = uv.into();
    m.chart_of = (0..triangles.len() as u32).collect();
    m.triangles = triangles.into();
    m.chart_size = sizes.to_vec().into();
    m.color = color.into();
    m
}

fn run(meshes: &[ChartedMesh], settings: &Settings) -> Result<Scene, AtlasError> {
    let names: Vec<_> = (0..meshes.len()).map(|i| format!("m{i}")).collect();
    let named: Vec<_> = names.iter().map(String::as_str).zip(meshes).collect();
    atlas(&named, settings, &Stop::default()).map(|a| a.scene)
}

fn picture(o: &Object) -> &Image {
    &o.parts[0].material.base_color_texture.as_ref().unwrap().image
}

/// Texels of mip level `level` by box filter, each as the set of colours that it mixes.
fn mixed(image: &Image, level: u32, x: i64, y: i64) -> Vec<[u8; 4]> {
    let step = 1i64 << level;
    let (w, h) = (i64::from(image.width), i64::from(image.height));
    let (x, y) = (x.clamp(0, w / step - 1) * step, y.clamp(0, h / step - 1) * step);
    let mut all: Vec<_> =
        (y..y + step).flat_map(|y| (x..x + step).map(move |x| (y * w + x) as usize)).map(|i| image.texels[i]).collect();
    all.sort_unstable();
    all.dedup();
    all
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// Down to the mip level that the gutter promises, what bilinear filtering of a face reads is its chart's colour.
    #[test]
    fn filtering_stays_within_a_chart(
        sizes in prop::collection::vec(prop::array::uniform2(5..30u32), 1..12),
        gutter in 1..9u32,
        level in 0..4u32,
    ) {
        let settings = Settings { gutter, max_page: 64 };
        prop_assume!(1 << level <= settings.alignment());
        let scene = run(&[mesh(&sizes, 7, 1.0), mesh(&sizes[..1], 9, 1.0)], &settings).unwrap();
        let mut seen = 0;
        for object in &scene.objects {
            let part = &object.parts[0];
            let image = picture(object);
            let scale = Vec2::new(image.width as f32, image.height as f32);
            for t in part.mesh.triangles.iter() {
                let corners = t.map(|v| Vec2::from(part.mesh.uv[0][v as usize]) * scale);
                let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
                let own = image.texels[middle.y as usize * image.width as usize + middle.x as usize];
                for p in corners.into_iter().chain([middle]) {
                    let at = p / (1u32 << level) as f32 - 0.5;
                    for k in 0..4 {
                        let (x, y) = (at.x.floor() as i64 + (k & 1), at.y.floor() as i64 + (k >> 1));
                        // A sample on a texel's centre does not read the next one.
                        let weight = (1.0 - (at.x - x as f32).abs()) * (1.0 - (at.y - y as f32).abs());
                        if weight > 1e-4 {
                            prop_assert_eq!(mixed(image, level, x, y), vec![own]);
                        }
                    }
                }
                seen += 1;
            }
        }
        prop_assert_eq!(seen, sizes.len() + 1);
    }
}

#[test]
fn all_triangles_keep_their_places() {
    let m = [mesh(&[[9, 7], [5, 5]], 1, 2.0), mesh(&[[12, 30]], 2, 2.0)];
    let scene = run(&m, &Settings::default()).unwrap();
    assert_eq!(scene.objects.len(), 1);
    let part = &scene.objects[0].parts[0];
    let found: Vec<_> = part.mesh.triangles.iter().map(|t| t.map(|v| part.mesh.positions[v as usize])).collect();
    let expected: Vec<_> =
        m.iter().flat_map(|m| m.triangles.iter().map(|t| t.map(|v| m.positions[v as usize]))).collect();
    assert_eq!(found, expected);
    assert!(part.mesh.uv[0].iter().flatten().all(|c| (0.0..=1.0).contains(c)));
    assert!(part.material.unlit && part.material.double_sided);
}

#[test]
fn pages_are_powers_of_two_and_more_are_begun_when_one_is_full() {
    let scene = run(&[mesh(&[[60, 60]; 3], 1, 2.0)], &Settings { gutter: 4, max_page: 64 }).unwrap();
    assert_eq!(scene.objects.iter().map(|o| o.name.as_str()).collect::<Vec<_>>(), ["page 00", "page 01", "page 02"]);
    assert!(scene.objects.iter().all(|o| picture(o).width == 64 && picture(o).texels.len() == 64 * 64));
}

#[test]
fn what_cannot_be_packed_is_an_error() {
    assert!(matches!(run(&[ChartedMesh::default()], &Settings::default()), Err(AtlasError::Empty)));
    let large = run(&[mesh(&[[61, 5]], 1, 2.0)], &Settings { gutter: 4, max_page: 64 });
    assert!(matches!(large, Err(AtlasError::TooLarge { width: 61, .. })));
    let mut mapped = mesh(&[[6, 6]], 1, 2.0);
    mapped.normal = vec![[128, 128, 255, 255]; 36].into();
    let mixed = run(&[mapped, mesh(&[[6, 6]], 1, 2.0)], &Settings::default());
    assert!(matches!(mixed, Err(AtlasError::Normals { .. })));
}

/// Vertex normal, tangent and normal texture together give back the world-space normal.
#[test]
fn normals_come_back() {
    let world = [Vec3::new(0.36, 0.48, 0.8), Vec3::new(0.0, 0.6, 0.8)];
    let bytes = world.map(|n| ((n + 1.0) * 127.5).round()).map(|c| [c.x as u8, c.y as u8, c.z as u8, 255]);
    let mut m = mesh(&[[6, 6]], 1, 2.0);
    m.normal = (0..36).map(|i| bytes[i % 2]).collect();
    let scene = run(&[m], &Settings::default()).unwrap();
    let part = &scene.objects[0].parts[0];
    assert!(!part.material.unlit);
    let map = &part.material.normal_texture.as_ref().unwrap().image;
    let (n, t) = (Vec3::from(part.mesh.normals[0]), part.mesh.tangents[0]);
    let tangent = Vec3::new(t[0], t[1], t[2]);
    let bitangent = n.cross(tangent) * t[3];
    for i in 0..2 {
        let local = unpacked(map.texels[(2 + 2) * map.width as usize + 4 + i]);
        let back = tangent * local.x + bitangent * local.y + n * local.z;
        assert!((back - world[i]).length() < 0.02, "{back} instead of {}", world[i]);
    }
}

/// A page is masked exactly if it has a transparent texel; its colours stay.
#[test]
fn pages_with_transparent_texels_are_masked() {
    let opaque = mesh(&[[12, 9], [7, 7]], 40, 2.0);
    let mut cut = opaque.clone();
    let texels: Vec<[u8; 4]> =
        cut.color.iter().enumerate().map(|(i, c)| [c[0], c[1], c[2], if i == 30 { 0 } else { 255 }]).collect();
    cut.color = texels.into();
    for (mesh, alpha) in [(opaque, Alpha::Opaque), (cut, Alpha::Mask { cutoff: 0.5 })] {
        let scene = run(&[mesh], &Settings::default()).unwrap();
        assert_eq!(scene.objects[0].parts[0].material.alpha, alpha);
        assert_eq!(picture(&scene.objects[0]).texels.iter().any(|t| t[3] == 0), alpha != Alpha::Opaque);
    }
}
