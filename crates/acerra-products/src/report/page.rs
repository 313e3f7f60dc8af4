//! The page of one campaign: frame, heading, order of the sections.

use super::data::{Fact, Picture, ReportData};
use super::{evidence, provenance, result};
use acerra_figure::markup::{base64, escape};
use acerra_figure::{Drawing, FigureError};
use std::fmt::Write as _;

/// Writes the report of one focused campaign as a complete HTML page.
///
/// # Errors
/// [`FigureError`] where lists that belong together differ in length.
pub fn report_page(data: &ReportData) -> Result<String, FigureError> {
    let mut body = String::new();
    heading(
        &mut body,
        &data.title,
        &data.summary,
        &data.version,
        data.warnings.len(),
    );
    result::write(&mut body, data)?;
    warnings(&mut body, &data.warnings);
    evidence::write(&mut body, data)?;
    provenance::write(&mut body, data);
    Ok(document(&data.title, &body))
}

/// Wraps a body into a page without any outside reference.
pub(super) fn document(title: &str, body: &str) -> String {
    const STYLE: &str = include_str!("style.css");
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" \
         content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <title>{}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n{body}</main>\n\
         </body>\n</html>\n",
        escape(title)
    )
}

/// Title, a sentence, the number of warnings, the version.
pub(super) fn heading(
    out: &mut String,
    title: &str,
    summary: &str,
    version: &str,
    warnings: usize,
) {
    let _ = writeln!(out, "<header>\n<h1>{}</h1>", escape(title));
    if !summary.is_empty() {
        let _ = writeln!(out, "<p class=\"lead\">{}</p>", escape(summary));
    }
    let (class, text) = match warnings {
        0 => ("good", "No warnings".to_owned()),
        1 => ("bad", "1 warning".to_owned()),
        n => ("bad", format!("{n} warnings")),
    };
    let version = if version.is_empty() {
        String::new()
    } else {
        format!("Acerra {}", escape(version))
    };
    let _ = writeln!(
        out,
        "<p><a class=\"badge {class}\" href=\"#warnings\">{text}</a> \
         <span class=\"muted\">{version}</span></p>\n</header>"
    );
}

/// The section of warnings.
pub(super) fn warnings(out: &mut String, warnings: &[String]) {
    out.push_str("<section id=\"warnings\">\n<h2>Warnings</h2>\n");
    if warnings.is_empty() {
        out.push_str("<p class=\"note good\">Nothing was dropped, replaced or doubted.</p>\n");
    } else {
        out.push_str("<ul class=\"note bad\">\n");
        for warning in warnings {
            let _ = writeln!(out, "<li>{}</li>", escape(warning));
        }
        out.push_str("</ul>\n");
    }
    out.push_str("</section>\n");
}

/// Facts as large numbers in a row.
pub(super) fn tiles(out: &mut String, facts: &[Fact]) {
    if facts.is_empty() {
        return;
    }
    out.push_str("<dl class=\"tiles\">\n");
    for fact in facts {
        let _ = write!(
            out,
            "<div><dt>{}</dt><dd>{}</dd>",
            escape(&fact.name),
            escape(&fact.value)
        );
        if !fact.note.is_empty() {
            let _ = write!(out, "<dd class=\"remark\">{}</dd>", escape(&fact.note));
        }
        out.push_str("</div>\n");
    }
    out.push_str("</dl>\n");
}

/// A picture with its caption, as wide as the same figure would be as SVG.
pub(super) fn picture(out: &mut String, picture: &Picture) {
    let width = png_width(&picture.png).map(|w| format!(" width=\"{}\"", w / PICTURE_SCALE));
    let _ = write!(
        out,
        "<figure><img class=\"figure\"{} alt=\"{}\" src=\"data:image/png;base64,{}\">",
        width.unwrap_or_default(),
        escape(&picture.alt),
        base64(&picture.png)
    );
    close_figure(out, &picture.caption);
}

/// Device pixels per CSS pixel of the figures' PNGs.
const PICTURE_SCALE: u32 = 2;

/// The width in the header of a PNG.
fn png_width(png: &[u8]) -> Option<u32> {
    let bytes: [u8; 4] = png.get(16..20)?.try_into().ok()?;
    png.starts_with(b"\x89PNG")
        .then(|| u32::from_be_bytes(bytes))
}

/// A drawing as inline SVG with its caption.
pub(super) fn drawing(out: &mut String, drawing: &Drawing, caption: &str) {
    let _ = write!(
        out,
        "<figure><div class=\"scroll\">{}</div>",
        drawing.to_svg()
    );
    close_figure(out, caption);
}

fn close_figure(out: &mut String, caption: &str) {
    if !caption.is_empty() {
        let _ = write!(out, "<figcaption>{}</figcaption>", escape(caption));
    }
    out.push_str("</figure>\n");
}

/// A table under a line that says what it shows; the first column heads its rows. Cells are plain text.
pub(super) fn table(out: &mut String, caption: &str, head: &[&str], rows: &[Vec<String>]) {
    if !caption.is_empty() {
        let _ = writeln!(out, "<p class=\"caption\">{}</p>", escape(caption));
    }
    out.push_str("<div class=\"scroll\"><table>");
    out.push_str("<thead><tr>");
    for name in head {
        let _ = write!(out, "<th scope=\"col\">{}</th>", escape(name));
    }
    out.push_str("</tr></thead><tbody>\n");
    for row in rows {
        out.push_str("<tr>");
        for (i, cell) in row.iter().enumerate() {
            let cell = escape(cell);
            let _ = if i == 0 {
                write!(out, "<th scope=\"row\">{cell}</th>")
            } else {
                write!(out, "<td>{cell}</td>")
            };
        }
        out.push_str("</tr>\n");
    }
    out.push_str("</tbody></table></div>\n");
}
