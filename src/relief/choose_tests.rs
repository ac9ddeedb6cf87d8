//! The strategies against slow searches and each other.

use super::{
    choose::{Perturbation, greedy, perturb},
    entropy::{Probe, Seen},
    entropy_tests::cube,
};
use crate::{
    math::Stop,
    raster::{Cpu, Geometry, tests::scene},
    scene::Scene,
    view::directions,
};
use glam::DVec3;

const IDS: u32 = 128;

fn with_probe<R>(scene: &Scene, work: impl FnOnce(&Probe) -> R) -> R {
    let geometry = Geometry::new(scene);
    let points = scene.points();
    work(&Probe::new(&Cpu, &geometry, &points, IDS).unwrap())
}

/// The score by its definition, of a direction in the lattice that `perturb` walks on: its neighbours are 2° away.
fn literal_score(probe: &Probe, regular: DVec3, [q, r]: [i32; 2], stability: f64) -> f64 {
    let stop = Stop::default();
    let (x, y) = regular.any_orthonormal_pair();
    let at = |q: i32, r: i32| {
        let (u, v) = (2.0 * (f64::from(q) + 0.5 * f64::from(r)), 3.0_f64.sqrt() * f64::from(r));
        let angle = (u * u + v * v).sqrt();
        if angle == 0.0 {
            return regular;
        }
        let (s, c) = (libm::sin(angle.to_radians()), libm::cos(angle.to_radians()));
        (regular * c + (x * u + y * v) / angle * s).normalize()
    };
    let dense = |d: DVec3| {
        let mut areas = vec![0.0; probe.face_count() as usize];
        probe.sight(d, &stop).unwrap().faces.iter().for_each(|f| areas[f.0 as usize] = f64::from(f.1));
        areas
    };
    let own = dense(at(q, r));
    let background = 1.0 - own.iter().sum::<f64>();
    let entropy = -own.iter().chain([&background]).filter(|p| **p > 0.0).map(|p| p * libm::log2(*p)).sum::<f64>();
    let mut revealed = 0.0;
    for (dq, dr) in [(1, 0), (0, 1), (-1, 1), (-1, 0), (0, -1), (1, -1)] {
        let other = dense(at(q + dq, r + dr));
        revealed += own.iter().zip(&other).filter(|(a, _)| **a == 0.0).map(|(_, b)| b).sum::<f64>() / 6.0;
    }
    entropy - stability * revealed
}

#[test]
fn moved_directions_score_as_the_definition_says_and_no_worse_than_regular_ones() {
    let car = crate::scene::builtin::make("car", 1).unwrap();
    let regular = directions::icosahedron();
    for stability in [0.0, 10.0] {
        with_probe(&car, |probe| {
            let moved = perturb(probe, &regular, Perturbation { reach: 4.0, stability }, &Stop::default()).unwrap();
            assert!(moved.iter().all(|m| m.scores[1] >= m.scores[0] && !m.blank));
            assert!(moved.iter().filter(|m| m.scores[1] > m.scores[0]).count() > 10);
            for (m, d) in moved.iter().zip(&regular).take(4) {
                assert!(m.direction.dot(*d) >= libm::cos(4.0001_f64.to_radians()));
                let places =
                    (-2_i32..=2).flat_map(|q| (-2_i32..=2).map(move |r| [q, r])).filter(|[q, r]| (q + r).abs() <= 2);
                let all: Vec<f64> = places.map(|p| literal_score(probe, *d, p, stability)).collect();
                assert_eq!(all.len(), 19);
                assert!((literal_score(probe, *d, [0, 0], stability) - m.scores[0]).abs() < 2e-3);
                let best = all.iter().copied().fold(f64::MIN, f64::max);
                assert!(m.scores[1] <= best + 2e-3 && all.iter().any(|s| (s - m.scores[1]).abs() < 2e-3));
            }
        });
    }
}

#[test]
fn without_reach_nothing_moves() {
    let regular = directions::icosahedron();
    with_probe(&scene(cube()), |probe| {
        let how = Perturbation { reach: 0.0, stability: 10.0 };
        let moved = perturb(probe, &regular, how, &Stop::default()).unwrap();
        assert!(moved.iter().zip(&regular).all(|(m, d)| m.direction == *d && m.scores[0] == m.scores[1]));
    });
}

#[test]
fn two_greedy_directions_show_the_whole_cube() {
    with_probe(&scene(cube()), |probe| {
        let found = greedy(probe, &directions::geodesic(2), 2, &Stop::default()).unwrap();
        assert_eq!((found.seen, found.chosen.len(), found.blank.len()), (12, 2, 0));
        // More than there is to see: all count again, and no direction is taken twice.
        let mut many = greedy(probe, &directions::geodesic(1), 100, &Stop::default()).unwrap().chosen;
        many.sort();
        assert_eq!(many, (0..80).collect::<Vec<_>>());
    });
}

#[test]
fn greedy_shows_more_than_the_best_on_their_own() {
    let car = crate::scene::builtin::make("car", 1).unwrap();
    let candidates = directions::geodesic(2);
    with_probe(&car, |probe| {
        let stop = Stop::default();
        let sights: Vec<_> = candidates.iter().map(|d| probe.sight(*d, &stop).unwrap()).collect();
        let mut order: Vec<usize> = (0..candidates.len()).collect();
        order.sort_by(|a, b| sights[*b].entropy().total_cmp(&sights[*a].entropy()));
        for n in [3, 8] {
            let mut top = Seen::none(probe.face_count());
            order[..n].iter().for_each(|i| top.add(&sights[*i]));
            let found = greedy(probe, &candidates, n, &stop).unwrap();
            assert!(found.seen > top.count(), "{n}: {} {}", found.seen, top.count());
            // Each choice is the best at its time.
            let mut seen = vec![false; probe.face_count() as usize];
            for i in &found.chosen {
                let gain = |i: usize| -> f64 {
                    let new = sights[i].faces.iter().filter(|f| !seen[f.0 as usize]);
                    new.map(|f| -f64::from(f.1) * libm::log2(f64::from(f.1))).sum()
                };
                let own = gain(*i);
                assert!((0..candidates.len()).all(|j| gain(j) <= own + 1e-4));
                sights[*i].faces.iter().for_each(|f| seen[f.0 as usize] = true);
            }
        }
    });
}
