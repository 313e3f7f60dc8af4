//! Guide and reference of the libraries as one static site.

use std::fs;
use std::path::Path;

use anyhow::{Context, ensure};

use crate::runner::{Runner, Step};

/// The site's first page.
const FIRST_PAGE: &str = "<!doctype html>
<html lang=\"en\">
<head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">
<title>Acerra</title></head>
<body>
<h1>Acerra</h1>
<p>From raw drone radar and GNSS logs to a focused, measured, georeferenced image of the ground.</p>
<ul>
<li><a href=\"guide/index.html\">User guide</a>, with a <a href=\"guide/gallery.html\">gallery</a></li>
<li><a href=\"api/acerra_chain/index.html\">Reference of the libraries</a></li>
</ul>
</body>
</html>
";

/// Writes the site to `target/site`, where mdBook is installed.
pub fn write(runner: &Runner) -> anyhow::Result<()> {
    if !runner.succeeds(&["mdbook", "--version"]) {
        runner.skip(
            "the site",
            "mdbook is not installed here (cargo install mdbook)",
        );
        return Ok(());
    }
    let site = runner.target().join("site");
    let _ = fs::remove_dir_all(&site);
    let guide = site.join("guide").display().to_string();
    let book = ["mdbook", "build", "docs/guide", "--dest-dir", &guide];
    runner.run(&Step::new("the guide", &book))?;
    let doc = ["cargo", "doc", "--workspace", "--no-deps", "--locked"];
    runner.run(&Step::new("the reference", &doc))?;
    copy_tree(&runner.target().join("doc"), &site.join("api"))?;
    fs::write(site.join("index.html"), FIRST_PAGE)?;
    let links = FIRST_PAGE.split("href=\"").skip(1);
    for link in links.filter_map(|rest| rest.split('"').next()) {
        ensure!(site.join(link).is_file(), "the site has no {link}");
    }
    println!("{}", site.join("index.html").display());
    Ok(())
}

fn copy_tree(from: &Path, to: &Path) -> anyhow::Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from).with_context(|| from.display().to_string())? {
        let entry = entry?;
        let target = to.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            copy_tree(&entry.path(), &target)?;
        } else {
            fs::copy(entry.path(), target)?;
        }
    }
    Ok(())
}
