//! `[batch]`: one pipeline baked several times, each time with other values. Lists of values give every combination, `[[batch]]` tables give rows one by one.

use super::{
    item::{Item, Setting, valid_name, what},
    problem::Problem,
    source::TextSpan,
};
use std::{collections::BTreeSet, path::Path};
use toml::{
    Spanned,
    de::{DeTable, DeValue},
};

/// Rows, at most.
const MOST: usize = 10_000;

/// One bake of a batch.
pub struct Row<'s> {
    /// Unlike those of all others, also where upper and lower case are one.
    pub name: String,
    pub settings: Vec<Setting<'s>>,
}

const FORM: &str = "[batch] has lists of values, resolution = [256, 512], and bakes every combination; [[batch]] has values, and bakes each table";

/// The rows that `item` asks for.
pub fn rows<'s>(item: Item<'s>, problems: &mut Vec<Problem>) -> Vec<Row<'s>> {
    let found = match item.value {
        DeValue::Table(table) => combinations(item, table, problems),
        DeValue::Array(tables) => one_by_one(item, tables, problems),
        other => {
            let message = format!("`batch` is {}, expected a table or tables", what(other));
            problems.push(Problem::at(item.place, message, "not a table").help(FORM));
            return Vec::new();
        }
    };
    name(found)
}

type Unnamed<'s> = (Option<&'s str>, Vec<Setting<'s>>);

fn combinations<'s>(item: Item<'s>, table: &'s DeTable<'s>, problems: &mut Vec<Problem>) -> Vec<Unnamed<'s>> {
    let mut keys: Vec<_> = table.iter().collect();
    // In the order in which they are written; the last varies fastest.
    keys.sort_by_key(|(key, _)| key.span().start);
    let mut rows: Vec<Unnamed> = vec![(None, Vec::new())];
    for (key, value) in keys {
        let place = TextSpan::new(item.place.source, value.span());
        let Some(list) = value.get_ref().as_array().filter(|list| list.iter().next().is_some()) else {
            let message =
                format!("`{}` in [batch] is {}, expected a list of values", key.get_ref(), what(value.get_ref()));
            problems.push(Problem::at(place, message, "not such a list").help(FORM));
            continue;
        };
        if rows.len().saturating_mul(list.iter().count()) > MOST {
            problems.push(Problem::at(place, format!("the batch has more than {MOST} bakes"), "too many").help(FORM));
            return Vec::new();
        }
        let longer = |row: &Unnamed<'s>| {
            let row = row.1.clone();
            list.iter().map(move |value| {
                let setting = setting(item.place.source, key, value);
                (None, row.iter().cloned().chain([setting]).collect())
            })
        };
        rows = rows.iter().flat_map(longer).collect();
    }
    if table.is_empty() {
        problems.push(Problem::at(item.key, "[batch] has no values", "nothing to bake").help(FORM));
        return Vec::new();
    }
    rows
}

fn one_by_one<'s>(item: Item<'s>, tables: &'s toml::de::DeArray<'s>, problems: &mut Vec<Problem>) -> Vec<Unnamed<'s>> {
    let source = item.place.source;
    let mut rows = Vec::new();
    let mut names: BTreeSet<String> = BTreeSet::new();
    for table in tables.iter().take(MOST) {
        let place = TextSpan::new(source, table.span());
        let Some(values) = table.get_ref().as_table() else {
            let message = format!("a row of `batch` is {}, expected a table", what(table.get_ref()));
            problems.push(Problem::at(place, message, "not a table").help(FORM));
            continue;
        };
        let (mut name, mut settings) = (None, Vec::new());
        for (key, value) in values {
            if key.get_ref() != "name" {
                settings.push(setting(source, key, value));
                continue;
            }
            let place = TextSpan::new(source, value.span());
            name = value.get_ref().as_str().filter(|name| valid_name(name));
            match name {
                None => problems.push(
                    Problem::at(place, "the name of a row is none", "not a name")
                        .help("at most 128 letters, digits, `-` and `_`: it is part of the folder's name"),
                ),
                Some(name) if !names.insert(name.to_lowercase()) => {
                    problems.push(Problem::at(place, format!("two rows are called `{name}`"), "the second"));
                }
                Some(_) => {}
            }
        }
        settings.sort_by_key(|s| s.path[0].1);
        rows.push((name, settings));
    }
    if tables.iter().count() > MOST {
        problems.push(Problem::at(item.place, format!("the batch has more than {MOST} bakes"), "too many"));
    }
    rows
}

fn setting<'s>(
    source: u32,
    key: &'s Spanned<std::borrow::Cow<'s, str>>,
    value: &'s Spanned<DeValue<'s>>,
) -> Setting<'s> {
    let place = TextSpan::new(source, key.span());
    let path = match key.get_ref().split_once('.') {
        Some((node, param)) => vec![(node, place), (param, place)],
        None => vec![(&**key.get_ref(), place)],
    };
    Setting { path, value: value.get_ref(), place: TextSpan::new(source, value.span()), from: "[batch]" }
}

/// Rows without a name are named by their values, the files among them without folder and extension.
fn name<'s>(rows: Vec<Unnamed<'s>>) -> Vec<Row<'s>> {
    let mut taken: BTreeSet<String> = rows.iter().filter_map(|(name, _)| Some(name.as_ref()?.to_lowercase())).collect();
    let row = |(name, settings): Unnamed<'s>| {
        if let Some(name) = name {
            return Row { name: name.to_owned(), settings };
        }
        let words: Vec<String> = settings.iter().map(|s| word(s.value)).filter(|w| !w.is_empty()).collect();
        let short: String = words.join("-").chars().take(100).collect();
        let short = if short.is_empty() { "row".to_owned() } else { short };
        let numbered = (2..).map(|n| format!("{short}-{n}"));
        let free = std::iter::once(short.clone()).chain(numbered).find(|name| taken.insert(name.to_lowercase()));
        Row { name: free.unwrap_or(short), settings }
    };
    rows.into_iter().map(row).collect()
}

/// A value as part of a name.
fn word(value: &DeValue) -> String {
    let text = match value {
        DeValue::String(text) => {
            let text = text.strip_prefix("builtin:").unwrap_or(text);
            let path = Path::new(text);
            // Of a file its stem.
            let stem = if path.extension().is_some() { path.file_stem().and_then(|s| s.to_str()) } else { None };
            stem.unwrap_or(text).to_owned()
        }
        other => super::value::json(other).to_string(),
    };
    let plain: String = text.chars().map(|c| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' }).collect();
    plain.split('-').filter(|part| !part.is_empty()).collect::<Vec<_>>().join("-")
}
