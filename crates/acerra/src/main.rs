//! The `acerra` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    acerra::cli::main()
}
