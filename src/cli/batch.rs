//! A pipeline with `[batch]`: its bakes one after another, and one table of them all.

use super::{
    Done, Exit,
    backend::Chosen,
    bake::{self, Args},
    interrupt, print,
    quantity::show_seconds,
    summary,
    terminal::say,
};
use crate::{
    engine::{
        bake::{Outcome, Report},
        pipeline,
        plan::Plan,
        publish::{page, table},
        registry::Registry,
        require,
    },
    report::{Batch, BatchRow, Column},
};
use serde_json::Value;
use std::{path::Path, time::Instant};

/// What a certificate may say of a bake: its place there, the column's title there and in the page, whether it is in bytes.
const COLUMNS: [(&str, &str, bool); 15] = [
    ("original_triangles", "original triangles", false),
    ("triangles", "triangles", false),
    ("original_draw_calls", "original draw calls", false),
    ("draw_calls", "draw calls", false),
    ("original_texels", "original texels", false),
    ("texels", "texels", false),
    ("original_memory_bytes", "original memory", true),
    ("memory_bytes", "memory", true),
    ("bytes", "file", true),
    ("psnr_y_object_db.mean", "dB, mean", false),
    ("psnr_y_object_db.min", "dB, worst view", false),
    ("missing_px.ratio", "missing", false),
    ("wrong_surface_px.ratio", "wrong surface", false),
    ("crack_px.total", "crack pixels", false),
    ("max_deviation_px", "outlines moved, px", false),
];

/// `farfield bake`.
pub fn bake(args: &Args, registry: &Registry) -> Done {
    let plan = args.pipeline.load(registry)?;
    let backend = args.backend.open()?;
    if plan.rows.is_empty() { bake::run(args, plan, &backend) } else { run(args, &plan, &backend, registry) }
}

/// Bakes the rows of `plan`, all of them or those that `args` name.
fn run(args: &Args, plan: &Plan, backend: &Chosen, registry: &Registry) -> Done {
    let chosen = chosen(args, plan)?;
    if args.traces() && chosen.len() > 1 {
        return Err(Exit::say(2, "--profile: a trace is of one bake; name one with --row"));
    }
    // Nothing runs before all are known to be sound.
    for row in &chosen {
        args.pipeline
            .load_row(*row, registry)
            .inspect_err(|_| say(format!("in the row `{}` of [batch]", plan.rows[*row])))?;
    }
    let stop = interrupt::stop()?;
    let start = Instant::now();
    let (mut worst, mut rows, mut given) = (0, Vec::new(), Vec::new());
    let (mut hits, mut ran) = (0, 0);
    for (at, row) in chosen.iter().enumerate() {
        let name = &plan.rows[*row];
        if args.speaks() {
            print(&format!("\n[{} of {}] {name}\n", at + 1, chosen.len()))?;
        }
        let plan = args.pipeline.load_row(*row, registry)?;
        let options = args.options(&plan, backend)?;
        let report = match args.bake(&plan, &options, backend, &stop) {
            Ok(report) => report,
            Err(Exit(code)) => {
                worst = worse(worst, code);
                rows.push((name.clone(), plan, None));
                continue;
            }
        };
        args.tell(&plan, &report)?;
        (hits, ran) = (hits + report.hits(), ran + report.runs());
        worst = worse(worst, report.outcome.exit_code());
        given.extend(plan.given.iter().map(|(path, _)| path.clone()));
        let interrupted = report.outcome == Outcome::Interrupted;
        rows.push((name.clone(), plan, Some(report)));
        if interrupted {
            return Err(Exit(worst));
        }
    }
    if args.publishes() {
        // Each once, in the order in which they first come.
        let mut titles: Vec<String> = Vec::new();
        given.into_iter().for_each(|path| {
            if !titles.contains(&path) {
                titles.push(path)
            }
        });
        let rows: Vec<BatchRow> =
            rows.iter().map(|(name, plan, report)| line(name, plan, report.as_ref(), &titles, args.out())).collect();
        let good = rows.iter().filter(|row| row.good).count();
        let count = rows.len();
        write(args, plan, titles, rows)?;
        if args.speaks() {
            let seconds = show_seconds(start.elapsed().as_secs_f64());
            print(&format!(
                "\nbatch: {good} of {count} bakes met all, {hits} hits, {ran} ran, {seconds} → {}\n",
                args.out().join(table::PAGE.0).display()
            ))?;
        }
    }
    if worst == 0 { Ok(()) } else { Err(Exit(worst)) }
}

/// Of two exit codes the one to end with: interruption, then failure, then a certificate that was not met.
fn worse(a: u8, b: u8) -> u8 {
    const RANK: [u8; 5] = [130, 1, 2, 3, 0];
    let rank = |code: u8| RANK.iter().position(|c| *c == code).unwrap_or(1);
    if rank(b) < rank(a) { b } else { a }
}

/// The numbers of the rows to bake.
pub fn chosen(args: &Args, plan: &Plan) -> Result<Vec<usize>, Exit> {
    if args.rows().is_empty() {
        return Ok((0..plan.rows.len()).collect());
    }
    let mut all = Vec::new();
    for name in args.rows() {
        let names = || plan.rows.iter().map(String::as_str);
        let Some(at) = plan.rows.iter().position(|row| row == name) else {
            let hint = pipeline::did_you_mean(name, names());
            let list = pipeline::name_list(names());
            return Err(Exit::say(2, format!("--row {name}: no such row; {hint}the rows of [batch] are {list}")));
        };
        all.push(at);
    }
    all.sort_unstable();
    all.dedup();
    Ok(all)
}

/// The row of a bake; no report: it failed. `out`: where the page lies.
fn line(name: &str, plan: &Plan, report: Option<&Report>, titles: &[String], out: &Path) -> BatchRow {
    let given = |title: &String| {
        let value = plan.given.iter().find(|(path, _)| path == title).map(|(_, value)| value);
        value.map_or(String::new(), |v| v.as_str().map_or_else(|| v.to_string(), str::to_owned))
    };
    let mut row = BatchRow {
        name: name.to_owned(),
        outcome: "failed".to_owned(),
        given: titles.iter().map(given).collect(),
        measured: vec![None; COLUMNS.len()],
        ..BatchRow::default()
    };
    let Some(report) = report else { return row };
    row.outcome = summary::outcome(report.outcome).to_owned();
    row.good = report.outcome == Outcome::Baked;
    if !matches!(report.outcome, Outcome::Baked | Outcome::NotMet) {
        return row;
    }
    row.met = [plan.require.len() - summary::missed(plan, report), plan.require.len()];
    let files = summary::published_files(&report.folder);
    let certificates = summary::certificates(plan, &report.folder, &files);
    // The one that says most: what was baked is judged by pictures before anything else.
    let judged = |json: &&Value| require::at(json, "psnr_y_object_db.mean").is_some();
    let all = || certificates.values().map(|(_, json)| json);
    if let Some(json) = all().find(judged).or_else(|| all().next()) {
        row.verdict = json.get("verdict").and_then(Value::as_str).unwrap_or_default().to_owned();
        row.measured = COLUMNS.iter().map(|(path, ..)| require::at(json, path).and_then(Value::as_f64)).collect();
    }
    if page::find(&report.folder) != page::Found::Nothing {
        // Links lead from the page, which lies in the folder of all results.
        let below = report.folder.strip_prefix(out).ok();
        let parts = below.map(|path| path.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/"));
        row.report = parts.map(|path| format!("{path}/{}", page::REPORT));
    }
    row
}

fn write(args: &Args, plan: &Plan, given: Vec<String>, rows: Vec<BatchRow>) -> Done {
    let wrong = |e: csv::Error| Exit::say(1, e);
    let mut csv = csv::Writer::from_writer(Vec::new());
    let heads = ["bake", "outcome", "verdict", "requirements_met", "requirements"].map(str::to_owned);
    let measured = COLUMNS.iter().map(|(path, ..)| (*path).to_owned());
    csv.write_record(heads.into_iter().chain(given.iter().cloned()).chain(measured)).map_err(wrong)?;
    for row in &rows {
        let own = [
            row.name.clone(),
            row.outcome.clone(),
            row.verdict.clone(),
            row.met[0].to_string(),
            row.met[1].to_string(),
        ];
        let measured = row.measured.iter().map(|v| v.map_or(String::new(), |v| v.to_string()));
        csv.write_record(own.into_iter().chain(row.given.iter().cloned()).chain(measured)).map_err(wrong)?;
    }
    let csv = csv.into_inner().map_err(|e| Exit::say(1, e))?;
    let column = |(_, title, is_bytes): &(&str, &str, bool)| Column { title: (*title).to_owned(), is_bytes: *is_bytes };
    let batch = Batch {
        name: plan.name.clone(),
        about: plan.about.clone(),
        given,
        measured: COLUMNS.iter().map(column).collect(),
        rows,
        version: env!("CARGO_PKG_VERSION").to_owned(),
    };
    table::write(args.out(), &crate::report::batch(&batch), &csv, args.overwrites())?;
    Ok(())
}
