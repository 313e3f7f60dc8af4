//! Lines of Rust in each crate's `src`: code, documentation, tests.

use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context;

/// Lines of one or more files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Count {
    /// Lines of code outside tests.
    pub code: usize,
    /// Lines of comments outside tests, documentation included.
    pub documentation: usize,
    /// Lines inside `#[cfg(test)]` modules, blank lines left out.
    pub tests: usize,
    /// Blank lines.
    pub blank: usize,
}

impl Count {
    /// Counts the lines of one file. A module after `#[cfg(test)]` ends where a closing brace
    /// has the indentation of its first line, which rustfmt guarantees.
    ///
    /// ```
    /// use xtask::lines::Count;
    /// let text = "//! Doc.\nfn a() {}\n\n#[cfg(test)]\nmod tests {\n    fn b() {}\n}\n";
    /// let count = Count::of_text(text);
    /// assert_eq!((count.documentation, count.code, count.tests, count.blank), (1, 1, 4, 1));
    /// ```
    #[must_use]
    pub fn of_text(text: &str) -> Self {
        let mut count = Self::default();
        let mut test_ends_with: Option<String> = None;
        let mut after_attribute = false;
        for line in text.lines() {
            let trimmed = line.trim_start();
            let indentation = &line[..line.len() - trimmed.len()];
            if trimmed.is_empty() {
                count.blank += 1;
            } else if let Some(end) = &test_ends_with {
                count.tests += 1;
                if line == end {
                    test_ends_with = None;
                }
            } else if trimmed == "#[cfg(test)]" {
                count.tests += 1;
                after_attribute = true;
            } else if after_attribute {
                count.tests += 1;
                if trimmed.ends_with('{') {
                    test_ends_with = Some(format!("{indentation}}}"));
                }
                after_attribute = trimmed.starts_with("#[");
            } else if trimmed.starts_with("//") {
                count.documentation += 1;
            } else {
                count.code += 1;
            }
        }
        count
    }

    /// All lines.
    #[must_use]
    pub fn total(self) -> usize {
        self.code + self.documentation + self.tests + self.blank
    }

    fn add(&mut self, other: Self) {
        self.code += other.code;
        self.documentation += other.documentation;
        self.tests += other.tests;
        self.blank += other.blank;
    }
}

/// Lines by crate; written as a table with a last row for the sum.
#[derive(Clone, Debug, Default)]
pub struct Lines {
    crates: BTreeMap<String, Count>,
}

impl Lines {
    /// Counts `src` of every crate under `root`/crates.
    ///
    /// # Errors
    /// A folder or file that cannot be read.
    pub fn of_crates(root: &Path) -> anyhow::Result<Self> {
        let mut lines = Self::default();
        let folder = root.join("crates");
        for entry in fs::read_dir(&folder).with_context(|| folder.display().to_string())? {
            let path = entry?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let mut count = Count::default();
            for file in rust_files(&path.join("src"))? {
                let text = fs::read_to_string(&file).with_context(|| file.display().to_string())?;
                count.add(Count::of_text(&text));
            }
            lines.crates.insert(name.into_owned(), count);
        }
        Ok(lines)
    }
}

fn rust_files(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.is_dir() {
            files.extend(rust_files(&path)?);
        } else if path.extension().is_some_and(|e| e == "rs") {
            files.push(path);
        }
    }
    Ok(files)
}

impl fmt::Display for Lines {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let row = |f: &mut fmt::Formatter<'_>, name: &str, count: Count| {
            writeln!(
                f,
                "{name:20} {:8} {:14} {:8} {:8} {:8}",
                count.code,
                count.documentation,
                count.tests,
                count.blank,
                count.total()
            )
        };
        let (code, documentation) = ("code", "documentation");
        let (tests, blank, total) = ("tests", "blank", "total");
        let name = "crate";
        writeln!(
            f,
            "{name:20} {code:>8} {documentation:>14} {tests:>8} {blank:>8} {total:>8}"
        )?;
        let mut sum = Count::default();
        for (name, count) in &self.crates {
            row(f, name, *count)?;
            sum.add(*count);
        }
        row(f, "all", sum)
    }
}
