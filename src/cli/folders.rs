//! Where the cache and the results lie.

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
