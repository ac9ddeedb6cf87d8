//! Whether a file can be a scene, judged by its name and its beginning: for messages before anything is baked. What is
//! let through here may still prove wrong when it is read.

use std::path::Path;

/// Looks at a file's beginning; `whole` says that it is all of the file. The error says what was found and what is
/// expected, to be put after the file's name.
pub fn probe(path: &Path, head: &[u8], whole: bool) -> Result<(), String> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    let expected: &[&str] = &["glb", "gltf", "obj", "ply", "toml"];
    if !expected.contains(&&*ending) {
        return Err("is no scene: expected a file that ends in .glb, .gltf, .obj, .ply or .toml".to_owned());
    }
    if head.is_empty() {
        return Err("is empty".to_owned());
    }
    if head.starts_with(b"version https://git-lfs.github.com/") {
        return Err("is only a Git LFS pointer: fetch the file itself with `git lfs pull`".to_owned());
    }
    // Text of two bytes a character is the reader's to take or to refuse.
    if head.starts_with(b"\xff\xfe") || head.starts_with(b"\xfe\xff") {
        return Ok(());
    }
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head).trim_ascii_start();
    let lower = text[..text.len().min(16)].to_ascii_lowercase();
    if lower.starts_with(b"<!doctype") || lower.starts_with(b"<html") {
        return Err("holds a web page: the download went wrong".to_owned());
    }
    let binary = head.contains(&0);
    match &*ending {
        "glb" | "gltf" if head.starts_with(b"glTF") || text.starts_with(b"{") => Ok(()),
        "glb" => Err("holds no GLB, which begins with `glTF`".to_owned()),
        "gltf" => Err("holds no glTF, which is JSON and begins with `{`".to_owned()),
        "ply" if text.starts_with(b"ply") => Ok(()),
        "ply" => Err("holds no PLY, which begins with the line `ply`".to_owned()),
        "obj" if binary => Err("holds binary data; an OBJ file is text".to_owned()),
        "obj" if whole && !has_vertices(text) => Err("holds no OBJ: no line begins with `v`".to_owned()),
        "toml" if binary => Err("holds binary data; a scene TOML is text".to_owned()),
        "toml" if whole => toml_of_a_scene(text),
        _ => Ok(()),
    }
}

/// Whether a line of an OBJ file gives a vertex, or the file draws on another.
fn has_vertices(text: &[u8]) -> bool {
    let lines = text.split(|b| matches!(b, b'\n' | b'\r'));
    lines.map(<[u8]>::trim_ascii_start).any(|line| {
        let word = line.split(|b| b.is_ascii_whitespace()).next().unwrap_or_default();
        [&b"v"[..], b"call"].iter().any(|w| word.eq_ignore_ascii_case(w))
    })
}

fn toml_of_a_scene(text: &[u8]) -> Result<(), String> {
    // What is no UTF-8 is the reader's to refuse, with its place.
    let Ok(text) = std::str::from_utf8(text) else { return Ok(()) };
    match toml::de::DeTable::parse(text) {
        Ok(table) if table.get_ref().contains_key("nodes") => {
            Err("is a pipeline, not a scene: a scene TOML has [[place]] tables".to_owned())
        }
        Ok(_) => Ok(()),
        Err(e) => {
            let line = e
                .span()
                .map_or(1, |s| text.as_bytes()[..s.start.min(text.len())].iter().filter(|b| **b == b'\n').count() + 1);
            Err(format!("is no TOML: line {line}: {}", e.message()))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_scene_is_told_by_its_beginning() {
        let check = |name: &str, head: &[u8], expect: &str| match probe(Path::new(name), head, true) {
            Ok(()) => assert_eq!(expect, "", "{name}"),
            Err(e) => assert!(!expect.is_empty() && e.contains(expect), "{name}: {e}"),
        };
        check("README.md", b"# Title", "is no scene");
        check("a", b"v 0 0 0", "is no scene");
        check("a.glb", b"", "is empty");
        check("a.glb", b"version https://git-lfs.github.com/spec/v1\noid", "Git LFS");
        check("a.glb", b"\n<!DOCTYPE html>", "web page");
        check("a.GLB", b"glTF\x02\0\0\0", "");
        check("a.glb", b" {\"asset\":{}}", "");
        check("a.glb", b"PK\x03\x04", "no GLB");
        check("a.gltf", b"\xef\xbb\xbf{}", "");
        check("a.gltf", b"glTF", "");
        check("a.gltf", b"solid", "no glTF");
        check("a.ply", b"ply\r\nformat", "");
        check("a.ply", b"v 1 2 3", "no PLY");
        check("a.obj", b"# x\r  V 1 2 3\r", "");
        check("a.obj", b"# Title\n\nSome words about vertices\n", "no OBJ");
        check("a.obj", b"v 1 2 3\0", "binary");
        check("a.obj", b"\xff\xfev\0 \0", "");
        check("a.toml", b"[[place]]\nfile = 'a.glb'\n", "");
        check("a.toml", b"[[place]\n", "line 1");
        check("a.toml", b"[nodes.load]\nkind = 'load-scene'\n", "is a pipeline");
        // Of a large file only the beginning is known.
        assert!(probe(Path::new("a.obj"), b"# a long head", false).is_ok());
    }
}
