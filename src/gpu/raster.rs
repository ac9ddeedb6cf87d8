//! The rasteriser's operations on a device: work goes to the device's thread, what comes back becomes what the CPU gives.

use super::{
    device::{AdapterInfo, Device, GpuError, Taken, Wanted},
    machine::Machine,
    work::{Band, Room, Table, Triangle, Work, bands},
};
use crate::{
    math::{Stop, Stopped},
    raster::{
        Backend, Cpu, Fragment, NOTHING, OnFragments, OnNearest, Prepared, Samples, ScreenTriangle, TileFragments,
    },
};
use rayon::prelude::*;
use std::{
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, AtomicU64, Ordering},
        mpsc,
    },
    thread::JoinHandle,
};

type Job = Box<dyn FnOnce(&Machine) + Send>;

/// A device with the rasteriser's shaders, on a thread of its own. That thread waits for no other; a worker that waits for it
/// holds nothing that it needs.
pub struct Gpu {
    pub info: AdapterInfo,
    room: Room,
    /// `None` once it is to end.
    jobs: Option<mpsc::Sender<Job>>,
    thread: Option<JoinHandle<()>>,
    /// It failed and is not asked again.
    gone: AtomicBool,
    undecided: AtomicU64,
    taken: Arc<Taken>,
    warnings: Mutex<Vec<String>>,
}

impl Gpu {
    /// Opens an adapter; its buffers take at most `memory` bytes together.
    pub fn open(wanted: Wanted, memory: u64) -> Result<Self, GpuError> {
        let device = Device::open(wanted, memory)?;
        let (info, room) = (device.info.clone(), Room { memory, largest: device.largest_buffer() });
        let taken = device.taken.clone();
        let (jobs, queue) = mpsc::channel::<Job>();
        let (ready, opened) = mpsc::channel();
        let run = move || {
            let machine = match Machine::new(device) {
                Ok(machine) => machine,
                // Nobody waits for the answer any more: nothing is to be done.
                Err(e) => return drop(ready.send(Err(e))),
            };
            drop(ready.send(Ok(())));
            queue.into_iter().for_each(|job| job(&machine));
            if machine.device.check().is_err() {
                // The library panics where it takes down a device that is lost.
                std::mem::forget(machine);
            }
        };
        let failed = |e: std::io::Error| GpuError::Failed(format!("its thread cannot be started: {e}"));
        let thread = std::thread::Builder::new().name("gpu".into()).spawn(run).map_err(failed)?;
        opened.recv().unwrap_or_else(|_| Err(ended()))?;
        Ok(Self {
            info,
            room,
            jobs: Some(jobs),
            thread: Some(thread),
            gone: AtomicBool::new(false),
            undecided: AtomicU64::new(0),
            taken,
            warnings: Mutex::default(),
        })
    }

    pub(super) fn room(&self) -> Room {
        self.room
    }

    /// What the user should know: where the CPU took over.
    pub fn warnings(&self) -> Vec<String> {
        self.warnings.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Of how many tiles, so far, the CPU had to find the nearest surfaces, because several are equally near up to rounding.
    pub fn undecided(&self) -> u64 {
        self.undecided.load(Ordering::Relaxed)
    }

    /// The most bytes that its buffers took together so far, with what they are filled and read through.
    pub fn most_memory(&self) -> u64 {
        self.taken.most()
    }

    /// Runs `f` on the device's thread.
    pub(super) fn call<R: Send + 'static>(
        &self,
        f: impl FnOnce(&Machine) -> Result<R, GpuError> + Send + 'static,
    ) -> Result<R, GpuError> {
        let (answer, answered) = mpsc::channel();
        let jobs = self.jobs.as_ref().ok_or_else(ended)?;
        jobs.send(Box::new(move |machine| drop(answer.send(f(machine))))).map_err(|_| ended())?;
        answered.recv().unwrap_or_else(|_| Err(ended()))
    }

    /// See [`Backend::nearest`].
    fn try_nearest(&self, prepared: &Prepared, stop: &Stop, tile: &OnNearest) -> Result<(), GpuError> {
        let table = Table::new(prepared);
        // Three words a pixel, and two to read them back.
        for band in bands(prepared, &self.room, 20)? {
            let work = Work::new(prepared, &band, &self.room)?;
            let (inner, some_left) = (stop.clone(), work.some_left());
            let [least, greatest] = self.call(move |machine| machine.nearest(&work, &inner))?;
            let width = prepared.view.width as usize;
            band.tiles.into_par_iter().try_for_each_init(Samples::default, |samples, index| {
                stop.check()?;
                let t = prepared.tile(index);
                samples.clear(t.pixels());
                for i in 0..t.pixels() {
                    let (x, y) = t.pixel(i);
                    let at = (y - band.rows.start) as usize * width + x as usize;
                    let Some(last) = greatest[at].checked_sub(1) else { continue };
                    let (first, last) = (!least[at], last);
                    let seen = table.get(first)?;
                    if first != last && seen.triangle != table.get(last)?.triangle {
                        // Several are as near as whole numbers can tell: the exact depths decide.
                        self.undecided.fetch_add(1, Ordering::Relaxed);
                        samples.fill(prepared, index);
                        tile(index, &samples.depth, &samples.triangle);
                        return Ok(());
                    }
                    samples.depth[i] = seen.depth_at(f64::from(x) + 0.5, f64::from(y) + 0.5);
                    samples.triangle[i] = seen.triangle;
                }
                if some_left {
                    prepared.fragments_of(index, left_to_the_cpu(prepared), |x, y, f| {
                        let i = t.at(x, y);
                        let (z, number) = (&mut samples.depth[i], &mut samples.triangle[i]);
                        if f.depth < *z || (f.depth == *z && *number != NOTHING && f.triangle < *number) {
                            (*z, *number) = (f.depth, f.triangle);
                        }
                    });
                }
                tile(index, &samples.depth, &samples.triangle);
                Ok::<(), GpuError>(())
            })?;
        }
        Ok(())
    }

    /// See [`Backend::fragments`].
    fn try_fragments(&self, prepared: &Prepared, stop: &Stop, tile: &OnFragments) -> Result<(), GpuError> {
        let table = Table::new(prepared);
        // Counts, cursors, and what they are read and written through. Bands whose lists do not fit are halved.
        let mut left = bands(prepared, &self.room, 16)?;
        left.reverse();
        while let Some(band) = left.pop() {
            let work = Arc::new(Work::new(prepared, &band, &self.room)?);
            let (same, inner) = (work.clone(), stop.clone());
            let counts = self.call(move |machine| machine.count(&same, &inner))?;
            let total: u64 = counts.iter().map(|c| u64::from(*c)).sum();
            if total * 4 > self.room.of(8) || total > u64::from(u32::MAX) {
                let Some([first, second]) = band.halves(prepared) else {
                    return Err(GpuError::TooSmall { need: total * 32, limit: self.room.memory });
                };
                left.extend([second, first]);
                continue;
            }
            let starts = starts(&counts);
            let (cursors, inner, some_left) = (starts.clone(), stop.clone(), work.some_left());
            let list = self.call(move |machine| machine.list(&work, &cursors, total as usize, &inner))?;
            let found = Found { band: &band, counts: &counts, starts: &starts, list: &list, table: &table, some_left };
            band.tiles.clone().into_par_iter().try_for_each_init(TileFragments::default, |buffer, index| {
                stop.check()?;
                found.collect(prepared, index, buffer)?;
                tile(index, buffer);
                Ok::<(), GpuError>(())
            })?;
        }
        Ok(())
    }

    /// Does on the device what `gpu` does; where that fails, or the device is gone, what `cpu` does.
    fn or_cpu(
        &self,
        gpu: impl FnOnce() -> Result<(), GpuError>,
        cpu: impl FnOnce() -> Result<(), Stopped>,
    ) -> Result<(), Stopped> {
        if !self.gone.load(Ordering::Relaxed) {
            match gpu() {
                Ok(()) => return Ok(()),
                Err(e) => self.take_over(e)?,
            }
        }
        cpu()
    }

    /// The CPU takes over: for this once where memory is too small, for good where the device failed.
    fn take_over(&self, error: GpuError) -> Result<(), Stopped> {
        let text = match error {
            GpuError::Stopped(stopped) => return Err(stopped),
            GpuError::TooSmall { .. } => format!("{}: {error}; the CPU does such views", self.info.name),
            _ => {
                self.gone.store(true, Ordering::Relaxed);
                format!("{}: {error}; the CPU goes on from here", self.info.name)
            }
        };
        let mut warnings = self.warnings.lock().unwrap_or_else(PoisonError::into_inner);
        let kind = |text: &str| text.rsplit("; ").next().map(str::to_owned);
        if !warnings.iter().any(|w| kind(w) == kind(&text)) {
            warnings.push(text);
        }
        Ok(())
    }
}

impl Drop for Gpu {
    /// Waits for the thread: a device should not be taken down while the process ends.
    fn drop(&mut self) {
        self.jobs = None;
        if let Some(thread) = self.thread.take() {
            // A panic of that thread has been told already.
            drop(thread.join());
        }
    }
}

#[cfg(test)]
impl Gpu {
    /// Takes the device away: whatever is asked of it from now on fails.
    pub fn lose(&self) {
        let destroy = |machine: &Machine| {
            machine.device.destroy();
            Ok(())
        };
        self.call(destroy).unwrap();
    }
}

impl Backend for Gpu {
    fn nearest(&self, prepared: &Prepared, stop: &Stop, tile: &OnNearest) -> Result<(), Stopped> {
        self.or_cpu(|| self.try_nearest(prepared, stop, tile), || Cpu.nearest(prepared, stop, tile))
    }

    fn fragments(&self, prepared: &Prepared, stop: &Stop, tile: &OnFragments) -> Result<(), Stopped> {
        self.or_cpu(|| self.try_fragments(prepared, stop, tile), || Cpu.fragments(prepared, stop, tile))
    }
}

fn ended() -> GpuError {
    GpuError::Failed("its thread has ended".into())
}

/// Whether the shaders cannot decide on a triangle.
fn left_to_the_cpu(prepared: &Prepared) -> impl Fn(&ScreenTriangle) -> bool {
    move |t| Triangle::new(t, prepared).is_none()
}

/// Where each list begins.
fn starts(counts: &[u32]) -> Vec<u32> {
    let sums = counts.iter().scan(0, |sum, c| {
        *sum += c;
        Some(*sum - c)
    });
    sums.collect()
}

/// The lists of a band.
struct Found<'a> {
    band: &'a Band,
    counts: &'a [u32],
    starts: &'a [u32],
    list: &'a [u32],
    table: &'a Table<'a>,
    some_left: bool,
}

impl Found<'_> {
    fn collect(&self, prepared: &Prepared, index: u32, out: &mut TileFragments) -> Result<(), GpuError> {
        let tile = prepared.tile(index);
        let mut all: Vec<(u32, Fragment)> = Vec::new();
        for i in 0..tile.pixels() {
            let (x, y) = tile.pixel(i);
            let at = (y - self.band.rows.start) as usize * prepared.view.width as usize + x as usize;
            let from = self.starts[at] as usize;
            for number in &self.list[from..from + self.counts[at] as usize] {
                let t = self.table.get(*number)?;
                let depth = t.depth_at(f64::from(x) + 0.5, f64::from(y) + 0.5);
                all.push((i as u32, Fragment { triangle: t.triangle, depth }));
            }
        }
        if self.some_left {
            prepared.fragments_of(index, left_to_the_cpu(prepared), |x, y, f| all.push((tile.at(x, y) as u32, f)));
        }
        // As the CPU collects them: by ascending number.
        all.sort_unstable_by_key(|(_, f)| f.triangle);
        out.collect(tile.pixels(), all);
        Ok(())
    }
}
