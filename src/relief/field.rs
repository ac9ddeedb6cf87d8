//! A relief map made ready for rays.

use super::{ReliefMap, pyramid::Pyramid};
use glam::{DMat3, DVec3, DVec4, Vec3};

/// What rays ask of a texel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Texel {
    /// Depth in texel sides from the near plane; infinite without surface.
    pub depth: f32,
    /// Above 0 where there is a surface. Between two centres, the surface ends where the linear interpolation of this is 0.
    pub edge: f32,
}

/// A height field in texel units: u to the right, v down from the top left corner of the map, w away from its camera, all in sides of a
/// texel. Texel (i, j) has its centre at (i + ½, j + ½).
#[derive(Clone, Debug)]
pub struct Field {
    /// From world space to texel units: offset first, then rotation and scale.
    eye: DVec3,
    axes: DMat3,
    /// Texels along a side.
    pub side: u32,
    /// Extent in w.
    pub deep: f32,
    pub(super) texels: Vec<Texel>,
    pub(super) pyramid: Pyramid,
    /// Columns and rows with a surface and those beside them: lowest u and v, highest u and v.
    pub(super) window: [f32; 4],
    /// The direction from the object towards the map's camera, world space.
    pub towards: DVec3,
    /// Side of a texel, metres.
    pub texel: f64,
}

/// A ray in texel units of a [`Field`]: points `origin + t·direction`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    pub origin: Vec3,
    pub direction: Vec3,
}

/// The value of [`Texel::edge`] at a surface.
const INSIDE: f32 = 0.5;

impl Field {
    pub fn new(map: &ReliefMap, wall: f32) -> Self {
        let texel = map.texel();
        let view = &map.view;
        let side = map.side();
        let levels = map.bits.levels();
        let deep = (view.far - view.near) / texel;
        let step = deep / f64::from(levels - 1);
        let texels: Vec<Texel> = map
            .depth
            .iter()
            .map(|code| match u32::from(*code) {
                code if code < levels => Texel { depth: (f64::from(code) * step) as f32, edge: INSIDE },
                code => Texel { depth: f32::INFINITY, edge: outside(map.bits.codes() - 1 - code) },
            })
            .collect();
        let half = f64::from(side) * 0.5;
        let window = match view.projection {
            crate::view::Projection::Orthographic { left, right, bottom, top }
            | crate::view::Projection::Perspective { left, right, bottom, top } => {
                DVec3::new((left + right) * 0.5, (bottom + top) * 0.5, 0.0)
            }
        };
        let middle = view.right * window.x + view.up * window.y;
        let eye = view.eye + middle + view.forward * view.near - (view.right - view.up) * (half * texel);
        let axes = DMat3::from_cols(view.right, -view.up, view.forward).transpose() * (1.0 / texel);
        let mut used = [side, side, 0, 0];
        for (i, t) in texels.iter().enumerate().filter(|(_, t)| t.edge > 0.0) {
            let (x, y) = (i as u32 % side, i as u32 / side);
            debug_assert!(t.depth.is_finite());
            used = [used[0].min(x), used[1].min(y), used[2].max(x + 1), used[3].max(y + 1)];
        }
        // Surfaces reach less than a texel beyond the centre of theirs.
        let n = side as f32;
        let [x0, y0, x1, y1] = used.map(|v| v as f32);
        let window = [(x0 - 0.5).max(0.0), (y0 - 0.5).max(0.0), (x1 + 0.5).min(n), (y1 + 0.5).min(n)];
        let mut field = Self {
            eye,
            axes,
            side,
            deep: deep as f32,
            texels,
            pyramid: Pyramid::default(),
            window,
            towards: -view.forward,
            texel,
        };
        field.pyramid = Pyramid::new(&field, wall);
        field
    }

    /// A point of world space in texel units.
    pub fn point(&self, p: DVec3) -> Vec3 {
        (self.axes * (p - self.eye)).as_vec3()
    }

    /// A point in texel units in world space.
    pub fn world(&self, p: Vec3) -> DVec3 {
        // The axes are orthogonal, each as long as a texel's side has sides in a metre.
        self.eye + self.axes.transpose() * p.as_dvec3() * (self.texel * self.texel)
    }

    /// Rows whose products with (x, y, z, 1) are the u, v and w of a point that lies at (x, y, z) from `centre`, in the axes of world space.
    pub fn rows(&self, centre: DVec3) -> [DVec4; 3] {
        let at = self.axes * (centre - self.eye);
        [0, 1, 2].map(|k| self.axes.row(k).extend(at[k]))
    }

    /// Least u and v, then greatest u and v that surfaces have.
    pub fn window(&self) -> [f32; 4] {
        self.window
    }

    /// Least and greatest depth of the surfaces in squares of 2^l cells a side, level l by level, row by row, as `shaders/ori.wgsl` reads them: a level has
    /// half as many squares along a side as the one before, level 0 the least power of two that is not below [`Field::side`]. Without surface the first is the
    /// greater.
    pub fn ranges(&self) -> impl Iterator<Item = [f32; 2]> {
        self.pyramid.ranges()
    }

    /// A ray of world space in texel units; lengths along it are those of the world: t stays t.
    pub fn ray(&self, origin: DVec3, direction: DVec3) -> Ray {
        Ray { origin: self.point(origin), direction: (self.axes * direction).as_vec3() }
    }
}

/// The edge value of a texel without surface whose code is `from_last` below the last one.
fn outside(from_last: u32) -> f32 {
    let reach = (from_last as f32 + 0.5) / super::REACHES as f32;
    -INSIDE * (1.0 - reach) / reach
}
