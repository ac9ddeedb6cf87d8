//! The kinds that a program knows, by kind and method, and what is said of names that it does not know.

use super::{
    node::{Kind, KindSpec, Node, kind},
    suggest,
};
use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

/// Methods of a kind that are designed but not built: refused by name.
#[derive(Clone, Copy, Debug)]
pub struct Planned {
    pub kind: &'static str,
    pub methods: &'static [&'static str],
}

/// A name that older pipelines use.
#[derive(Clone, Copy, Debug)]
pub struct Renamed {
    pub kind: &'static str,
    /// The old parameter of the kind; empty: the kind's own name is old.
    pub param: &'static str,
    /// What to write now.
    pub now: &'static str,
}

/// The key of a node that an [`Unknown`] is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum About {
    Kind,
    /// A method that is named.
    Method,
    /// No method is named.
    NoMethod,
}

/// Why kind and method name no type.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unknown {
    pub about: About,
    /// What is wrong, in one line.
    pub message: String,
    /// The same, in two or three words.
    pub label: &'static str,
    /// What can be written instead.
    pub help: String,
}

/// The kinds that a program knows. A value: tests add their own.
#[derive(Clone, Default)]
pub struct Registry {
    kinds: BTreeMap<(&'static str, &'static str), Arc<dyn Kind>>,
    planned: &'static [Planned],
    renamed: &'static [Renamed],
}

impl Registry {
    /// An empty registry that knows of these methods to come and these old names.
    pub fn new(planned: &'static [Planned], renamed: &'static [Renamed]) -> Self {
        Self { kinds: BTreeMap::new(), planned, renamed }
    }

    pub fn add<N: Node>(&mut self) {
        let mixed = self.methods(N::KIND).any(|k| k.spec().method.is_empty() != N::METHOD.is_empty());
        assert!(!mixed, "kind {} has methods with and without a name", N::KIND);
        let old = self.kinds.insert((N::KIND, N::METHOD), kind::<N>());
        assert!(old.is_none(), "kind {} {} is registered twice", N::KIND, N::METHOD);
    }

    /// All kinds and methods, sorted by kind, then by method.
    pub fn iter(&self) -> impl Iterator<Item = &Arc<dyn Kind>> {
        self.kinds.values()
    }

    /// The kinds' names, each once, sorted.
    pub fn names(&self) -> Vec<&'static str> {
        let mut names: Vec<_> = self.kinds.keys().map(|(kind, _)| *kind).collect();
        names.dedup();
        names
    }

    /// The methods of a kind, sorted; one without a name for a kind that has no methods.
    pub fn methods(&self, kind: &str) -> impl Iterator<Item = &Arc<dyn Kind>> {
        self.iter().filter(move |k| k.spec().name == kind)
    }

    /// The methods of a kind that are not built yet.
    pub fn planned(&self, kind: &str) -> &'static [&'static str] {
        self.planned.iter().find(|p| p.kind == kind).map_or(&[], |p| p.methods)
    }

    /// What is written now in place of parameter `param` of `kind`, where pipelines once had it.
    pub fn renamed(&self, kind: &str, param: &str) -> Option<&'static str> {
        self.renamed.iter().find(|r| r.kind == kind && r.param == param).map(|r| r.now)
    }

    /// The type that `kind` and `method` name. A method may be left out where the kind has only one.
    pub fn find(&self, kind: &str, method: Option<&str>) -> Result<&Arc<dyn Kind>, Unknown> {
        let found: Vec<&Arc<dyn Kind>> = self.methods(kind).collect();
        match (&found[..], method) {
            ([], _) => Err(self.unknown_kind(kind)),
            ([only], None) => Ok(only),
            ([only], Some(method)) if only.spec().method.is_empty() => Err(Unknown {
                about: About::Method,
                message: format!("kind `{kind}` has no methods, `{method}` is named"),
                label: "no such method",
                help: "leave `method` out".to_owned(),
            }),
            (_, Some(method)) => {
                let named = found.iter().find(|k| k.spec().method == method);
                named.copied().ok_or_else(|| self.unknown_method(kind, method))
            }
            (_, None) => Err(Unknown {
                about: About::NoMethod,
                message: format!("kind `{kind}` needs a `method`"),
                label: "no method",
                help: format!("method = \"…\", one of{}", self.described(kind)),
            }),
        }
    }

    fn unknown_kind(&self, kind: &str) -> Unknown {
        if let Some(now) = self.renamed(kind, "") {
            return Unknown {
                about: About::Kind,
                message: format!("kind `{kind}` has another name now"),
                label: "an old name",
                help: format!("write {now}"),
            };
        }
        let names = self.names();
        let of: BTreeSet<&str> = self.iter().map(|k| k.spec()).filter(|s| s.method == kind).map(|s| s.name).collect();
        let hint = match of.first() {
            Some(of) => format!("it is a method: write kind = \"{of}\" and method = \"{kind}\"; "),
            None => suggest::did_you_mean(kind, names.iter().copied()),
        };
        Unknown {
            about: About::Kind,
            message: format!("unknown kind `{kind}`"),
            label: "no such kind",
            help: format!("{hint}the kinds are {}", suggest::list(names)),
        }
    }

    fn unknown_method(&self, kind: &str, method: &str) -> Unknown {
        let built = || self.methods(kind).map(|k| k.spec().method);
        if self.planned(kind).contains(&method) {
            return Unknown {
                about: About::Method,
                message: format!("method `{method}` of `{kind}` is not built yet"),
                label: "not built yet",
                help: format!("built: {}", suggest::list(built())),
            };
        }
        let near = suggest::did_you_mean(method, built().chain(self.planned(kind).iter().copied()));
        let knob = if method.starts_with('{') {
            "a method cannot be a knob: `--set NODE.method=…` changes it; "
        } else {
            ""
        };
        Unknown {
            about: About::Method,
            message: format!("kind `{kind}` has no method `{method}`"),
            label: "no such method",
            help: format!("{knob}{near}the methods are {}", suggest::list(built())),
        }
    }

    /// The methods of a kind with what they do, a line each.
    fn described(&self, kind: &str) -> String {
        let line = |spec: &KindSpec| format!("\n`{}`: {}", spec.method, suggest::elide(&spec.summary(), 120));
        self.methods(kind).map(|k| line(k.spec())).collect()
    }
}
