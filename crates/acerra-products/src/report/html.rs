//! Elements of every page: document, heading, warnings, tiles, tables, pictures.

use super::data::{Fact, Picture};
use acerra_figure::Drawing;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use maud::{DOCTYPE, Markup, PreEscaped, html};

/// Wraps a body into a page without any outside reference. Control characters, which HTML may not
/// hold, become the replacement character.
pub(crate) fn document(title: &str, body: &Markup) -> String {
    const STYLE: &str = include_str!("style.css");
    const POLICY: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'";
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body { main { (body) } }
        }
    };
    let printable = |c: char| {
        let allowed = !c.is_control() || matches!(c, '\n' | '\t');
        if allowed { c } else { '\u{FFFD}' }
    };
    let mut text: String = page.into_string().chars().map(printable).collect();
    text.push('\n');
    text
}

/// Title, a sentence, badges, the version.
pub(crate) fn heading(title: &str, summary: &str, version: &str, badges: &Markup) -> Markup {
    html! {
        header {
            h1 { (title) }
            @if !summary.is_empty() {
                p.lead { (summary) }
            }
            p {
                (badges)
                @if !version.is_empty() {
                    span.muted { "Acerra " (version) }
                }
            }
        }
    }
}

/// Number of warnings, as a link to `target`.
pub(crate) fn warning_badge(count: usize, target: &str) -> Markup {
    let (class, text) = match count {
        0 => ("good", "No warnings".to_owned()),
        1 => ("bad", "1 warning".to_owned()),
        n => ("bad", format!("{n} warnings")),
    };
    html! { a.badge.(class) href=(target) { (text) } " " }
}

/// The section of warnings, with the notes behind them.
pub(crate) fn warnings(warnings: &[String], notes: &[String]) -> Markup {
    html! {
        section #warnings {
            h2 { @if notes.is_empty() { "Warnings" } @else { "Warnings and notes" } }
            @if warnings.is_empty() {
                p.note.good { "Nothing was dropped, replaced or doubted." }
            } @else {
                ul.note.bad {
                    @for warning in warnings {
                        li { (warning) }
                    }
                }
            }
            @if !notes.is_empty() {
                p.caption { "Left out without harm:" }
                ul.muted {
                    @for note in notes {
                        li { (note) }
                    }
                }
            }
        }
    }
}

/// Facts as large numbers in a row.
pub(crate) fn tiles(facts: &[Fact]) -> Markup {
    html! {
        @if !facts.is_empty() {
            dl.tiles {
                @for fact in facts {
                    div {
                        dt { (fact.name) }
                        dd { (fact.value) }
                        @if !fact.note.is_empty() {
                            dd.remark { (fact.note) }
                        }
                    }
                }
            }
        }
    }
}

/// A picture with its caption: the layout for the reader's screen, or the PNG where there is no other.
pub(crate) fn picture(picture: &Picture) -> Markup {
    if !picture.wide_svg.is_empty() {
        return html! {
            figure {
                div.whole.wide { (PreEscaped(&picture.wide_svg)) }
                div.whole.narrow { (PreEscaped(&picture.narrow_svg)) }
                (caption(&picture.caption))
            }
        };
    }
    html! {
        figure {
            img.figure
                width=[png_size(&picture.png).map(|[width, _]| width / PICTURE_SCALE)]
                height=[png_size(&picture.png).map(|[_, height]| height / PICTURE_SCALE)]
                alt=(picture.alt)
                src=(data_uri(&picture.png));
            (caption(&picture.caption))
        }
    }
}

/// A PNG as a data URI (RFC 2397).
pub(crate) fn data_uri(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", BASE64.encode(png))
}

/// Device pixels per CSS pixel of the figures' PNGs.
const PICTURE_SCALE: u32 = 2;

/// Width and height in the header of a PNG.
fn png_size(png: &[u8]) -> Option<[u32; 2]> {
    let word = |at: usize| -> Option<u32> {
        let bytes: [u8; 4] = png.get(at..at + 4)?.try_into().ok()?;
        Some(u32::from_be_bytes(bytes))
    };
    png.starts_with(b"\x89PNG")
        .then(|| Some([word(16)?, word(20)?]))
        .flatten()
}

/// Placement of a drawing in the page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fit {
    /// Wide plots keep a readable size: on a narrow screen they are scrolled sideways.
    Scrolled,
    /// Maps are seen whole: never enlarged, and shrunk to the width of the screen.
    Whole,
}

/// A drawing as inline SVG with a description in words, and its caption.
pub(crate) fn drawing(drawing: Drawing, fit: Fit, alt: &str, text: &str) -> Markup {
    let svg = drawing.described(alt).to_svg();
    html! {
        figure {
            @match fit {
                Fit::Scrolled => div.scroll tabindex="0" role="group" aria-label=(alt) { (PreEscaped(svg)) },
                Fit::Whole => div.whole { (PreEscaped(svg)) },
            }
            (caption(text))
        }
    }
}

fn caption(text: &str) -> Markup {
    html! {
        @if !text.is_empty() {
            figcaption { (text) }
        }
    }
}

/// A table of numbers with a caption; the first column heads its rows.
#[derive(Clone, Debug, Default)]
pub(crate) struct Table<'a> {
    /// Content of the table; may be empty.
    pub caption: &'a str,
    /// Column headings.
    pub head: &'a [&'a str],
    /// Rows of as many cells.
    pub rows: &'a [Vec<String>],
}

/// Lays out a table of numbers.
pub(crate) fn table(table: &Table<'_>) -> Markup {
    let label = if table.caption.is_empty() {
        table.head.join(", ")
    } else {
        table.caption.to_owned()
    };
    html! {
        @if !table.caption.is_empty() {
            p.caption { (table.caption) }
        }
        div.scroll tabindex="0" role="group" aria-label=(label) {
            table {
                thead {
                    tr {
                        @for name in table.head {
                            th scope="col" { (name) }
                        }
                    }
                }
                tbody {
                    @for row in table.rows {
                        tr {
                            @for (i, cell) in row.iter().enumerate() {
                                @if i == 0 {
                                    th scope="row" { (cell) }
                                } @else {
                                    td { (cell) }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// A long table behind a line that opens it; closed, neither screen nor paper shows its rows.
pub(crate) fn folded(summary: &str, content: &Markup) -> Markup {
    html! {
        details.long {
            summary { (summary) }
            (content)
        }
    }
}
