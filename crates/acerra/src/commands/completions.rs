//! `acerra completions`: completion scripts for shells.

use std::io::Write;

use clap_complete::Shell;

/// Print the completions of a shell.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acerra completions bash > ~/.local/share/bash-completion/completions/acerra
  acerra completions zsh > \"${fpath[1]}/_acerra\"
  acerra completions fish > ~/.config/fish/completions/acerra.fish")]
pub struct Args {
    /// Which shell.
    #[arg(value_enum)]
    shell: Shell,
}

/// Writes the completions of `command`, the whole command line, to `out`.
///
/// # Errors
/// Standard output cannot be written.
pub fn run(args: &Args, mut command: clap::Command, out: &mut dyn Write) -> anyhow::Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command, "acerra", &mut script);
    out.write_all(&script)?;
    Ok(())
}
