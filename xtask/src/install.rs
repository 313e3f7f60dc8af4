//! The program as a stranger installs it: `cargo install`, then the demonstration with nothing else at hand.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, ensure};

use crate::runner::{Runner, Step};

/// Most bytes of the stripped program.
const MOST_BYTES: u64 = 40_000_000;

/// Products of the demonstration.
const LEFT: [&str; 4] = [
    "index.html",
    "track-1/products/image.npz",
    "track-1/products/report.html",
    "track-2/products/run.json",
];

/// Installs the program from its crate, and runs the demonstration without any variable of the environment, in an empty
/// home, and again in a root directory that holds the program and the libraries that it is linked to alone.
/// `--debug` installs what the tests have built instead: then the size is not checked.
pub fn test(runner: &Runner, options: &[String]) -> anyhow::Result<()> {
    let is_debug = options.iter().any(|option| option == "--debug");
    let here = runner.target().join("installed");
    let _ = fs::remove_dir_all(&here);
    let root = here.display().to_string();
    let path = "cargo install --path crates/acerra --locked --root";
    let mut install: Vec<&str> = path.split_whitespace().chain([root.as_str()]).collect();
    install.extend(is_debug.then_some("--debug"));
    runner.run(&Step::new("cargo install", &install))?;
    let program = here.join("bin/acerra");
    let bytes = fs::metadata(&program)?.len();
    println!("{} has {bytes} bytes", program.display());
    ensure!(
        is_debug || bytes <= MOST_BYTES,
        "expected at most {MOST_BYTES} bytes, found {bytes}"
    );
    let home = here.join("home");
    fs::create_dir_all(&home)?;
    let mut demo = Command::new(&program);
    demo.current_dir(&home).env_clear().env("HOME", &home);
    demonstrate("in an empty environment", demo, &home.join("acerra-demo"))?;
    in_empty_root(runner, &program, &here.join("root"))
}

/// Runs the demonstration in a root directory of its own, where the system lets this user enter one.
fn in_empty_root(runner: &Runner, program: &Path, root: &Path) -> anyhow::Result<()> {
    if !runner.succeeds(&["unshare", "--map-root-user", "chroot", "/", "true"]) {
        runner.skip(
            "the demonstration in an empty root",
            "unshare and chroot cannot be used here",
        );
        return Ok(());
    }
    for file in libraries(program)?.iter().chain([&program.to_owned()]) {
        let inside = root.join(file.strip_prefix("/").unwrap_or(file));
        fs::create_dir_all(inside.parent().context("a library's folder")?)?;
        fs::copy(file, inside).with_context(|| file.display().to_string())?;
    }
    let mut demo = Command::new("unshare");
    demo.env_clear();
    demo.args(["--map-root-user", "--root"]).arg(root);
    demo.args(["--wd", "/"]).arg(program);
    demonstrate("in an empty root", demo, &root.join("acerra-demo"))
}

/// The shared libraries that a program is linked to, by their whole names; none of a static program.
fn libraries(program: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let linked = Command::new("ldd").arg(program).output().context("ldd")?;
    let text = String::from_utf8_lossy(&linked.stdout);
    let named = text.split_whitespace().filter(|word| word.starts_with('/'));
    Ok(named.map(PathBuf::from).collect())
}

/// Runs `demo` by a command, and looks for what it leaves in a folder.
fn demonstrate(place: &str, mut command: Command, folder: &Path) -> anyhow::Result<()> {
    command.args(["demo", "--quiet"]);
    println!("\n== the demonstration {place}: {command:?}");
    let output = command
        .output()
        .context("the demonstration cannot be run")?;
    ensure!(
        output.status.success(),
        "the demonstration {place}: {}\n{}",
        output.status,
        String::from_utf8_lossy(&output.stderr)
    );
    for name in LEFT {
        let product = folder.join(name);
        let bytes = fs::metadata(&product).with_context(|| product.display().to_string())?;
        ensure!(bytes.len() > 0, "{}: empty", product.display());
    }
    println!(
        "== the demonstration {place}: {} and others are there",
        LEFT[1]
    );
    Ok(())
}
