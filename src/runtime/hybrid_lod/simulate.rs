//! A walk through the cells against recorded sizes: how long each frame waits for the disk, what is read and what goes to texture memory.
//! No clock and no file takes part: the same input gives the same report.
//!
//! A frame goes like this (Chen et al. 2003, section 3.2):
//!
//! 1. The viewer's cell is looked up. Where it is another than before, cells that are neither it nor its neighbours are evicted, with
//!    what waits for them.
//! 2. Where the timestamp has grown, and for the first pose and in a new cell, its neighbours that are not in memory enter the prefetch queue.
//! 3. The viewer's own cell must be in main memory. Where it is not, the frame waits until the disk has read the rest of it; nothing else is read
//!    meanwhile. That is a stall.
//! 4. Textures go from main memory to texture memory, within the budget. Time on the bus is not counted. What the viewer's cell still lacks
//!    then is reported; the frame is drawn without.
//! 5. While the frame lasts, the disk reads the cells of the prefetch queue. A cell's textures enter the texture queue when the whole
//!    cell is read.
//!
//! Poses belong to frames, so a stall lengthens the walk and moves no later pose.

use super::prefetch::{Footprint, PrefetchQueue, Stride, Texture, TextureQueue, Timestamp, priority};
use crate::view::Pose;
use glam::DVec3;
use serde::Serialize;
use std::collections::BTreeMap;

/// A cell's place and the sizes of its files.
#[derive(Clone, Debug, PartialEq)]
pub struct CellData {
    pub footprint: Footprint,
    /// Bytes of its meshes.
    pub geometry: u64,
    /// Bytes of each of its textures.
    pub textures: Vec<u64>,
}

/// The cells, and which are neighbours of which.
pub struct Cells<'a> {
    pub cells: &'a [CellData],
    /// For each cell the numbers of its neighbours; itself among them does not count.
    pub neighbours: &'a [Vec<usize>],
    /// The cell that holds a point, if any.
    pub find: &'a dyn Fn(DVec3) -> Option<usize>,
}

/// Whether the operating system has the files in memory already.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cache {
    /// Every read goes to the disk, also of a cell that was evicted.
    Cold,
    /// Reads take no time.
    Warm,
}

/// How the walk is played.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Bytes a second, above 0; infinite is allowed.
    pub disk: f64,
    pub cache: Cache,
    /// Whether neighbours are read ahead.
    pub prefetch: bool,
    /// Bytes of textures that go to texture memory before a frame. A texture larger than that goes alone, see [`TextureQueue::upload`].
    pub texture_budget: u64,
    pub stride: Stride,
    /// Horizontal field of view, radians, above 0 and below π.
    pub fov: f64,
    /// Of a frame that does not wait, seconds, above 0.
    pub time_step: f64,
}

/// The paper's disk (section 4.5) and field of view (section 4.1.2); the paper does not give budget and stride.
impl Default for Settings {
    fn default() -> Self {
        Self {
            disk: 35e6,
            cache: Cache::Cold,
            prefetch: true,
            texture_budget: 256 << 10,
            stride: Stride { distance: 5.0, angle: 10f64.to_radians() },
            fov: 60f64.to_radians(),
            time_step: 1.0 / 60.0,
        }
    }
}

/// What one frame needed.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Frame {
    pub cell: usize,
    pub timestamp: u64,
    /// Bytes read while the frame waited, and while it lasted.
    pub demanded: u64,
    pub prefetched: u64,
    /// Milliseconds that the frame waited for the disk; above 0 it is a stall.
    pub stall_ms: f64,
    /// Number and bytes of the textures that went to texture memory.
    pub textures: usize,
    pub texture_bytes: u64,
    /// One texture alone was larger than the budget.
    pub over_budget: bool,
    /// Bytes of the cell's textures that are not in texture memory when the frame is drawn.
    pub missing_texture_bytes: u64,
    /// Bytes in main memory at the end of the frame, a cell that is being read included; and in texture memory.
    pub memory: u64,
    pub texture_memory: u64,
}

impl Frame {
    pub fn bytes_read(&self) -> u64 {
        self.demanded + self.prefetched
    }
}

/// What the walk needed.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Totals {
    pub bytes_read: u64,
    /// Cells read to their end; one that is read again after its eviction counts again.
    pub cells_read: u64,
    /// Cells that were evicted without the viewer having been there, and cells given up while they were read.
    pub cells_in_vain: u64,
    pub stalls: u64,
    pub longest_stall_ms: f64,
    pub stall_ms: f64,
    /// The frame that took longest, the first of such, and its milliseconds with its wait.
    pub worst_frame: usize,
    pub worst_frame_ms: f64,
    pub frames_over_budget: u64,
    pub frames_with_missing_textures: u64,
    /// Most bytes in main memory and in texture memory.
    pub peak_memory: u64,
    pub peak_texture_memory: u64,
}

/// A walk.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Report {
    pub frames: Vec<Frame>,
    pub totals: Totals,
}

/// Why a walk cannot be played.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SimulateError {
    #[error("the path has no pose")]
    EmptyPath,
    #[error("{what}: {found}; expected {expected}")]
    Setting { what: &'static str, found: f64, expected: &'static str },
    #[error("pose {frame}: {what}")]
    Pose { frame: usize, what: String },
    #[error("{found} lists of neighbours for {cells} cells")]
    Neighbours { found: usize, cells: usize },
    #[error("cell {cell}: {what}")]
    Cell { cell: usize, what: String },
}

/// Plays a walk.
///
/// # Errors
/// An empty path, a pose that is not finite or lies in no cell, settings out of range, and cell numbers that do not exist.
pub fn simulate(world: &Cells, path: &[Pose], settings: &Settings) -> Result<Report, SimulateError> {
    check_settings(settings)?;
    let sizes = check_cells(world)?;
    let Some(start) = path.first() else { return Err(SimulateError::EmptyPath) };
    let mut player = Player {
        world,
        settings,
        sizes,
        timestamp: Timestamp::new(*start, settings.stride),
        current: None,
        loaded: BTreeMap::new(),
        reading: None,
        time_owed: 0.0,
        queue: PrefetchQueue::default(),
        textures: TextureQueue::default(),
        totals: Totals::default(),
    };
    let mut frames = Vec::with_capacity(path.len());
    for (number, pose) in path.iter().enumerate() {
        let frame = player.play(number, pose)?;
        player.totals.add(number, &frame, settings.time_step);
        frames.push(frame);
    }
    Ok(Report { frames, totals: player.totals })
}

fn check_settings(settings: &Settings) -> Result<(), SimulateError> {
    let Settings { disk, stride, fov, time_step, .. } = *settings;
    let positive = |v: f64| v > 0.0 && v.is_finite();
    for (what, found, good, expected) in [
        ("speed of the disk", disk, disk > 0.0, "bytes a second above 0"),
        ("time step", time_step, positive(time_step), "seconds above 0"),
        ("stride's distance", stride.distance, positive(stride.distance), "metres above 0"),
        ("stride's angle", stride.angle, positive(stride.angle), "radians above 0"),
        ("field of view", fov, fov > 0.0 && fov < std::f64::consts::PI, "radians above 0 and below π"),
    ] {
        if !good {
            return Err(SimulateError::Setting { what, found, expected });
        }
    }
    Ok(())
}

/// The bytes of each cell.
fn check_cells(world: &Cells) -> Result<Vec<u64>, SimulateError> {
    let count = world.cells.len();
    if world.neighbours.len() != count {
        return Err(SimulateError::Neighbours { found: world.neighbours.len(), cells: count });
    }
    let mut sizes = Vec::with_capacity(count);
    let mut sum = 0u64;
    for (cell, (data, near)) in world.cells.iter().zip(world.neighbours).enumerate() {
        let fault = |what: String| Err(SimulateError::Cell { cell, what });
        if let Some(n) = near.iter().find(|n| **n >= count) {
            return fault(format!("its neighbour {n} is none of {count} cells"));
        }
        let Footprint { centre, radius } = data.footprint;
        if !(centre.is_finite() && radius > 0.0 && radius.is_finite()) {
            return fault(format!(
                "its centre {centre} and radius {radius} m: expected finite ones, the radius above 0"
            ));
        }
        let size = data.textures.iter().try_fold(data.geometry, |a, b| a.checked_add(*b));
        // Of all cells, so that no later sum overflows.
        match size.and_then(|size| Some((size, sum.checked_add(size)?))) {
            Some((size, all)) => (sizes.push(size), sum = all),
            None => return fault("the sizes of all cells up to this one exceed 64 bits".into()),
        };
    }
    Ok(sizes)
}

/// A cell in main memory.
struct Loaded {
    visited: bool,
    /// Bytes of its textures that are in texture memory.
    uploaded: u64,
}

/// A cell that the disk is at.
struct Reading {
    cell: usize,
    left: u64,
}

struct Player<'a> {
    world: &'a Cells<'a>,
    settings: &'a Settings,
    sizes: Vec<u64>,
    timestamp: Timestamp,
    current: Option<usize>,
    loaded: BTreeMap<usize, Loaded>,
    reading: Option<Reading>,
    /// Seconds of the disk that are left of earlier frames: less than one byte's.
    time_owed: f64,
    queue: PrefetchQueue,
    textures: TextureQueue,
    totals: Totals,
}

impl Player<'_> {
    fn play(&mut self, number: usize, pose: &Pose) -> Result<Frame, SimulateError> {
        let cell = self.cell(number, pose)?;
        let mut frame = Frame { cell, ..Frame::default() };
        let grown = self.timestamp.follow(pose);
        frame.timestamp = self.timestamp.now();
        let entered = self.current != Some(cell);
        if entered {
            self.current = Some(cell);
            self.evict(cell);
        }
        if self.settings.prefetch && (grown || entered) {
            self.ask(cell, pose);
        }
        self.demand(cell, &mut frame);
        self.upload(&mut frame);
        self.read_ahead(&mut frame);
        let lacks =
            self.loaded.get(&cell).map_or(0, |l| self.sizes[cell] - self.world.cells[cell].geometry - l.uploaded);
        frame.missing_texture_bytes = lacks;
        let partial = self.reading.as_ref().map_or(0, |r| self.sizes[r.cell] - r.left);
        frame.memory = self.loaded.keys().map(|c| self.sizes[*c]).sum::<u64>() + partial;
        frame.texture_memory = self.loaded.values().map(|l| l.uploaded).sum();
        Ok(frame)
    }

    fn cell(&self, frame: usize, pose: &Pose) -> Result<usize, SimulateError> {
        let fault = |what: String| Err(SimulateError::Pose { frame, what });
        if !(pose.eye.is_finite() && pose.aim.is_finite() && pose.aim.length_squared() > 0.0) {
            let Pose { eye, aim } = pose;
            return fault(format!("eye {eye} and direction {aim}: expected finite ones, the direction not 0"));
        }
        match (self.world.find)(pose.eye) {
            Some(cell) if cell < self.sizes.len() => Ok(cell),
            Some(cell) => fault(format!("its cell {cell} is none of {} cells", self.sizes.len())),
            None => fault(format!("{} lies in no cell", pose.eye)),
        }
    }

    /// Keeps the cell and its neighbours only.
    fn evict(&mut self, cell: usize) {
        let near = &self.world.neighbours[cell];
        let keep = |c: usize| c == cell || near.contains(&c);
        let vain = self.loaded.iter().filter(|(c, l)| !keep(**c) && !l.visited).count() as u64;
        self.loaded.retain(|c, _| keep(*c));
        let given_up = self.reading.take_if(|r| !keep(r.cell)).is_some();
        self.totals.cells_in_vain += vain + u64::from(given_up);
        self.queue.retain(keep);
        self.textures.retain(keep);
    }

    /// Puts the neighbours that are not in memory into the queue.
    fn ask(&mut self, cell: usize, pose: &Pose) {
        let now = self.timestamp.now();
        for near in &self.world.neighbours[cell] {
            let here = *near == cell || self.loaded.contains_key(near);
            if !here && self.reading.as_ref().is_none_or(|r| r.cell != *near) {
                let urgent = priority(pose, self.settings.fov, &self.world.cells[*near].footprint);
                self.queue.push(*near, now, urgent);
            }
        }
    }

    /// Makes sure that the viewer's cell is in main memory.
    fn demand(&mut self, cell: usize, frame: &mut Frame) {
        self.queue.remove(cell);
        if !self.loaded.contains_key(&cell) {
            let begun = self.reading.take_if(|r| r.cell == cell);
            let left = begun.map_or(self.sizes[cell], |r| r.left);
            frame.demanded = left;
            if self.settings.cache == Cache::Cold {
                frame.stall_ms = left as f64 / self.settings.disk * 1000.0;
            }
            self.arrive(cell);
        }
        if let Some(loaded) = self.loaded.get_mut(&cell) {
            loaded.visited = true;
        }
    }

    /// A cell is in main memory from now on.
    fn arrive(&mut self, cell: usize) {
        self.loaded.insert(cell, Loaded { visited: false, uploaded: 0 });
        self.totals.cells_read += 1;
        for (number, bytes) in self.world.cells[cell].textures.iter().enumerate() {
            self.textures.push(Texture { cell, number, bytes: *bytes });
        }
    }

    fn upload(&mut self, frame: &mut Frame) {
        let upload = self.textures.upload(self.settings.texture_budget);
        for texture in &upload.textures {
            if let Some(loaded) = self.loaded.get_mut(&texture.cell) {
                loaded.uploaded += texture.bytes;
            }
        }
        frame.textures = upload.textures.len();
        frame.texture_bytes = upload.bytes;
        frame.over_budget = upload.over_budget;
    }

    /// What the disk reads while a frame lasts.
    fn read_ahead(&mut self, frame: &mut Frame) {
        self.queue.drop_stale(self.timestamp.now());
        let free = self.settings.cache == Cache::Warm;
        let time = self.time_owed + self.settings.time_step;
        // The cast saturates: an infinite speed reads all.
        let mut bytes = if free { u64::MAX } else { (time * self.settings.disk) as u64 };
        let start = bytes;
        loop {
            let next = |q: &mut PrefetchQueue| q.pop().map(|r| Reading { cell: r.cell, left: self.sizes[r.cell] });
            let Some(mut reading) = self.reading.take().or_else(|| next(&mut self.queue)) else {
                // A disk that has nothing to do saves no time up.
                self.time_owed = 0.0;
                break;
            };
            let read = reading.left.min(bytes);
            bytes -= read;
            frame.prefetched += read;
            reading.left -= read;
            if reading.left > 0 {
                self.reading = Some(reading);
                self.time_owed = if free { 0.0 } else { (time - start as f64 / self.settings.disk).max(0.0) };
                break;
            }
            self.arrive(reading.cell);
        }
    }
}

impl Totals {
    fn add(&mut self, number: usize, frame: &Frame, time_step: f64) {
        self.bytes_read = self.bytes_read.saturating_add(frame.bytes_read());
        self.stalls += u64::from(frame.stall_ms > 0.0);
        self.longest_stall_ms = self.longest_stall_ms.max(frame.stall_ms);
        self.stall_ms += frame.stall_ms;
        let took = time_step * 1000.0 + frame.stall_ms;
        if took > self.worst_frame_ms {
            (self.worst_frame, self.worst_frame_ms) = (number, took);
        }
        self.frames_over_budget += u64::from(frame.over_budget);
        self.frames_with_missing_textures += u64::from(frame.missing_texture_bytes > 0);
        self.peak_memory = self.peak_memory.max(frame.memory);
        self.peak_texture_memory = self.peak_texture_memory.max(frame.texture_memory);
    }
}
