//! TOML values against the types of parameters.

use super::{
    draft::Draft,
    item::{Item, Items, reference, references, valid_name, what},
    problem::Problem,
    source::{Sources, TextSpan},
};
use crate::{
    engine::{
        suggest,
        types::{Ty, lies_within},
    },
    regular,
};
use serde_json::{Map, Number, Value};
use std::{cell::RefCell, collections::BTreeSet, path::Path};
use toml::{
    Spanned,
    de::{DeInteger, DeValue},
};

/// Turns values into JSON, follows references to knobs, and collects what is wrong.
pub struct Values<'s> {
    pub sources: &'s Sources,
    pub draft: &'s Draft<'s>,
    /// Knobs that something referred to.
    pub used: RefCell<BTreeSet<&'s str>>,
    /// References to knobs that are not there.
    pub missed: RefCell<BTreeSet<&'s str>>,
}

/// Why a number of the right type is refused.
const OUT_OF_RANGE: &str = "out of range";

/// A value on its way, with the reference to a knob that led to it.
#[derive(Clone, Copy)]
struct Found<'s> {
    value: &'s DeValue<'s>,
    place: TextSpan,
    reference: Option<TextSpan>,
    /// The parameter that it is for.
    name: &'s str,
}

pub fn integer(i: &DeInteger) -> Option<i128> {
    let digits = i.as_str().trim_start_matches('+');
    i128::from_str_radix(digits, i.radix()).ok()
}

/// A value as it is written, for the record.
pub fn json(value: &DeValue) -> Value {
    match value {
        DeValue::String(s) => Value::String(s.to_string()),
        DeValue::Boolean(b) => Value::Bool(*b),
        DeValue::Integer(i) => integer(i).and_then(Number::from_i128).map_or(Value::Null, Value::Number),
        DeValue::Float(f) => f.as_str().parse().ok().and_then(Number::from_f64).map_or(Value::Null, Value::Number),
        DeValue::Datetime(d) => Value::String(d.to_string()),
        DeValue::Array(items) => Value::Array(items.iter().map(|item| json(item.get_ref())).collect()),
        DeValue::Table(table) => {
            Value::Object(table.iter().map(|(key, item)| (key.get_ref().to_string(), json(item.get_ref()))).collect())
        }
    }
}

impl<'s> Values<'s> {
    /// A value that nothing takes, although it may be meant: the knobs that it refers to count as used.
    pub fn pass_over(&self, value: &'s DeValue<'s>) {
        let mut knobs = Vec::new();
        references(value, &mut knobs);
        self.used.borrow_mut().extend(knobs);
    }

    fn part(&self, place: TextSpan) -> usize {
        self.sources.get(place).part
    }

    /// The knobs that a value refers to.
    fn knobs(&self, found: Found) -> &'s Items<'s> {
        self.draft.knobs_of(self.part(found.place))
    }

    /// The knob that a node's own value refers to.
    pub fn knob_of(&self, item: Item) -> Option<Item<'s>> {
        self.draft.knobs_of(self.part(item.place)).get(reference(item.value.as_str()?)?).copied()
    }

    /// The value that `item` gives to parameter `name` of type `ty`.
    pub fn convert(&self, name: &'s str, item: Item<'s>, ty: &Ty, problems: &mut Vec<Problem>) -> Option<Value> {
        self.value(Found { value: item.value, place: item.place, reference: None, name }, ty, problems)
    }

    fn value(&self, mut found: Found<'s>, ty: &Ty, problems: &mut Vec<Problem>) -> Option<Value> {
        // A knob holds a plain value; that of a part may hold what its parent says, which may be a knob of the parent.
        while let Some(text) = found.value.as_str()
            && let Some(name) = reference(text)
            && found.reference.is_none_or(|from| self.part(from) != self.part(found.place))
        {
            let before = found;
            found = self.knob(found, name, ty, problems)?;
            if std::ptr::eq(before.value, found.value) {
                break;
            }
        }
        match (ty, found.value) {
            (Ty::Bool, DeValue::Boolean(b)) => Some(Value::Bool(*b)),
            (Ty::Integer { min, max, .. }, DeValue::Integer(i)) => {
                let value = integer(i);
                let json = value.filter(|v| v >= min && v <= max).and_then(Number::from_i128);
                json.map_or_else(|| self.refuse(found, ty, OUT_OF_RANGE, problems), |n| Some(Value::Number(n)))
            }
            (Ty::Number { min, max, .. }, DeValue::Integer(_) | DeValue::Float(_)) => {
                let value = match found.value {
                    DeValue::Integer(i) => integer(i).map(|v| v as f64),
                    DeValue::Float(f) => f.as_str().parse::<f64>().ok(),
                    _ => None,
                };
                let Some(json) = value.and_then(Number::from_f64) else {
                    return self.refuse(found, ty, "is no finite number", problems);
                };
                let value = value.unwrap_or_default();
                if !lies_within(value, *min, *max) {
                    return self.refuse(found, ty, OUT_OF_RANGE, problems);
                }
                Some(Value::Number(json))
            }
            (Ty::Text, DeValue::String(s)) => self.text(found, s, problems).map(Value::String),
            (Ty::Path, DeValue::String(s)) => {
                let text = self.text(found, s, problems)?;
                self.path(found, text, problems).map(Value::String)
            }
            // `--set scene=2024`: an argument needs no quotes.
            (Ty::Text | Ty::Path, _) if self.sources.get(found.place).argument => {
                let text = self.sources.text(found.place).to_owned();
                if matches!(ty, Ty::Path) {
                    return self.path(found, text, problems).map(Value::String);
                }
                Some(Value::String(text))
            }
            (Ty::Word(words), DeValue::String(s)) => {
                if words.iter().any(|w| w == s) {
                    return Some(Value::String(s.clone().into_owned()));
                }
                let hint = suggest::did_you_mean(s, words.iter().map(String::as_str));
                self.report(found, format!("`{}` cannot be \"{s}\"", found.name), "no such choice", problems, || {
                    format!("{hint}expected {}", ty.describe())
                })
            }
            (Ty::List { first, rest, min, max }, DeValue::Array(items)) => {
                if items.len() < *min || items.len() > *max {
                    let found_count = format!("`{}` has {} entries", found.name, items.len());
                    return self.report(found, found_count, "wrong length", problems, || {
                        format!("expected {}", ty.describe())
                    });
                }
                let each = items.iter().enumerate().map(|(i, item)| {
                    self.value(
                        Found { value: item.get_ref(), ..self.inside(found, item) },
                        first.get(i).unwrap_or(rest),
                        problems,
                    )
                });
                // Every entry is looked at before the first missing one ends it.
                each.collect::<Vec<_>>().into_iter().collect::<Option<Vec<_>>>().map(Value::Array)
            }
            (Ty::Table { fields, required, rest }, DeValue::Table(table)) => {
                let mut out = Some(Map::new());
                for (key, item) in table {
                    let inner = Found { value: item.get_ref(), name: key.get_ref(), ..self.inside(found, item) };
                    let Some(ty) = fields.get(&**key.get_ref()).or(rest.as_deref()) else {
                        let place = TextSpan::new(found.place.source, key.span());
                        let help = format!(
                            "{}`{}` has {}",
                            suggest::did_you_mean(key.get_ref(), fields.keys().map(String::as_str)),
                            found.name,
                            suggest::list(fields.keys().map(String::as_str))
                        );
                        let message = format!("unknown key `{}` in `{}`", key.get_ref(), found.name);
                        problems.push(Problem::at(place, message, "no such key").help(help));
                        out = None;
                        continue;
                    };
                    let value = self.value(inner, ty, problems);
                    out = out.zip(value).map(|(mut out, value)| {
                        out.insert(key.get_ref().to_string(), value);
                        out
                    });
                }
                for name in required {
                    if !table.iter().any(|(k, _)| k.get_ref() == name.as_str()) {
                        let message = format!("`{}` has no `{name}`", found.name);
                        return self
                            .report(found, message, "incomplete", problems, || format!("expected {}", ty.describe()));
                    }
                }
                out.map(Value::Object)
            }
            (Ty::OneOf(types), _) => self.one_of(found, ty, types, problems),
            (Ty::Any, _) => self.any(found, problems),
            _ => self.refuse(found, ty, "", problems),
        }
    }

    fn inside(&self, found: Found<'s>, item: &Spanned<DeValue>) -> Found<'s> {
        Found { place: TextSpan::new(found.place.source, item.span()), ..found }
    }

    /// What knob `name` holds.
    fn knob(&self, found: Found<'s>, name: &'s str, ty: &Ty, problems: &mut Vec<Problem>) -> Option<Found<'s>> {
        let knobs = self.knobs(found);
        if let Some((name, knob)) = knobs.get_key_value(name) {
            if self.part(found.place) == 0 {
                self.used.borrow_mut().insert(name);
            }
            return Some(Found { value: knob.value, place: knob.place, reference: Some(found.place), ..found });
        }
        if !valid_name(name.trim()) && matches!(ty, Ty::Text) {
            return Some(found);
        }
        self.missed.borrow_mut().insert(name);
        let message = format!("no knob `{name}`");
        self.report(found, message, "no such knob", problems, || {
            let trimmed = name.trim();
            let expression = if knobs.contains_key(trimmed) {
                format!("write exactly \"{{{trimmed}}}\"; ")
            } else if name.contains(['*', '+', '/', ' ']) {
                "there are no expressions: compute the value and write it; ".to_owned()
            } else {
                suggest::did_you_mean(name, knobs.keys().copied())
            };
            format!("{expression}the knobs in [params] are {}", suggest::list(knobs.keys().copied()))
        })
    }

    /// A text in which no reference to a knob is hidden.
    fn text(&self, found: Found<'s>, text: &str, problems: &mut Vec<Problem>) -> Option<String> {
        let hidden = text.split('{').skip(1).find_map(|rest| rest.split_once('}').map(|(name, _)| name));
        let Some(name) = hidden.filter(|name| self.knobs(found).contains_key(name) && reference(text) != Some(name))
        else {
            return Some(text.to_owned());
        };
        self.report(found, format!("`{{{name}}}` inside a longer text"), "not a reference", problems, || {
            format!("only exactly \"{{{name}}}\" refers to a knob; put the whole text into the knob")
        })
    }

    /// The absolute form of a path, which must name a file.
    fn path(&self, found: Found<'s>, text: String, problems: &mut Vec<Problem>) -> Option<String> {
        if text.starts_with("builtin:") {
            return Some(text);
        }
        if text.is_empty() {
            let message = format!("`{}` names no file", found.name);
            return self.report(found, message, "empty", problems, || "expected the path of a file".to_owned());
        }
        let folder = &self.sources.get(found.place).folder;
        let path = folder.join(&text);
        let shown = path.display();
        let (message, label) = match std::fs::metadata(&path) {
            Ok(data) => match (regular::check(&data), path.to_str()) {
                (Ok(()), Some(path)) => return Some(path.to_owned()),
                (Ok(()), None) => (format!("the path `{shown}` is not UTF-8"), "not UTF-8"),
                (Err(e), _) => (format!("`{text}` {e}"), "no regular file"),
            },
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
                let name = if text.contains(char::is_control) { text.escape_debug().to_string() } else { text.clone() };
                (format!("no file `{name}`"), "no such file")
            }
            Err(e) => (format!("cannot read `{text}`: {e}"), "not readable"),
        };
        let none = self.report(found, message, label, problems, || {
            if text.contains(char::is_control) {
                let help = "it holds a control character: in \"…\" a backslash begins an escape; write `/`, or single \
                            quotes '…'";
                return help.to_owned();
            }
            let hint = near_file(&path).map(|near| format!("did you mean `{near}`? ")).unwrap_or_default();
            let whose = if self.sources.get(found.place).argument {
                "in --set, paths start from the working folder"
            } else {
                "paths start from the folder of the pipeline file"
            };
            format!("{hint}looked for {shown}; {whose}")
        });
        if let Some(problem) = problems.last_mut() {
            problem.file = Some(Box::new(path));
        }
        none
    }

    /// The first of `types` that fits; else what the nearest of them says.
    fn one_of(&self, found: Found<'s>, ty: &Ty, types: &[Ty], problems: &mut Vec<Problem>) -> Option<Value> {
        let mut near = Vec::new();
        for option in types {
            let mut trial = Vec::new();
            let value = self.value(found, option, &mut trial);
            if trial.is_empty() {
                return value;
            }
            let shape = match found.value {
                DeValue::Table(_) => matches!(option, Ty::Table { .. }),
                DeValue::Array(_) => matches!(option, Ty::List { .. }),
                DeValue::String(_) => matches!(option, Ty::Text | Ty::Word(_) | Ty::Path),
                DeValue::Integer(_) | DeValue::Float(_) => matches!(option, Ty::Integer { .. } | Ty::Number { .. }),
                _ => false,
            };
            if shape {
                near.push(trial);
            }
        }
        if near.len() == 1 {
            problems.extend(near.remove(0));
            return None;
        }
        self.refuse(found, ty, "fits none of the forms", problems)
    }

    fn any(&self, found: Found<'s>, problems: &mut Vec<Problem>) -> Option<Value> {
        match found.value {
            DeValue::String(s) => Some(Value::String(s.clone().into_owned())),
            DeValue::Boolean(b) => Some(Value::Bool(*b)),
            DeValue::Integer(_) => self.value(
                found,
                &Ty::Integer { min: i64::MIN.into(), max: u64::MAX.into(), unit: String::new() },
                problems,
            ),
            DeValue::Float(_) => self.value(found, &Ty::Number { min: None, max: None, unit: String::new() }, problems),
            DeValue::Datetime(d) => Some(Value::String(d.to_string())),
            DeValue::Array(_) => {
                let ty = Ty::List { first: Vec::new(), rest: Box::new(Ty::Any), min: 0, max: usize::MAX };
                self.value(found, &ty, problems)
            }
            DeValue::Table(_) => {
                let ty = Ty::Table { fields: Default::default(), required: Vec::new(), rest: Some(Box::new(Ty::Any)) };
                self.value(found, &ty, problems)
            }
        }
    }

    /// The problem that `found` does not fit `ty`.
    fn refuse(&self, found: Found<'s>, ty: &Ty, why: &str, problems: &mut Vec<Problem>) -> Option<Value> {
        let (name, wanted) = (found.name, ty.describe());
        let (message, label) = match (why, found.value) {
            ("", value) => {
                (format!("`{name}` is {}, expected {wanted}", what(value)), format!("found {}", what(value)))
            }
            (OUT_OF_RANGE, DeValue::Integer(i)) => {
                let shown = integer(i).map_or_else(|| i.as_str().to_owned(), |v| v.to_string());
                (format!("`{name}` is {shown}, expected {wanted}"), OUT_OF_RANGE.to_owned())
            }
            (OUT_OF_RANGE, DeValue::Float(f)) => {
                (format!("`{name}` is {}, expected {wanted}", f.as_str()), OUT_OF_RANGE.to_owned())
            }
            _ => (format!("`{name}` {why}, expected {wanted}"), why.trim_start_matches("is ").to_owned()),
        };
        self.report(found, message, &label, problems, || match (found.value, ty) {
            (DeValue::Integer(i), Ty::Integer { max, .. }) if integer(i).is_none_or(|v| v > *max) => {
                format!("at most {max}")
            }
            (DeValue::Float(f), Ty::Integer { .. }) => {
                format!("write it without a fraction: {name} = {}", f.as_str().split('.').next().unwrap_or("0"))
            }
            (DeValue::String(s), Ty::Integer { .. } | Ty::Number { .. }) if s.trim().parse::<f64>().is_ok() => {
                format!("numbers stand without quotes: {name} = {}", s.trim())
            }
            (DeValue::String(s), Ty::Bool) if matches!(s.to_lowercase().as_str(), "true" | "false" | "yes" | "no") => {
                let value = matches!(s.to_lowercase().as_str(), "true" | "yes");
                format!("write it without quotes: {name} = {value}")
            }
            (DeValue::String(s), _) => self.hidden_hint(found, s),
            _ => String::new(),
        })
    }

    fn hidden_hint(&self, found: Found, text: &str) -> String {
        let hidden = self.draft.knobs_of(self.part(found.place)).keys().find(|k| text.contains(&format!("{{{k}}}")));
        hidden
            .map(|k| format!("only exactly \"{{{k}}}\" refers to a knob; there are no expressions"))
            .unwrap_or_default()
    }

    fn report<T>(
        &self,
        found: Found,
        message: String,
        label: &str,
        problems: &mut Vec<Problem>,
        help: impl FnOnce() -> String,
    ) -> Option<T> {
        let help = if suggest::worthwhile(problems.len()) { help() } else { String::new() };
        let mut problem = Problem::at(found.place, message, label).help(help);
        if let Some(reference) = found.reference {
            problem = problem.also(reference, "used here");
        }
        problems.push(problem);
        None
    }
}

/// A file of the same folder whose name is near and that can be meant: one with the same ending, or with the same name
/// but for the ending.
fn near_file(path: &Path) -> Option<String> {
    let part = |path: &Path, f: fn(&Path) -> Option<&std::ffi::OsStr>| Some(f(path)?.to_str()?.to_lowercase());
    let (stem, ending) = (part(path, Path::file_stem), part(path, Path::extension));
    let related = |name: &String| {
        let name = Path::new(name);
        part(name, Path::extension) == ending || part(name, Path::file_stem) == stem
    };
    let mut names: Vec<String> = std::fs::read_dir(path.parent()?)
        .ok()?
        .take(2000)
        .filter_map(|e| e.ok().filter(|e| e.path().is_file())?.file_name().into_string().ok())
        .filter(related)
        .collect();
    names.sort();
    suggest::nearest(path.file_name()?.to_str()?, names.iter().map(String::as_str)).map(str::to_owned)
}
