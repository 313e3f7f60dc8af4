//! Running commands in the workspace's root, each under a heading.

use std::path::PathBuf;
use std::process::Command;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use anyhow::{Context, ensure};

/// The Rust suite.
pub const TEST: [&str; 4] = ["cargo", "test", "--workspace", "--locked"];

/// A command with a heading.
pub struct Step<'a> {
    name: &'a str,
    command: &'a [&'a str],
    environment: Vec<(&'a str, String)>,
    folder: Option<PathBuf>,
}

impl<'a> Step<'a> {
    pub fn new(name: &'a str, command: &'a [&'a str]) -> Self {
        Self {
            name,
            command,
            environment: Vec::new(),
            folder: None,
        }
    }

    /// Runs in a folder instead of the workspace's root.
    pub fn within(mut self, folder: PathBuf) -> Self {
        self.folder = Some(folder);
        self
    }

    pub fn with(mut self, variable: &'a str, value: impl Into<String>) -> Self {
        self.environment.push((variable, value.into()));
        self
    }
}

/// Runs steps in the workspace's root.
pub struct Runner {
    pub root: PathBuf,
    /// Checks that this machine cannot run, each with its reason.
    skipped: Mutex<Vec<String>>,
}

impl Runner {
    /// The workspace that this program was built from.
    pub fn in_workspace() -> anyhow::Result<Self> {
        let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
            .parent()
            .context("the workspace's root")?
            .to_owned();
        let skipped = Mutex::default();
        Ok(Self { root, skipped })
    }

    /// Runs a step; its failure is an error.
    pub fn run(&self, step: &Step<'_>) -> anyhow::Result<()> {
        println!("\n== {}: {}", step.name, step.command.join(" "));
        let start = Instant::now();
        let status = self.command(step)?.status();
        let status = status.with_context(|| format!("{}: cannot be run", step.name))?;
        ensure!(status.success(), "{}: {status}", step.name);
        println!(
            "== {} done in {:.0} s",
            step.name,
            start.elapsed().as_secs_f64()
        );
        Ok(())
    }

    /// Runs a step whose output is shown whole at its end, since other steps run in parallel; its failure is
    /// an error.
    pub fn run_quietly(&self, step: &Step<'_>) -> anyhow::Result<()> {
        let start = Instant::now();
        let output = self.command(step)?.output();
        let output = output.with_context(|| format!("{}: cannot be run", step.name))?;
        println!(
            "\n== {}: {}\n{}{}== {} done in {:.0} s",
            step.name,
            step.command.join(" "),
            String::from_utf8_lossy(&output.stdout),
            String::from_utf8_lossy(&output.stderr),
            step.name,
            start.elapsed().as_secs_f64()
        );
        ensure!(output.status.success(), "{}: {}", step.name, output.status);
        Ok(())
    }

    /// A step's command with its environment, in its folder.
    fn command(&self, step: &Step<'_>) -> anyhow::Result<Command> {
        let (program, arguments) = step.command.split_first().context("an empty command")?;
        let mut command = Command::new(program);
        command
            .args(arguments)
            .envs(step.environment.iter().map(|(k, v)| (k, v)))
            .current_dir(step.folder.as_ref().unwrap_or(&self.root));
        Ok(command)
    }

    /// Whether a command runs and succeeds; its output is thrown away.
    pub fn succeeds(&self, command: &[&str]) -> bool {
        let Some((program, arguments)) = command.split_first() else {
            return false;
        };
        Command::new(program)
            .args(arguments)
            .current_dir(&self.root)
            .output()
            .is_ok_and(|output| output.status.success())
    }

    /// Prints that a check is skipped, and keeps the check for [`Runner::print_skipped`].
    pub fn skip(&self, check: &str, reason: &str) {
        println!("\n== {check}: {reason}; skipped");
        let mut skipped = self.skipped.lock().unwrap_or_else(PoisonError::into_inner);
        skipped.push(format!(
            "{check} ({})",
            reason.lines().next().unwrap_or_default()
        ));
    }

    /// Prints one line that lists every skipped check.
    pub fn print_skipped(&self) {
        let skipped = self.skipped.lock().unwrap_or_else(PoisonError::into_inner);
        if skipped.is_empty() {
            println!("\n== not checked: nothing, every check ran");
        } else {
            println!("\n== not checked: {}", skipped.join("; "));
        }
    }

    /// Cargo's target directory.
    pub fn target(&self) -> PathBuf {
        std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| self.root.join("target"), PathBuf::from)
    }

    /// Runs a script of the workspace.
    pub fn script(&self, path: &str, arguments: &[String]) -> anyhow::Result<()> {
        let mut command = vec!["bash", path];
        command.extend(arguments.iter().map(String::as_str));
        self.run(&Step::new(path, &command))
    }
}
