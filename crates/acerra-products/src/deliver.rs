//! Stage `deliver`: all products of a run, together or not at all.

use std::fs::File;
use std::io::{BufWriter, Write};

use acerra_geo::geodesy::EnuFrame;
use acerra_geo::interpolate::Interpolated;
use anyhow::Context;

use crate::display::Shown;
use crate::outcome::Outcome;
use crate::report::{Picture, ReportData, report_page};
use crate::report_data::Drawn;
use crate::run_record::{RunRecord, TargetsRecord};
use crate::staging::Staging;
use crate::{correction, data, image_npz, maps, pictures, report_data};
use acerra_chain::journal::stages::Stages;
use serde::Serialize;

/// Writes the products of `outcome` to `staging` and publishes them. The stage `deliver` ends before
/// `run.json` and the report are written, as both state its cost.
///
/// # Errors
/// A directory that cannot be written; it is then left as it was.
pub fn deliver(outcome: &Outcome, staging: Staging, stages: &mut Stages) -> anyhow::Result<()> {
    let mut report = stages.run("deliver", || written(outcome, &staging))?;
    staging.write("run.json", json(&RunRecord::of(outcome, stages.done()))?)?;
    report.stages = stages.done().to_vec();
    staging.write("report.html", report_page(&report).context("report.html")?)?;
    staging.publish()
}

/// Writes `image.npz` and `run.json` alone to `staging` and publishes them.
///
/// # Errors
/// As [`deliver`].
pub fn deliver_image(
    outcome: &Outcome,
    staging: Staging,
    stages: &mut Stages,
) -> anyhow::Result<()> {
    stages.run("deliver", || write_image(outcome, &staging))?;
    staging.write("run.json", json(&RunRecord::of(outcome, stages.done()))?)?;
    staging.publish()
}

/// Writes all products but `run.json` and the report, on all threads, and collects the data of the report.
fn written(outcome: &Outcome, staging: &Staging) -> anyhow::Result<ReportData> {
    let shown = &Shown::of(outcome);
    let ((image, files), (pictures, report)) = rayon::join(
        || {
            rayon::join(
                || write_picture(outcome, shown, staging),
                || write_files(outcome, shown, staging),
            )
        },
        || {
            rayon::join(
                || {
                    let radargrams = write_radargrams(outcome, staging)?;
                    anyhow::Ok((radargrams, further_pictures(outcome, staging)?))
                },
                || report_data::collect(outcome),
            )
        },
    );
    let image = image?;
    let (radargrams, more) = pictures?;
    files?;
    let drawn = Drawn {
        image,
        radargrams,
        more,
    };
    Ok(drawn.shown_in(report))
}

/// Writes the products that are not pictures, and the map overlays.
fn write_files(outcome: &Outcome, shown: &Shown, staging: &Staging) -> anyhow::Result<()> {
    let (image, (maps, data)) = rayon::join(
        || write_image(outcome, staging),
        || {
            rayon::join(
                || maps::write(outcome, shown, staging),
                || {
                    write_trajectory(outcome, staging)?;
                    data::write(outcome, staging)
                },
            )
        },
    );
    image.and(data).and(maps)?;
    staging.write("targets.json", json(&TargetsRecord::of(outcome))?)
}

/// Pictures of the corrections and of stacks.
fn further_pictures(outcome: &Outcome, staging: &Staging) -> anyhow::Result<Vec<Picture>> {
    let mut more = correction::pictures(outcome)?;
    more.extend(pictures::of_stacks(outcome)?);
    more.into_iter()
        .map(|(name, picture)| {
            staging.write(&name, &picture.png)?;
            Ok(picture)
        })
        .collect()
}

fn json(record: &impl Serialize) -> serde_json::Result<String> {
    serde_json::to_string_pretty(record).map(|text| text + "\n")
}

fn write_image(outcome: &Outcome, staging: &Staging) -> anyhow::Result<()> {
    let mut npz = buffered(staging, "image.npz")?;
    let frame = outcome.prepared.first().positions.earth_frame();
    let origin = frame.as_ref().map(EnuFrame::origin);
    let focused = &outcome.focused;
    image_npz::write(&mut npz, &focused.image, &focused.pixels, origin)
        .and_then(|()| npz.flush())
        .context("image.npz: cannot write")
}

fn write_picture(outcome: &Outcome, shown: &Shown, staging: &Staging) -> anyhow::Result<Picture> {
    let picture = pictures::image(outcome, shown).context("image.png")?;
    staging.write("image.png", &picture.png)?;
    Ok(picture)
}

/// Before and after cleaning; none where there are no traces.
fn write_radargrams(outcome: &Outcome, staging: &Staging) -> anyhow::Result<Option<[Picture; 2]>> {
    let Some(traces) = outcome.prepared.cleaned() else {
        return Ok(None);
    };
    let (raw, clean) = rayon::join(
        || pictures::radargram_raw(outcome, traces).context("radargram-raw.png"),
        || pictures::radargram_clean(outcome, traces).context("radargram.png"),
    );
    let (raw, clean) = (raw?, clean?);
    staging.write("radargram-raw.png", &raw.png)?;
    staging.write("radargram.png", &clean.png)?;
    Ok(Some([raw, clean]))
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
