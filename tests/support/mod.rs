//! Runs the program and says what it did.

use serde_json::Value;
use std::{
    path::Path,
    process::{Command, Output},
};

/// A bake of a stock pipeline in a folder, on the CPU and with a cache of its own; arguments are added by the caller.
pub fn command(folder: &Path, pipeline: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_farfield"));
    command.current_dir(folder).env_remove("FARFIELD_CACHE").env_remove("FARFIELD_REMOTE_CACHE").args([
        "bake",
        pipeline,
        "--backend",
        "cpu",
    ]);
    command
}

/// Runs it: exit code, the names of the nodes that ran and how often, sorted, and what was said.
pub fn outcome(mut command: Command, folder: &Path, pipeline: &str) -> (i32, Vec<String>, String) {
    let Output { status, stdout, stderr } = command.output().unwrap();
    let text = format!("{}{}", String::from_utf8_lossy(&stderr), String::from_utf8_lossy(&stdout));
    let run = std::fs::read_to_string(folder.join("out").join(pipeline).join("run.json"));
    let run: Value = run.map_or(Value::Null, |text| serde_json::from_str(&text).unwrap());
    let mut ran = Vec::new();
    for (name, node) in run["nodes"].as_object().into_iter().flatten() {
        let n = node["runs"].as_u64().unwrap();
        if n > 0 {
            ran.push(format!("{name} {n}"));
        }
    }
    ran.sort();
    (status.code().unwrap_or(-1), ran, text)
}
