//! The page over several campaigns.

use super::data::Fact;
use super::page::{document, table};
use acerra_figure::markup::{base64, escape};
use std::fmt::Write as _;

/// One campaign on the index page.
#[derive(Clone, Debug, Default)]
pub struct IndexEntry {
    /// Its title.
    pub title: String,
    /// Where its report lies, relative to the index page.
    pub report: String,
    /// Its image as PNG; none where empty.
    pub png: Vec<u8>,
    /// The numbers that matter most.
    pub facts: Vec<Fact>,
    /// How many warnings its report holds.
    pub warnings: usize,
}

/// A table over the campaigns; each row begins with its heading.
#[derive(Clone, Debug, Default)]
pub struct ComparisonTable {
    /// What it compares, above the table.
    pub caption: String,
    /// Column headings, the first for the row headings.
    pub head: Vec<String>,
    /// Rows of as many cells.
    pub rows: Vec<Vec<String>>,
}

/// Everything that an index page shows.
#[derive(Clone, Debug, Default)]
pub struct IndexPage {
    /// Heading and window title.
    pub title: String,
    /// What the campaigns are, in a few sentences; may be empty.
    pub summary: String,
    /// The campaigns in order.
    pub entries: Vec<IndexEntry>,
    /// Tables under them.
    pub tables: Vec<ComparisonTable>,
    /// Closing remarks, one paragraph each.
    pub remarks: Vec<String>,
}

/// Writes the page over several campaigns as a complete HTML page.
///
/// ```
/// use acerra_products::report::{IndexEntry, IndexPage, index_page};
///
/// let entry = IndexEntry {
///     title: "Track 1".to_owned(),
///     report: "track-1/report.html".to_owned(),
///     ..IndexEntry::default()
/// };
/// let page = IndexPage {
///     title: "Campaign".to_owned(),
///     entries: vec![entry],
///     ..IndexPage::default()
/// };
/// assert!(index_page(&page).contains("href=\"track-1/report.html\""));
/// ```
#[must_use]
pub fn index_page(page: &IndexPage) -> String {
    let mut body = format!("<header>\n<h1>{}</h1>\n", escape(&page.title));
    if !page.summary.is_empty() {
        let _ = writeln!(body, "<p class=\"lead\">{}</p>", escape(&page.summary));
    }
    body.push_str("</header>\n<div class=\"cards\">\n");
    for entry in &page.entries {
        card(&mut body, entry);
    }
    body.push_str("</div>\n");
    for comparison in &page.tables {
        let head: Vec<&str> = comparison.head.iter().map(String::as_str).collect();
        table(&mut body, &comparison.caption, &head, &comparison.rows);
    }
    for remark in &page.remarks {
        let _ = writeln!(body, "<p>{}</p>", escape(remark));
    }
    document(&page.title, &body)
}

fn card(out: &mut String, entry: &IndexEntry) {
    let (title, report) = (escape(&entry.title), escape(&entry.report));
    let _ = writeln!(
        out,
        "<article class=\"card\">\n<h2><a href=\"{report}\">{title}</a></h2>"
    );
    if !entry.png.is_empty() {
        let _ = writeln!(
            out,
            "<a href=\"{report}\"><img alt=\"Focused image of {title}\" \
             src=\"data:image/png;base64,{}\"></a>",
            base64(&entry.png)
        );
    }
    super::page::tiles(out, &entry.facts);
    let (class, text) = match entry.warnings {
        0 => ("good", "No warnings".to_owned()),
        1 => ("bad", "1 warning".to_owned()),
        n => ("bad", format!("{n} warnings")),
    };
    let _ = writeln!(
        out,
        "<p><a class=\"badge {class}\" href=\"{report}#warnings\">{text}</a></p>\n</article>"
    );
}
