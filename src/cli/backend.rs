//! `--backend`, `--adapter` and `--gpu-memory`: who renders.

use super::{Exit, quantity::bytes};
use crate::{
    engine::node::Device,
    raster::{Backend, Cpu},
};
use std::sync::Arc;

/// Which back end renders
#[derive(clap::Args)]
pub struct BackendArgs {
    /// Which back end renders; results are the same, bit for bit
    #[arg(long, value_enum, default_value_t = Which::Auto)]
    backend: Which,
    /// Render on the first adapter whose name contains this (see `farfield devices`); implies --backend gpu
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// GPU memory that buffers may take together
    #[arg(long, value_name = "SIZE", default_value = "1GiB", value_parser = bytes)]
    gpu_memory: u64,
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Which {
    /// A GPU where there is one, but never one that is software
    Auto,
    /// The machine's threads
    Cpu,
    /// A GPU; an error where there is none
    Gpu,
}

/// The back end that was chosen.
pub struct Chosen(Arc<dyn Backend>, #[cfg(feature = "gpu")] Option<Arc<gpu::Lazy>>);

impl Chosen {
    pub fn raster(&self) -> &dyn Backend {
        &*self.0
    }

    /// As nodes know it.
    pub fn device(&self) -> Arc<Device> {
        Arc::new(self.0.clone())
    }

    /// Says where the CPU took over.
    pub fn warn(&self) {
        #[cfg(feature = "gpu")]
        self.1
            .iter()
            .flat_map(|gpu| gpu.warnings())
            .for_each(|text| super::terminal::say(format_args!("warning: {text}")));
    }
}

impl BackendArgs {
    pub fn open(&self) -> Result<Chosen, Exit> {
        if self.adapter.is_some() && self.backend == Which::Cpu {
            return Err(Exit::say(2, "--adapter names a GPU, but --backend is cpu"));
        }
        self.chosen()
    }

    #[cfg(feature = "gpu")]
    fn chosen(&self) -> Result<Chosen, Exit> {
        use crate::gpu::{Gpu, GpuError, Wanted};
        let wanted = match (&self.adapter, self.backend) {
            (Some(name), _) => Wanted::Named(name),
            (None, Which::Gpu) => Wanted::Any,
            (None, Which::Auto) => {
                let lazy = Arc::new(gpu::Lazy::new(self.gpu_memory));
                return Ok(Chosen(lazy.clone(), Some(lazy)));
            }
            (None, Which::Cpu) => return Ok(Chosen(Arc::new(Cpu), None)),
        };
        let gpu = Gpu::open(wanted, self.gpu_memory).map_err(|e| match e {
            GpuError::NoAdapter(_) => Exit::say(2, e),
            e => Exit::say(1, e),
        })?;
        if gpu.info.software {
            let text = format!(
                "note: `{}` is a software adapter; it renders on the CPU, and --backend cpu is faster. What it \
                 or its driver prints on standard error is not farfield's",
                gpu.info.name
            );
            super::terminal::say(super::terminal::fill(&text));
        }
        let lazy = Arc::new(gpu::Lazy::with(gpu));
        Ok(Chosen(lazy.clone(), Some(lazy)))
    }

    #[cfg(not(feature = "gpu"))]
    fn chosen(&self) -> Result<Chosen, Exit> {
        if self.adapter.is_some() || self.backend == Which::Gpu {
            return Err(Exit::say(2, "this program was built without the feature `gpu`"));
        }
        Ok(Chosen(Arc::new(Cpu)))
    }
}

#[cfg(feature = "gpu")]
mod gpu {
    use crate::{
        gpu::{Gpu, GpuError, Wanted},
        math::{Stop, Stopped},
        raster::{Backend, Cpu, OnFragments, OnNearest, Prepared},
    };
    use std::sync::OnceLock;

    /// A real GPU that is looked for when something is to be rendered: a bake in which nothing changed need not wait for it.
    pub struct Lazy {
        memory: u64,
        gpu: OnceLock<Result<Gpu, GpuError>>,
    }

    impl Lazy {
        pub fn new(memory: u64) -> Self {
            Self { memory, gpu: OnceLock::new() }
        }

        pub fn with(gpu: Gpu) -> Self {
            Self { memory: 0, gpu: OnceLock::from(Ok(gpu)) }
        }

        fn get(&self) -> &dyn Backend {
            match self.gpu.get_or_init(|| Gpu::open(Wanted::Real, self.memory)) {
                Ok(gpu) => gpu,
                Err(_) => &Cpu,
            }
        }

        pub fn warnings(&self) -> Vec<String> {
            match self.gpu.get() {
                Some(Ok(gpu)) => gpu.warnings(),
                // Most machines of a build farm have none.
                None | Some(Err(GpuError::NoAdapter(_))) => Vec::new(),
                Some(Err(e)) => vec![format!("{e}; the CPU renders")],
            }
        }
    }

    impl Backend for Lazy {
        fn nearest(&self, prepared: &Prepared, stop: &Stop, tile: &OnNearest) -> Result<(), Stopped> {
            self.get().nearest(prepared, stop, tile)
        }

        fn fragments(&self, prepared: &Prepared, stop: &Stop, tile: &OnFragments) -> Result<(), Stopped> {
            self.get().fragments(prepared, stop, tile)
        }
    }
}
