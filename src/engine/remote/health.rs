//! Whether the second level is of use: when it is given up, what is told of it, and what went over the wire.

use super::{Traffic, fault::Fault};
use crate::engine::{hash::Digest, lookup::DigestSet};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Failures in succession after which a store that has worked before is given up. No answer counts twice; one that has
/// never worked is given up at its first failure.
const FAILURES: u32 = 3;
/// Damaged objects that are told one by one.
const TOLD: u64 = 3;

/// What was tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Deed {
    Read,
    Write,
}

#[derive(Default)]
struct Inner {
    /// Whether results are read, and whether they are written.
    on: [bool; 2],
    worked: bool,
    failures: u32,
    warnings: Vec<String>,
    damaged: DigestSet,
    damages: u64,
    traffic: Traffic,
}

pub struct Health {
    url: String,
    hint: String,
    inner: Mutex<Inner>,
}

impl Health {
    pub fn new(url: String, hint: String, writes: bool) -> Self {
        Self { url, hint, inner: Mutex::new(Inner { on: [true, writes], ..Inner::default() }) }
    }

    fn inner(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub fn is_on(&self, deed: Deed) -> bool {
        self.inner().on[deed as usize]
    }

    pub fn worked(&self) {
        let mut inner = self.inner();
        (inner.worked, inner.failures) = (true, 0);
    }

    /// Notes a failure, which may be the last. `object`: of what.
    pub fn failed(&self, deed: Deed, object: &str, fault: &Fault) {
        let mut inner = self.inner();
        if !inner.on[deed as usize] {
            return;
        }
        let (url, hint, text) = (&self.url, &self.hint, fault.text());
        let doing = if deed == Deed::Read { "reading" } else { "writing" };
        match fault {
            Fault::Absent | Fault::Present => {}
            Fault::Refused(_) if deed == Deed::Write => {
                inner.on[Deed::Write as usize] = false;
                let rest = if inner.on[Deed::Read as usize] { "; it is still read" } else { "" };
                let text = format!(
                    "the remote cache {url} takes no results: writing {object} was refused ({text}){hint}; nothing more is \
                     uploaded in this bake{rest}"
                );
                inner.warnings.push(text);
            }
            Fault::Refused(_) => {
                inner.on = [false; 2];
                // Who may not list is refused what is absent, too.
                let rights = text.contains("AccessDenied") || text.contains("403");
                let rights =
                    if rights { "; who reads needs the rights to get objects and to list the bucket" } else { "" };
                inner.warnings.push(format!(
                    "the remote cache {url} is off for the rest of this bake, which goes on with the local cache: reading \
                     {object} was refused ({text}){hint}{rights}"
                ));
            }
            Fault::Silent(_) | Fault::Other(_) => {
                inner.failures += if matches!(fault, Fault::Silent(_)) { 2 } else { 1 };
                if inner.worked && inner.failures < FAILURES {
                    return;
                }
                inner.on = [false; 2];
                inner.warnings.push(format!(
                    "the remote cache {url} is off for the rest of this bake, which goes on with the local cache: {doing} \
                     {object} failed ({text}){hint}"
                ));
            }
        }
    }

    /// Notes an object that is not what it should be: it counts as absent, and whoever makes its content replaces it.
    pub fn damaged(&self, of: Digest, object: &str, what: &str) {
        let mut inner = self.inner();
        if inner.damaged.contains(&of) {
            return;
        }
        inner.damaged.insert(of);
        inner.damages += 1;
        if inner.damages <= TOLD {
            let text = format!("{object} in the remote cache {} is damaged ({what}); it is not used", self.url);
            inner.warnings.push(text);
        }
    }

    /// Whether an object was found damaged.
    pub fn is_damaged(&self, of: &Digest) -> bool {
        self.inner().damaged.contains(of)
    }

    pub fn repaired(&self, of: &Digest) {
        self.inner().damaged.remove(of);
    }

    pub fn count(&self, add: impl FnOnce(&mut Traffic)) {
        add(&mut self.inner().traffic);
    }

    pub fn traffic(&self) -> Traffic {
        self.inner().traffic
    }

    /// What there is to tell.
    pub fn warnings(&self) -> Vec<String> {
        std::mem::take(&mut self.inner().warnings)
    }

    /// What is left to tell at the end.
    pub fn close(&self, unsent: u64) {
        let mut inner = self.inner();
        let more = inner.damages.saturating_sub(TOLD);
        if more > 0 {
            let text = format!("{more} more objects in the remote cache {} are damaged", self.url);
            inner.warnings.push(text);
        }
        if unsent > 0 && inner.on[Deed::Write as usize] {
            let text = format!("{unsent} results were not uploaded to the remote cache {}", self.url);
            inner.warnings.push(text);
        }
        inner.on = [false; 2];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn health() -> Health {
        Health::new("s3://b".to_owned(), String::new(), true)
    }

    #[test]
    fn a_store_that_never_worked_is_given_up_at_once_with_one_warning() {
        let h = health();
        for _ in 0..5 {
            h.failed(Deed::Read, "run/a", &Fault::Other("refused".into()));
        }
        assert!(!h.is_on(Deed::Read) && !h.is_on(Deed::Write));
        let told = h.warnings();
        assert_eq!(told.len(), 1);
        assert!(told[0].contains("s3://b") && told[0].contains("run/a") && told[0].contains("refused"), "{told:?}");
    }

    #[test]
    fn one_that_works_may_fail_now_and_then() {
        let h = health();
        for _ in 0..10 {
            h.worked();
            h.failed(Deed::Read, "a", &Fault::Silent("no answer".into()));
        }
        assert!(h.is_on(Deed::Read) && h.warnings().is_empty());
        h.failed(Deed::Write, "a", &Fault::Other("reset".into()));
        assert!(!h.is_on(Deed::Read) && h.warnings().len() == 1);
    }

    #[test]
    fn what_cannot_be_written_is_still_read() {
        let h = health();
        h.failed(Deed::Write, "run/a", &Fault::Refused("AccessDenied".into()));
        h.failed(Deed::Write, "run/b", &Fault::Refused("AccessDenied".into()));
        assert!(h.is_on(Deed::Read) && !h.is_on(Deed::Write));
        assert_eq!(h.warnings().len(), 1);
        h.failed(Deed::Read, "run/b", &Fault::Absent);
        assert!(h.is_on(Deed::Read) && h.warnings().is_empty());
    }

    #[test]
    fn much_damage_is_told_in_few_words() {
        let h = health();
        for i in 0..100u8 {
            h.damaged(Digest([i; 32]), "value/a", "cut");
            h.damaged(Digest([i; 32]), "value/a", "cut");
        }
        h.close(0);
        let told = h.warnings();
        assert_eq!(told.len(), 4);
        assert!(told[3].contains("97 more"));
    }
}
