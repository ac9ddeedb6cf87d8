//! A value of a pipeline file with its place, and what can be said of it without knowing what it is for.

use super::source::TextSpan;
use std::collections::BTreeMap;
use toml::de::DeValue;

/// A value with its place and that of its key.
#[derive(Clone, Copy)]
pub struct Item<'s> {
    pub key: TextSpan,
    pub value: &'s DeValue<'s>,
    pub place: TextSpan,
}

/// Items by name; within the pipeline names are few or looked up once.
pub type Items<'s> = BTreeMap<&'s str, Item<'s>>;

/// A value given over what the nodes and the knobs say.
#[derive(Clone)]
pub struct Setting<'s> {
    /// A knob's name, or a node's and the name of one of its keys.
    pub path: Vec<(&'s str, TextSpan)>,
    pub value: &'s DeValue<'s>,
    pub place: TextSpan,
    /// Who gives it, for messages: `--set` or `[batch]`.
    pub from: &'static str,
}

/// What a value is, for messages.
pub fn what(value: &DeValue) -> &'static str {
    match value {
        DeValue::String(_) => "text",
        DeValue::Integer(_) => "a whole number",
        DeValue::Float(_) => "a decimal number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "a list",
        DeValue::Table(_) => "a table",
    }
}

/// Names of nodes, knobs and pipelines: at most 128 letters, digits, `-` and `_`.
pub fn valid_name(name: &str) -> bool {
    (1..=128).contains(&name.len()) && name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'-' || b == b'_')
}

/// The name in exactly `{name}`.
pub fn reference(text: &str) -> Option<&str> {
    text.strip_prefix('{')?.strip_suffix('}').filter(|name| !name.contains(['{', '}']))
}

/// The knobs that a value refers to.
pub fn references<'s>(value: &'s DeValue<'s>, found: &mut Vec<&'s str>) {
    match value {
        DeValue::String(s) => found.extend(reference(s)),
        DeValue::Array(items) => items.iter().for_each(|item| references(item.get_ref(), found)),
        DeValue::Table(table) => table.values().for_each(|item| references(item.get_ref(), found)),
        _ => {}
    }
}
