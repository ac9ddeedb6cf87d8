//! Where the cache and the results lie.

use super::Exit;
use crate::engine::remote::RemoteOptions;
use std::path::PathBuf;

#[derive(clap::Args)]
pub struct CacheArg {
    /// The cache folder [default: the environment's FARFIELD_CACHE, else .farfield/cache in the working folder]
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
}

impl CacheArg {
    pub fn folder(&self) -> PathBuf {
        let given = self.cache.clone();
        let from_environment = || std::env::var_os("FARFIELD_CACHE").filter(|v| !v.is_empty()).map(PathBuf::from);
        given.or_else(from_environment).unwrap_or_else(|| PathBuf::from(".farfield/cache"))
    }
}

/// A second level of the cache.
#[derive(clap::Args)]
pub struct RemoteArgs {
    /// A cache that machines share, asked for what the cache folder does not have: a folder, or s3://BUCKET/PREFIX with
    /// the usual AWS_… variables [default: the environment's FARFIELD_REMOTE_CACHE, else none]
    #[arg(long, value_name = "URL")]
    remote_cache: Option<String>,
    /// Upload results there, too: who may write decides what others get [default: whether the environment's
    /// FARFIELD_REMOTE_WRITE is 1]
    #[arg(long)]
    remote_write: bool,
}

impl RemoteArgs {
    pub fn options(&self) -> Result<Option<RemoteOptions>, Exit> {
        let set = |name: &str| std::env::var(name).ok().filter(|v| !v.is_empty());
        let write = self.remote_write || set("FARFIELD_REMOTE_WRITE").is_some_and(|v| v == "1");
        match self.remote_cache.clone().or_else(|| set("FARFIELD_REMOTE_CACHE")) {
            Some(url) => {
                let settings =
                    std::env::vars_os().filter_map(|(k, v)| Some((k.into_string().ok()?, v.into_string().ok()?)));
                let settings = settings.filter(|(name, _)| name.starts_with("AWS_")).collect();
                Ok(Some(RemoteOptions { url, write, settings }))
            }
            None if self.remote_write => {
                let text = "--remote-write: no remote cache is given; name one with --remote-cache URL or FARFIELD_REMOTE_CACHE";
                Err(Exit::say(2, text))
            }
            None => Ok(None),
        }
    }
}
