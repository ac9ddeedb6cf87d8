//! What every number of a certificate means: text, unit, which direction is better, which picture shows it.
//!
//! The table is keyed by the number's path in the certificate (members separated by dots). Pipelines' requirements are checked
//! against it, failed ones are explained by it, and the certificate carries it.

use serde::Serialize;
use std::sync::LazyLock;

/// Which direction of a measure is the better one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Better {
    Higher,
    Lower,
    /// The number describes what was compared and judges nothing.
    Neither,
}

/// What makes a measure better.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Helps {
    /// A higher resolution, less simplification.
    Finer,
    /// A lower resolution, more simplification.
    Coarser,
    Nothing,
}

/// One number of a certificate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Measure {
    /// Such as `crack_px.ratio`.
    pub path: String,
    /// One line.
    pub about: String,
    /// Such as `px`, `dB`; empty for plain ratios and counts.
    pub unit: &'static str,
    pub better: Better,
    /// Name of the picture that shows it, without folder and extension.
    pub picture: Option<&'static str>,
    pub helps: Helps,
}

/// Every number of a certificate that a pipeline can require something of, by path.
pub fn measures() -> &'static [Measure] {
    static ALL: LazyLock<Vec<Measure>> = LazyLock::new(|| {
        let mut all: Vec<Measure> = GROUPS.iter().flat_map(Group::measures).collect();
        let compared = GROUPS.iter().filter(|g| g.of_ceiling).flat_map(Group::measures);
        let ceiling: Vec<Measure> = compared
            .map(|m| Measure {
                path: format!("ceiling.{}", m.path),
                about: format!("of the mesh before simplification: {}", m.about),
                picture: None,
                ..m
            })
            .collect();
        all.extend(ceiling);
        for (mode, words) in MODES {
            let of_mode = OF_MODES.iter().flat_map(Group::measures);
            all.extend(of_mode.map(|m| Measure {
                path: format!("{mode}.{}", m.path),
                about: format!("{words}: {}", m.about),
                ..m
            }));
        }
        all.sort_by(|a, b| a.path.cmp(&b.path));
        all
    });
    &ALL
}

/// The measure at `path`.
pub fn measure(path: &str) -> Option<&'static Measure> {
    let all = measures();
    all.binary_search_by(|m| m.path.as_str().cmp(path)).ok().map(|i| &all[i])
}

/// Numbers of one measure: `path.part` for each part.
struct Group {
    path: &'static str,
    parts: &'static [Part],
    about: &'static str,
    unit: &'static str,
    better: Better,
    picture: Option<&'static str>,
    /// The ceiling has it too.
    of_ceiling: bool,
}

#[derive(Clone, Copy)]
enum Part {
    /// The group is a number itself.
    Itself,
    Mean,
    Min,
    Max,
    Total,
    Ratio,
}

impl Group {
    fn measures(&self) -> impl Iterator<Item = Measure> {
        self.parts.iter().map(|part| {
            let (name, of, unit) = match part {
                Part::Itself => ("", "", self.unit),
                Part::Mean => (".mean", "; mean over the views", self.unit),
                Part::Min => (".min", "; in the worst view", self.unit),
                Part::Max => (".max", "; in the worst view", self.unit),
                Part::Total => (".total", "; all views together", self.unit),
                Part::Ratio => (".ratio", "; over the original's covered pixels, all views together", ""),
            };
            Measure {
                path: format!("{}{name}", self.path),
                about: format!("{}{of}", self.about),
                unit,
                better: self.better,
                picture: self.picture,
                helps: match self.better {
                    Better::Neither => Helps::Nothing,
                    _ if COSTS.contains(&self.path) => Helps::Coarser,
                    _ => Helps::Finer,
                },
            }
        })
    }
}

/// What a stand-in costs: less of it is less detail.
const COSTS: [&str; 8] = [
    "triangles",
    "triangles_per_view",
    "draw_calls",
    "texels",
    "bytes",
    "memory_bytes",
    "overdraw.opaque",
    "overdraw.transparent",
];

const MIN: &[Part] = &[Part::Mean, Part::Min];
const MAX: &[Part] = &[Part::Mean, Part::Max];
const COUNT: &[Part] = &[Part::Mean, Part::Max, Part::Ratio];
const ONE: &[Part] = &[Part::Itself];

/// A measure of the comparison, which the ceiling has too.
const fn compared(
    path: &'static str,
    parts: &'static [Part],
    unit: &'static str,
    better: Better,
    picture: Option<&'static str>,
    about: &'static str,
) -> Group {
    Group { path, parts, about, unit, better, picture, of_ceiling: true }
}

/// A number of the stand-in, the original or the comparison as a whole.
const fn single(
    path: &'static str,
    parts: &'static [Part],
    unit: &'static str,
    better: Better,
    about: &'static str,
) -> Group {
    Group { path, parts, about, unit, better, picture: None, of_ceiling: false }
}

/// Ways to draw a stand-in that certificates tell apart, see [`super::modes`].
pub const MODES: [(&str, &str); 2] =
    [("static", "drawn with its static meshes"), ("view_dependent", "drawn with meshes made for each view")];

/// Numbers of each way to draw.
const OF_MODES: &[Group] = &[
    single("triangles_per_view", MAX, "", Better::Lower, "triangles that are drawn"),
    single("references_per_view", MAX, "", Better::Neither, "reference views that take part"),
    single("psnr_y_object_db", MIN, "dB", Better::Higher, "likeness of brightness over the object's pixels"),
    single("floor_px", COUNT, "px", Better::Lower, "pixels whose surface no reference view saw"),
    single("missing_px", COUNT, "px", Better::Lower, "holes, away from edges"),
    single("missing_px.with_edges_ratio", ONE, "", Better::Lower, "holes; over the original's covered pixels"),
    single(
        "missing_px.without_floor",
        COUNT,
        "px",
        Better::Lower,
        "holes where a reference view saw the surface, away from edges",
    ),
    single(
        "missing_px.without_floor_with_edges_ratio",
        ONE,
        "",
        Better::Lower,
        "holes where a reference view saw the surface; over the original's covered pixels",
    ),
    single("wrong_surface_px", COUNT, "px", Better::Lower, "a surface behind the right one shows, away from edges"),
    single(
        "wrong_surface_px.with_edges_ratio",
        ONE,
        "",
        Better::Lower,
        "a surface behind the right one shows; over the original's covered pixels",
    ),
    single(
        "wrong_surface_px.without_floor",
        COUNT,
        "px",
        Better::Lower,
        "a surface behind the right one shows where a reference view saw that, away from edges",
    ),
    single(
        "wrong_surface_px.without_floor_with_edges_ratio",
        ONE,
        "",
        Better::Lower,
        "a surface behind the right one shows where a reference view saw that; over the original's covered pixels",
    ),
];

const GROUPS: &[Group] = &[
    compared(
        "psnr_y_db",
        MIN,
        "dB",
        Better::Higher,
        Some("worst-psnr"),
        "likeness of brightness over the whole picture (PSNR of luminance; 100 means equal)",
    ),
    compared(
        "psnr_y_object_db",
        MIN,
        "dB",
        Better::Higher,
        Some("worst-psnr"),
        "likeness of brightness over the object's pixels (PSNR of luminance; 100 means equal)",
    ),
    compared(
        "ssim",
        MIN,
        "",
        Better::Higher,
        Some("worst-psnr"),
        "likeness of local structure over the whole picture (SSIM; 1 means equal)",
    ),
    compared(
        "ssim_object",
        MIN,
        "",
        Better::Higher,
        Some("worst-psnr"),
        "likeness of local structure over the object's pixels (SSIM; 1 means equal)",
    ),
    compared(
        "missing_px",
        COUNT,
        "px",
        Better::Lower,
        Some("worst-missing"),
        "holes: the original is there, the stand-in is not; away from edges",
    ),
    compared(
        "extra_px",
        COUNT,
        "px",
        Better::Lower,
        Some("worst-extra"),
        "the stand-in is there, the original is not; away from edges",
    ),
    compared(
        "wrong_surface_px",
        COUNT,
        "px",
        Better::Lower,
        Some("worst-wrong-surface"),
        "a surface behind the right one shows through; away from edges",
    ),
    compared(
        "in_front_px",
        COUNT,
        "px",
        Better::Lower,
        Some("worst-in-front"),
        "something of the stand-in stands before the right surface; away from edges",
    ),
    compared(
        "crack_px",
        &[Part::Total, Part::Ratio],
        "px",
        Better::Lower,
        Some("worst-crack"),
        "cracks: thin gaps in a surface that is whole in the original",
    ),
    compared(
        "lost_detail_px",
        COUNT,
        "px",
        Better::Lower,
        Some("worst-lost-detail"),
        "detail that vanished: the original is there, and the stand-in has nothing at that depth within the band's width",
    ),
    compared(
        "lost_detail_px.band_ratio",
        ONE,
        "",
        Better::Lower,
        Some("worst-lost-detail"),
        "detail that vanished at edges and thin parts; over the original's covered pixels, all views together",
    ),
    compared(
        "band.px",
        ONE,
        "px",
        Better::Neither,
        None,
        "half width of the band around the original's edges, in which a method may move outlines",
    ),
    compared(
        "band.differing_ratio",
        ONE,
        "",
        Better::Lower,
        Some("worst-psnr"),
        "pixels at edges that differ in any way; over the original's covered pixels, all views together",
    ),
    compared(
        "band.share",
        ONE,
        "",
        Better::Neither,
        None,
        "pixels at edges; over the original's covered pixels, all views together",
    ),
    compared(
        "band.missing_px",
        COUNT,
        "px",
        Better::Lower,
        Some("worst-missing"),
        "holes at edges: the original is there, the stand-in is not",
    ),
    compared(
        "band.extra_px",
        COUNT,
        "px",
        Better::Lower,
        Some("worst-extra"),
        "the stand-in is there, the original is not; at edges",
    ),
    compared(
        "band.wrong_surface_px",
        COUNT,
        "px",
        Better::Lower,
        Some("worst-wrong-surface"),
        "a surface behind the right one shows; at edges",
    ),
    compared(
        "band.in_front_px",
        COUNT,
        "px",
        Better::Lower,
        Some("worst-in-front"),
        "something of the stand-in stands before the right surface; at edges",
    ),
    compared(
        "max_deviation_px",
        ONE,
        "px",
        Better::Lower,
        Some("worst-deviation"),
        "the farthest that any pixel of an outline moved; whether the bound holds is `bound.held`",
    ),
    compared(
        "back_facing_px",
        MAX,
        "px",
        Better::Lower,
        None,
        "the stand-in shows the back of a single-sided material, which engines do not draw",
    ),
    compared("covered_px", MAX, "px", Better::Neither, None, "pixels that the original covers"),
    single(
        "flip.mean",
        ONE,
        "",
        Better::Lower,
        "visible difference as a person flips between the pictures (FLIP; 0 means equal); mean over the views of lowest PSNR",
    ),
    single(
        "flip.max",
        ONE,
        "",
        Better::Lower,
        "visible difference as a person flips between the pictures (FLIP; 0 means equal); in the worst view",
    ),
    single("flip.views", ONE, "", Better::Neither, "views in which FLIP was measured"),
    single(
        "overdraw.opaque",
        ONE,
        "",
        Better::Lower,
        "surfaces that a covered pixel of the stand-in draws one over the other, hidden ones included; over the views of lowest PSNR",
    ),
    single(
        "overdraw.transparent",
        ONE,
        "",
        Better::Lower,
        "surfaces that the alpha test discards, for each covered pixel of the stand-in; over the views of lowest PSNR",
    ),
    single("overdraw.views", ONE, "", Better::Neither, "views in which overdraw was counted"),
    single("triangles", ONE, "", Better::Lower, "triangles of the stand-in"),
    single("original_triangles", ONE, "", Better::Neither, "triangles of the original"),
    single("draw_calls", ONE, "", Better::Lower, "draw calls of the stand-in: one for each mesh and material"),
    single(
        "original_draw_calls",
        ONE,
        "",
        Better::Neither,
        "draw calls of the original: one for each mesh and material of each object",
    ),
    single("texels", ONE, "", Better::Lower, "texels of the stand-in's textures, base levels"),
    single("original_texels", ONE, "", Better::Neither, "texels of the original's textures, base levels"),
    single("bytes", ONE, "bytes", Better::Lower, "size of the stand-in's file"),
    single(
        "memory_bytes",
        ONE,
        "bytes",
        Better::Lower,
        "vertices, indices and uncompressed texels of the stand-in in a renderer's memory",
    ),
    single(
        "original_memory_bytes",
        ONE,
        "bytes",
        Better::Neither,
        "vertices, indices and uncompressed texels of the original in a renderer's memory",
    ),
    single("views", ONE, "", Better::Neither, "views that were measured, the corners of the cell first"),
    single("bound.value", ONE, "px", Better::Neither, "how far the method means to move an outline at most"),
    single("ceiling.triangles", ONE, "", Better::Neither, "triangles of the mesh before simplification"),
    single("ceiling.views", ONE, "", Better::Neither, "views in which the ceiling was measured"),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_unique_and_every_measure_says_what_it_is() {
        assert!(measures().windows(2).all(|m| m[0].path < m[1].path));
        for m in measures() {
            assert!(m.about.len() > 10 && !m.about.contains('\n'), "{}", m.path);
            assert_eq!(measure(&m.path), Some(m));
        }
        assert_eq!(measure("crack_px.ratio").unwrap().better, Better::Lower);
        assert_eq!(measure("ceiling.psnr_y_object_db.mean").unwrap().unit, "dB");
        assert!(measure("psnr_y_objct_db.mean").is_none() && measure("crack_px").is_none());
    }
}
