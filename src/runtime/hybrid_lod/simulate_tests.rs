//! Walks over a chessboard of cells.

use super::{
    prefetch::{Footprint, Stride},
    simulate::{Cache, CellData, Cells, Report, Settings, SimulateError, simulate},
};
use crate::view::Pose;
use glam::DVec3;

const SIDE: f64 = 50.0;

/// `n` × `n` squares with eight neighbours each.
struct Board {
    n: usize,
    cells: Vec<CellData>,
    neighbours: Vec<Vec<usize>>,
}

impl Board {
    fn new(n: usize, size: impl Fn(usize) -> (u64, Vec<u64>)) -> Self {
        let cell = |k: usize| {
            let centre = DVec3::new((k % n) as f64 + 0.5, 0.0, (k / n) as f64 + 0.5) * SIDE;
            let (geometry, textures) = size(k);
            CellData { footprint: Footprint { centre, radius: SIDE * 0.71 }, geometry, textures }
        };
        let near = |k: usize| {
            let close = |a: usize, b: usize| a.abs_diff(b) <= 1;
            (0..n * n).filter(|o| *o != k && close(o % n, k % n) && close(o / n, k / n)).collect()
        };
        Self { n, cells: (0..n * n).map(cell).collect(), neighbours: (0..n * n).map(near).collect() }
    }

    fn play(&self, path: &[Pose], settings: &Settings) -> Result<Report, SimulateError> {
        let n = self.n;
        let find = |p: DVec3| {
            let (x, z) = ((p.x / SIDE).floor(), (p.z / SIDE).floor());
            let inside = |v: f64| v >= 0.0 && v < n as f64;
            (inside(x) && inside(z)).then(|| x as usize + z as usize * n)
        };
        simulate(&Cells { cells: &self.cells, neighbours: &self.neighbours, find: &find }, path, settings)
    }

    fn size(&self, k: usize) -> u64 {
        self.cells[k].geometry + self.cells[k].textures.iter().sum::<u64>()
    }
}

/// As large as the paper's cells, different from each other.
fn usual() -> Board {
    Board::new(6, |k| {
        let k = k as u64;
        (800_000 + 10_000 * k, vec![300_000 + 1000 * k, 90_000, 700_000, 5_000 + k, 350_000])
    })
}

/// From left to right through the middle row at the paper's greatest speed, 30 m/s.
fn walk(frames: usize) -> Vec<Pose> {
    let at = |i: usize| DVec3::new(5.0 + i as f64 * 0.5, 1.7, 2.5 * SIDE);
    (0..frames).map(|i| Pose { eye: at(i), aim: DVec3::X }).collect()
}

fn settings() -> Settings {
    Settings { texture_budget: 400_000, ..Settings::default() }
}

#[test]
fn a_walk_waits_for_its_first_cell_only() {
    let board = usual();
    let report = board.play(&walk(560), &settings()).unwrap();
    assert_eq!(report.totals.stalls, 1);
    let first = &report.frames[0];
    assert_eq!((first.cell, first.demanded), (12, board.size(12)));
    assert!((first.stall_ms - board.size(12) as f64 / 35e6 * 1000.0).abs() < 1e-9);
    assert_eq!((report.totals.worst_frame, report.totals.longest_stall_ms), (0, first.stall_ms));
    assert!((report.totals.worst_frame_ms - first.stall_ms - 1000.0 / 60.0).abs() < 1e-9);
    assert_eq!(report.frames.last().unwrap().cell, 17, "the walk crosses five borders");
    // The same without prefetching: a wait at each border.
    let none = board.play(&walk(560), &Settings { prefetch: false, ..settings() }).unwrap();
    assert_eq!(none.totals.stalls, 6);
    assert_eq!(none.totals.bytes_read, (12..18).map(|k| board.size(k)).sum::<u64>());
    assert!(none.totals.longest_stall_ms > 60.0, "2.3 MB at 35 MB/s are {} ms", none.totals.longest_stall_ms);
    assert_eq!(none.totals.cells_in_vain, 0);
}

#[test]
fn the_disks_speed_is_kept() {
    let slow = Settings { disk: 1e6, ..settings() };
    let report = usual().play(&walk(560), &slow).unwrap();
    assert!(report.totals.stalls > 1, "2.3 MB take longer than the 1.7 s in a cell");
    // Never more than the disk has had time for, waits included, but for the rounding of one byte.
    let (mut time, mut read) = (0.0, 0u64);
    for frame in &report.frames {
        time += frame.stall_ms / 1000.0 + 1.0 / 60.0;
        read += frame.bytes_read();
        assert!(read as f64 <= time * slow.disk + 1.0, "{read} bytes in {time} s");
    }
    assert_eq!(read, report.totals.bytes_read);
    assert!(read as f64 > 0.95 * time * slow.disk, "a slow disk is never idle");
    // Where a cell was half read when it was entered, the wait is for the other half.
    let later = report.frames.iter().skip(1).filter(|f| f.demanded > 0).map(|f| f.demanded);
    assert!(later.clone().any(|d| d < 2_000_000), "{:?}", later.collect::<Vec<_>>());
}

#[test]
fn staying_in_one_cell_waits_once() {
    for disk in [1.0, 35e6] {
        let inside = |i: usize| {
            let a = i as f64 * 0.05;
            let around = DVec3::new(libm::cos(a), 0.0, libm::sin(a));
            Pose { eye: DVec3::new(2.5 * SIDE, 1.7, 2.5 * SIDE) + around * 20.0, aim: around }
        };
        let path: Vec<Pose> = (0..300).map(inside).collect();
        let report = usual().play(&path, &Settings { disk, ..settings() }).unwrap();
        assert!(report.frames[0].stall_ms > 0.0);
        assert!(report.frames[1..].iter().all(|f| f.stall_ms == 0.0 && f.demanded == 0 && f.cell == 14));
    }
}

#[test]
fn an_infinite_disk_and_a_warm_cache_never_wait() {
    for settings in [
        Settings { disk: f64::INFINITY, ..settings() },
        Settings { cache: Cache::Warm, disk: 1.0, ..settings() },
        Settings { cache: Cache::Warm, prefetch: false, ..settings() },
    ] {
        let report = usual().play(&walk(560), &settings).unwrap();
        assert_eq!((report.totals.stalls, report.totals.stall_ms), (0, 0.0));
        if settings.prefetch {
            // Neighbours are there one frame after they are asked for.
            assert!(report.frames[1..].iter().all(|f| f.demanded == 0));
        }
    }
}

#[test]
fn without_eviction_every_cell_is_read_once() {
    // All cells are neighbours of all.
    let mut board = usual();
    board.neighbours = (0..36).map(|_| (0..36).collect()).collect();
    let report = board.play(&walk(560), &settings()).unwrap();
    let all: u64 = (0..36).map(|k| board.size(k)).sum();
    assert_eq!((report.totals.bytes_read, report.totals.cells_read), (all, 36));
    assert_eq!(report.totals.cells_in_vain, 0);
    let last = report.frames.last().unwrap();
    assert_eq!((last.memory, report.totals.peak_memory), (all, all));
    let textures: u64 = board.cells.iter().flat_map(|c| &c.textures).sum();
    assert_eq!(last.texture_memory, textures, "9 s bring all of them");
    let uploaded: u64 = report.frames.iter().map(|f| f.texture_bytes).sum();
    assert_eq!(uploaded, textures);
}

#[test]
fn what_is_neither_here_nor_next_is_evicted() {
    let board = usual();
    let report = board.play(&walk(560), &settings()).unwrap();
    for frame in &report.frames {
        let kept = board.neighbours[frame.cell].iter().chain([&frame.cell]).map(|k| board.size(*k));
        assert!(frame.memory <= kept.sum::<u64>() && frame.texture_memory <= frame.memory);
    }
    // Every border leaves three cells of which the viewer saw one.
    assert!(report.totals.cells_in_vain >= 8, "{}", report.totals.cells_in_vain);
    // Back and forth over a border two cells wide reads what was evicted again.
    let there = |i: usize| if (i / 200).is_multiple_of(2) { 0.5 } else { 3.5 } * SIDE;
    let leaps: Vec<Pose> =
        (0..800).map(|i| Pose { eye: DVec3::new(there(i), 0.0, 0.5 * SIDE), aim: DVec3::X }).collect();
    let report = board.play(&leaps, &Settings { prefetch: false, ..settings() }).unwrap();
    assert_eq!(report.totals.bytes_read, 2 * (board.size(0) + board.size(3)));
    assert_eq!(report.totals.stalls, 4);
}

#[test]
fn textures_go_up_within_the_budget() {
    let report = usual().play(&walk(560), &settings()).unwrap();
    for frame in &report.frames {
        assert!(frame.texture_bytes <= 400_000 || (frame.over_budget && frame.textures == 1), "{frame:?}");
    }
    // A texture of 700,000 bytes in every cell is larger than the budget.
    let over = report.frames.iter().filter(|f| f.over_budget).count() as u64;
    assert!(over > 10 && over == report.totals.frames_over_budget);
    // The first cell's textures are there after a few frames, those of the next before they are needed.
    let missing: Vec<usize> = (0..560).filter(|i| report.frames[*i].missing_texture_bytes > 0).collect();
    assert_eq!(missing, [0, 1, 2], "312, 90, 700 and 355 thousand bytes: 402 are too many for one frame");
    assert_eq!(report.totals.frames_with_missing_textures, 3);
    let tight = usual().play(&walk(560), &Settings { texture_budget: 0, ..settings() }).unwrap();
    assert!(tight.frames.iter().all(|f| f.textures <= 1));
}

#[test]
fn cells_ahead_are_read_before_those_behind() {
    // Time for three cells of eight before the border.
    let board = Board::new(5, |_| (1_000_000, Vec::new()));
    let path: Vec<Pose> =
        (0..80).map(|i| Pose { eye: DVec3::new(110.0 + i as f64 * 0.6, 0.0, 125.0), aim: DVec3::X }).collect();
    let slow = Settings { disk: 3.2e6, fov: 1.2, ..settings() };
    let ahead = board.play(&path, &slow).unwrap();
    let entered: Vec<_> = ahead.frames.iter().skip(1).filter(|f| f.demanded > 0).collect();
    assert!(entered.is_empty(), "the cell ahead was read first");
    // The viewer who goes backwards finds nothing.
    let back: Vec<Pose> = path.iter().map(|p| Pose { aim: -p.aim, ..*p }).collect();
    let back = board.play(&back, &slow).unwrap();
    assert_eq!(back.totals.stalls, 2);
}

#[test]
fn the_same_walk_gives_the_same_report() {
    let (a, b) = (usual().play(&walk(300), &settings()).unwrap(), usual().play(&walk(300), &settings()).unwrap());
    assert_eq!(a, b);
    assert_eq!(serde_json::to_string(&a).unwrap(), serde_json::to_string(&b).unwrap());
}

#[test]
fn bad_input_is_an_error() {
    let board = usual();
    let error = |path: &[Pose], s: Settings| board.play(path, &s).unwrap_err().to_string();
    let path = walk(3);
    assert_eq!(error(&[], settings()), "the path has no pose");
    for disk in [0.0, -1.0, f64::NAN] {
        let text = error(&path, Settings { disk, ..settings() });
        assert_eq!(text, format!("speed of the disk: {disk}; expected bytes a second above 0"));
    }
    for time_step in [0.0, f64::NAN, f64::INFINITY] {
        assert!(error(&path, Settings { time_step, ..settings() }).starts_with("time step: "));
    }
    let stride = |distance, angle| Settings { stride: Stride { distance, angle }, ..settings() };
    assert!(error(&path, stride(0.0, 1.0)).starts_with("stride's distance: 0; "));
    assert!(error(&path, stride(1.0, f64::NAN)).starts_with("stride's angle: NaN; "));
    assert!(error(&path, Settings { fov: 3.2, ..settings() }).starts_with("field of view: 3.2; "));
    let with = |pose: Pose| [path[0], pose];
    let lost = Pose { eye: DVec3::new(f64::NAN, 0.0, 0.0), aim: DVec3::X };
    assert!(error(&with(lost), settings()).starts_with("pose 1: eye [NaN, 0, 0] and direction"));
    assert!(error(&with(Pose { aim: DVec3::ZERO, ..path[0] }), settings()).contains("the direction not 0"));
    let outside = Pose { eye: DVec3::new(-1.0, 0.0, 5.0), aim: DVec3::X };
    assert_eq!(error(&with(outside), settings()), "pose 1: [-1, 0, 5] lies in no cell");

    let play = |cells: &[CellData], neighbours: &[Vec<usize>], cell: usize| {
        simulate(&Cells { cells, neighbours, find: &|_| Some(cell) }, &path, &settings()).unwrap_err().to_string()
    };
    assert_eq!(play(&board.cells, &board.neighbours, 36), "pose 0: its cell 36 is none of 36 cells");
    assert_eq!(play(&board.cells, &board.neighbours[1..], 0), "35 lists of neighbours for 36 cells");
    assert_eq!(play(&[], &[], 0), "pose 0: its cell 0 is none of 0 cells");
    let one = &board.cells[..1];
    assert_eq!(play(one, &[vec![1]], 0), "cell 0: its neighbour 1 is none of 1 cells");
    let huge = CellData { geometry: u64::MAX, ..one[0].clone() };
    assert_eq!(play(&[huge], &[vec![]], 0), "cell 0: the sizes of all cells up to this one exceed 64 bits");
    let flat = CellData { footprint: Footprint { radius: 0.0, ..one[0].footprint }, ..one[0].clone() };
    assert!(play(&[flat], &[vec![]], 0).starts_with("cell 0: its centre"));
}
