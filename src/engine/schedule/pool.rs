//! The threads that compute, made when the first run starts: a bake without one has no use for them.

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use std::cell::OnceCell;

pub struct Pool {
    threads: usize,
    made: OnceCell<ThreadPool>,
}

impl Pool {
    pub fn new(threads: usize) -> Self {
        Self { threads, made: OnceCell::new() }
    }

    pub fn get(&self) -> Result<&ThreadPool, ThreadPoolBuildError> {
        if let Some(pool) = self.made.get() {
            return Ok(pool);
        }
        let pool = ThreadPoolBuilder::new().num_threads(self.threads).build()?;
        Ok(self.made.get_or_init(|| pool))
    }
}
