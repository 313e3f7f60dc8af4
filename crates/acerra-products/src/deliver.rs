//! Stage `deliver`: all products of a run, together or not at all.

use std::fs::File;
use std::io::{BufWriter, Write};

use acerra_geo::geodesy::EnuFrame;
use acerra_geo::interpolate::Interpolated;
use anyhow::Context;

use crate::outcome::Outcome;
use crate::report::{Picture, report_page};
use crate::run_record::{RunRecord, TargetsRecord};
use crate::staging::Staging;
use crate::{correction, data, image_npz, maps, pictures, report_data};
use acerra_chain::stages::Stages;
use serde::Serialize;

/// Writes the products of `outcome` beside what `staging` holds, and publishes them. The stage `deliver` ends before `run.json`
/// and the report are written, as both state what it cost.
///
/// # Errors
/// A directory that cannot be written; it is then left as it was.
pub fn deliver(outcome: &Outcome, staging: Staging, stages: &mut Stages) -> anyhow::Result<()> {
    let (image_png, raw_png, clean_png, more) = stages.run("deliver", || {
        // Each file is the work of one thread: the pictures are drawn beside one another.
        let (image, (radargrams, more)) = rayon::join(
            || {
                rayon::join(
                    || write_image(outcome, &staging),
                    || write_picture(outcome, &staging),
                )
            },
            || {
                rayon::join(
                    || write_radargrams(outcome, &staging),
                    || further_pictures(outcome),
                )
            },
        );
        image.0?;
        let image_png = image.1?;
        let (raw_png, clean_png) = radargrams?;
        let more = more?;
        for (name, picture) in &more {
            staging.write(name, &picture.png)?;
        }
        write_trajectory(outcome, &staging)?;
        maps::write(outcome, &staging)?;
        data::write(outcome, &staging)?;
        staging.write("targets.json", json(&TargetsRecord::of(outcome))?)?;
        let more: Vec<_> = more.into_iter().map(|(_, picture)| picture).collect();
        anyhow::Ok((image_png, raw_png, clean_png, more))
    })?;
    staging.write("run.json", json(&RunRecord::of(outcome, stages.done()))?)?;
    let mut data = report_data::collect(outcome, stages.done(), image_png, raw_png, clean_png);
    data.pictures = more;
    staging.write("report.html", report_page(&data).context("report.html")?)?;
    staging.publish()
}

/// Pictures of the corrections and of stacks, with the names of their files.
fn further_pictures(outcome: &Outcome) -> anyhow::Result<Vec<(String, Picture)>> {
    let mut more = correction::pictures(outcome)?;
    more.extend(pictures::of_stacks(outcome)?);
    Ok(more)
}

fn json(record: &impl Serialize) -> serde_json::Result<String> {
    serde_json::to_string_pretty(record).map(|text| text + "\n")
}

fn write_image(outcome: &Outcome, staging: &Staging) -> anyhow::Result<()> {
    let mut npz = buffered(staging, "image.npz")?;
    let frame = maps::earth_frame(&outcome.prepared.first().positions);
    let origin = frame.as_ref().map(EnuFrame::origin);
    let focused = &outcome.focused;
    image_npz::write(&mut npz, &focused.image, &focused.pixels, origin)
        .and_then(|()| npz.flush())
        .context("image.npz: cannot write")
}

fn write_picture(outcome: &Outcome, staging: &Staging) -> anyhow::Result<Vec<u8>> {
    let png = pictures::image(outcome).context("image.png")?;
    staging.write("image.png", &png)?;
    Ok(png)
}

/// Before and after cleaning; empty where there are no traces.
fn write_radargrams(outcome: &Outcome, staging: &Staging) -> anyhow::Result<(Vec<u8>, Vec<u8>)> {
    let Some(traces) = outcome.prepared.cleaned() else {
        return Ok((Vec::new(), Vec::new()));
    };
    let (raw, clean) = rayon::join(
        || pictures::radargram_raw(outcome, traces).context("radargram-raw.png"),
        || pictures::radargram_clean(outcome, traces).context("radargram.png"),
    );
    let (raw, clean) = (raw?, clean?);
    staging.write("radargram-raw.png", &raw)?;
    staging.write("radargram.png", &clean)?;
    Ok((raw, clean))
}

fn write_trajectory(outcome: &Outcome, staging: &Staging) -> anyhow::Result<()> {
    write_places(
        outcome,
        &outcome.prepared.aligned.all,
        staging,
        "trajectory.csv",
    )?;
    match &outcome.prepared.correction {
        Some(correction) if correction.is_applied() => write_places(
            outcome,
            &correction.stated,
            staging,
            "trajectory-uncorrected.csv",
        ),
        _ => Ok(()),
    }
}

fn write_places(
    outcome: &Outcome,
    places: &[Interpolated],
    staging: &Staging,
    name: &str,
) -> anyhow::Result<()> {
    let mut csv = buffered(staging, name)?;
    let positions = &outcome.prepared.first().positions;
    let (frame, origin) = (positions.frame(), positions.time_origin());
    acerra_geo::write::write_positions_csv(&mut csv, places, frame, origin)
        .and_then(|()| csv.flush())
        .with_context(|| format!("{name}: cannot write"))
}

fn buffered(staging: &Staging, name: &str) -> anyhow::Result<BufWriter<File>> {
    let file = File::create(staging.path(name)).with_context(|| format!("{name}: cannot write"))?;
    Ok(BufWriter::with_capacity(1 << 20, file))
}
