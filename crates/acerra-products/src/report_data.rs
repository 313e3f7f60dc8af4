//! The report's data from the outcome of a run.

use acerra_imaging::metrics::{LocalTrack, Target};
use acerra_imaging::psf::{Cell, PointSpread};
use acerra_imaging::resolution::displacement_m;

use super::cuts::{cuts, spread_of};
use super::soil::soil_facts;
use crate::outcome::Outcome;
use crate::report::{
    AlignmentEvidence, EvidenceRow, Fact, GhostRow, Picture, ReportData, SurfaceEvidence,
    TargetRow, TrackEvidence, TrajectoryEvidence, Verdict, Widths,
};
use crate::run_record::depth_of;
use acerra_chain::Track;
use acerra_chain::align::offset::OffsetSearch;
use acerra_chain::findings::Finding;

/// The pictures of a run.
#[derive(Debug)]
pub struct Drawn {
    /// `image.png`.
    pub image: Picture,
    /// `radargram-raw.png` and `radargram.png`, where there are traces.
    pub radargrams: Option<[Picture; 2]>,
    /// Figures of corrections and stacks.
    pub more: Vec<Picture>,
}

impl Drawn {
    /// The report with these pictures.
    pub fn shown_in(self, report: ReportData) -> ReportData {
        let (radargram_raw, radargram_clean) = match self.radargrams {
            Some([before, after]) => (Some(before), Some(after)),
            None => (None, None),
        };
        ReportData {
            image: Some(self.image),
            radargram_raw,
            radargram_clean,
            pictures: self.more,
            ..report
        }
    }
}

/// Collects the report's data except its pictures and the cost of the stages.
pub fn collect(outcome: &Outcome) -> ReportData {
    let spread = spread_of(outcome);
    ReportData {
        title: outcome.name.clone(),
        summary: summary(outcome),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        facts: facts(outcome),
        evidence: outcome
            .evidence
            .findings()
            .iter()
            .map(evidence_row)
            .collect(),
        unchecked: outcome
            .unchecked
            .iter()
            .map(|one| [one.setting, one.explanation].map(str::to_owned))
            .collect(),
        warnings: outcome.warnings.clone(),
        notes: outcome.notes.clone(),
        image: None,
        inversion: outcome.focused.inversion.clone(),
        targets: rows(outcome, spread.as_ref()),
        surveyed: outcome.surveyed.clone(),
        remarks: at_nadir(outcome, spread.as_ref()),
        radargram_raw: None,
        radargram_clean: None,
        pictures: Vec::new(),
        tracks: tracks(outcome),
        choices: choices(outcome),
        plan: plan(outcome),
        inputs: outcome.inputs.clone(),
        stages: Vec::new(),
        configuration: toml::to_string_pretty(&outcome.campaign).unwrap_or_default(),
    }
}

fn summary(outcome: &Outcome) -> String {
    format!(
        "{}; {} of {} traces imaged{}.",
        outcome.radar_summary(),
        outcome.prepared.aligned.traces.len(),
        outcome.prepared.traces_in_log(),
        if outcome.prepared.aligned.is_often_at_rest {
            ", those recorded in motion, each weighted by its path length"
        } else {
            ""
        }
    )
}

fn facts(outcome: &Outcome) -> Vec<Fact> {
    let aligned = &outcome.prepared.aligned;
    let path_m: f64 = aligned.path_m.iter().sum();
    let height_m = &aligned.height_m;
    #[expect(clippy::cast_precision_loss, reason = "a count of traces")]
    let mean_height_m = height_m.iter().sum::<f64>() / height_m.len().max(1) as f64;
    let statistics = &outcome.measured.statistics;
    let mut facts = vec![
        Fact::new("Targets", outcome.measured.targets.len().to_string()).note(format!(
            "peaks above −{} dB that no other target explains",
            -outcome.campaign.measure.threshold_db
        )),
        Fact::new("Traces imaged", aligned.traces.len().to_string()),
        Fact::new("Path", format!("{path_m:.2} m")),
        Fact::new("Mean height", format!("{mean_height_m:.2} m")).note(
            match (
                &outcome.focused.pixels.surface,
                &outcome.focused.projections,
            ) {
                (_, Some(_)) => "above the ground",
                (Some(_), None) => "above the terrain",
                (None, None) => "above the image plane",
            },
        ),
    ];
    facts.extend(soil_facts(outcome));
    if let Some(median_db) = statistics.median_db {
        facts.push(
            Fact::new("Peak over median", format!("{:.1} dB", -median_db))
                .note("the image's maximum over its median level"),
        );
    }
    facts
}

fn rows(outcome: &Outcome, spread: Option<&PointSpread>) -> Vec<TargetRow> {
    let targets = &outcome.measured.targets;
    let cuts = spread.map_or_else(|| vec![None; targets.len()], |s| cuts(outcome, s));
    targets
        .iter()
        .zip(cuts)
        .enumerate()
        .map(|(k, (target, cuts))| TargetRow {
            cuts,
            depth_m: depth_of(outcome, target),
            exceeds_clutter: outcome.exceeds_clutter.get(k).copied(),
            ..row(target)
        })
        .collect()
}

/// Effect of a height error on targets under the track.
fn at_nadir(outcome: &Outcome, spread: Option<&PointSpread>) -> Vec<String> {
    const ERROR_M: f64 = 0.03;
    // Below ground rays are refracted.
    let Some(spread) = spread.filter(|_| outcome.focused.underground.is_none()) else {
        return Vec::new();
    };
    let mut under = Vec::new();
    let mut moved_m = 0.0_f64;
    for (k, t) in outcome.measured.targets.iter().enumerate() {
        let point = [t.x_m, t.y_m, t.z_m];
        let Some(track) = LocalTrack::at(spread.position_m(), point) else {
            continue;
        };
        let offset_m = track.offset_m.abs();
        if offset_m > Cell::expected(spread, &track, point).across_m {
            continue;
        }
        // From below the track itself, where it matters most.
        if let Ok(Some(by_m)) = displacement_m(track.height_m, 0.0, ERROR_M) {
            under.push((k + 1).to_string());
            moved_m = moved_m.max(by_m);
        }
    }
    if under.is_empty() {
        return Vec::new();
    }
    let (noun, verb) = if under.len() == 1 {
        ("Target", "lies")
    } else {
        ("Targets", "lie")
    };
    vec![format!(
        "{noun} {} {verb} under the track, nearer than the Rayleigh width across it. There the image cannot \
         distinguish a small height error from a shift across the track: by Eq. (14), an image plane {:.0} \
         cm too high moves a target by up to {moved_m:.2} m to either side. Along the track there is no \
         such shift.",
        under.join(", "),
        1e2 * ERROR_M
    )]
}

fn row(target: &Target) -> TargetRow {
    TargetRow {
        x_m: target.x_m,
        y_m: target.y_m,
        z_m: target.z_m,
        depth_m: None,
        exceeds_clutter: None,
        level_db: target.level_db,
        along: Widths {
            rayleigh_m: target.along.rayleigh_m,
            width_3db_m: target.along.width_3db_m,
            width_6db_m: target.along.width_6db_m,
            ..Widths::default()
        },
        across: Widths {
            rayleigh_m: target.across.rayleigh_m,
            width_3db_m: target.across.width_3db_m,
            width_6db_m: target.across.width_6db_m,
            inner_m: target.across.inner_m,
            outer_m: target.across.outer_m,
        },
        pslr_db: target.pslr_db,
        islr_db: target.islr_db,
        ghost: target.ghost.map(|g| GhostRow {
            level: g.level,
            x_m: g.x_m,
            y_m: g.y_m,
        }),
        cuts: None,
    }
}

/// One entry per track; a campaign of one track needs no name for it.
fn tracks(outcome: &Outcome) -> Vec<TrackEvidence> {
    let several = outcome.prepared.tracks.len() > 1;
    let tracks = outcome.prepared.tracks.iter();
    tracks
        .map(|track| TrackEvidence {
            name: if several {
                track.name.clone()
            } else {
                String::new()
            },
            trajectory: Some(trajectory(outcome, track)),
            alignment: track.search.as_ref().map(alignment),
            surface: surface(outcome, track),
        })
        .collect()
}

/// Times of a track's traces as its trajectory counts them (s).
fn trajectory_time_s(outcome: &Outcome, track: &Track) -> Vec<f64> {
    let radar_time_s = &outcome.prepared.aligned.time_s[track.range.clone()];
    radar_time_s
        .iter()
        .map(|t| t + track.time_offset_s)
        .collect()
}

fn trajectory(outcome: &Outcome, track: &Track) -> TrajectoryEvidence {
    let aligned = &outcome.prepared.aligned;
    let range = track.range.clone();
    TrajectoryEvidence {
        time_s: trajectory_time_s(outcome, track),
        position_m: aligned.position_m[range.clone()].to_vec(),
        // Deviations are known of all traces or of none.
        sigma_m: aligned
            .sigma_m
            .get(range.clone())
            .unwrap_or_default()
            .to_vec(),
        status: aligned.status[range].to_vec(),
        plane_z_m: outcome.focused.pixels.middle_m(),
        line_starts: (aligned.lines(track.range.clone()).iter().skip(1))
            .map(|line| line.start)
            .collect(),
        is_untimed: track.is_untimed,
        used_s: None,
    }
}

fn evidence_row(finding: &Finding) -> EvidenceRow {
    EvidenceRow {
        name: finding.name.replace('_', " "),
        value: finding.value,
        expected: finding.expected,
        sigma: finding.sigma,
        unit: finding.unit.to_owned(),
        verdict: match finding.verdict {
            acerra_chain::findings::Verdict::Agrees => Verdict::Agrees,
            acerra_chain::findings::Verdict::Doubtful => Verdict::Doubtful,
            acerra_chain::findings::Verdict::Contradicts => Verdict::Contradicts,
        },
        explanation: finding.explanation.clone(),
    }
}

fn alignment(search: &OffsetSearch) -> AlignmentEvidence {
    let total = &search.likelihood.total;
    let best = total.best().1;
    // Likelihoods far below the best are drawn at this limit.
    let stride = (total.log_likelihood.len() / 4000).max(1);
    let (offset_s, score) = (0..total.log_likelihood.len())
        .step_by(stride)
        .map(|k| {
            (
                total.offset_s(k),
                (total.log_likelihood[k] - best).max(-60.0),
            )
        })
        .unzip();
    let estimate = &search.estimate;
    let mut remark = format!(
        "The offset is {:.4} ± {:.4} s by height, motion and sharpness together.",
        estimate.offset_s, estimate.sigma_s
    );
    if let Some(height) = &search.likelihood.height {
        remark += &format!(" Height alone gives {:.3} s.", height.offset_s);
    }
    if let Some(motion) = &search.likelihood.motion {
        remark += &format!(" Motion alone gives {:.3} s.", motion.offset_s);
    }
    if let Some(sharpness) = &estimate.sharpness {
        remark += &format!(
            " The image is sharpest at {:.4} ± {:.4} s, of {} offsets tried.",
            sharpness.offset_s,
            sharpness.sigma_s,
            search.sharpness.offset_s.len()
        );
    }
    match estimate.second {
        Some((second_s, below)) => {
            remark += &format!(
                " The most likely other offset is {second_s:.3} s, at a log-likelihood {below:.0} \
                 below."
            );
        }
        None => remark += " Every other offset tried is excluded.",
    }
    AlignmentEvidence {
        offset_s,
        score,
        chosen_s: estimate.offset_s,
        score_name: "log-likelihood below the best".to_owned(),
        remark,
    }
}

fn surface(outcome: &Outcome, track: &Track) -> Option<SurfaceEvidence> {
    let traces = track.cleaned.as_ref()?;
    let surface = traces.surface.as_ref()?;
    let half_c = 0.5 * outcome.campaign.image.light_speed_m_s;
    let residual = match (surface.median_residual_s, surface.spread_s) {
        (Some(median), Some(spread)) => format!(
            "The echo less 2h/c is {:+.0} mm in the median of the traces, spread {:.0} mm; it is {:.0} dB \
             above the signal that does not follow the height.",
            median * half_c * 1e3,
            spread * half_c * 1e3,
            surface.contrast_db
        ),
        _ => "The echo was not found in enough traces to compare it with the height.".to_owned(),
    };
    let aligned = &outcome.prepared.aligned;
    Some(SurfaceEvidence {
        time_s: trajectory_time_s(outcome, track),
        picked_range_m: surface
            .fast_time_s
            .iter()
            .map(|t| t.map_or(f64::NAN, |t| t * half_c))
            .collect(),
        height_m: aligned.height_m[track.range.clone()].to_vec(),
        shift_ns: traces.shift_s * 1e9,
        remark: residual,
    })
}

fn choices(outcome: &Outcome) -> Vec<Fact> {
    let mut choices = vec![
        Fact::new(
            "Time offset",
            format!("{:.4} s", outcome.prepared.first().time_offset_s),
        )
        .note(if outcome.prepared.first().recorded_clock.is_some() {
            "trajectory time minus radar time, by the clock recorded with the radar log"
        } else {
            "trajectory time minus radar time"
        }),
    ];
    if let Some(traces) = outcome.prepared.cleaned() {
        choices.push(
            Fact::new(
                "Shift of fast time",
                format!("{:+.3} ns", traces.shift_s * 1e9),
            )
            .note("by delay and zero-timing together"),
        );
    }
    for track in outcome.listed_tracks() {
        let k = &track.calibration;
        let given = format!(
            "{:+.3} ns and {:+.1}° given",
            k.given_delay_ns, k.given_phase_deg
        );
        let note = match k.found {
            Some(f) => format!(
                "{given}; found on the common target relative to the first track; the target is {:.0} dB \
                 above the rest (phase at mid-band)",
                f.contrast_db
            ),
            None => given,
        };
        let value = k.found.map_or_else(
            || format!("{} traces", track.range.len()),
            |f| {
                format!(
                    "{} traces, {:+.4} ± {:.4} ns, {:+.1} ± {:.1}°",
                    track.range.len(),
                    f.delay_ns,
                    f.delay_sigma_ns,
                    f.phase_deg,
                    f.phase_sigma_deg
                )
            },
        );
        choices.push(Fact::new(format!("Track {}", track.name), value).note(note));
    }
    if let Some(error) = outcome.focused.checked_error {
        choices.push(
            Fact::new("Checked error", format!("{error:.1e}"))
                .note("relative L2 against Eq. (3) in double precision, on random pixels"),
        );
    }
    choices
}

/// The plan, a row for each of its lines: first the amount of computation, then the method and further
/// choices.
fn plan(outcome: &Outcome) -> Vec<Fact> {
    let mut lines = outcome.focused.plan.lines();
    let work = lines.next().map(|line| Fact::new("Work", line));
    work.into_iter().chain(lines.map(plan_fact)).collect()
}

/// Letters of a row's name at most.
const MOST_NAME: usize = 48;

/// A line of the plan, split at its colon where few words precede the colon.
fn plan_fact(line: &str) -> Fact {
    let named = line
        .split_once(": ")
        .filter(|(name, _)| name.chars().count() <= MOST_NAME);
    let (name, value) = named.unwrap_or(("Method", line));
    let mut letters = name.chars();
    let capital = letters
        .next()
        .map_or_else(String::new, |first| first.to_uppercase().collect());
    Fact::new(capital + letters.as_str(), value)
}
