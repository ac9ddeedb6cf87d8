//! `farfield completions`.

use super::{Cli, Done, print};
use clap::CommandFactory as _;
use clap_complete::Shell;

/// Prints a shell's completion script
///
/// For bash: farfield completions bash > ~/.local/share/bash-completion/completions/farfield
#[derive(clap::Args)]
pub struct Args {
    /// The shell that the script is for
    #[arg(value_enum)]
    shell: Shell,
}

pub fn run(args: &Args) -> Done {
    print(&script(args.shell))
}

fn script(shell: Shell) -> String {
    let mut out = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "farfield", &mut out);
    String::from_utf8_lossy(&out).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::ValueEnum as _;

    #[test]
    fn every_shell_completes_every_command() {
        for shell in Shell::value_variants() {
            let script = script(*shell);
            for command in Cli::command().get_subcommands() {
                assert!(script.contains(command.get_name()), "{shell}: {} is not completed", command.get_name());
            }
            assert!(script.contains("dry-run"), "{shell}: the options of `bake` are not completed");
        }
    }
}
