//! Adapters and the open device.

use crate::math::{Stop, Stopped};
use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
    time::Duration,
};
use wgpu::{Adapter, DeviceType, Instance, PollType};

/// What an adapter is, for people and for keys.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterInfo {
    pub name: String,
    /// `Vulkan`, `Metal` or `Dx12`.
    pub api: String,
    /// Name and version.
    pub driver: String,
    /// It computes on the CPU.
    pub software: bool,
    /// Largest buffer that a shader can see, bytes.
    pub largest_buffer: u64,
}

/// Why the GPU gave no result.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    #[error("there is no GPU adapter{0}; `farfield devices` lists them")]
    NoAdapter(String),
    #[error("the adapter `{adapter}` gives no device: {cause}")]
    NoDevice { adapter: String, cause: String },
    #[error("the GPU failed: {0}")]
    Failed(String),
    #[error("{need} bytes of GPU memory are needed, the limit is {limit}")]
    TooSmall { need: u64, limit: u64 },
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// An open device.
pub struct Device {
    pub info: AdapterInfo,
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    /// Bytes that its buffers may take together.
    pub(super) memory: u64,
    /// What its buffers take.
    pub(super) taken: Arc<Taken>,
    /// The first error that nobody waited for.
    fault: Fault,
}

/// What went wrong first.
#[derive(Clone, Default)]
struct Fault(Arc<Mutex<Option<String>>>);

impl Fault {
    fn note(&self, text: String) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(text);
    }
}

/// Bytes that buffers take now, and the most that they ever took.
#[derive(Default)]
pub struct Taken {
    now: AtomicU64,
    most: AtomicU64,
}

impl Taken {
    fn add(&self, bytes: u64) {
        let now = self.now.fetch_add(bytes, Ordering::Relaxed) + bytes;
        self.most.fetch_max(now, Ordering::Relaxed);
    }

    pub fn most(&self) -> u64 {
        self.most.load(Ordering::Relaxed)
    }
}

/// A buffer whose bytes are counted while it lives.
pub struct Buffer {
    pub buffer: wgpu::Buffer,
    bytes: u64,
    taken: Arc<Taken>,
}

impl Drop for Buffer {
    fn drop(&mut self) {
        self.taken.now.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

/// The adapters of this machine that can run the back end, real ones first, otherwise in the order of the system.
pub fn adapters() -> Vec<AdapterInfo> {
    found().iter().map(describe).collect()
}

fn found() -> Vec<Adapter> {
    let instance = Instance::new(wgpu::InstanceDescriptor {
        backends: wgpu::Backends::PRIMARY,
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let mut all = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
    let shaders = wgpu::DownlevelFlags::COMPUTE_SHADERS;
    // Five storage buffers, and work groups of 64 threads in one dimension.
    let suits = |l: wgpu::Limits| {
        l.max_storage_buffers_per_shader_stage >= 5
            && l.max_compute_invocations_per_workgroup >= 64
            && l.max_compute_workgroup_size_x >= 64
            && l.max_compute_workgroups_per_dimension >= 65535
    };
    all.retain(|a| a.get_downlevel_capabilities().flags.contains(shaders) && suits(a.limits()));
    all.sort_by_key(|a| match a.get_info().device_type {
        DeviceType::DiscreteGpu => 0,
        DeviceType::IntegratedGpu => 1,
        DeviceType::VirtualGpu | DeviceType::Other => 2,
        DeviceType::Cpu => 3,
    });
    all
}

fn describe(adapter: &Adapter) -> AdapterInfo {
    let info = adapter.get_info();
    AdapterInfo {
        name: info.name,
        api: format!("{:?}", info.backend),
        driver: [info.driver, info.driver_info].join(" ").trim().to_owned(),
        software: info.device_type == DeviceType::Cpu,
        largest_buffer: largest(&adapter.limits()),
    }
}

fn largest(limits: &wgpu::Limits) -> u64 {
    limits.max_storage_buffer_binding_size.min(limits.max_buffer_size)
}

/// Which adapter is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted<'a> {
    /// The first that is no software.
    Real,
    /// The first.
    Any,
    /// The first whose name contains this, whatever the case.
    Named(&'a str),
}

impl Device {
    /// Opens an adapter; its buffers take at most `memory` bytes together.
    pub fn open(wanted: Wanted, memory: u64) -> Result<Self, GpuError> {
        let suits = |a: &Adapter| match wanted {
            Wanted::Real => a.get_info().device_type != DeviceType::Cpu,
            Wanted::Any => true,
            Wanted::Named(name) => a.get_info().name.to_lowercase().contains(&name.to_lowercase()),
        };
        let all = found();
        let adapter = all.iter().find(|a| suits(a)).ok_or_else(|| {
            let names: Vec<_> = all.iter().map(|a| format!("`{}`", a.get_info().name)).collect();
            GpuError::NoAdapter(match (wanted, &names[..]) {
                (_, []) => String::new(),
                (Wanted::Named(name), _) => format!(" whose name contains `{name}`; found {}", names.join(", ")),
                _ => format!(" but software: {}", names.join(", ")),
            })
        })?;
        let info = describe(adapter);
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("farfield"),
            required_limits: adapter.limits(),
            // Blocks as small as can be: the limit is meant for all that is taken.
            memory_hints: wgpu::MemoryHints::MemoryUsage,
            ..wgpu::DeviceDescriptor::default()
        };
        let failed =
            |e: wgpu::RequestDeviceError| GpuError::NoDevice { adapter: info.name.clone(), cause: e.to_string() };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).map_err(failed)?;
        let fault = Fault::default();
        let (on_error, on_loss) = (fault.clone(), fault.clone());
        device.on_uncaptured_error(Arc::new(move |e: wgpu::Error| on_error.note(e.to_string())));
        device.set_device_lost_callback(move |reason, text| {
            if reason != wgpu::DeviceLostReason::Destroyed {
                on_loss.note(format!("the device was lost: {text}"));
            }
        });
        Ok(Self { info, device, queue, memory, taken: Arc::default(), fault })
    }

    /// Largest buffer that can be made, bytes.
    pub(super) fn largest_buffer(&self) -> u64 {
        largest(&self.device.limits()).min(self.memory)
    }

    /// An error if anything has gone wrong since the device was opened.
    pub(super) fn check(&self) -> Result<(), GpuError> {
        match &*self.fault.0.lock().unwrap_or_else(PoisonError::into_inner) {
            Some(text) => Err(GpuError::Failed(text.clone())),
            None => Ok(()),
        }
    }

    /// A buffer; `copies`: how many of its size exist at a time, with those that it is filled through.
    pub(super) fn buffer(&self, size: u64, usage: wgpu::BufferUsages, copies: u64) -> Buffer {
        let size = size.max(16);
        let buffer =
            self.device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false });
        self.taken.add(size * copies);
        Buffer { buffer, bytes: size * copies, taken: self.taken.clone() }
    }

    /// A buffer of zeros that shaders read and write.
    pub(super) fn zeros(&self, bytes: u64) -> Buffer {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        self.buffer(bytes, usage, 1)
    }

    /// A buffer that shaders read.
    pub(super) fn upload<T: bytemuck::NoUninit>(&self, values: &[T], usage: wgpu::BufferUsages) -> Buffer {
        let bytes: &[u8] = bytemuck::cast_slice(values);
        let buffer = self.buffer(bytes.len() as u64, usage | wgpu::BufferUsages::COPY_DST, 2);
        self.queue.write_buffer(&buffer.buffer, 0, bytes);
        buffer
    }

    /// Waits for all work so far and gives the first `count` words of a buffer.
    pub(super) fn read(&self, buffer: &Buffer, count: usize, stop: &Stop) -> Result<Vec<u32>, GpuError> {
        let bytes = count as u64 * 4;
        if count == 0 {
            return Ok(Vec::new());
        }
        let staging = self.buffer(bytes, wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST, 1);
        let staging = &staging.buffer;
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(&buffer.buffer, 0, staging, 0, bytes);
        self.queue.submit([encoder.finish()]);
        let mapped = Arc::new(Mutex::new(None));
        let done = mapped.clone();
        staging.map_async(wgpu::MapMode::Read, .., move |result| {
            *done.lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
        });
        loop {
            self.wait(stop)?;
            match mapped.lock().unwrap_or_else(PoisonError::into_inner).take() {
                Some(Ok(())) => break,
                Some(Err(e)) => return Err(GpuError::Failed(e.to_string())),
                None => {}
            }
        }
        let view = staging.get_mapped_range(..).map_err(|e| GpuError::Failed(e.to_string()))?;
        Ok(bytemuck::pod_collect_to_vec(&view[..]))
    }

    #[cfg(test)]
    pub fn destroy(&self) {
        self.device.destroy();
    }

    /// Waits for all work so far.
    pub(super) fn finish(&self, stop: &Stop) -> Result<(), GpuError> {
        while !self.wait(stop)? {}
        Ok(())
    }

    /// Waits a little for submitted work; whether all of it is done.
    fn wait(&self, stop: &Stop) -> Result<bool, GpuError> {
        stop.check()?;
        self.check()?;
        let timeout = Some(Duration::from_millis(50));
        // The library panics where a device is lost while it is waited for.
        let poll = || self.device.poll(PollType::Wait { submission_index: None, timeout });
        let done = match catch_unwind(AssertUnwindSafe(poll)) {
            Ok(Ok(_)) => true,
            Ok(Err(wgpu::PollError::Timeout)) => false,
            Ok(Err(e)) => return Err(GpuError::Failed(e.to_string())),
            Err(_) => {
                self.fault.note("the device was lost while it was waited for".into());
                false
            }
        };
        self.check()?;
        Ok(done)
    }
}
