//! `farfield man`.

use super::{Cli, Done, Exit, print};
use clap::CommandFactory as _;
use std::path::{Path, PathBuf};

/// Prints the manual page, or writes one for the program and each of its commands
///
/// `farfield man | man -l -` shows it; `farfield man ~/.local/share/man/man1` installs all.
#[derive(clap::Args)]
pub struct Args {
    /// The folder for the pages farfield.1, farfield-bake.1, …; made where it is missing. Without it the program's own page goes to
    /// standard output
    #[arg(value_name = "DIR")]
    folder: Option<PathBuf>,
}

pub fn run(args: &Args) -> Done {
    match &args.folder {
        None => print(&page()?),
        Some(folder) => {
            write(folder).map_err(|e| Exit::say(1, format!("{}: {e}", folder.display())))?;
            print(&format!("wrote farfield.1 and a page for each command to {}\n", folder.display()))
        }
    }
}

/// The commands; `help` needs no page.
fn command() -> clap::Command {
    Cli::command().disable_help_subcommand(true)
}

/// The program's own page.
fn page() -> Result<String, Exit> {
    let mut out = Vec::new();
    clap_mangen::Man::new(command()).render(&mut out).map_err(|e| Exit::say(1, e))?;
    Ok(String::from_utf8_lossy(&out).into_owned())
}

fn write(folder: &Path) -> std::io::Result<()> {
    std::fs::create_dir_all(folder)?;
    clap_mangen::generate_to(command(), folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_has_a_page_and_stands_in_that_of_the_program() {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path()).unwrap();
        let main = std::fs::read_to_string(folder.path().join("farfield.1")).unwrap();
        assert_eq!(main, page().ok().unwrap());
        for command in command().get_subcommands() {
            let name = command.get_name();
            assert!(main.contains(&format!("farfield\\-{name}(1)")), "{name}");
            let own = std::fs::read_to_string(folder.path().join(format!("farfield-{name}.1"))).unwrap();
            // The first sentence of its help.
            let about = command.get_about().unwrap().to_string();
            assert!(own.contains(&about.split(' ').next().unwrap().to_owned()), "{name}: {own}");
        }
        assert!(folder.path().join("farfield-cache-gc.1").is_file());
    }
}
