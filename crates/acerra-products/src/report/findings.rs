//! The evidence: independent findings about a run, and their summary.

use super::data::{EvidenceRow, Verdict};
use super::numbers::{fixed, measured, with_minus_signs};
use maud::{Markup, html};

/// The section with the one-line verdict and all findings, gravest first; those that agree are folded away;
/// then the unchecked settings. Empty without findings.
pub(super) fn section(rows: &[EvidenceRow], unchecked: &[[String; 2]]) -> Markup {
    let mut sorted: Vec<&EvidenceRow> = rows.iter().collect();
    sorted.sort_by_key(|row| std::cmp::Reverse(row.verdict));
    let agreeing = sorted.partition_point(|row| row.verdict != Verdict::Agrees);
    let (questionable, agreeing) = sorted.split_at(agreeing);
    html! {
        @if !rows.is_empty() {
            section #evidence {
                h2 { "Evidence" }
                p.note.(class(worst(rows))) { (verdict_line(rows)) }
                @if !questionable.is_empty() { (table(questionable)) }
                @if !agreeing.is_empty() {
                    details {
                        summary { "What agrees: " (names(agreeing)) }
                        (table(agreeing))
                    }
                }
                @if !unchecked.is_empty() {
                    details {
                        summary { "Nothing in this flight checks: " (settings(unchecked)) }
                        dl {
                            @for [setting, explanation] in unchecked {
                                dt { (setting) }
                                dd { (explanation) }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn names(rows: &[&EvidenceRow]) -> String {
    let names: Vec<&str> = rows.iter().map(|row| row.name.as_str()).collect();
    names.join(", ")
}

fn settings(unchecked: &[[String; 2]]) -> String {
    let names: Vec<&str> = unchecked.iter().map(|[name, _]| name.as_str()).collect();
    names.join(", ")
}

fn table(rows: &[&EvidenceRow]) -> Markup {
    html! {
        div.scroll {
            table.findings {
                thead {
                    tr {
                        @for name in ["finding", "value", "expected", "σ", "verdict", "what it means"] {
                            th scope="col" { (name) }
                        }
                    }
                }
                tbody {
                    @for row in rows { (finding(row)) }
                }
            }
        }
    }
}

fn finding(row: &EvidenceRow) -> Markup {
    let sigma = row.sigma.filter(|sigma| sigma.is_finite() && *sigma > 0.0);
    let shown = |value: Option<f64>| measured(value, sigma, &row.unit);
    let off = deviation(row).map_or_else(String::new, |off| {
        format!("({} σ off)", fixed(off.abs(), 1))
    });
    html! {
        tr {
            th scope="row" { (row.name) }
            td data-label="value" { (shown(row.value)) }
            td data-label="expected" { (shown(row.expected)) }
            td data-label="σ" { (shown(sigma)) " " span.muted { (off) } }
            td data-label="verdict" { span.badge.(class(row.verdict)) { (row.verdict.name()) } }
            td.explanation { (with_minus_signs(&row.explanation)) }
        }
    }
}

/// Difference of value and expectation in standard deviations.
fn deviation(row: &EvidenceRow) -> Option<f64> {
    let sigma = row.sigma.filter(|sigma| *sigma > 0.0)?;
    let off = (row.value? - row.expected?) / sigma;
    off.is_finite().then_some(off)
}

fn worst(rows: &[EvidenceRow]) -> Verdict {
    rows.iter().map(|row| row.verdict).max().unwrap_or_default()
}

fn class(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Agrees => "good",
        Verdict::Doubtful => "doubt",
        Verdict::Contradicts => "bad",
    }
}

/// The badge at the top of the page.
pub(super) fn badge(rows: &[EvidenceRow]) -> Markup {
    let count = |verdict| rows.iter().filter(|row| row.verdict == verdict).count();
    let text = match worst(rows) {
        Verdict::Agrees => "Evidence agrees".to_owned(),
        Verdict::Doubtful => format!("{} doubtful", count(Verdict::Doubtful)),
        Verdict::Contradicts => format!("{} contradicting", count(Verdict::Contradicts)),
    };
    html! {
        @if !rows.is_empty() {
            a.badge.(class(worst(rows))) href="#evidence" { (text) } " "
        }
    }
}

/// Summary of the findings, in one line.
///
/// ```
/// use acerra_products::report::{EvidenceRow, Verdict, verdict_line};
///
/// let row = |name: &str, verdict| EvidenceRow {
///     name: name.to_owned(),
///     verdict,
///     ..EvidenceRow::default()
/// };
/// let rows = [
///     row("surface echo", Verdict::Contradicts),
///     row("clock offset", Verdict::Agrees),
/// ];
/// assert_eq!(
///     verdict_line(&rows),
///     "1 of 2 findings contradicts this result: surface echo. Do not trust the image before \
///      this is explained."
/// );
/// ```
#[must_use]
pub fn verdict_line(rows: &[EvidenceRow]) -> String {
    let named = |verdict: Verdict| -> Vec<&str> {
        rows.iter()
            .filter(|row| row.verdict == verdict)
            .map(|row| row.name.as_str())
            .collect()
    };
    let (contradicting, doubtful) = (named(Verdict::Contradicts), named(Verdict::Doubtful));
    let share = |names: &[&str]| {
        let noun = if rows.len() == 1 {
            "finding"
        } else {
            "findings"
        };
        format!("{} of {} {noun}", names.len(), rows.len())
    };
    let verb = |names: &[&str], one: &'static str, more: &'static str| {
        if names.len() == 1 { one } else { more }
    };
    if !contradicting.is_empty() {
        let mut line = format!(
            "{} {} this result: {}.",
            share(&contradicting),
            verb(&contradicting, "contradicts", "contradict"),
            contradicting.join(", ")
        );
        if !doubtful.is_empty() {
            line.push_str(&format!(" Doubtful: {}.", doubtful.join(", ")));
        }
        line.push_str(" Do not trust the image before this is explained.");
        return line;
    }
    if !doubtful.is_empty() {
        let is = verb(&doubtful, "is", "are");
        return format!(
            "{} {is} doubtful: {}.",
            share(&doubtful),
            doubtful.join(", ")
        );
    }
    match rows.len() {
        0 => "No finding supports or questions this result.".to_owned(),
        1 => "The one finding agrees with this result.".to_owned(),
        n => format!("All {n} findings agree with this result."),
    }
}
