//! What a certificate says, read as plain JSON: whatever a method's certificate lacks is left out.

use super::{Certificate, Cost, Series, Unit, pictures::Panels};
use serde_json::Value;

/// A measure that a certificate may give for every view: its name there, title, unit, whether higher is better.
const SERIES: [(&str, &str, &str, bool); 17] = [
    ("psnr_y_object_db", "Likeness over the object", "dB", true),
    ("psnr_y_db", "Likeness over the picture", "dB", true),
    ("ssim_object", "Likeness of structure (SSIM)", "", true),
    ("missing_px", "Holes", "px", false),
    ("wrong_surface_px", "A surface behind shows", "px", false),
    ("lost_detail_px", "Lost detail", "px", false),
    ("crack_px", "Cracks", "px", false),
    ("in_front_px", "Sticks out in front", "px", false),
    ("extra_px", "Beyond the outline", "px", false),
    ("max_deviation_px", "Farthest displacement", "px", false),
    ("coverage_error", "Missing, as a share of the picture", "", false),
    ("missing", "Missing", "px", false),
    ("extra", "Extra", "", false),
    ("hole_px", "Widest hole", "px", false),
    ("triangles", "Triangles in view", "", false),
    ("texels", "Texels in view", "", false),
    ("bytes", "Bytes in view", "", false),
];

/// Costs by the names of their numbers: of the original, of the stand-in.
const COSTS: [(&str, Unit, &str, &str); 10] = [
    ("Triangles", Unit::Count, "original_triangles", "triangles"),
    ("Draw calls", Unit::Count, "original_draw_calls", "draw_calls"),
    ("Texels", Unit::Count, "original_texels", "texels"),
    ("Memory, uncompressed", Unit::Bytes, "original_memory_bytes", "memory_bytes"),
    ("Files of the stand-in", Unit::Bytes, "", "bytes"),
    ("Triangles in view, mean", Unit::Count, "original_triangles_per_frame.avg", "triangles_per_frame.avg"),
    ("Triangles of a cell, mean", Unit::Count, "cells.original_triangles", "cells.triangles_avg"),
    ("Texels of a cell, mean", Unit::Count, "", "cells.texels_avg"),
    ("Geometry of a cell, mean", Unit::Bytes, "", "cells.glb_bytes_avg"),
    ("Textures of a cell, mean", Unit::Bytes, "", "cells.texture_bytes_avg"),
];

/// The pictures that are shown first, and their titles where the certificate gives none.
const PICTURES: [(&str, &str); 12] = [
    ("worst-psnr", "Least alike"),
    ("worst-missing", "Most holes"),
    ("worst-wrong-surface", "Most of a surface behind"),
    ("worst-crack", "Most cracks"),
    ("worst-lost-detail", "Most lost detail"),
    ("worst-in-front", "Most in front"),
    ("worst-extra", "Most beyond the outline"),
    ("worst-deviation", "Farthest displacement"),
    ("typical", "Typical"),
    ("middle", "In the middle of the walk"),
    ("coverage-front", "Coverage, from the front"),
    ("coverage-back", "Coverage, from behind"),
];

/// The certificate in the file `path` below the output folder, without figures and pictures.
pub fn read(path: &str, json: &Value) -> Certificate {
    let text = |name: &str| json.get(name).and_then(Value::as_str);
    let mut certificate = Certificate {
        path: path.to_owned(),
        verdict: text("verdict").map(str::to_owned),
        sentence: text("sentence").unwrap_or_default().to_owned(),
        costs: costs(json),
        ..Certificate::default()
    };
    for (set, of) in [("", "views"), ("directions", "directions"), ("others", "other directions")] {
        let Some(all) = (if set.is_empty() { Some(json) } else { json.get(set) }) else { continue };
        if let Some(Value::Object(lists)) = all.get("per_view") {
            let numbers = |name: &str| Some(lists.get(name)?.as_array()?.iter().filter_map(Value::as_f64).collect());
            certificate.series.extend(series(of, numbers));
        }
    }
    if let Some(Value::Array(frames)) = json.get("per_frame") {
        let numbers = |name: &str| {
            let values: Vec<f64> = frames.iter().filter_map(|f| f.get(name)?.as_f64()).collect();
            (!values.is_empty()).then_some(values)
        };
        certificate.series.extend(series("frames", numbers));
    }
    certificate
}

fn series(of: &'static str, numbers: impl Fn(&str) -> Option<Vec<f64>>) -> Vec<Series> {
    let one = |(name, title, unit, higher_is_better): &(&str, &str, &'static str, bool)| {
        let values = numbers(name).filter(|v| !v.is_empty())?;
        // A walk counts pixels, other methods give their share.
        let unit = if of == "frames" && *name == "extra" { "px" } else { unit };
        let title = if of.starts_with("other") { format!("{title}, {of}") } else { (*title).to_owned() };
        Some(Series { title, unit, higher_is_better: *higher_is_better, values, of })
    };
    SERIES.iter().filter_map(one).collect()
}

fn costs(json: &Value) -> Vec<Cost> {
    let number = |path: &str| path.split('.').try_fold(json, |v, name| v.get(name))?.as_f64();
    let one = |(what, unit, before, after): &(&'static str, Unit, &str, &str)| {
        Some(Cost { what, unit: *unit, before: number(before), after: number(after)? })
    };
    // A number without an original beside it may mean anything in another method's certificate.
    COSTS.iter().filter(|c| c.3 != "triangles" || number(c.2).is_some()).filter_map(one).collect()
}

/// A picture that a certificate speaks of.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    pub name: String,
    pub title: String,
    /// Its view and camera, for people.
    pub place: String,
    pub panels: Option<Panels>,
}

/// The pictures of these names, the most telling first; before all those in `missed`.
pub fn pictures(json: &Value, names: &[&str], missed: &[String]) -> Vec<Picture> {
    let mut all: Vec<Picture> = names.iter().map(|name| picture(json, name)).collect();
    let rank = |p: &Picture| {
        let place = PICTURES.iter().position(|(name, _)| *name == p.name).unwrap_or(PICTURES.len());
        (!missed.contains(&p.name), place)
    };
    all.sort_by(|a, b| rank(a).cmp(&rank(b)).then_with(|| a.name.cmp(&b.name)));
    all
}

fn picture(json: &Value, name: &str) -> Picture {
    let worst = json.get("worst_view").and_then(Value::as_object).into_iter().flatten();
    let mut of_this = worst.filter(|(_, w)| w.get("picture").and_then(Value::as_str) == Some(name));
    let known = PICTURES.iter().find(|p| p.0 == name).map_or(name, |p| p.1);
    let (mut title, mut place) = (known.to_owned(), String::new());
    if let Some((measure, worst)) = of_this.next() {
        let unit = SERIES.iter().find(|s| s.0 == measure).map_or("", |s| s.2);
        match worst.get("value").and_then(Value::as_f64) {
            Some(0.0) => title += ": at edges only",
            Some(value) => title += &format!(": {}", super::numbers::amount(value, unit)),
            None => {}
        }
        place = camera(worst, json.get("views").and_then(Value::as_u64));
    }
    let panels = json.get("panels").and_then(|p| p.get(name));
    let panels = panels.and_then(|p| serde_json::from_value(p.clone()).ok());
    Picture { name: name.to_owned(), title, place, panels }
}

/// `View 5 of 64, from (0, 2, 300) m towards (0, 0, -1), 45°`.
fn camera(worst: &Value, views: Option<u64>) -> String {
    let triple = |name: &str| {
        let values = worst.get("camera")?.get(name)?.as_array()?;
        let values: Vec<String> = values.iter().filter_map(Value::as_f64).map(super::numbers::number).collect();
        Some(format!("({})", values.join(", ")))
    };
    let mut text = String::new();
    if let Some(view) = worst.get("view").and_then(Value::as_u64) {
        text += &format!("View {view}");
        text += &views.map_or(String::new(), |n| format!(" of 0 to {}", n.saturating_sub(1)));
    }
    if let (Some(eye), Some(forward)) = (triple("eye"), triple("forward")) {
        text += &format!(", from {eye} m towards {forward}");
    }
    if let Some(fov) = worst.get("camera").and_then(|c| c.get("fov")?.as_f64()) {
        text += &format!(", {}°", super::numbers::number(fov));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_certificate_of_views() {
        let c = json!({
            "verdict": "good", "sentence": "It is.", "triangles": 9, "original_triangles": 90, "bytes": 2048, "views": 64,
            "per_view": { "psnr_y_object_db": [20.5, null, 30], "missing_px": [0, 1, 2], "unknown": [1] },
            "worst_view": { "missing_px": { "value": 2.0, "view": 3, "picture": "worst-missing",
                "camera": { "eye": [0, 1.5, 2], "forward": [0, 0, -1], "fov": 45.0 } } },
            "panels": { "worst-missing": { "scale": 2, "original": [0, 0, 1, 1], "stand_in": [1, 0, 1, 1], "difference": [2, 0, 1, 1] } }
        });
        let found = read("certificate.json", &c);
        assert_eq!((found.verdict.as_deref(), &*found.sentence), (Some("good"), "It is."));
        let costs: Vec<_> = found.costs.iter().map(|c| (c.what, c.before, c.after)).collect();
        assert_eq!(costs, [("Triangles", Some(90.0), 9.0), ("Files of the stand-in", None, 2048.0)]);
        let series: Vec<_> = found.series.iter().map(|s| (&*s.title, s.values.len())).collect();
        assert_eq!(series, [("Likeness over the object", 2), ("Holes", 3)]);
        let all = pictures(&c, &["typical", "x", "worst-missing", "worst-psnr"], &["typical".to_owned()]);
        let names: Vec<&str> = all.iter().map(|p| &*p.name).collect();
        assert_eq!(names, ["typical", "worst-psnr", "worst-missing", "x"]);
        assert_eq!(all[2].title, "Most holes: 2 px");
        assert_eq!(all[2].place, "View 3 of 0 to 63, from (0, 1.5, 2) m towards (0, 0, -1), 45°");
        assert_eq!(all[2].panels.unwrap().stand_in, [1, 0, 1, 1]);
    }

    #[test]
    fn certificates_of_walks_directions_and_points() {
        let walk = json!({
            "per_frame": [{ "psnr_y_db": 30.0, "hole_px": 2 }, { "psnr_y_db": 31.0, "hole_px": 0, "popping": { "share": 1 } }],
            "triangles_per_frame": { "avg": 10.0 }, "original_triangles_per_frame": { "avg": 100.0 },
        });
        let found = read("c.json", &walk);
        assert_eq!((found.verdict, found.costs[0].before, found.series.len()), (None, Some(100.0), 2));
        assert_eq!((found.series[1].of, &found.series[1].values[..]), ("frames", &[2.0, 0.0][..]));
        let directions = json!({ "directions": { "per_view": { "extra": [0.1] } }, "others": null });
        assert_eq!(read("c.json", &directions).series[0].of, "directions");
        // The triangles of a coverage certificate are the object's.
        let points = read("c.json", &json!({ "points": 5, "triangles": 7, "per_view": 3, "per_frame": {} }));
        assert!(points.costs.is_empty() && points.series.is_empty());
    }
}
