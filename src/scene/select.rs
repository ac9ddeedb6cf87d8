//! Part of a scene, by name, place and distance.

use super::Scene;
use crate::math::Aabb;
use glam::DVec3;

/// What to keep: objects that pass every condition.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// Patterns of names, one of which must match: `*` is any text, `?` any one character.
    pub include: Vec<String>,
    /// Patterns of names, none of which may match.
    pub exclude: Vec<String>,
    /// The object's bounds must touch this box.
    pub region: Option<Aabb>,
    /// The distance of the object's bounds from a box (metres, 0 where they touch): at least the first, less than the second.
    pub distance: Option<(Aabb, f64, f64)>,
}

impl Default for Selection {
    fn default() -> Self {
        Self { include: vec!["*".into()], exclude: Vec::new(), region: None, distance: None }
    }
}

/// No triangle is selected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no triangle of the scene's {objects} objects is selected{hint}")]
pub struct NothingSelected {
    pub objects: usize,
    /// Names near to what was asked for, or why nothing is left.
    pub hint: String,
}

/// The selected part of `scene`. Objects outside leave no trace in it.
pub fn select(scene: &Scene, selection: &Selection) -> Result<Scene, NothingSelected> {
    let named = |name: &str| {
        selection.include.iter().any(|p| matches(p, name)) && !selection.exclude.iter().any(|p| matches(p, name))
    };
    let placed = |bounds: Aabb| {
        selection.region.is_none_or(|r| r.overlaps(&bounds))
            && selection.distance.is_none_or(|(from, least, most)| (least..most).contains(&distance(&from, &bounds)))
    };
    let by_place = selection.region.is_some() || selection.distance.is_some();
    let mut found_by_name = 0;
    let keep = scene.objects.iter().filter(|o| o.triangle_count() > 0 && named(&o.name));
    let keep = keep.inspect(|_| found_by_name += 1).filter(|o| !by_place || placed(o.bounds()));
    let objects: Vec<_> = keep.cloned().collect();
    if !objects.is_empty() {
        return Ok(Scene { objects });
    }
    let hint = if found_by_name > 0 {
        format!("; {found_by_name} have the right name, but none the right place")
    } else {
        let names = nearest(scene, &selection.include);
        if names.is_empty() { String::new() } else { format!("; the nearest names are {}", names.join(", ")) }
    };
    Err(NothingSelected { objects: scene.objects.len(), hint })
}

/// Smallest distance between two boxes.
fn distance(a: &Aabb, b: &Aabb) -> f64 {
    (a.min - b.max).max(b.min - a.max).max(DVec3::ZERO).length()
}

/// Whether `pattern` describes the whole of `text`.
pub fn matches(pattern: &str, text: &str) -> bool {
    let (p, t): (Vec<char>, Vec<char>) = (pattern.chars().collect(), text.chars().collect());
    let (mut i, mut j) = (0, 0);
    // Where the last star was, and how much of the text it has swallowed: only the last one need be tried again.
    let mut star: Option<(usize, usize)> = None;
    while j < t.len() {
        match p.get(i) {
            Some('*') => {
                star = Some((i, j));
                i += 1;
            }
            Some(c) if *c == '?' || *c == t[j] => {
                i += 1;
                j += 1;
            }
            _ => match &mut star {
                Some((at, swallowed)) => {
                    *swallowed += 1;
                    (i, j) = (*at + 1, *swallowed);
                }
                None => return false,
            },
        }
    }
    p[i..].iter().all(|c| *c == '*')
}

/// Up to five names of the scene that are nearest to one of the patterns.
fn nearest(scene: &Scene, patterns: &[String]) -> Vec<String> {
    let plain: Vec<String> = patterns.iter().map(|p| p.replace(['*', '?'], "")).collect();
    let score = |name: &str| plain.iter().map(|p| edits(p, name)).min().unwrap_or(0);
    let mut names: Vec<_> = scene.objects.iter().map(|o| (score(&o.name), &o.name)).collect();
    names.sort();
    names.into_iter().take(5).map(|(_, name)| format!("`{name}`")).collect()
}

/// Edits that turn one text into the other (Levenshtein), of their first 64 characters.
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().take(64).collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().take(64).enumerate() {
        let mut corner = std::mem::replace(&mut row[0], i + 1);
        for (j, y) in b.iter().enumerate() {
            let change = corner + usize::from(x != *y);
            corner = row[j + 1];
            row[j + 1] = change.min(corner + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Mesh, Object, Part};
    use glam::Mat4;
    use proptest::prelude::*;
    use std::sync::Arc;

    fn row(names: &[&str]) -> Scene {
        let mesh = Arc::new(Mesh {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].into(),
            triangles: vec![[0, 1, 2]].into(),
            ..Mesh::default()
        });
        let object = |(i, name): (usize, &&str)| Object {
            name: name.to_string(),
            transform: Mat4::from_translation(glam::vec3(10.0 * i as f32, 0.0, 0.0)),
            parts: vec![Part { mesh: mesh.clone(), material: Arc::default() }],
        };
        Scene { objects: names.iter().enumerate().map(object).collect() }
    }

    fn names(scene: &Scene, selection: &Selection) -> Vec<String> {
        select(scene, selection).unwrap().objects.into_iter().map(|o| o.name).collect()
    }

    #[test]
    fn names_places_and_distances() {
        let scene = row(&["Root/House.001", "Root/House.002", "Root/Tree", "Terrain"]);
        let all = Selection::default();
        assert_eq!(names(&scene, &all).len(), 4);
        let houses = Selection { include: vec!["*House*".into()], ..all.clone() };
        assert_eq!(names(&scene, &houses), ["Root/House.001", "Root/House.002"]);
        let not = Selection { exclude: vec!["Root/*".into()], ..all.clone() };
        assert_eq!(names(&scene, &not), ["Terrain"]);
        let at = |x: f64| Aabb { min: DVec3::new(x, 0.0, 0.0), max: DVec3::new(x, 1.0, 1.0) };
        assert_eq!(names(&scene, &Selection { region: Some(at(11.0)), ..all.clone() }), ["Root/House.002"]);
        // Distances 0, 8, 18, 28 m from x = 1..2.
        let from = Aabb { min: DVec3::X, max: DVec3::X * 2.0 };
        let far = Selection { distance: Some((from, 8.0, 28.0)), ..all };
        assert_eq!(names(&scene, &far), ["Root/House.002", "Root/Tree"]);
    }

    #[test]
    fn nothing_selected_names_the_nearest() {
        let scene = row(&["Root/House.001", "Root/House.002", "Root/Tree", "Terrain", "a", "b", "c"]);
        let ask = |s: &str| select(&scene, &Selection { include: vec![s.into()], ..Selection::default() }).unwrap_err();
        let text = ask("Terain").to_string();
        assert!(
            text.starts_with("no triangle of the scene's 7 objects is selected; the nearest names are `Terrain`, "),
            "{text}"
        );
        assert_eq!(text.matches('`').count(), 10);
        let nowhere = Aabb { min: DVec3::splat(1e6), max: DVec3::splat(2e6) };
        let none = select(&scene, &Selection { region: Some(nowhere), ..Selection::default() }).unwrap_err();
        assert_eq!(none.hint, "; 7 have the right name, but none the right place");
        assert!(select(&Scene::default(), &Selection::default()).is_err());
    }

    #[test]
    fn what_is_outside_leaves_no_trace() {
        let scene = row(&["in", "out"]);
        let mut moved = scene.clone();
        moved.objects[1].transform = Mat4::from_translation(glam::Vec3::Y);
        let selection = Selection { include: vec!["in".into()], ..Selection::default() };
        assert_eq!(select(&scene, &selection), select(&moved, &selection));
    }

    /// Patterns by the letter of their definition.
    fn slow(p: &[char], t: &[char]) -> bool {
        match (p, t) {
            ([], []) => true,
            (['*', rest @ ..], _) => slow(rest, t) || (!t.is_empty() && slow(p, &t[1..])),
            (['?', rest @ ..], [_, tail @ ..]) => slow(rest, tail),
            ([a, rest @ ..], [b, tail @ ..]) => a == b && slow(rest, tail),
            _ => false,
        }
    }

    proptest! {
        #[test]
        fn patterns(p in "[ab?*]{0,8}", t in "[ab]{0,10}") {
            let (pc, tc): (Vec<char>, Vec<char>) = (p.chars().collect(), t.chars().collect());
            prop_assert_eq!(matches(&p, &t), slow(&pc, &tc));
        }

        #[test]
        fn edits_are_a_distance(a in "[abc]{0,8}", b in "[abc]{0,8}", c in "[abc]{0,8}") {
            prop_assert_eq!(edits(&a, &a), 0);
            prop_assert_eq!(edits(&a, &b), edits(&b, &a));
            prop_assert!(edits(&a, &c) <= edits(&a, &b) + edits(&b, &c));
            prop_assert!(edits(&a, &b) >= a.len().abs_diff(b.len()));
        }
    }
}
