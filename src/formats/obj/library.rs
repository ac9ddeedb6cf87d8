//! Material libraries: the MTL files that an OBJ names, and materials by the names that its faces use.

use super::{
    mtl,
    paths::{self, Found},
};
use crate::{
    formats::{
        FormatError,
        loader::Loader,
        text::{self, trim, unquote, words},
    },
    scene::Material,
};
use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
    sync::Arc,
};

/// Materials by name. `usemtl a # b` may mean `a # b` or `a`: exporters write both, the whole name counts first.
pub(super) struct Library {
    whole: BTreeMap<String, Arc<Material>>,
    short: BTreeMap<String, Arc<Material>>,
    plain: Arc<Material>,
}

impl Library {
    pub fn find(&self, name: &str) -> Option<Arc<Material>> {
        let short = without_comment(name);
        let found = self.whole.get(name).or_else(|| self.whole.get(short)).or_else(|| self.short.get(short));
        found.cloned()
    }

    /// What faces without a material have: white, neither metal nor glossy.
    pub fn plain(&self) -> Arc<Material> {
        self.plain.clone()
    }
}

/// `name` up to a comment.
fn without_comment(name: &str) -> &str {
    match text::comment(name) {
        Some(at) if at > 0 => unquote(trim(&name[..at])),
        _ => name,
    }
}

/// The materials of all libraries that faces use; of two with one name the first counts. A library that is not there
/// is a warning, as in every viewer; a texture that is not there is an error.
pub(super) fn materials(
    loader: &mut Loader,
    file: &Path,
    libraries: &[(usize, String)],
    used: &BTreeSet<&str>,
) -> Result<Library, FormatError> {
    let plain = Arc::new(Material { metallic: 0.0, ..Material::default() });
    let mut out = Library { whole: BTreeMap::new(), short: BTreeMap::new(), plain };
    let short: BTreeSet<&str> = used.iter().map(|name| without_comment(name)).collect();
    let home = file.parent().unwrap_or(Path::new("")).to_owned();
    let mut read = BTreeSet::new();
    for (line, names) in libraries {
        for (path, bytes) in open(loader, file, &home, *line, names)? {
            if !read.insert(path.clone()) {
                continue;
            }
            let text = text::decode((*bytes).as_ref()).map_err(|(at, what)| FormatError::invalid(&path, at, what))?;
            let wanted = |name: &str| used.contains(name) || short.contains(without_comment(name));
            for (name, material) in mtl::materials(loader, &path, &home, &text, &wanted)? {
                out.short.entry(without_comment(&name).to_owned()).or_insert_with(|| material.clone());
                out.whole.entry(name).or_insert(material);
            }
        }
    }
    Ok(out)
}

type Opened = Vec<(std::path::PathBuf, crate::array::Bytes)>;

/// The files that one `mtllib` names: its whole text is one file's name, or else several names one after another.
fn open(loader: &mut Loader, file: &Path, home: &Path, line: usize, names: &str) -> Result<Opened, FormatError> {
    let shortened = without_comment(names);
    let several = split(shortened);
    if several.len() > 1 || shortened != names {
        for whole in [names, shortened] {
            if let Found::File(path, bytes) = paths::exact(loader, file, unquote(whole))? {
                return Ok(vec![(path, bytes)]);
            }
        }
    }
    let mut out = Vec::new();
    for name in several {
        match paths::find(loader, file, home, &name)? {
            Found::File(path, bytes) => out.push((path, bytes)),
            Found::Nothing(tried) => {
                loader.warn(file, format!("line {line}: the material library {}", paths::nowhere(&name, &tried)));
            }
        }
    }
    Ok(out)
}

/// Names one after another: quoted ones, ones that end in `.mtl` and may hold blanks, else words.
fn split(text: &str) -> Vec<String> {
    let mut out = Vec::new();
    let mut rest = trim(text);
    while let Some(quoted) = rest.strip_prefix('"')
        && let Some(end) = quoted.find('"')
    {
        out.push(quoted[..end].to_owned());
        rest = trim(&quoted[end + 1..]);
    }
    let mut name = String::new();
    for word in words(rest) {
        if !name.is_empty() {
            name.push(' ');
        }
        name.push_str(word);
        if word.len() > 4 && word.as_bytes()[word.len() - 4..].eq_ignore_ascii_case(b".mtl") {
            out.push(std::mem::take(&mut name));
        }
    }
    if out.is_empty() {
        return words(rest).map(str::to_owned).collect();
    }
    out.extend((!name.is_empty()).then_some(name));
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_line_names_several_libraries() {
        for (text, expect) in [
            ("a.mtl b.mtl", &["a.mtl", "b.mtl"][..]),
            ("my materials.mtl  other.MTL", &["my materials.mtl", "other.MTL"]),
            ("\"my a.mtl\" \"b\" c.mtl", &["my a.mtl", "b", "c.mtl"]),
            ("a b", &["a", "b"]),
            ("a.mtl b", &["a.mtl", "b"]),
        ] {
            assert_eq!(split(text), expect, "{text}");
        }
    }
}
