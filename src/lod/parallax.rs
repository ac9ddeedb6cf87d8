//! The space in which collapses are measured: pixels of the centre's picture, and pixels of parallax.
//!
//! A point at (x, y, z) in the axes of the centre's camera goes to (f·x/z, f·y/z, f·c/z), f being the focal length in pixels and c the cell's radius. The
//! third number is how far the point moves in the picture when the eye moves by c across. So the distance between two points of this space is about how far
//! apart, in pixels, the cell can see them; moving a surface by less than a pixel there moves no pixel of any picture by more. The map is
//! projective: planes stay planes, so quadrics are exact. The third extent of an object is the self-occluding error of section 3.1.2 up to its constant.

use crate::view::View;
use glam::DVec3;

/// Where `p` lies in that space. The third number falls with depth, so what is seen from the front has a normal with positive z. `None` behind the camera.
pub fn parallax(view: &View, p: DVec3, focal: f64, c: f64) -> Option<DVec3> {
    let d = p - view.eye;
    let z = d.dot(view.forward);
    (z > 0.0).then(|| DVec3::new(d.dot(view.right), d.dot(view.up), c) * (focal / z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Sequence;

    fn view() -> View {
        View::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1.0, 64, 64, 0.1, 100.0)
    }

    #[test]
    fn distances_hold_in_every_picture_of_the_cell() {
        let (view, focal, c) = (view(), 500.0, 2.0);
        let sequence = Sequence::<3>::new(4);
        for i in 0..300 {
            let u = sequence.point(i);
            let p = DVec3::new(u[0] - 0.5, u[1] - 0.5, -15.0 - 5.0 * u[2]);
            let q = p + (DVec3::from(sequence.point(i + 1000)) - 0.5) * 0.3;
            let apart = parallax(&view, p, focal, c).unwrap().distance(parallax(&view, q, focal, c).unwrap());
            let eye = (DVec3::from(sequence.point(i + 2000)) - 0.5) * 2.0 * (c / 3.0_f64.sqrt());
            let moved = View { eye, ..view };
            let on = |p: DVec3| parallax(&moved, p, focal, 0.0).unwrap().truncate();
            let seen = on(p).distance(on(q));
            // The eye's own motion towards the points enlarges all by c/(z − c).
            assert!(seen <= apart * 2.0_f64.sqrt() * (1.0 + 2.0 * c / 15.0), "{seen} {apart}");
        }
    }

    #[test]
    fn planes_stay_planes_and_fronts_fronts() {
        let at = |x: f64, y: f64, z: f64| parallax(&view(), DVec3::new(x, y, z), 300.0, 1.0).unwrap();
        let [a, b, c] = [at(0.0, 0.0, -5.0), at(1.0, 0.0, -6.0), at(0.0, 1.0, -7.0)];
        let d = at(0.25, 0.25, -5.75);
        let n = (b - a).cross(c - a);
        assert!(n.normalize().dot(d - a).abs() < 1e-9 && n.z > 0.0);
        assert_eq!(parallax(&view(), DVec3::Z, 300.0, 1.0), None);
    }
}
