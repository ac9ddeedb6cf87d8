//! Whether a triangle meets a box around the origin (separating axes; Akenine-Möller 2001).

use glam::DVec3;

/// True where the triangle and the box of half extents `half` have more than their surfaces in common.
pub fn triangle_meets_box(t: &[DVec3; 3], half: DVec3) -> bool {
    let edges = [t[1] - t[0], t[2] - t[1], t[0] - t[2]];
    let apart = |axis: DVec3| {
        let reach = axis.abs().dot(half);
        let d = t.map(|p| p.dot(axis));
        let (least, most) = (d[0].min(d[1]).min(d[2]), d[0].max(d[1]).max(d[2]));
        // An axis of no length separates nothing.
        reach > 0.0 && (least >= reach || most <= -reach)
    };
    !(DVec3::AXES.into_iter().any(apart)
        || apart(edges[0].cross(edges[1]))
        || edges.iter().any(|e| DVec3::AXES.iter().any(|a| apart(a.cross(*e)))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::Polygon;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = DVec3> {
        prop::array::uniform3(-3.0..3.0f64).prop_map(DVec3::from)
    }

    proptest! {
        #[test]
        fn agrees_with_clipping(a in point(), b in point(), c in point()) {
            let half = DVec3::new(0.5, 1.0, 0.8);
            let clip = |half: DVec3| {
                let mut p = Polygon::triangle([a, b, c]);
                for axis in DVec3::AXES {
                    p.clip(|p| half.dot(axis) - p.dot(axis));
                    p.clip(|p| half.dot(axis) + p.dot(axis));
                }
                !p.corners().is_empty()
            };
            let meets = triangle_meets_box(&[a, b, c], half);
            prop_assert!(!meets || clip(half * (1.0 + 1e-6)));
            prop_assert!(meets || !clip(half * (1.0 - 1e-6)));
        }
    }

    #[test]
    fn touching_is_not_meeting() {
        let t = [DVec3::new(1.0, -5.0, -5.0), DVec3::new(1.0, 5.0, -5.0), DVec3::new(1.0, 0.0, 5.0)];
        assert!(!triangle_meets_box(&t, DVec3::ONE));
        assert!(triangle_meets_box(&t, DVec3::splat(1.01)));
    }
}
