//! What the command line says of itself. `INSTA_UPDATE=always cargo test -p acerra --test help`
//! takes the present texts as the wanted ones.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use acerra::cli::Cli;
use assert_cmd::Command;
use clap::CommandFactory;

fn acerra(arguments: &[&str]) -> String {
    let output = Command::cargo_bin("acerra")
        .unwrap()
        .args(arguments)
        .output()
        .unwrap();
    assert!(output.status.success(), "{arguments:?}");
    String::from_utf8(output.stdout).unwrap()
}

fn commands() -> Vec<clap::Command> {
    let mut all = Cli::command();
    all.build();
    all.get_subcommands()
        .filter(|command| command.get_name() != "help")
        .cloned()
        .collect()
}

/// Columns of the texts compared, whatever the terminal of the test.
const COLUMNS: usize = 100;

#[test]
fn every_help_is_as_it_was() {
    let mut program = Cli::command().term_width(COLUMNS);
    insta::assert_snapshot!("help-acerra", program.render_long_help());
    for command in commands() {
        let mut command = command.term_width(COLUMNS);
        let name = format!("help-{}", command.get_name());
        insta::assert_snapshot!(name, command.render_long_help());
    }
}

#[test]
fn every_help_has_examples_that_are_accepted() {
    for command in commands() {
        let name = command.get_name().to_owned();
        let examples = command.get_after_help().map(ToString::to_string);
        let examples = examples.unwrap_or_else(|| panic!("{name} has no examples"));
        let mut tried = 0;
        for line in examples.lines().map(str::trim) {
            // What a shell would hand over: up to a pipe, a redirection, a comment.
            let end = line.find(['|', '>', '(', '&']).unwrap_or(line.len());
            if let Some(arguments) = line[..end].trim().strip_prefix("acerra ") {
                let words = std::iter::once("acerra").chain(arguments.split_whitespace());
                let parsed = Cli::command().try_get_matches_from(words);
                assert!(parsed.is_ok(), "{line}: {}", parsed.unwrap_err());
                tried += usize::from(arguments.starts_with(&name));
            }
        }
        assert!(tried > 0, "{name} shows no example of itself");
    }
}

#[test]
fn completions_and_manual_pages_name_every_command() {
    let scripts = ["bash", "zsh", "fish"].map(|shell| acerra(&["completions", shell]));
    let folder = tempfile::tempdir().unwrap();
    acerra(&["man", "-o", folder.path().to_str().unwrap()]);
    for command in commands() {
        let name = command.get_name();
        assert!(scripts.iter().all(|script| script.contains(name)), "{name}");
        let page = acerra(&["man", name]);
        assert!(
            page.contains(".SH SYNOPSIS") && page.contains("Examples"),
            "{name}"
        );
        let file = folder.path().join(format!("acerra-{name}.1"));
        assert_eq!(std::fs::read_to_string(file).unwrap(), page);
    }
    assert!(acerra(&["man"]).contains("focus"));
}
