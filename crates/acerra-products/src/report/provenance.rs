//! Last section: how to do it again.

use super::data::{Fact, ReportData};
use super::html::{self, Table};
use super::numbers::{bytes, seconds, with_minus_signs};
use acerra_chain::journal::stages::Stage;
use acerra_chain::read::inputs::InputFile;
use maud::{Markup, html};

pub(super) fn section(data: &ReportData) -> Markup {
    html! {
        section #provenance {
            h2 { "How it was made" }
            p.muted {
                code { "acerra view" }
                " with the directory of this report shows the run in the browser: image, radargram and \
                 flight, linked, and images again as settings change."
            }
            (facts("What was chosen", &data.choices))
            (facts("How the image was computed", &data.plan))
            (inputs(&data.inputs))
            (cost(&data.stages))
            (configuration(&data.configuration))
        }
    }
}

fn facts(heading: &str, facts: &[Fact]) -> Markup {
    let has_notes = facts.iter().any(|fact| !fact.note.is_empty());
    html! {
        @if !facts.is_empty() {
            h3 { (heading) }
            div.scroll tabindex="0" role="group" aria-label=(heading) {
                table.text {
                    tbody {
                        @for fact in facts {
                            tr {
                                th scope="row" { (fact.name) }
                                td { (with_minus_signs(&fact.value)) }
                                @if has_notes { td.muted { (fact.note) } }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn cost(stages: &[Stage]) -> Markup {
    let total: f64 = stages.iter().map(|stage| stage.seconds).sum();
    let row = |stage: &Stage| {
        let memory = stage
            .peak_memory_bytes
            .map_or_else(|| "–".to_owned(), bytes);
        vec![stage.name.to_owned(), seconds(stage.seconds), memory]
    };
    let mut rows: Vec<Vec<String>> = stages.iter().map(row).collect();
    rows.push(vec!["total".to_owned(), seconds(total), String::new()]);
    html! {
        @if !stages.is_empty() {
            h3 { "Cost" }
            (html::table(&Table {
                caption: "",
                head: &["stage", "time", "peak memory"],
                rows: &rows,
            }))
        }
    }
}

/// The input files with their digests.
pub(super) fn inputs(inputs: &[InputFile]) -> Markup {
    html! {
        @if !inputs.is_empty() {
            h3 { "Input files" }
            div.scroll tabindex="0" role="group" aria-label="Input files" {
                table.text {
                    thead {
                        tr {
                            th scope="col" { "file" }
                            th scope="col" { "size" }
                            th scope="col" { "SHA-256" }
                        }
                    }
                    tbody {
                        @for input in inputs {
                            tr {
                                th scope="row" {
                                    (input.path.display())
                                    @if let Some(sources) = &input.sources { " (" (sources) ")" }
                                }
                                td { (bytes(input.bytes)) }
                                td { code { (input.sha256) } }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// The configuration as text.
pub(super) fn configuration(configuration: &str) -> Markup {
    html! {
        @if !configuration.is_empty() {
            h3 { "Configuration" }
            details {
                summary { "As resolved, with every default filled in" }
                pre tabindex="0" role="group" aria-label="Configuration" { (configuration) }
            }
        }
    }
}
