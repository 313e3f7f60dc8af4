//! Tests that no input breaks the markup of the pages, and that the pages are complete.

use super::*;

#[test]
fn a_report_asks_nothing_from_outside() {
    let html = report_page(&full()).unwrap();
    assert!(!html.contains("<script"));
    for attribute in ["src=\"", "href=\""] {
        for part in html.split(attribute).skip(1) {
            let inside = part.starts_with("data:") || part.starts_with('#');
            assert!(inside, "{attribute}{}", &part[..60]);
        }
    }
    assert!(!html.contains("url(") && !html.contains("@import"));
}

#[test]
fn tags_are_balanced() {
    let pages = [
        report_page(&full()).unwrap(),
        index_page(&IndexPage::default()),
    ];
    for html in pages {
        for tag in [
            "section", "figure", "div", "table", "tr", "td", "th", "svg", "text", "dl", "ul", "p",
        ] {
            let opened = html.matches(&format!("<{tag}>")).count()
                + html.matches(&format!("<{tag} ")).count();
            let closed = html.matches(&format!("</{tag}>")).count();
            assert_eq!(opened, closed, "<{tag}>");
        }
    }
}

#[test]
fn hostile_names_stay_text() {
    let evil = "</title><script>alert(1)</script>\"'&".to_owned();
    let mut data = full();
    data.title = evil.clone();
    data.summary = evil.clone();
    data.warnings = vec![evil.clone()];
    data.configuration = evil.clone();
    data.facts = vec![Fact::new(evil.clone(), evil.clone()).note(evil.clone())];
    data.choices = data.facts.clone();
    data.inputs[0].path = evil.clone().into();
    data.tracks[0].alignment.as_mut().unwrap().score_name = evil.clone();
    data.tracks[0].alignment.as_mut().unwrap().remark = evil.clone();
    data.image.as_mut().unwrap().alt = evil.clone();
    data.evidence[0].name = evil.clone();
    data.evidence[0].unit = evil.clone();
    data.evidence[0].explanation = evil.clone();
    data.unchecked[0] = [evil.clone(), evil.clone()];
    data.tracks[0].name = evil.clone();
    assert!(!report_page(&data).unwrap().contains("<script"));
    let entry = IndexEntry {
        title: evil.clone(),
        report: "x\" onclick=\"y".to_owned(),
        ..IndexEntry::default()
    };
    let html = index_page(&IndexPage {
        title: evil.clone(),
        entries: vec![entry],
        remarks: vec![evil],
        ..IndexPage::default()
    });
    assert!(!html.contains("<script") && !html.contains("onclick=\"y\""));
}

#[test]
fn every_picture_is_described() {
    let mut data = full();
    data.pictures = vec![data.image.clone().unwrap()];
    let pages = [
        report_page(&data).unwrap(),
        ppk_page(&PpkReport {
            title: String::new(),
            version: String::new(),
            solution: &simulated_run(),
            ratio_threshold: None,
            pass_difference_m: Vec::new(),
            warnings: Vec::new(),
            inputs: Vec::new(),
            configuration: String::new(),
        })
        .unwrap(),
    ];
    for html in pages {
        let words = |mark: &str, attribute: &str| -> Vec<usize> {
            let parts = html.split(mark).skip(1);
            parts
                .map(|part| {
                    let tag = part.split('>').next().unwrap_or_default();
                    let value = tag.split(attribute).nth(1).unwrap_or_default();
                    let text = value.split('"').next().unwrap_or_default();
                    text.split_whitespace().count()
                })
                .collect()
        };
        let images = words("<img ", "alt=\"");
        let drawings = words("<svg xmlns", "aria-label=\"");
        assert!(images.len() + drawings.len() >= 2);
        assert!(images.iter().chain(&drawings).all(|count| *count >= 2));
    }
}

#[test]
fn an_empty_report_is_a_page_and_odd_lists_are_refused() {
    let html = report_page(&ReportData::default()).unwrap();
    assert!(html.contains("No targets") && html.contains("No warnings"));
    let mut data = full();
    data.tracks[0].trajectory.as_mut().unwrap().status.pop();
    assert!(report_page(&data).is_err());
    let mut data = full();
    data.tracks[0].surface.as_mut().unwrap().height_m.pop();
    assert!(report_page(&data).is_err());
    let mut data = full();
    data.tracks[0].trajectory = Some(TrajectoryEvidence::default());
    assert!(report_page(&data).unwrap().contains("holds no positions"));
}

#[test]
fn the_same_data_make_the_same_page() {
    assert_eq!(report_page(&full()).unwrap(), report_page(&full()).unwrap());
}
