//! Triangles in space.

use glam::DVec3;

/// Squared distance of `p` from a triangle (Ericson, Real-Time Collision Detection, section 5.1.5); one without area is its edges.
pub fn squared_distance([a, b, c]: [DVec3; 3], p: DVec3) -> f64 {
    let n = (b - a).cross(c - a);
    let area = n.length_squared();
    // Inside the prism over the face its plane is nearest, elsewhere one of its edges.
    let inside = area > 0.0 && [(a, b), (b, c), (c, a)].into_iter().all(|(s, e)| (e - s).cross(p - s).dot(n) >= 0.0);
    if inside {
        let d = (p - a).dot(n);
        return d * d / area;
    }
    let to_edge = |s: DVec3, e: DVec3| {
        let (d, q) = (e - s, p - s);
        let length = d.length_squared();
        let t = if length > 0.0 { (d.dot(q) / length).clamp(0.0, 1.0) } else { 0.0 };
        (q - d * t).length_squared()
    };
    to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_to_face_edge_and_corner() {
        let t = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]].map(DVec3::from);
        for (p, expected) in [
            ([1.0, 1.0, 3.0], 9.0),
            ([1.0, 1.0, 0.0], 0.0),
            ([2.0, -2.0, 0.0], 4.0),
            ([-3.0, -4.0, 0.0], 25.0),
            ([4.0, 4.0, 0.0], 8.0),
        ] {
            assert!((squared_distance(t, DVec3::from(p)) - expected).abs() < 1e-12, "{p:?}");
        }
    }
}
