//! What a cell's stand-ins are of: which objects are drawn as they are, and which share a mesh made from one or from several views
//! (Chen et al. 2003, sections 3.1.2 and 3.1.6).

use super::{
    cluster::{Cluster, Rect, cluster},
    occlusion::{Distance, Estimate, self_occluding_error},
    outline::Outline,
    weights::{Window, Windows},
    window::{WindowCamera, focal, window},
};
use crate::view::{Prism, View};
use glam::{DAffine3, DVec3};

/// An object in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// Object to world.
    pub transform: DAffine3,
    /// In world space; `None` where it has no faces.
    pub outline: Option<Outline>,
    pub triangles: u64,
}

/// How objects are told apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Classifying {
    /// Pixels along a side of pictures that show 60°.
    pub image_res: f64,
    /// T_s: the largest hole of a single-view mesh, pixels.
    pub t_s: f64,
    pub estimate: Estimate,
    pub clusters: bool,
}

/// How many views a mesh is made from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Views {
    /// SVMesh: the cell's centre.
    Single,
    /// MVMesh: the centres of the cell and of its neighbours.
    Multi,
}

/// What one stand-in of a cell is made of. All coordinates are about the cell's centre.
#[derive(Clone, Debug, PartialEq)]
pub struct Subject {
    /// Objects by name, each with its place.
    pub members: Vec<(String, DAffine3)>,
    pub views: Views,
    /// The cell, its centre at the origin.
    pub cell: Prism,
    /// Around the members.
    pub outline: Outline,
    /// Pixels per unit of the tangent.
    pub focal: f64,
    /// What it is captured with, and where that camera stands: first at the cell's centre, then at neighbours'. More than one for
    /// [`Views::Multi`] only.
    pub cameras: Vec<(DVec3, WindowCamera)>,
}

impl Subject {
    /// The windows of its cameras, which were captured in their order, about the cell's centre.
    ///
    /// # Errors
    /// Where they are those of other cameras.
    pub fn windows<'a>(&self, captured: impl ExactSizeIterator<Item = &'a Window>) -> Result<Windows, OtherWindows> {
        if captured.len() != self.cameras.len() {
            return Err(OtherWindows::Number { expected: self.cameras.len(), found: captured.len() });
        }
        let placed = |(window, (eye, camera)): (&Window, &(DVec3, WindowCamera))| {
            let view = View { eye: *eye, ..window.view };
            (window.view == camera.view).then(|| Window { view, ..window.clone() }).ok_or(OtherWindows::Camera)
        };
        captured.zip(&self.cameras).map(placed).collect::<Result<_, _>>().map(Windows)
    }
}

/// Windows were captured with other cameras than those of the subject.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OtherWindows {
    #[error("`windows` are not those of `stand_in`: expected {expected}, found {found}")]
    Number { expected: usize, found: usize },
    #[error("`windows` are not those of `stand_in`: they have other cameras")]
    Camera,
}

/// A cell's objects.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Classified {
    /// Drawn as they are: they reach into the cell, or are so near that a picture from its centre cannot hold them.
    pub inside: Vec<String>,
    /// By name, sorted.
    pub subjects: Vec<(String, Subject)>,
}

/// Tells the objects of a scene apart for `cell`. `objects` are sorted by name; `neighbours` are the centres of the neighbouring cells.
pub fn classify(cell: &Prism, neighbours: &[DVec3], objects: &[(String, &Placement)], how: &Classifying) -> Classified {
    let local = Prism { centre: DVec3::ZERO, ..*cell };
    let focal = focal(how.image_res);
    let passes = |o: &Outline| {
        let at = Distance { c: local.radius(), d: o.nearest(), l: o.depth() };
        self_occluding_error(at, how.image_res, how.estimate) < how.t_s
    };
    let mut out = Classified::default();
    let (mut single, mut multi) = (Vec::new(), Vec::new());
    for (i, (name, placement)) in objects.iter().enumerate() {
        let Some(outline) = placement.outline.as_ref().map(|o| o.about(cell.centre)) else { continue };
        let near = outline.meets(&local) || outline.nearest() <= local.radius();
        if near || window(&outline, DVec3::ZERO, focal).is_none() {
            out.inside.push(name.clone());
        } else if passes(&outline) {
            single.push((i, outline));
        } else {
            let rect = Rect::of(&outline, focal);
            multi.push(Cluster { members: vec![i], outline, rect });
        }
    }
    let outlines: Vec<Outline> = single.iter().map(|s| s.1.clone()).collect();
    let may = |o: &Outline| how.clusters && passes(o) && window(o, DVec3::ZERO, focal).is_some();
    let mut singles = cluster(&outlines, focal, &may);
    for c in &mut singles {
        c.members.iter_mut().for_each(|m| *m = single[*m].0);
    }
    for (views, c) in
        singles.into_iter().map(|c| (Views::Single, c)).chain(multi.into_iter().map(|c| (Views::Multi, c)))
    {
        let about = |centre: DVec3| -> Vec<(String, DAffine3)> {
            let member = |m: &usize| {
                let (name, placement) = &objects[*m];
                let mut transform = placement.transform;
                transform.translation -= centre;
                (name.clone(), transform)
            };
            c.members.iter().map(member).collect()
        };
        let members = about(cell.centre);
        // From the objects' places in the world, so that all cells that look from one point have the same cameras.
        let camera = |centre: DVec3, outline: &Outline| {
            let view = window(outline, DVec3::ZERO, focal)?;
            Some((centre - cell.centre, WindowCamera { members: about(centre), view }))
        };
        let around = neighbours.iter().filter_map(|centre| match (views, &objects[c.members[0]].1.outline) {
            // One object: clusters have one view.
            (Views::Multi, Some(outline)) => camera(*centre, &outline.about(*centre)),
            _ => None,
        });
        let cameras = camera(cell.centre, &c.outline).into_iter().chain(around).collect();
        let mut name = members[0].0.clone();
        if let more @ 1.. = members.len() - 1 {
            name = format!("{name}+{more}");
            // An object may have that name.
            while objects.binary_search_by(|o| o.0.cmp(&name)).is_ok() {
                name.push('+');
            }
        }
        out.subjects.push((name, Subject { members, views, cell: local, outline: c.outline, focal, cameras }));
    }
    out.subjects.sort_by(|a, b| a.0.cmp(&b.0));
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::HexGrid;
    use glam::DVec2;

    fn at(x: f64, z: f64, half: f64) -> Placement {
        let plan = [(-half, -half), (half, -half), (half, half), (-half, half)];
        let plan = plan.iter().map(|(a, b)| DVec2::new(x + a, z + b)).collect();
        let transform = DAffine3::from_translation(DVec3::new(x, 0.0, z));
        Placement { transform, outline: Some(Outline { plan, low: 0.0, high: 2.0 * half }), triangles: 12 }
    }

    const HOW: Classifying = Classifying { image_res: 1024.0, t_s: 5.0, estimate: Estimate::Bound, clusters: true };

    fn classified(objects: &[(&str, Placement)], how: &Classifying) -> Classified {
        let grid = HexGrid { origin: DVec3::Y, size: 50.0, half_height: 1.0, columns: 9, rows: 9 };
        let (cell, around) = (grid.cell(4, 4), grid.neighbours(4, 4));
        let centres: Vec<DVec3> = around.iter().map(|(c, r)| grid.cell(*c, *r).centre).collect();
        let moved: Vec<(String, Placement)> = objects
            .iter()
            .map(|(n, p)| {
                let o = p.outline.as_ref().map(|o| o.about(DVec3::new(-cell.centre.x, 0.0, -cell.centre.z)));
                let mut transform = p.transform;
                transform.translation += cell.centre - DVec3::Y;
                ((*n).to_owned(), Placement { transform, outline: o, ..p.clone() })
            })
            .collect();
        let lent: Vec<(String, &Placement)> = moved.iter().map(|(n, p)| (n.clone(), p)).collect();
        classify(&cell, &centres, &lent, how)
    }

    #[test]
    fn near_objects_stay_far_ones_have_one_view() {
        let objects = [
            ("a", at(0.0, 0.0, 5.0)),
            ("b", at(100.0, 0.0, 20.0)),
            ("c", at(2000.0, 0.0, 5.0)),
            ("d", at(53.0, 0.0, 4.0)),
            ("e", at(-2000.0, 30.0, 5.0)),
        ];
        let found = classified(&objects, &HOW);
        assert_eq!(found.inside, ["a", "d"]);
        let views = |n: &str| found.subjects.iter().find(|s| s.0 == n).map(|s| (s.1.views, s.1.cameras.len()));
        // Some neighbours stand too near to the object, or in it.
        assert!(matches!(views("b"), Some((Views::Multi, 3..=7))), "{:?}", views("b"));
        assert_eq!((views("c"), views("e")), (Some((Views::Single, 1)), Some((Views::Single, 1))));
        let strict = classified(&objects, &Classifying { t_s: 0.0, ..HOW });
        assert!(strict.subjects.iter().all(|s| s.1.views == Views::Multi));
    }

    #[test]
    fn clusters_are_named_by_their_first_member() {
        let objects = [
            ("far", at(2010.0, 1.0, 5.0)),
            ("near", at(1990.0, 0.0, 5.0)),
            ("none", Placement { outline: None, ..at(0.0, 0.0, 1.0) }),
        ];
        let found = classified(&objects, &HOW);
        assert_eq!(found.subjects.iter().map(|s| s.0.as_str()).collect::<Vec<_>>(), ["far+1"]);
        let named = [("far", objects[0].1.clone()), ("far+1", at(0.0, 2500.0, 5.0)), ("near", objects[1].1.clone())];
        let names: Vec<String> = classified(&named, &HOW).subjects.into_iter().map(|s| s.0).collect();
        assert_eq!(names, ["far+1", "far+1+"]);
        let alone = classified(&objects, &Classifying { clusters: false, ..HOW });
        assert_eq!(alone.subjects.len(), 2);
        assert_eq!(found.subjects[0].1.members[1].1.translation, DVec3::new(1990.0, -1.0, 0.0));
    }
}
