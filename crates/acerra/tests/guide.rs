//! The user guide: its first flight is flown from its own text, its examples are accepted, and it
//! describes every finding.

#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use acerra::cli::Cli;
use acerra_chain::campaign::Campaign;
use clap::CommandFactory;

/// A fenced block of a page.
#[derive(Debug)]
struct Block {
    page: String,
    line: usize,
    language: String,
    text: String,
}

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn guide() -> PathBuf {
    repository().join("docs/guide/src")
}

/// Name and text of every page.
fn pages() -> Vec<(String, String)> {
    let mut pages: Vec<(String, String)> = fs::read_dir(guide())
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "md"))
        .map(|path| {
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            (name, fs::read_to_string(path).unwrap())
        })
        .collect();
    pages.sort();
    pages
}

fn blocks(page: &str, text: &str) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    let mut is_open = false;
    for (k, line) in text.lines().enumerate() {
        match line.strip_prefix("```") {
            Some(_) if is_open => is_open = false,
            Some(language) => {
                is_open = true;
                blocks.push(Block {
                    page: page.to_owned(),
                    line: k + 1,
                    language: language.to_owned(),
                    text: String::new(),
                });
            }
            None if is_open => {
                let block = blocks.last_mut().unwrap();
                block.text.push_str(line);
                block.text.push('\n');
            }
            None => {}
        }
    }
    assert!(!is_open, "{page}: a block is not closed");
    blocks
}

fn all_blocks(language: &str) -> Vec<Block> {
    let of_page = |(name, text): (String, String)| blocks(&name, &text);
    let mut found: Vec<Block> = pages().into_iter().flat_map(of_page).collect();
    found.retain(|block| block.language == language);
    found
}

/// The first flight as a newcomer flies it: every `sh` block of the page, in order, in an empty
/// directory, with no key edited.
#[cfg(unix)]
mod first_flight {
    use super::*;
    use serde_json::Value;
    use std::process::Command;

    /// Along the track nobody has stated that the radar sits 5 cm ahead of the GNSS antenna; the
    /// clock offset and the image itself add some centimetres.
    const ALONG_M: f64 = 0.15;
    /// Across the track an error of the height above ground counts h/d = 5 times at 2 m beside the
    /// track and 10 m of height: 6 cm of it.
    const ACROSS_M: f64 = 0.30;

    #[test]
    fn a_newcomer_gets_from_raw_logs_to_the_reflectors() {
        let folder = tempfile::tempdir().unwrap();
        let script = script();
        let shown = run(&script, folder.path());
        let truth = json(&folder.path().join("acerra-demo/track-2/truth.json"));
        let products = folder.path().join("flight/flight-products");
        let targets = json(&products.join("targets.json"));
        let strongest: Vec<[f64; 2]> = targets["targets"]
            .as_array()
            .unwrap()
            .iter()
            .take(2)
            .map(|target| [&target["x_m"], &target["y_m"]].map(number))
            .collect();
        let base = place(&truth["base_m"]);
        for reflector in truth["targets_m"].as_array().unwrap() {
            let reflector = place(reflector);
            // Positions count from the base's antenna, as the page says.
            let expected: [f64; 2] = [0, 1].map(|k| reflector[k] - base[k]);
            let is_there = |found: &&[f64; 2]| {
                (found[0] - expected[0]).abs() < ALONG_M
                    && (found[1] - expected[1]).abs() < ACROSS_M
            };
            assert!(
                strongest.iter().any(|found| is_there(&found)),
                "a reflector at {expected:?} m, the two strongest targets at {strongest:?} m\n{shown}"
            );
        }
        let record = json(&products.join("run.json"));
        for finding in record["evidence"].as_array().unwrap() {
            assert_ne!(finding["verdict"], "contradicts", "{finding}");
        }
    }

    /// The page's commands. Whatever edits a file has no place among them.
    fn script() -> String {
        let page = fs::read_to_string(guide().join("first-flight.md")).unwrap();
        let commands: Vec<Block> = blocks("first-flight.md", &page)
            .into_iter()
            .filter(|block| block.language == "sh")
            .collect();
        for block in &commands {
            for line in block.text.lines() {
                let word = line.split_whitespace().next().unwrap_or_default();
                assert!(
                    ["acerra", "cd", "cp", "mkdir"].contains(&word),
                    "{}:{}: {line}",
                    block.page,
                    block.line
                );
            }
        }
        let text: String = commands.into_iter().map(|block| block.text).collect();
        for wanted in ["acerra init ", "acerra focus "] {
            assert!(text.contains(wanted), "{wanted}: {text}");
        }
        text
    }

    fn run(script: &str, folder: &Path) -> String {
        let program = Path::new(env!("CARGO_BIN_EXE_acerra"));
        let mut search = vec![program.parent().unwrap().to_owned()];
        search.extend(std::env::split_paths(
            &std::env::var_os("PATH").unwrap_or_default(),
        ));
        let output = Command::new("sh")
            .args(["-e", "-x", "-c", script])
            .current_dir(folder)
            .env("PATH", std::env::join_paths(search).unwrap())
            .output()
            .unwrap();
        let shown = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
        let shown = shown.join("\n");
        assert!(output.status.success(), "{shown}");
        shown
    }

    fn json(path: &Path) -> Value {
        let text = fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        serde_json::from_str(&text).unwrap()
    }

    fn number(value: &Value) -> f64 {
        value.as_f64().unwrap()
    }

    fn place(value: &Value) -> [f64; 3] {
        [0, 1, 2].map(|k| number(&value[k]))
    }
}

#[test]
fn every_command_of_the_guide_is_accepted() {
    let mut tried = 0;
    for block in all_blocks("sh") {
        for line in block
            .text
            .lines()
            .filter(|line| line.starts_with("acerra "))
        {
            // Redirections and variables are the shell's.
            let line = line.replace("$SLURM_ARRAY_TASK_ID", "1");
            let words = line.split_whitespace().take_while(|word| *word != ">");
            let parsed = Cli::command().try_get_matches_from(words);
            if let Err(error) = parsed {
                panic!("{}:{}: {line}\n{error}", block.page, block.line);
            }
            tried += 1;
        }
    }
    assert!(tried > 10, "{tried}");
}

#[test]
fn every_setting_of_the_guide_is_accepted() {
    let examples = all_blocks("toml");
    for block in &examples {
        if let Err(error) = Campaign::parse(&completed(&block.text)) {
            panic!("{}:{}: {error}\n{}", block.page, block.line, block.text);
        }
    }
    assert!(examples.len() > 5, "{}", examples.len());
}

/// An excerpt of a campaign with what every campaign must state.
fn completed(excerpt: &str) -> String {
    let has = |key: &str| excerpt.lines().any(|line| line.starts_with(key));
    let mut text = excerpt.to_owned();
    for (table, key, lines) in [
        ("[radar]", "file = ", "file = \"flight.mrm\"\n"),
        ("[image]", "x_m = ", "x_m = [0, 1]\ny_m = [0, 1]\n"),
    ] {
        // Tracks bring radar logs of their own, and `files` names several.
        if table == "[radar]" && (has("[[track]]") || has("files = ")) {
            continue;
        }
        if !has(table) {
            text.push_str(&format!("\n{table}\n{lines}"));
        } else if !has(key) {
            text = text.replacen(&format!("{table}\n"), &format!("{table}\n{lines}"), 1);
        }
    }
    text
}

#[test]
fn every_finding_is_described() {
    let described = fs::read_to_string(guide().join("evidence.md")).unwrap();
    let folder = repository().join("crates/acerra-chain/src");
    let mut names = BTreeSet::new();
    for file in sources(&folder) {
        let text = fs::read_to_string(file).unwrap();
        let code = text.split("#[cfg(test)]").next().unwrap_or_default();
        names.extend(finding_names(code));
    }
    assert!(names.len() > 5, "{names:?}");
    for name in names {
        assert!(
            described.contains(&format!("\n### `{name}`\n")),
            "docs/guide/src/evidence.md does not describe the finding {name}"
        );
    }
}

/// Files of Rust in a folder and those below it.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
    let (folders, files): (Vec<_>, Vec<_>) = entries.partition(|path| path.is_dir());
    let mut found: Vec<PathBuf> = folders.iter().flat_map(|f| sources(f)).collect();
    found.extend(
        files
            .into_iter()
            .filter(|file| file.extension().is_some_and(|e| e == "rs")),
    );
    found
}

/// Names given to findings where they are made, examples in comments left out.
fn finding_names(code: &str) -> BTreeSet<String> {
    let code: String = code
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"))
        .collect();
    let made = ["Finding::compared(", "Finding::judged("];
    let after = made.iter().flat_map(|call| code.split(call).skip(1));
    after
        .filter_map(|rest| rest.trim_start().strip_prefix('"'))
        .filter_map(|rest| rest.split('"').next())
        .map(str::to_owned)
        .collect()
}

#[test]
fn every_page_is_listed_and_every_link_leads_somewhere() {
    let summary = fs::read_to_string(guide().join("SUMMARY.md")).unwrap();
    for (name, text) in pages() {
        assert!(
            name == "SUMMARY.md" || summary.contains(&format!("]({name})")),
            "SUMMARY.md does not list {name}"
        );
        for target in text.split("](").skip(1) {
            let target = target.split([')', '#']).next().unwrap_or_default();
            if target.is_empty() || target.contains("://") {
                continue;
            }
            assert!(guide().join(target).exists(), "{name} links {target}");
        }
    }
}
