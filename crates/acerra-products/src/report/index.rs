//! The page over several campaigns.

use super::data::Fact;
use super::html::{self, Table};
use maud::{Markup, html};

/// One campaign on the index page.
#[derive(Clone, Debug, Default)]
pub struct IndexEntry {
    /// Title.
    pub title: String,
    /// Path of the campaign's report, relative to the index page.
    pub report: String,
    /// Image as PNG; none where empty.
    pub png: Vec<u8>,
    /// The numbers that matter most.
    pub facts: Vec<Fact>,
    /// Number of warnings of its report.
    pub warnings: usize,
}

/// A table over the campaigns; each row begins with its heading.
#[derive(Clone, Debug, Default)]
pub struct ComparisonTable {
    /// Subject of the comparison, above the table.
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
    /// Description of the campaigns in a few sentences; may be empty.
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
    let body = html! {
        header {
            h1 { (page.title) }
            @if !page.summary.is_empty() {
                p.lead { (page.summary) }
            }
        }
        div.cards {
            @for entry in &page.entries { (card(entry)) }
        }
        @for comparison in &page.tables { (table(comparison)) }
        @for remark in &page.remarks {
            p { (remark) }
        }
    };
    html::document(&page.title, &body)
}

fn table(comparison: &ComparisonTable) -> Markup {
    let head: Vec<&str> = comparison.head.iter().map(String::as_str).collect();
    html::table(&Table {
        caption: &comparison.caption,
        head: &head,
        rows: &comparison.rows,
    })
}

fn card(entry: &IndexEntry) -> Markup {
    let (title, report) = (&entry.title, &entry.report);
    html! {
        article.card {
            h2 { a href=(report) { (title) } }
            @if !entry.png.is_empty() {
                a href=(report) {
                    img alt={ "Focused image of " (title) } src=(html::data_uri(&entry.png));
                }
            }
            (html::tiles(&entry.facts))
            p { (html::warning_badge(entry.warnings, &format!("{report}#warnings"))) }
        }
    }
}
