//! The GPU back end of the rasteriser: the only place that names wgpu.
//!
//! Vertices are transformed, clipped and snapped by the code of [`crate::raster`]; shaders decide in whole numbers which samples
//! a triangle covers and which of several is nearer, so that every adapter finds the same. They give triangles' numbers; depths
//! and colours follow from those on the CPU. What shaders cannot decide, materials with holes, planes seen nearly edge-on,
//! pixels where several triangles are equally near up to rounding, the CPU decides and merges. So both back ends give the same,
//! bit for bit, and which of them made a result need not be known.
//!
//! The memory of buffers is known before it is taken (a driver may round it up): a view is worked through in bands of tile rows and its triangles in batches, so that all
//! buffers together stay below the given limit. Where they cannot, or the device fails, the CPU takes over.

mod device;
mod dmesh;
#[cfg(test)]
mod dmesh_tests;
mod hybrid_lod;
#[cfg(test)]
mod hybrid_lod_tests;
mod machine;
mod octahedral;
#[cfg(test)]
mod octahedral_tests;
mod ori;
mod ori_pipeline;
#[cfg(test)]
mod ori_tests;
mod passes;
mod raster;
mod samples;
mod sprite;
#[cfg(test)]
mod tests;
mod work;

pub use device::{AdapterInfo, GpuError, Wanted, adapters};
pub use dmesh::{DrawnByGpu, LoadedDmesh};
pub use ori::LoadedOri;
pub use raster::Gpu;
