//! Which voxels a viewer sees at a place of a chart: those of its surface that are visible on the viewer's ray through it.
//!
//! The nearest voxel in three dimensions can lie on another surface, a few layers behind, which nobody sees there. So
//! a texel asks along a ray, and takes what the chart's own faces cover before anything else. Charts that face the reference viewpoint use its
//! rays, which are the pixels' columns through the layers; charts that it sees edge-on use the rays of the cell's corner that sees them best.

use super::{
    charts::{Axis, Chart},
    colour::EPS,
    place::Space,
};
use crate::voxel::{
    Voxel, VoxelMesh,
    columns::{Columns, around},
};
use glam::{DVec2, DVec3, dvec3};

impl Columns<'_> {
    /// The front-most voxel on a ray, a visible one if there is any. `ray` gives its pixel in a layer; layers `low` to
    /// `high` are looked at.
    fn first(&self, ray: &Ray, low: f64, high: f64) -> Option<u32> {
        let layer = |i: &u32| f64::from(self.voxels[*i as usize].layer);
        let visible = |i: &u32| self.voxels[*i as usize].ring == 0;
        let mut hidden = None;
        if let Ray::Straight(p) = ray {
            let column = self.column(p.x, p.y).iter().filter(|i| layer(i) >= low && layer(i) <= high);
            for i in column {
                if visible(i) {
                    return Some(*i);
                }
                hidden = hidden.or(Some(*i));
            }
            return hidden;
        }
        for l in low.ceil().max(0.0) as i32..=high.floor() as i32 {
            let p = ray.pixel(l);
            match self.column(p.x, p.y).iter().find(|i| layer(i) == f64::from(l)) {
                Some(i) if visible(i) => return Some(*i),
                Some(i) => hidden = hidden.or(Some(*i)),
                None => {}
            }
        }
        hidden
    }
}

/// A viewer's ray in voxel space.
enum Ray<'a> {
    /// From the reference viewpoint: one pixel in all layers.
    Straight(DVec2),
    /// From elsewhere in the cell: the viewer and a place on the ray.
    Oblique(&'a Space<'a>, DVec3, DVec3),
}

impl Ray<'_> {
    fn pixel(&self, l: i32) -> DVec2 {
        match self {
            Self::Straight(p) => *p,
            Self::Oblique(space, viewer, through) => space.map.seen_at(*viewer, *through, l),
        }
    }
}

/// How far a texel looks along its ray.
#[derive(Clone, Copy)]
pub struct Tolerance {
    /// Layers before and behind the face.
    reach: f64,
    /// Neighbours that lie more layers apart are on another surface.
    jump: f64,
}

impl Tolerance {
    /// For a mesh that was simplified with boxes enlarged by `factor`.
    pub fn of(factor: f64) -> Self {
        Self { reach: factor + 2.0, jump: factor + 1.0 }
    }
}

/// A voxel that is seen, and through which of its quarters (left to right, then top to bottom).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seen {
    pub number: u32,
    pub quarter: u8,
}

impl Seen {
    /// The voxel in the colour of its quarter, if it has one.
    pub fn voxel(&self, mesh: &VoxelMesh) -> Voxel {
        let voxel = mesh.voxels[self.number as usize];
        let quarters = mesh.quarters.get(self.number as usize);
        Voxel { color: quarters.map_or(voxel.color, |q| q[usize::from(self.quarter)]), ..voxel }
    }
}

/// The voxels of a chart and of its mesh, on the rays of the viewer who sees the chart best.
pub struct Sight<'a> {
    space: &'a Space<'a>,
    /// Those that the chart's faces cover.
    own: Columns<'a>,
    whole: &'a Columns<'a>,
    /// Offset from the cell's centre; none for the reference viewpoint.
    viewer: Option<DVec3>,
    tolerance: Tolerance,
}

impl<'a> Sight<'a> {
    pub fn new(space: &'a Space<'a>, chart: &Chart, whole: &'a Columns<'a>) -> Self {
        let mesh = space.mesh;
        let mut numbers: Vec<u32> = chart.faces.iter().flat_map(|f| mesh.covered_by(*f as usize)).copied().collect();
        numbers.sort_unstable();
        numbers.dedup();
        let viewer = (chart.axis != Axis::Layer).then(|| best_corner(space, chart));
        let own = Columns::new(&mesh.voxels, numbers);
        Self { space, own, whole, viewer, tolerance: Tolerance::of(mesh.factor) }
    }

    /// The voxel that is seen at a place of the chart: one that the chart covers, or else one of the mesh.
    fn first(&self, p: DVec3) -> Option<u32> {
        let ray = self.ray(p);
        let (low, high) = (p.z - self.tolerance.reach, p.z + self.tolerance.reach);
        self.own.first(&ray, low, high).or_else(|| self.whole.first(&ray, low, high))
    }

    /// What is seen at `p` (x, y in pixels, z the layer), into `seen`, with weights: bilinear over the four nearest pixels as far as they show the
    /// same surface, or over quarters of pixels where the voxels have colours for those. Without `filter` that of the pixel itself alone. Nothing
    /// where the ray meets none.
    pub fn seen(&self, p: DVec3, filter: bool, seen: &mut Vec<(f64, Seen)>) {
        seen.clear();
        // Places to a pixel's side.
        let fine = if self.space.mesh.quarters.is_empty() { 1.0 } else { 2.0 };
        let centre = |x: f64, y: f64| dvec3(((x * fine).floor() + 0.5) / fine, ((y * fine).floor() + 0.5) / fine, p.z);
        let Some(here) = self.first(centre(p.x, p.y)) else { return };
        if !filter {
            return seen.push((1.0, Seen { number: here, quarter: self.quarter(here, p) }));
        }
        for (at, weight) in around(p.truncate(), fine) {
            self.pixel(at.extend(p.z), self.layer(here), weight, seen);
        }
    }

    /// The quarter of a voxel that the ray through `p` passes.
    fn quarter(&self, voxel: u32, p: DVec3) -> u8 {
        let at = self.ray(p).pixel(self.space.mesh.voxels[voxel as usize].layer.into());
        u8::from(at.x - at.x.floor() >= 0.5) + 2 * u8::from(at.y - at.y.floor() >= 0.5)
    }

    fn ray(&self, p: DVec3) -> Ray<'_> {
        match self.viewer {
            None => Ray::Straight(p.truncate()),
            Some(viewer) => Ray::Oblique(self.space, viewer, p),
        }
    }

    /// Adds what the pixel at `p` shows of the surface that has a voxel in layer `here`, with a total weight: its front-most voxel and those of
    /// the same object that follow it layer by layer. A steep surface shows several in a pixel, all visible from somewhere in the cell: the
    /// nearer to the chart, the more they count. What begins behind an empty layer is another surface.
    fn pixel(&self, p: DVec3, here: f64, weight: f64, seen: &mut Vec<(f64, Seen)>) {
        let Tolerance { reach, jump } = self.tolerance;
        let same = |i: &u32| (self.layer(*i) - here).abs() <= jump;
        let found = |i: u32| Seen { number: i, quarter: self.quarter(i, p) };
        let start = seen.len();
        if self.viewer.is_none() {
            let shown = |i: &u32| {
                let visible = self.space.mesh.voxels[*i as usize].ring == 0;
                visible && same(i) && (self.layer(*i) - p.z).abs() <= reach
            };
            let nearness = |i: u32| {
                let d = self.layer(i) - p.z;
                1.0 / (Axis::Layer.weight().z * d * d + EPS * EPS)
            };
            for columns in [&self.own, self.whole] {
                let mut last: Option<&Voxel> = None;
                let follows = |i: &u32| {
                    let v = &self.space.mesh.voxels[*i as usize];
                    let before = last.replace(v);
                    before.is_none_or(|b| v.layer == b.layer + 1 && v.object == b.object)
                };
                let run = columns.column(p.x, p.y).iter().copied().filter(shown).take_while(follows);
                seen.extend(run.map(|i| (nearness(i), found(i))));
                if seen.len() > start {
                    break;
                }
            }
        }
        if seen.len() == start {
            seen.extend(self.first(p).filter(same).map(|i| (1.0, found(i))));
        }
        let total: f64 = seen[start..].iter().map(|s| s.0).sum();
        seen[start..].iter_mut().for_each(|s| s.0 *= weight / total);
    }

    fn layer(&self, voxel: u32) -> f64 {
        f64::from(self.space.mesh.voxels[voxel as usize].layer)
    }
}

/// The corner of the cell that sees a chart least obliquely, as its offset from the centre.
fn best_corner(space: &Space, chart: &Chart) -> DVec3 {
    let world = |v: u32| space.map.world(space.mesh.vertices[v as usize]);
    let (mut normal, mut centre, mut area) = (DVec3::ZERO, DVec3::ZERO, 0.0);
    for f in &chart.faces {
        let [a, b, c] = space.mesh.faces[*f as usize].map(world);
        let n = (b - a).cross(c - a);
        normal += n;
        centre += (a + b + c) / 3.0 * n.length();
        area += n.length();
    }
    let centre = if area > 0.0 { centre / area } else { world(space.mesh.faces[chart.faces[0] as usize][0]) };
    let cell = space.map.cell();
    let mut best = (-1.0, DVec3::ZERO);
    for k in 0..8 {
        let sign = |bit: i32| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
        let corner = cell.half * dvec3(sign(0), sign(1), sign(2));
        let cosine = normal.dot((cell.centre + corner - centre).normalize_or_zero()).abs();
        if cosine > best.0 {
            best = (cosine, corner);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Stop;
    use crate::voxel::{reproject::Reprojection, resample::charts, testing};
    use proptest::prelude::*;

    /// Of all voxels in reach whose own pixel the ray passes in their own layer: visible ones before hidden ones, then the nearest
    /// layer.
    fn literal(mesh: &VoxelMesh, numbers: &[u32], viewer: Option<DVec3>, p: DVec3, reach: f64) -> Option<u32> {
        let slices = testing::slices();
        let map = Reprojection::of(&slices, mesh).unwrap();
        let on_ray = |i: &&u32| {
            let v = &mesh.voxels[**i as usize];
            let layer = i32::from(v.layer);
            let at = viewer.map_or(p.truncate(), |viewer| map.seen_at(viewer, p, layer));
            at.floor() == DVec2::new(f64::from(v.x), f64::from(v.y)) && (f64::from(layer) - p.z).abs() <= reach
        };
        let key = |i: &&u32| (mesh.voxels[**i as usize].ring > 0, mesh.voxels[**i as usize].layer);
        numbers.iter().filter(on_ray).min_by_key(key).copied()
    }

    /// For each of the four pixels around: the voxels of the chart, or else of the mesh, that are visible in its column within reach and near
    /// `here`, by nearness; else the first on its ray.
    fn literal_seen(mesh: &VoxelMesh, own: &[u32], viewer: Option<DVec3>, p: DVec3) -> Vec<(f64, u32)> {
        let all: Vec<u32> = (0..mesh.voxels.len() as u32).collect();
        let (reach, jump) = (mesh.factor + 2.0, mesh.factor + 1.0);
        let first = |p: DVec3| {
            let from = |numbers: &[u32]| literal(mesh, numbers, viewer, p, reach);
            from(own).or_else(|| from(&all))
        };
        let voxel = |i: u32| &mesh.voxels[i as usize];
        let layer = |i: u32| f64::from(voxel(i).layer);
        let centre = |x: f64, y: f64| dvec3(x.floor() + 0.5, y.floor() + 0.5, p.z);
        let Some(here) = first(centre(p.x, p.y)) else { return Vec::new() };
        let mut seen = Vec::new();
        for y in [-0.5, 0.5] {
            for x in [-0.5, 0.5] {
                let at = centre(p.x + x, p.y + y);
                let weight = (1.0 - (at.x - p.x).abs()) * (1.0 - (at.y - p.y).abs());
                let shown = |numbers: &[u32]| -> Vec<u32> {
                    let in_column =
                        |i: &u32| at.truncate() == DVec2::new(f64::from(voxel(*i).x), f64::from(voxel(*i).y)) + 0.5;
                    let near = |i: &u32| (layer(*i) - p.z).abs() <= reach && (layer(*i) - layer(here)).abs() <= jump;
                    let mut all: Vec<u32> =
                        numbers.iter().copied().filter(|i| in_column(i) && near(i) && voxel(*i).ring == 0).collect();
                    all.sort_by_key(|i| voxel(*i).layer);
                    let run = (1..all.len())
                        .find(|k| {
                            let (a, b) = (voxel(all[*k - 1]), voxel(all[*k]));
                            b.layer != a.layer + 1 || a.object != b.object
                        })
                        .unwrap_or(all.len());
                    all[..run].to_vec()
                };
                let mut found = if viewer.is_none() { shown(own) } else { Vec::new() };
                if found.is_empty() && viewer.is_none() {
                    found = shown(&all);
                }
                if found.is_empty() {
                    found.extend(first(at).filter(|i| (layer(*i) - layer(here)).abs() <= jump));
                }
                let nearness = |i: u32| 1.0 / ((layer(i) - p.z) * (layer(i) - p.z) / 16.0 + 1.0 / 16.0);
                let total: f64 = found.iter().map(|i| nearness(*i)).sum();
                if weight > 1e-6 {
                    seen.extend(found.iter().map(|i| (weight * nearness(*i) / total, *i)));
                }
            }
        }
        seen
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn agrees_with_looking_at_all(
            places in prop::collection::btree_set((0..6u16, 0..8u16, 0..8u16), 1..120),
            hidden in prop::collection::vec(prop::bool::weighted(0.3), 120),
            own in prop::collection::vec(prop::bool::weighted(0.5), 120),
            p in (-1.5..10.0f64, -1.5..10.0f64, -1.0..7.0f64),
            snap in any::<bool>(),
            axis in prop::sample::select(vec![Axis::X, Axis::Y, Axis::Layer]),
            factor in prop::sample::select(vec![0.0, 1.0, 2.0]),
        ) {
            let mut mesh = testing::mesh(
                vec![[1, 1, 0], [1, 31, 0], [31, 31, 5]],
                vec![[0, 1, 2]],
                places.iter().map(|&(l, y, x)| [x, y, l]),
            );
            let kind = |(v, h): (&Voxel, &bool)| Voxel { ring: u8::from(*h), object: u32::from(v.x % 5 == v.layer), ..*v };
            let voxels: Vec<Voxel> = mesh.voxels.iter().zip(&hidden).map(kind).collect();
            let own: Vec<u32> = (0..voxels.len() as u32).filter(|i| own[*i as usize]).collect();
            (mesh.voxels, mesh.factor) = (voxels.into(), factor);
            (mesh.cover_start, mesh.cover) = (vec![0, own.len() as u32].into(), own.clone().into());
            let slices = testing::slices();
            let space = Space::new(&mesh, Reprojection::of(&slices, &mesh).unwrap());
            let mut charts = charts::cut(&space, 1.0, 2, 64, &Stop::default()).unwrap();
            charts[0].axis = axis;
            let whole = Columns::new(&mesh.voxels, 0..mesh.voxels.len() as u32);
            let sight = Sight::new(&space, &charts[0], &whole);
            prop_assert_eq!(sight.viewer.is_none(), axis == Axis::Layer);
            let mut p = DVec3::from(p);
            if snap {
                p = (p * 2.0).round() / 2.0;
            }
            let (mut fast, mut sharp) = (Vec::new(), Vec::new());
            sight.seen(p, true, &mut fast);
            sight.seen(p, false, &mut sharp);
            let mut slow = literal_seen(&mesh, &own, sight.viewer, p);
            let mut fast: Vec<(f64, u32)> = fast.iter().map(|s| (s.0, s.1.number)).collect();
            fast.sort_by_key(|s| s.1);
            slow.sort_by_key(|s| s.1);
            prop_assert_eq!(fast.len(), slow.len());
            for (f, s) in fast.iter().zip(&slow) {
                prop_assert!(f.1 == s.1 && (f.0 - s.0).abs() < 1e-9, "{:?} {:?}", f, s);
            }
            prop_assert!(sharp.len() <= 1 && sharp.is_empty() == fast.is_empty());
        }
    }

    #[test]
    fn walls_are_seen_from_the_corner_on_their_side() {
        let slices = testing::slices();
        let mesh = testing::edge_on();
        let space = Space::new(&mesh, Reprojection::of(&slices, &mesh).unwrap());
        let charts = charts::cut(&space, 1.0, 2, 256, &Stop::default()).unwrap();
        // The wall lies along its own ray to the right of the centre: corners to the left and far back see it best.
        let corner = best_corner(&space, &charts[0]);
        assert_eq!(corner.x, -2.0, "{corner}");
    }
}
