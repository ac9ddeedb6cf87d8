//! What ran and why: changes where they began, and below each what followed from it.

use super::{Page, Reason, markup::Markup, numbers::count};
use std::collections::BTreeMap;

pub fn reasons(m: &mut Markup, page: &Page) {
    let ran = page.nodes.iter().filter(|n| n.runs > 0).count();
    let (all, runs) = (page.nodes.len(), page.nodes.iter().map(|n| n.runs).sum::<u64>());
    if ran == 0 {
        m.with_text("p", &[], &format!("Nothing ran: all {} were taken from the cache.", count(all, "node")));
        return;
    }
    let text = match all - ran {
        0 => format!("{} ran, {} in all.", count(all, "node"), count(runs as usize, "run")),
        rest => format!(
            "{} of {all} nodes ran, {} in all; {} taken from the cache.",
            ran,
            count(runs as usize, "run"),
            if rest == 1 { "1 node was".to_owned() } else { format!("{rest} nodes were") }
        ),
    };
    m.with_text("p", &[], &text);
    let mut below: BTreeMap<&str, Vec<&Reason>> = BTreeMap::new();
    let known = |name: &str| page.reasons.iter().any(|r| r.node == name);
    // Changes that began at several nodes for the same cause are one: a first bake, or a cache that was emptied.
    let mut began: Vec<(&str, Vec<&Reason>)> = Vec::new();
    for reason in &page.reasons {
        match reason.from.as_deref().filter(|from| known(from)) {
            Some(from) => below.entry(from).or_default().push(reason),
            None => match began.iter_mut().find(|(cause, _)| *cause == reason.cause) {
                Some((_, group)) => group.push(reason),
                None => began.push((&reason.cause, vec![reason])),
            },
        }
    }
    m.element("ul", &[("class", "why")], |m| {
        for (cause, group) in began {
            m.element("li", &[], |m| {
                match &group[..] {
                    [one] => step(m, one),
                    all => {
                        let names: Vec<&str> = all.iter().map(|r| &*r.node).collect();
                        m.with_text("b", &[], &names.join(", "));
                        m.text(&format!(" ran: {cause}"));
                    }
                }
                followers(m, &group, &below, page.reasons.len());
            });
        }
    });
}

fn step(m: &mut Markup, reason: &Reason) {
    let rest = reason.did.strip_prefix(&*reason.node);
    m.with_text("b", &[], rest.map_or("", |_| &reason.node)).text(rest.unwrap_or(&reason.did));
    if !reason.cause.is_empty() {
        m.text(": ").with_text("span", &[("class", "cause")], &reason.cause);
    }
}

/// What followed; `depth` bounds how deep, whatever the page says.
fn followers(m: &mut Markup, of: &[&Reason], below: &BTreeMap<&str, Vec<&Reason>>, depth: usize) {
    let all: Vec<&Reason> = of.iter().filter_map(|r| below.get(&*r.node)).flatten().copied().collect();
    let Some(depth) = depth.checked_sub(1).filter(|_| !all.is_empty()) else { return };
    m.element("ul", &[], |m| {
        for reason in all {
            m.element("li", &[], |m| {
                step(m, reason);
                followers(m, &[reason], below, depth);
            });
        }
    });
}
