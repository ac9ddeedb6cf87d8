//! Where the sampling layers and their borders lie (Jeschke and Wimmer 2002, section 4.1).
//!
//! Two rules hold for every point of the cell and every direction of the frusta: neighbouring sampling layers never
//! move by more than a pixel against each other (*movement*), and a point is never seen farther than the angle α from
//! its projection onto its sampling layer (*parallax*). All distances are planar depths from the cell's centre, metres.
//!
//! Parallax is bounded in closed form. Seen from V a point at depth z moves, per metre of depth along its ray d, by
//! |q×V|·cos ψ / (z·(z − V_z)) radians, with q the unit vector from V to the point and ψ its angle to the axis. Over all
//! directions |q×V|·cos ψ is at most K = (|V| + ρ)/2, ρ the lateral part of V, reached halfway between the axis and the
//! normal of V (22.5° in the paper's 2D case); K/(z·(z − V_z)) is largest at the front corners of the cell. Integrated
//! from s to b, A(s, b) = K/az · (φ(s) − φ(b)) with φ(z) = −ln(1 − az/z). This is exact for thin layers in a frustum that
//! contains the worst direction, at most about a tenth too large in narrow ones (where movement is the tighter rule by
//! far), never too small, and every step of the iteration becomes a formula.

use glam::DVec3;

/// What one frustum demands of the layers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// az: the cell's half extent along the frustum's axis.
    pub az: f64,
    /// The larger of ax + t·az over the two lateral directions, t the window's largest tangent there.
    pub sway: f64,
    /// K = (|V| + ρ)/2 of a front corner V.
    pub k: f64,
}

impl Reach {
    /// `half`: the cell's half extents along the frustum's right, up and forward; `t`: the window's largest |tangent|
    /// to the right and up.
    pub fn new(half: DVec3, t: [f64; 2]) -> Self {
        let lateral = (half.x * half.x + half.y * half.y).sqrt();
        Self {
            az: half.z,
            sway: (half.x + t[0] * half.z).max(half.y + t[1] * half.z),
            k: (half.length() + lateral) * 0.5,
        }
    }

    /// One demand that implies both.
    pub fn union(self, o: Self) -> Self {
        Self { az: self.az.max(o.az), sway: self.sway.max(o.sway), k: self.k.max(o.k) }
    }

    /// P(F): the least distance of a layer that moves by at most `pixel` (in tangents) against layer F.
    /// With ax = az = m and pixel = 2·tan(FOV/2)/RES this is equation (1).
    pub fn movement(&self, f: f64, pixel: f64) -> f64 {
        f * self.sway / (self.sway + pixel * (f - self.az))
    }

    /// A(s, b): no point between s and b is seen farther from its projection onto s, radians; b may be infinite.
    pub fn parallax(&self, s: f64, b: f64) -> f64 {
        self.k / self.az * (self.phi(s) - self.phi(b)).abs()
    }

    /// φ(z), descending from infinity at az to 0 at infinity.
    fn phi(&self, z: f64) -> f64 {
        -libm::log1p(-self.az / z)
    }

    /// The depth at which φ has a value > 0.
    fn depth(&self, phi: f64) -> f64 {
        self.az / -libm::expm1(-phi)
    }

    /// The depth halfway between two depths as parallax counts.
    fn middle(&self, a: f64, b: f64) -> f64 {
        self.depth((self.phi(a) + self.phi(b)) * 0.5)
    }
}

/// Placed layers, nearest first; see [`Slices`](super::Slices).
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    pub layers: Vec<f64>,
    pub borders: Vec<f64>,
}

/// What layers are placed for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    pub reach: Reach,
    /// Size of a pixel in tangents.
    pub pixel: f64,
    /// α: the parallax that is allowed, radians.
    pub alpha: f64,
    /// The nearest border, > az.
    pub near: f64,
    /// The farthest border, > near; may be infinite.
    pub far: f64,
}

impl Placement {
    /// Places layers from far to near. `None` where more than `max_layers` would be needed.
    pub fn place(&self, max_layers: usize) -> Option<Layers> {
        let Self { reach, near, far, .. } = *self;
        debug_assert!(near > reach.az && far > near && self.alpha > 0.0 && self.pixel > 0.0);
        // α in units of φ.
        let step = self.alpha * reach.az / reach.k;
        // A layer that would lie at or in front of the near border moves back to the middle of what is left:
        // nearer to its farther neighbour and border, so every bound still holds.
        let behind_near = |s: f64, far: f64| if s > near { s } else { reach.middle(near, far) };

        let mut s = behind_near(reach.depth(reach.phi(far) + step), far);
        let (mut layers, mut borders) = (vec![s], vec![far]);
        loop {
            // b': how far the layer's own parallax allows it to reach towards the cell.
            let nearest = reach.depth(reach.phi(s) + step);
            if nearest <= near {
                break;
            }
            if layers.len() == max_layers {
                return None;
            }
            let q = reach.depth(reach.phi(nearest) + step);
            let next = behind_near(reach.movement(s, self.pixel).max(q), nearest);
            borders.push(reach.middle(next, s));
            layers.push(next);
            s = next;
        }
        borders.push(near);
        layers.reverse();
        borders.reverse();
        (layers.len() <= max_layers && strictly_ascending(&layers, &borders)).then_some(Layers { layers, borders })
    }
}

/// False where layers are so close that their distances no longer differ as numbers.
fn strictly_ascending(layers: &[f64], borders: &[f64]) -> bool {
    layers.iter().enumerate().all(|(l, s)| borders[l] < *s && *s < borders[l + 1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The paper's settings: a cubic cell of half side m, a model that begins `gap` behind the cell's front, is `depth`
    /// deep and as wide as the frustum where it begins.
    fn paper(m: f64, gap: f64, width: f64, depth: f64) -> Placement {
        let near = gap + m;
        let t = width * 0.5 / near;
        let pixel = 2.0 * t / 1024.0;
        Placement {
            reach: Reach::new(DVec3::splat(m), [t, t]),
            pixel,
            alpha: pixel * near / (near - m),
            near,
            far: near + depth,
        }
    }

    #[test]
    fn counts_of_the_papers_scenes() {
        // Layers that are spaced by movement alone number RES·(ax + t·az)/(2t·az)·ln((F−az)/F), taken from near to far:
        // 33.4 and 169.5. Where a count is cut to whole layers, parallax decides: the outermost layers reach out by it.
        for (name, p, by_movement, expect) in
            [("city", paper(21.0, 487.0, 450.0, 450.0), 33.4, 33), ("car", paper(31.5, 73.0, 4.7, 1.8), 169.5, 169)]
        {
            let Reach { az, sway, .. } = p.reach;
            let n = sway / (p.pixel * az) * libm::log((p.far - az) / p.far * p.near / (p.near - az));
            assert!((n - by_movement).abs() < 0.1, "{name}: {n}");
            assert_eq!(p.place(4096).unwrap().layers.len(), expect, "{name}");
        }
    }

    #[test]
    fn movement_is_equation_1_for_a_cube() {
        for (m, t, f, res) in [(21.0, 0.44, 700.0, 1024.0), (2.0, 1.0, 5.0, 512.0), (0.5, 0.02, 90.0, 64.0)] {
            let p = (t + 1.0) * f / (1.0 + t * (1.0 + 2.0 * (f - m) / (res * m)));
            let ours = Reach::new(DVec3::splat(m), [t, t]).movement(f, 2.0 * t / res);
            assert!((ours - p).abs() < 1e-9 * p, "{ours} {p}");
        }
    }

    #[test]
    fn the_last_border_may_be_infinite() {
        let p = Placement { far: f64::INFINITY, ..paper(21.0, 487.0, 450.0, 450.0) };
        let placed = p.place(4096).unwrap();
        assert_eq!(placed.borders.last(), Some(&f64::INFINITY));
        assert!(placed.layers.last().unwrap().is_finite());
    }

    #[test]
    fn too_many_layers_are_refused() {
        let p = paper(31.5, 73.0, 4.7, 1.8);
        let n = p.place(4096).unwrap().layers.len();
        assert_eq!(p.place(n).unwrap().layers.len(), n);
        assert_eq!(p.place(n - 1), None);
    }

    fn placements() -> impl Strategy<Value = (DVec3, [f64; 2], Placement)> {
        let half = (0.1..2.0f64, 0.1..2.0f64, 0.1..2.0f64);
        (half, 0.02..1.5f64, 0.02..1.5f64, 1.5..30.0f64, 1.001..20.0f64, 16..300u32, 0.6..1.0f64, any::<bool>())
            .prop_map(|((ax, ay, az), tx, ty, near, deep, res, alpha, infinite)| {
                let half = DVec3::new(ax, ay, az);
                let near = near * az;
                let pixel = 2.0 * tx.max(ty) / res as f64;
                let alpha = alpha * pixel * near / (near - az);
                let far = if infinite { f64::INFINITY } else { near * deep };
                (half, [tx, ty], Placement { reach: Reach::new(half, [tx, ty]), pixel, alpha, near, far })
            })
    }

    /// A point of the cell: corners for the first numbers, then anything.
    fn viewpoint(half: DVec3, corner: u32, at: [f64; 3]) -> DVec3 {
        if corner < 8 {
            let sign = |bit: u32| if corner & bit == 0 { -1.0 } else { 1.0 };
            DVec3::new(sign(1), sign(2), sign(4)) * half
        } else {
            (DVec3::from(at) * 2.0 - 1.0) * half
        }
    }

    proptest! {
        #[test]
        fn parallax_and_movement_are_kept(
            (half, t, p) in placements(),
            samples in prop::collection::vec((0..16u32, prop::array::uniform3(0.0..1.0f64), -1.0..1.0f64, -1.0..1.0f64, 0.0..1.0f64), 200),
        ) {
            let Some(placed) = p.place(5000) else { return Ok(()) };
            let (layers, borders) = (&placed.layers, &placed.borders);
            prop_assert_eq!((borders[0], borders[layers.len()]), (p.near, p.far));
            for (i, (corner, at, u, w, f)) in samples.into_iter().enumerate() {
                let v = viewpoint(half, corner, at);
                let d = DVec3::new(u * t[0], w * t[1], 1.0);
                let l = i % layers.len();
                let (from, to) = (borders[l], borders[l + 1].min(layers[l] * 1e4));
                for z in [from, to, from + f * (to - from)] {
                    let (a, b) = (d * z - v, d * layers[l] - v);
                    let angle = libm::atan2(a.cross(b).length(), a.dot(b));
                    prop_assert!(angle <= p.alpha * (1.0 + 1e-9), "layer {} of {}: {} > {}", l, layers.len(), angle, p.alpha);
                }
                if l > 0 {
                    // Where the ray from V through a point of layer l meets layer l − 1, against that point's own pixel.
                    let (near, far) = (layers[l - 1], layers[l]);
                    let meet = v + (d * far - v) * ((near - v.z) / (far - v.z));
                    let moved = (meet - d * near).truncate() / near;
                    prop_assert!(moved.abs().max_element() <= p.pixel * (1.0 + 1e-9));
                }
            }
        }

        #[test]
        fn no_layer_is_idle((_, _, p) in placements()) {
            let Some(placed) = p.place(5000) else { return Ok(()) };
            // Every layer but the nearest lies as near as one of the two rules allows.
            let step = p.alpha * p.reach.az / p.reach.k;
            for l in 1..placed.layers.len().saturating_sub(1) {
                let (near, s) = (placed.layers[l], placed.layers[l + 1]);
                let by_movement = p.reach.movement(s, p.pixel);
                let by_parallax = p.reach.depth(p.reach.phi(s) + 2.0 * step);
                prop_assert!((near - by_movement.max(by_parallax)).abs() <= 1e-9 * near);
            }
        }
    }
}
