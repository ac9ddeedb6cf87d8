//! Procedural scenes with a seed: what examples, tests and benchmarks bake without any file.
//!
//! Same name and seed, same bytes: the only randomness is [`Random`], and no platform function takes part.

mod car;
mod city;
pub mod park;
mod random;
mod shape;
mod solids;
mod texture;

pub use random::Random;
pub use solids::closed_box;

use super::Scene;

/// Names that [`make`] knows.
pub const NAMES: [&str; 4] = ["car", "city", "park", "solids"];

/// The procedural scene `name` grown from `seed`; `None` for a name that is not in [`NAMES`].
pub fn make(name: &str, seed: u64) -> Option<Scene> {
    let mut scene = match name {
        "car" => car::car(),
        "city" => city::city(seed),
        "park" => park::park(seed),
        "solids" => solids::solids(),
        _ => return None,
    };
    scene.objects.sort_by(|a, b| a.name.cmp(&b.name));
    Some(scene)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn size(scene: &Scene) -> [f64; 3] {
        scene.bounds().size().to_array()
    }

    #[test]
    fn the_city_has_the_papers_size_and_count() {
        let city = make("city", 1).unwrap();
        let n = city.triangle_count();
        assert!((157_000..161_000).contains(&n), "{n} triangles, the paper's model has 158,944");
        assert!(city.objects.len() > 400);
        let s = size(&city);
        assert!((s[0] - 450.0).abs() < 1.0 && (s[2] - 450.0).abs() < 1.0 && (s[1] - 50.0).abs() < 1.0, "{s:?}");
    }

    #[test]
    fn the_car_has_the_papers_size_and_count() {
        let car = make("car", 1).unwrap();
        let n = car.triangle_count();
        assert!((1_130..1_250).contains(&n), "{n} triangles, the paper's model has 1,188");
        let s = size(&car);
        assert!((s[0] - 4.7).abs() < 0.05 && (s[1] - 1.5).abs() < 0.05 && (s[2] - 1.8).abs() < 0.05, "{s:?}");
    }

    #[test]
    fn names_are_unique_and_sorted_and_seeds_matter() {
        for name in NAMES {
            let scene = make(name, 1).unwrap();
            let names: Vec<_> = scene.objects.iter().map(|o| o.name.as_str()).collect();
            assert_eq!(names.iter().collect::<BTreeSet<_>>().len(), names.len());
            assert!(names.is_sorted());
            assert_eq!(scene, make(name, 1).unwrap());
        }
        assert_ne!(make("city", 1), make("city", 2));
        assert_ne!(make("park", 1), make("park", 2));
    }

    #[test]
    fn solids_are_closed() {
        for object in make("solids", 1).unwrap().objects {
            let mut edges = std::collections::BTreeMap::new();
            for part in &object.parts {
                let key = |i: u32| part.mesh.positions[i as usize].map(f32::to_bits);
                for t in part.mesh.triangles.iter() {
                    for k in 0..3 {
                        *edges.entry((key(t[k]), key(t[(k + 1) % 3]))).or_insert(0) += 1;
                    }
                }
            }
            assert!(edges.iter().all(|((a, b), n)| edges.get(&(*b, *a)) == Some(n)), "{} is open", object.name);
        }
    }
}
