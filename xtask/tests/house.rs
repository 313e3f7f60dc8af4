//! The layers of ARCHITECTURE.md hold: crates depend downwards, and no two files import each other.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::fs;
use std::path::Path;

use xtask::house::{Fault, House};

/// A workspace of one crate with the given files.
fn workspace(name: &str, dependencies: &str, files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("crates").join(name).join("src");
    fs::create_dir_all(&source).unwrap();
    let manifest = format!("[package]\nname = \"{name}\"\n[dependencies]\n{dependencies}");
    fs::write(source.parent().unwrap().join("Cargo.toml"), manifest).unwrap();
    for (file, text) in files {
        fs::create_dir_all(source.join(file).parent().unwrap()).unwrap();
        fs::write(source.join(file), text).unwrap();
    }
    folder
}

#[test]
fn a_circle_is_seen_through_re_exports_and_paths() {
    let folder = workspace(
        "acerra-geo",
        "",
        &[
            (
                "lib.rs",
                "mod a;\nmod b;\npub use a::A;\npub use b::make;\n",
            ),
            (
                "a.rs",
                "pub struct A;\npub fn first() -> u8 { crate::make() }\n",
            ),
            (
                "b.rs",
                "use crate::A;\npub fn make() -> u8 { let _ = A; 1 }\n",
            ),
        ],
    );
    let faults = House::read(folder.path()).unwrap().faults();
    assert_eq!(faults.len(), 1);
    let said = faults[0].to_string();
    assert!(
        said.contains("src/a.rs") && said.contains("src/b.rs"),
        "{said}"
    );
}

#[test]
fn a_parent_that_calls_its_child_which_uses_the_parents_type_is_a_circle() {
    let folder = workspace(
        "acerra-geo",
        "",
        &[
            ("lib.rs", "pub mod a;\n"),
            (
                "a/mod.rs",
                "mod b;\npub struct A;\npub fn run() { b::help(&A) }\n",
            ),
            ("a/b.rs", "use super::A;\npub fn help(_: &A) {}\n"),
        ],
    );
    assert_eq!(House::read(folder.path()).unwrap().faults().len(), 1);
}

#[test]
fn a_circle_is_seen_through_a_used_module_and_through_macros() {
    let folder = workspace(
        "acerra-geo",
        "",
        &[
            ("lib.rs", "mod commands;\nmod cli;\nmod third;\n"),
            (
                "cli.rs",
                "use crate::commands;\npub struct Cli;\npub fn run() { commands::man::run() }\n",
            ),
            ("commands/mod.rs", "pub mod man;\n"),
            (
                "commands/man.rs",
                "use crate::cli::Cli;\npub fn run() { let _ = Cli; }\npub fn page() { println!(\"{}\", crate::third::name()) }\n",
            ),
            (
                "third.rs",
                "pub fn name() -> u8 { vec![crate::commands::man::run()]; 1 }\n",
            ),
        ],
    );
    let faults = House::read(folder.path()).unwrap().faults();
    assert_eq!(faults.len(), 1);
    let text = faults[0].to_string();
    for file in ["src/cli.rs", "src/commands/man.rs", "src/third.rs"] {
        assert!(text.contains(file), "{file} is missing: {text}");
    }
}

#[test]
fn rooms_of_a_crate_that_import_one_another_are_named_with_their_imports() {
    let folder = workspace(
        "acerra-gnss",
        "",
        &[
            ("lib.rs", "mod read;\nmod focus;\nmod prepare;\n"),
            ("read/mod.rs", "pub mod log;\npub struct Log;\n"),
            (
                "read/log.rs",
                "pub fn pixels() -> crate::focus::grid::Grid { crate::focus::grid::Grid }\n",
            ),
            (
                "focus/mod.rs",
                "pub mod grid;\npub fn run(_: crate::read::Log) {}\n",
            ),
            ("focus/grid.rs", "pub struct Grid;\n"),
            (
                "prepare.rs",
                "pub fn run() { crate::focus::run(crate::read::Log) }\n",
            ),
        ],
    );
    let faults = House::read(folder.path()).unwrap().faults();
    assert_eq!(faults.len(), 1);
    let text = faults[0].to_string();
    assert!(
        text.contains("src/read/log.rs imports crates/acerra-gnss/src/focus/grid.rs"),
        "{text}"
    );
    assert!(!text.contains("prepare"), "{text}");
}

#[test]
fn what_is_handed_on_or_tested_ties_no_files() {
    let folder = workspace(
        "acerra-geo",
        "",
        &[
            ("lib.rs", "mod a;\nmod b;\npub use a::A;\npub use b::B;\n"),
            (
                "a.rs",
                "pub struct A;\n#[cfg(test)]\nmod tests { use crate::B; }\n",
            ),
            ("b.rs", "use crate::A;\npub struct B(pub A);\n"),
        ],
    );
    assert_eq!(House::read(folder.path()).unwrap().faults(), []);
}

#[test]
fn a_crate_that_depends_on_one_above_is_named() {
    let folder = workspace(
        "acerra-geo",
        "acerra-chain.workspace = true\n",
        &[("lib.rs", "")],
    );
    let upwards = Fault::Upwards {
        from: "acerra-geo".to_owned(),
        to: "acerra-chain".to_owned(),
    };
    assert_eq!(House::read(folder.path()).unwrap().faults(), [upwards]);
}

#[test]
fn crates_depend_downwards_and_files_make_no_circle() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let house = House::read(root).unwrap();
    assert!(
        house.files() > 200 && house.imports() > 500,
        "little was read"
    );
    let faults: Vec<String> = house.faults().iter().map(Fault::to_string).collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
