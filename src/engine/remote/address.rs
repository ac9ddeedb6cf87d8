//! From the address of the second level to a store.

use super::RemoteOptions;
use crate::engine::error::EngineError;
use object_store::{
    BackoffConfig, ClientOptions, ObjectStore, RetryConfig, aws::AmazonS3Builder, local::LocalFileSystem, path::Path,
};
use std::{collections::BTreeMap, fs, path::PathBuf, sync::Arc, time::Duration};

/// How long a connection may take to be made.
const CONNECT: Duration = Duration::from_secs(5);
/// A request that failed is repeated so often, within so long a time.
const RETRIES: (usize, Duration) = (2, Duration::from_secs(5));
/// What marks a local cache.
const LOCAL_MARK: &str = "CACHEDIR.TAG";

/// What an address names.
#[derive(Debug, PartialEq, Eq)]
enum Address {
    Bucket { name: String, prefix: String },
    Folder(PathBuf),
}

/// An open store, and the prefix of all of its objects that are ours.
pub struct Opened {
    pub store: Arc<dyn ObjectStore>,
    pub prefix: Path,
    /// What may be wrong where the store refuses or does not answer.
    pub hint: String,
}

fn parse(url: &str) -> Result<Address, String> {
    const EXPECTED: &str = "expected s3://BUCKET/PREFIX, file:///FOLDER, or a folder";
    if let Some(rest) = url.strip_prefix("s3://") {
        let (name, prefix) = rest.split_once('/').unwrap_or((rest, ""));
        if name.is_empty() {
            return Err(format!("it names no bucket; {EXPECTED}"));
        }
        let strange = |c: char| !c.is_ascii_alphanumeric() && !"-._".contains(c);
        if let Some(c) = name.chars().find(|c| strange(*c)) {
            return Err(format!("{c:?} cannot be in a bucket's name; {EXPECTED}"));
        }
        return Ok(Address::Bucket { name: name.to_owned(), prefix: prefix.trim_end_matches('/').to_owned() });
    }
    if let Some(rest) = url.strip_prefix("file://") {
        let rest = rest.strip_prefix("localhost").unwrap_or(rest);
        let path = decoded(rest).filter(|path| path.starts_with('/'));
        // `/C:/folder` is an absolute path on Windows without its first character.
        let path = path.ok_or_else(|| format!("its path is not absolute, or badly encoded; {EXPECTED}"))?;
        let path = if cfg!(windows) { path.trim_start_matches('/') } else { &path };
        return Ok(Address::Folder(path.into()));
    }
    if let Some((scheme, _)) = url.split_once("://") {
        return Err(format!("`{scheme}://` is not known; {EXPECTED}"));
    }
    if url.is_empty() {
        return Err(format!("it is empty; {EXPECTED}"));
    }
    Ok(Address::Folder(url.into()))
}

/// A path of a URL without its `%XX`.
fn decoded(text: &str) -> Option<String> {
    let mut out = Vec::new();
    let mut rest = text.as_bytes();
    while let [first, tail @ ..] = rest {
        rest = tail;
        if *first != b'%' {
            out.push(*first);
            continue;
        }
        let (hex, tail) = rest.split_at_checked(2)?;
        out.push(u8::from_str_radix(std::str::from_utf8(hex).ok()?, 16).ok()?);
        rest = tail;
    }
    String::from_utf8(out).ok()
}

pub fn open(options: &RemoteOptions) -> Result<Opened, EngineError> {
    let fail = |what: String| EngineError::Remote { url: options.url.clone(), what };
    match parse(&options.url).map_err(fail)? {
        Address::Folder(folder) => open_folder(&folder, options.write).map_err(fail),
        Address::Bucket { name, prefix } => open_bucket(&name, &prefix, &options.settings).map_err(fail),
    }
}

fn open_folder(folder: &std::path::Path, write: bool) -> Result<Opened, String> {
    if folder.join(LOCAL_MARK).exists() {
        return Err("it is a local cache, whose layout is another; name a new or an empty folder".to_owned());
    }
    match fs::metadata(folder) {
        Ok(meta) if !meta.is_dir() => return Err("it is a file; expected a folder".to_owned()),
        Ok(_) => {}
        Err(e) if e.kind() == std::io::ErrorKind::NotFound && write => {
            fs::create_dir_all(folder).map_err(|e| format!("the folder cannot be made: {e}"))?;
        }
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
            return Err("there is no such folder; --remote-write makes it".to_owned());
        }
        Err(e) => return Err(format!("the folder cannot be read: {e}")),
    }
    let store = LocalFileSystem::new_with_prefix(folder).map_err(|e| e.to_string())?.with_fsync(true);
    Ok(Opened { store: Arc::new(store), prefix: Path::default(), hint: String::new() })
}

fn open_bucket(name: &str, prefix: &str, settings: &BTreeMap<String, String>) -> Result<Opened, String> {
    let prefix = Path::parse(prefix).map_err(|e| format!("its prefix cannot be used: {e}"))?;
    let set = |name: &str| settings.get(name).filter(|value| !value.is_empty());
    let endpoint = ["AWS_ENDPOINT_URL_S3", "AWS_ENDPOINT_URL", "AWS_ENDPOINT"].into_iter().find_map(set);
    let plain = endpoint.is_some_and(|url| url.starts_with("http://"));
    // Another library of the process may have chosen one before.
    let _ = rustls::crypto::ring::default_provider().install_default();
    let client = ClientOptions::new()
        .with_allow_http(plain)
        .with_connect_timeout(CONNECT)
        // Requests are as long as their bodies: each has a limit of its own.
        .with_timeout_disabled();
    let backoff =
        BackoffConfig { init_backoff: Duration::from_millis(100), max_backoff: Duration::from_secs(1), base: 2.0 };
    let retry = RetryConfig { backoff, max_retries: RETRIES.0, retry_timeout: RETRIES.1 };
    let mut builder = AmazonS3Builder::new();
    for (name, value) in settings.iter().filter(|(name, value)| name.starts_with("AWS_") && !value.is_empty()) {
        // Many variables of that name mean something to other programs only.
        if let Ok(key) = name.to_ascii_lowercase().parse() {
            builder = builder.with_config(key, value);
        }
    }
    let builder = builder.with_bucket_name(name).with_client_options(client).with_retry(retry);
    let builder = match endpoint {
        Some(endpoint) => builder.with_endpoint(endpoint),
        None => builder,
    };
    let store = builder.build().map_err(|e| super::fault::text(&e))?;
    let mut hint = match endpoint {
        // It may hold a password.
        Some(endpoint) if !endpoint.contains('@') => format!("; the endpoint is {endpoint}"),
        Some(_) => String::new(),
        None => "; AWS_ENDPOINT_URL is not set, so it is Amazon's".to_owned(),
    };
    if set("AWS_ACCESS_KEY_ID").is_none() && set("AWS_SKIP_SIGNATURE").is_none() {
        hint += "; AWS_ACCESS_KEY_ID is not set, so the machine's own role was asked for";
    }
    Ok(Opened { store: Arc::new(store), prefix, hint })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_told_apart() {
        let bucket = |name: &str, prefix: &str| Ok(Address::Bucket { name: name.into(), prefix: prefix.into() });
        let folder = |path: &str| Ok(Address::Folder(path.into()));
        assert_eq!(parse("s3://bucket"), bucket("bucket", ""));
        assert_eq!(parse("s3://my.bucket-1/a/b/"), bucket("my.bucket-1", "a/b"));
        assert_eq!(parse("some/folder"), folder("some/folder"));
        if cfg!(unix) {
            assert_eq!(parse("file:///a%20b/c"), folder("/a b/c"));
        }
        for (url, says) in [
            ("s3://", "no bucket"),
            ("s3://a b/c", "' '"),
            ("file://a/b", "not absolute"),
            ("file:///%zz", "badly encoded"),
            ("https://host/bucket", "`https://` is not known"),
            ("", "empty"),
        ] {
            let text = parse(url).unwrap_err();
            assert!(text.contains(says) && text.contains("s3://BUCKET/PREFIX"), "{url}: {text}");
        }
    }
}
