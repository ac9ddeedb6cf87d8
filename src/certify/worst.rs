//! The view in which each measure is worst, and which pictures are made of it.

use super::{
    certificate::{Camera, WorstView},
    figures::rounded,
    measure::ViewFigures,
};
use std::collections::BTreeMap;

/// What a picture draws attention to: its zoomed part is where most such pixels lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Focus {
    /// Any pixel that is not right.
    Wrong,
    Missing,
    Extra,
    WrongSurface,
    InFront,
    Crack,
    Lost,
}

/// A picture to be made.
#[derive(Clone, Debug, PartialEq)]
pub struct Wanted {
    pub view: usize,
    pub name: &'static str,
    /// The measure that it shows, and its value in this view.
    pub title: String,
    pub focus: Focus,
}

/// Views that see something, the worst by PSNR over the object first.
pub fn by_psnr(figures: &[ViewFigures]) -> Vec<usize> {
    let mut seen: Vec<(usize, f64)> =
        figures.iter().enumerate().filter_map(|(i, f)| Some((i, f.psnr_object?))).collect();
    seen.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
    seen.into_iter().map(|(i, _)| i).collect()
}

type Key = fn(&ViewFigures) -> (u64, u64);

/// Measure, picture, its words, what it shows, and pixels outside and inside the band; those inside decide where there are none outside.
const COUNTS: [(&str, &str, &str, Focus, Key); 6] = [
    ("missing_px", "worst-missing", "most holes", Focus::Missing, |f| {
        (f.counts.outside.missing, f.counts.inside.missing)
    }),
    ("extra_px", "worst-extra", "most extra", Focus::Extra, |f| (f.counts.outside.extra, f.counts.inside.extra)),
    ("wrong_surface_px", "worst-wrong-surface", "most of a wrong surface", Focus::WrongSurface, |f| {
        (f.counts.outside.wrong_surface, f.counts.inside.wrong_surface)
    }),
    ("in_front_px", "worst-in-front", "most in front", Focus::InFront, |f| {
        (f.counts.outside.in_front, f.counts.inside.in_front)
    }),
    ("crack_px", "worst-crack", "most cracks", Focus::Crack, |f| (f.counts.crack, 0)),
    ("lost_detail_px", "worst-lost-detail", "most lost detail", Focus::Lost, |f| {
        (f.counts.outside.lost + f.counts.inside.lost, 0)
    }),
];

/// The worst view of each measure, and the pictures: one for each measure that found something, and `typical`, the view of
/// median PSNR over the object. `by_psnr` is [`by_psnr`]'s.
pub fn worst_views(
    figures: &[ViewFigures],
    by_psnr: &[usize],
    camera: impl Fn(usize) -> Camera,
) -> (BTreeMap<&'static str, WorstView>, Vec<Wanted>) {
    let mut worst = BTreeMap::new();
    let mut pictures = Vec::new();
    let mut add = |measure: &'static str, value: f64, wanted: Wanted, bad: bool| {
        let picture = bad.then(|| wanted.name.to_owned());
        let view = wanted.view;
        let camera = camera(view);
        worst.insert(measure, WorstView { value: rounded(value, 3), view: view as u32, camera, picture });
        if bad {
            pictures.push(wanted);
        }
    };
    if let Some(view) = by_psnr.first().copied() {
        let value = figures[view].psnr_object.unwrap_or_default();
        let wanted = Wanted { view, name: "worst-psnr", title: "least alike".into(), focus: Focus::Wrong };
        add("psnr_y_object_db", value, wanted, true);
    }
    for (measure, name, words, focus, key) in COUNTS {
        // Of equals the first.
        let (mut view, mut most) = (0, (0, 0));
        for (i, f) in figures.iter().enumerate() {
            if key(f) > most {
                (view, most) = (i, key(f));
            }
        }
        let title = match most {
            (0, inside) => format!("{words}: {inside} px, all at edges"),
            (outside, 0) => format!("{words}: {outside} px"),
            (outside, inside) => format!("{words}: {outside} px, and {inside} px at edges"),
        };
        add(measure, most.0 as f64, Wanted { view, name, title, focus }, most != (0, 0));
    }
    let (mut view, mut most) = (0, 0.0);
    for (i, f) in figures.iter().enumerate() {
        if f.max_deviation > most {
            (view, most) = (i, f.max_deviation);
        }
    }
    let title = format!("farthest displacement: {most:.1} px");
    let focus = if figures[view].counts.inside.lost + figures[view].counts.outside.lost > 0 {
        Focus::Lost
    } else {
        Focus::Wrong
    };
    add("max_deviation_px", most, Wanted { view, name: "worst-deviation", title, focus }, most > 0.0);
    if let Some(view) = by_psnr.get(by_psnr.len() / 2) {
        pictures.push(Wanted { view: *view, name: "typical", title: "typical view".into(), focus: Focus::Wrong });
    }
    (worst, pictures)
}
