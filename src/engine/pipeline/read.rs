//! From names to TOML trees: the given file, its bases, and the `--set` arguments.

use super::{
    item::Setting,
    problem::Problem,
    source::{Source, Sources, TextSpan},
};
use crate::engine::suggest;
use std::{
    io::Read,
    path::{Path, PathBuf},
    sync::Arc,
};
use toml::{
    Spanned,
    de::{DeTable, DeValue},
};

/// A pipeline file may be this large; spans fit in 32 bits.
const MAX_BYTES: usize = 64 << 20;

/// A pipeline that the program carries: its name and its text.
pub type Stock = (&'static str, &'static str);

/// One text's tree.
pub struct Layer<'s> {
    pub source: u32,
    pub table: DeTable<'s>,
}

/// Finds `file`, a path below `folder` or the name of a stock pipeline: its text, and what tells it from others.
pub fn open(file: &str, folder: &Path, stock: &[Stock]) -> Result<(Source, PathBuf), Problem> {
    let names = || suggest::list(stock.iter().map(|s| s.0));
    let path = folder.join(file);
    let looks_like_a_file = file.ends_with(".toml") || file.contains(['/', '\\']);
    if !looks_like_a_file {
        if let Some((name, text)) = stock.iter().find(|s| s.0 == file) {
            let source = Source {
                name: format!("{name} (stock pipeline)"),
                text: Arc::from(*text),
                folder: folder.to_owned(),
                argument: false,
                file: None,
                part: 0,
            };
            return Ok((source, PathBuf::from(format!("<stock>/{name}"))));
        }
        if !path.is_file() {
            let hint = suggest::did_you_mean(file, stock.iter().map(|s| s.0));
            return Err(Problem::nowhere(format!("no pipeline `{file}`"))
                .help(format!("{hint}expected the path of a TOML file, or a stock pipeline: {}", names())));
        }
    }
    let fail =
        |what: String| Err(Problem::nowhere(format!("cannot read the pipeline file `{file}`: {what}")).of_file(&path));
    let bytes = match read_bytes(&path) {
        Ok(bytes) => bytes,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
            let hint = neighbour(&path).map(|n| format!("did you mean `{n}`? ")).unwrap_or_default();
            return fail("no such file".to_owned())
                .map_err(|p: Problem| p.help(format!("{hint}stock pipelines, by name: {}", names())));
        }
        Err(e) => return fail(e.to_string()),
    };
    if bytes.len() > MAX_BYTES {
        return fail(format!("it is longer than {} MiB", MAX_BYTES >> 20));
    }
    let text = match String::from_utf8(bytes) {
        Ok(text) => text,
        Err(e) => return fail(format!("byte {} is not UTF-8; a pipeline file is text", e.utf8_error().valid_up_to())),
    };
    let home = path.parent().map_or_else(|| folder.to_owned(), Path::to_owned);
    let own = Some(path.clone());
    Ok((Source { name: file.to_owned(), text: text.into(), folder: home, argument: false, file: own, part: 0 }, path))
}

/// A file's bytes, but not many more than a pipeline may have.
fn read_bytes(path: &Path) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    crate::regular::open(path)?.take(MAX_BYTES as u64 + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// A file in the same folder whose name is near.
fn neighbour(path: &Path) -> Option<String> {
    let wrong = path.file_name()?.to_str()?;
    let mut names: Vec<String> = std::fs::read_dir(path.parent()?)
        .ok()?
        .take(1000)
        .filter_map(|e| e.ok()?.file_name().into_string().ok())
        .filter(|n| n.ends_with(".toml"))
        .collect();
    names.sort();
    suggest::nearest(wrong, names.iter().map(String::as_str)).map(str::to_owned)
}

/// The tree of `text`, or every syntax error in it.
pub fn parse<'s>(source: u32, text: &'s str, problems: &mut Vec<Problem>) -> Option<DeTable<'s>> {
    let (table, errors) = DeTable::parse_recoverable(text);
    if errors.is_empty() {
        return Some(table.into_inner());
    }
    for error in errors {
        let mut span = error.span().unwrap_or(0..0);
        span.end = span.end.min(text.len());
        span.start = span.start.min(span.end);
        let problem = syntax(TextSpan::new(source, span), error.message(), text);
        // A line with several wrong escapes has one cause.
        let line =
            |p: &Problem| p.place.map(|p| text.as_bytes()[..p.start as usize].iter().filter(|b| **b == b'\n').count());
        let again = |last: &&Problem| {
            let same = last.place.map(|p| p.source) == Some(source) && last.message == problem.message;
            same && line(last) == line(&problem)
        };
        if problems.last().filter(again).is_none() {
            problems.push(problem);
        }
    }
    None
}

/// A syntax error, with what usually causes it.
fn syntax(place: TextSpan, message: &str, text: &str) -> Problem {
    let (start, end) = (place.start as usize, place.end as usize);
    let line_start = text[..start].rfind('\n').map_or(0, |at| at + 1);
    let line_end = text[end..].find('\n').map_or(text.len(), |at| end + at);
    let (line, found) = (text[line_start..line_end].trim(), &text[start..end]);
    let assignment = line.split_once('=').filter(|(key, _)| !key.contains('"'));
    let (what, label, help) = if is_windows_path(line) {
        let help = "in \"…\" a backslash begins an escape: write `/` (\"C:/models/town.glb\"), or single quotes \
                    ('C:\\models\\town.glb')";
        ("a backslash in text".to_owned(), "begins an escape", help.to_owned())
    } else if message.contains("duplicate key") {
        (
            format!("`{found}` a second time"),
            "again",
            "a key stands once in a table, and a table has one header".to_owned(),
        )
    } else if let Some((key, value)) = assignment {
        let (key, value) = (key.trim(), value.split('#').next().unwrap_or_default().trim());
        if value.is_empty() {
            let help = format!("write a value behind `{key} =`: a number, \"text\", true or false, a [list]");
            (format!("`{key}` has no value"), "here", help)
        } else if value.starts_with(|c: char| c.is_alphabetic() || "./~".contains(c)) && !value.contains(['"', '\'']) {
            let help = format!("text needs quotes: {key} = \"{value}\"");
            (format!("`{value}` is no value"), "text without quotes?", help)
        } else {
            (message.to_owned(), "not valid TOML", String::new())
        }
    } else if line.starts_with('[') && !line.ends_with(']') {
        (message.to_owned(), "here", "a table's header ends with `]`".to_owned())
    } else if !line.contains('=') && !line.is_empty() && !line.starts_with('[') {
        (message.to_owned(), "here", "a line is `key = value`, a `[header]` or a `# comment`".to_owned())
    } else {
        (message.to_owned(), "not valid TOML", String::new())
    };
    Problem::at(place, format!("TOML syntax: {what}"), label).help(help)
}

/// Whether a line has a basic string in which a backslash begins no escape that TOML knows.
fn is_windows_path(line: &str) -> bool {
    let mut chars = line.chars();
    let mut inside = false;
    while let Some(c) = chars.next() {
        match c {
            '\'' if !inside => drop(chars.find(|c| *c == '\'')),
            '#' if !inside => return false,
            '"' => inside = !inside,
            '\\' if inside => match chars.next() {
                // `\u` and `\U` need digits; `\"` at the end of a path leaves the string open.
                Some('u' | 'U') => {
                    if !chars.clone().take(4).all(|c| c.is_ascii_hexdigit()) || chars.clone().count() < 4 {
                        return true;
                    }
                }
                Some('b' | 't' | 'n' | 'f' | 'r' | 'e' | '"' | '\\') | None => {}
                Some(_) => return true,
            },
            _ => {}
        }
    }
    false
}

/// `[pipeline] base` of `table`, if it is text. (Its other types are reported with the rest of the section.)
fn base_of<'t>(table: &'t DeTable<'_>) -> Option<(&'t str, std::ops::Range<usize>)> {
    let section = table.iter().find(|(k, _)| k.get_ref() == "pipeline")?.1.get_ref().as_table()?;
    let value = section.iter().find(|(k, _)| k.get_ref() == "base")?.1;
    Some((value.get_ref().as_str()?, value.span()))
}

/// Adds the texts of the bases of `top`, the text number `number`, nearest first, to `sources`.
pub fn bases(
    number: u32,
    top: &DeTable<'_>,
    top_path: &Path,
    stock: &[Stock],
    sources: &mut Sources,
    problems: &mut Vec<Problem>,
) -> Vec<(u32, Arc<str>)> {
    let mut texts: Vec<(u32, Arc<str>)> = Vec::new();
    let mut seen = vec![identity(top_path)];
    let mut names = vec![sources.by_number(number).name.clone()];
    let part = sources.by_number(number).part;
    let mut next = base_of(top).map(|(name, span)| (name.to_owned(), TextSpan::new(number, span)));
    while let Some((base, place)) = next {
        let folder = sources.get(place).folder.clone();
        let (mut source, path) = match open(&base, &folder, stock) {
            Ok(found) => found,
            Err(p) => {
                problems.push(Problem { place: Some(place), label: "not found".to_owned(), ..p });
                break;
            }
        };
        let identity = identity(&path);
        names.push(base);
        if seen.contains(&identity) {
            let message = format!("a pipeline is its own base: {}", names.join(" → "));
            problems.push(Problem::at(place, message, "leads back").help("remove one `base` of the circle"));
            break;
        }
        seen.push(identity);
        source.part = part;
        let text = Arc::clone(&source.text);
        let number = sources.add(source);
        let Some(table) = parse(number, &text, problems) else { break };
        next = base_of(&table).map(|(name, span)| (name.to_owned(), TextSpan::new(number, span)));
        texts.push((number, Arc::clone(&text)));
    }
    texts
}

/// What tells a file from others, whatever it is called.
pub fn identity(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

/// A `--set` argument.
pub struct Argument<'s> {
    /// A knob's name, or a node's and the name of one of its keys.
    pub path: Vec<(&'s str, TextSpan)>,
    pub value: Spanned<DeValue<'s>>,
}

impl<'s> Argument<'s> {
    pub fn setting(&'s self) -> Setting<'s> {
        let source = self.path.first().map_or(0, |(_, place)| place.source);
        let place = TextSpan::new(source, self.value.span());
        Setting { path: self.path.clone(), value: self.value.get_ref(), place, from: "--set" }
    }
}

/// Reads `name=value` or `node.key=value`, the value in TOML's syntax or as plain text.
pub fn argument<'s>(source: u32, text: &'s str) -> Result<Argument<'s>, Problem> {
    let whole = TextSpan::new(source, 0..text.len());
    let expected = "expected --set name=value for a knob, or --set node.param=value";
    let Some(at) = text.find('=') else {
        return Err(Problem::at(whole, format!("--set {text}: there is no `=`"), "no value").help(expected));
    };
    let mut path = Vec::new();
    let mut start = 0;
    for part in text[..at].split('.') {
        let name = part.trim();
        let name = name.strip_prefix('"').and_then(|n| n.strip_suffix('"')).unwrap_or(name);
        let from = start + part.len() - part.trim_start().len();
        path.push((name, TextSpan::new(source, from..from + name.len())));
        start += part.len() + 1;
    }
    if path.len() > 2 || path.iter().any(|(name, _)| name.is_empty()) {
        let place = TextSpan::new(source, 0..at);
        return Err(Problem::at(place, format!("--set {text}: no such name"), "no knob or parameter").help(expected));
    }
    let trimmed = text[at + 1..].trim();
    let from = at + 1 + (text.len() - at - 1 - text[at + 1..].trim_start().len());
    let plain = || Spanned::new(from..from + trimmed.len(), DeValue::String(trimmed.into()));
    // The argument is a line of TOML, which keeps the places; what does not parse is text without quotes.
    let value = match DeTable::parse(text) {
        Ok(table) => leaf(table.into_inner(), path.len()).unwrap_or_else(plain),
        Err(_) => plain(),
    };
    Ok(Argument { path, value })
}

/// The only value of a table, `depth` keys deep.
fn leaf(table: DeTable<'_>, depth: usize) -> Option<Spanned<DeValue<'_>>> {
    if table.len() != 1 {
        return None;
    }
    let (_, value) = table.into_iter().next()?;
    if depth == 1 {
        return Some(value);
    }
    match value.into_inner() {
        DeValue::Table(inner) => leaf(inner, depth - 1),
        _ => None,
    }
}
