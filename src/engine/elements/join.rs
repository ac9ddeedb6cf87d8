//! The join of lists by the names of their elements.

use super::{ElementError, pick};
use crate::engine::value::{JOIN, shown};
use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

/// Axes as the node numbers them, names on these axes, and the port that they come from.
pub type OwnedSide<'a> = (Vec<usize>, Vec<Arc<str>>, &'a str);
pub type Side<'a> = (&'a [usize], &'a [Arc<str>], &'a str);

/// Tuples that agree on the axes that both sides have. A name that one side lacks is an error unless `lenient`, or
/// unless that side has further axes: its list below that name may be empty.
pub fn natural_join(a: Side, b: Side, lenient: bool) -> Result<(Vec<usize>, Vec<Arc<str>>), ElementError> {
    let shared: Vec<usize> = a.0.iter().filter(|x| b.0.contains(x)).copied().collect();
    let at =
        |axes: &[usize]| -> Vec<usize> { shared.iter().filter_map(|s| axes.iter().position(|x| x == s)).collect() };
    let (in_a, in_b) = (at(a.0), at(b.0));
    let extra: Vec<usize> = (0..b.0.len()).filter(|i| !shared.contains(&b.0[*i])).collect();
    let mut by_key: BTreeMap<String, Vec<&Arc<str>>> = BTreeMap::new();
    for name in b.1 {
        by_key.entry(pick(name, &in_b)).or_default().push(name);
    }
    let mut met = BTreeSet::new();
    let mut out = Vec::new();
    let missing = |name: &str, side: &str, other: &str| {
        ElementError(format!(
            "input `{other}` has the element `{}`, input `{side}` has not; say `join = \"inner\"` to drop it",
            shown(name)
        ))
    };
    for name in a.1 {
        let key = pick(name, &in_a);
        match by_key.get(&key) {
            Some(others) => {
                for other in others {
                    let tail = pick(other, &extra);
                    out.push(if extra.is_empty() { name.clone() } else { format!("{name}{JOIN}{tail}").into() });
                }
                met.insert(key);
            }
            None if lenient || !extra.is_empty() => {}
            None => return Err(missing(&key, b.2, a.2)),
        }
    }
    if !lenient
        && shared.len() == a.0.len()
        && let Some(key) = by_key.keys().find(|k| !met.contains(*k))
    {
        return Err(missing(key, a.2, b.2));
    }
    let axes = a.0.iter().copied().chain(extra.iter().map(|i| b.0[*i])).collect();
    Ok((axes, out))
}
