//! Last section: how to do it again.

use super::data::ReportData;
use super::numbers::{bytes, seconds};
use super::page;
use acerra_chain::inputs::InputFile;
use acerra_figure::markup::escape;
use std::fmt::Write as _;

pub(super) fn write(out: &mut String, data: &ReportData) {
    out.push_str("<section id=\"provenance\">\n<h2>How it was made</h2>\n");
    if !data.choices.is_empty() {
        out.push_str(
            "<h3>What was chosen</h3>\n<div class=\"scroll\"><table class=\"text\"><tbody>\n",
        );
        for fact in &data.choices {
            let _ = writeln!(
                out,
                "<tr><th scope=\"row\">{}</th><td>{}</td><td class=\"muted\">{}</td></tr>",
                escape(&fact.name),
                escape(&fact.value),
                escape(&fact.note)
            );
        }
        out.push_str("</tbody></table></div>\n");
    }
    inputs(out, &data.inputs);
    if !data.stages.is_empty() {
        let total: f64 = data.stages.iter().map(|stage| stage.seconds).sum();
        out.push_str("<h3>Cost</h3>\n");
        let mut rows: Vec<Vec<String>> = data
            .stages
            .iter()
            .map(|stage| {
                let memory = stage
                    .peak_memory_bytes
                    .map_or_else(|| "–".to_owned(), bytes);
                vec![stage.name.to_owned(), seconds(stage.seconds), memory]
            })
            .collect();
        rows.push(vec!["total".to_owned(), seconds(total), String::new()]);
        page::table(out, "", &["stage", "time", "peak memory"], &rows);
    }
    configuration(out, &data.configuration);
    out.push_str("</section>\n");
}

/// The input files with their digests.
pub(super) fn inputs(out: &mut String, inputs: &[InputFile]) {
    if inputs.is_empty() {
        return;
    }
    out.push_str(
        "<h3>Input files</h3>\n<div class=\"scroll\"><table class=\"text\"><thead><tr>\
         <th scope=\"col\">file</th><th scope=\"col\">size</th>\
         <th scope=\"col\">SHA-256</th></tr></thead><tbody>\n",
    );
    for input in inputs {
        let _ = writeln!(
            out,
            "<tr><th scope=\"row\">{}</th><td>{}</td><td><code>{}</code></td></tr>",
            escape(&input.path.display().to_string()),
            bytes(input.bytes),
            escape(&input.sha256)
        );
    }
    out.push_str("</tbody></table></div>\n");
}

/// The configuration as text.
pub(super) fn configuration(out: &mut String, configuration: &str) {
    if !configuration.is_empty() {
        let _ = writeln!(
            out,
            "<h3>Configuration</h3>\n<details open><summary>As resolved, with every default \
             filled in</summary><pre>{}</pre></details>",
            escape(configuration)
        );
    }
}
