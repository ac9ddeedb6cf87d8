//! `farfield devices`.

use super::{Done, print};

/// Lists the adapters that `--backend gpu` and `--adapter` choose from
#[derive(clap::Args)]
pub struct Args {}

#[cfg(feature = "gpu")]
pub fn run(_: &Args) -> Done {
    use super::quantity::show_bytes;
    let adapters = crate::gpu::adapters();
    if adapters.is_empty() {
        return print("no adapters\n");
    }
    let line = |a: &crate::gpu::AdapterInfo| {
        let software = if a.software { ", software: --backend auto does not take it" } else { "" };
        let largest = show_bytes(a.largest_buffer);
        format!("{} ({}, {}), buffers up to {largest}{software}\n", a.name, a.api, a.driver)
    };
    print(&adapters.iter().map(line).collect::<String>())
}

#[cfg(not(feature = "gpu"))]
pub fn run(_: &Args) -> Done {
    print("no adapters: this program was built without the feature `gpu`\n")
}
