//! Names for files that are not finished. A file grows under such a name and is then renamed to its own. The names are
//! random, because a process number with a counter repeats between machines and containers that share a folder.

use std::{
    collections::hash_map::RandomState,
    hash::{BuildHasher as _, Hasher as _},
    path::{Path, PathBuf},
    sync::atomic::{AtomicU64, Ordering},
};

const END: &str = ".farfield-tmp";
/// Hexadecimal digits of the random part.
const DIGITS: usize = 32;

/// 32 lowercase hexadecimal digits that no other process and no other call gives: 128 bits from the system's random
/// numbers, through the keys of the standard library's hasher.
pub fn random() -> String {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let word = || {
        let mut hasher = RandomState::new().build_hasher();
        hasher.write_u64(COUNT.fetch_add(1, Ordering::Relaxed));
        hasher.write_u32(std::process::id());
        hasher.finish()
    };
    format!("{:016x}{:016x}", word(), word())
}

/// A new file name, `.<random>.farfield-tmp`. Its length does not depend on the file's final name.
pub fn name() -> String {
    format!(".{}{END}", random())
}

/// Whether `file_name` is one that [`name`] may have given, in this process or another.
pub fn is_name(file_name: &str) -> bool {
    let random = file_name.strip_prefix('.').and_then(|rest| rest.strip_suffix(END));
    random.is_some_and(is_random)
}

/// Whether `text` has the form that [`random`] gives.
pub fn is_random(text: &str) -> bool {
    text.len() == DIGITS && text.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'))
}

/// A new path in the folder of `path`, so that a rename to `path` stays within one file system.
pub fn beside(path: &Path) -> PathBuf {
    path.with_file_name(name())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn names_differ_and_are_known_again() {
        let names: BTreeSet<String> = (0..10_000).map(|_| name()).collect();
        assert_eq!(names.len(), 10_000);
        assert!(names.iter().all(|n| is_name(n)));
        let path = beside(Path::new("out/a very long name.glb"));
        assert_eq!(path.parent(), Some(Path::new("out")));
        assert!(is_name(&path.file_name().unwrap().to_string_lossy()));
    }

    #[test]
    fn names_of_others_are_not_ours() {
        let digits = "0123456789abcdef0123456789abcdef";
        assert!(is_name(&format!(".{digits}.farfield-tmp")));
        for other in ["notes.txt", ".farfield-tmp", "123-4", ".x.farfield-tmp", &format!("{digits}.farfield-tmp")] {
            assert!(!is_name(other), "{other}");
        }
        assert!(!is_name(&format!(".{}.farfield-tmp", digits.to_uppercase())));
    }
}
