//! A simulated flight imaged live: the target stands where it is, positions that cannot focus are told.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed
#![allow(clippy::print_stdout)] // figures

use std::time::Instant;

use acerra_geo::time::GpsTime;
use acerra_gnss::ubx::epoch_time;
use acerra_gnss::ubx::frame::{Piece, pieces};
use acerra_imaging::Control;
use acerra_live::status::{Status, doubts};
use acerra_live::{LiveSettings, Pipeline};
use acerra_record::driver::Intake;
use acerra_record::emulate::{Quality, with_solutions};
use acerra_record::log::{Record, RecordKind};
use acerra_record::session::Session;
use acerra_simulate::scene::Scene;
use acerra_simulate::write::simulate_campaign;

const SCENE: &str = "seed = 3\nrecord = \"flight\"\n\
    [flight]\ntrack_start_m = [0, 0]\ntrack_end_m = [8, 0]\nheight_m = 4\ntrack_duration_s = 6\n\
    [radar]\nsamples = 960\nlever_arm_m = [0.05, 0.0, -0.2]\n[ground]\nfacets_per_m2 = 1\nextent_m = 5\n[gnss]\n\
    [[corner]]\nposition_m = [3, 1.5, 0]\n";

/// What the instruments of the scene send, with the host's clock at each: message or bytes.
struct Sent {
    records: Vec<Record>,
    session: Session,
}

fn sent(quality: Quality, live: &str) -> Sent {
    let scene = Scene::parse(SCENE).unwrap();
    let made = simulate_campaign(&scene).unwrap();
    let file = |name: &str| &made.files.iter().find(|f| f.name == name).unwrap().bytes;
    let (flight, frame, start) = (scene.fly().unwrap(), scene.frame(), scene.start().unwrap());
    let place = |time: GpsTime| {
        let pose = flight.pose_at(time.seconds_since(start));
        Some(frame.ecef_from_enu(pose.position_m))
    };
    let rover = with_solutions(file("rover.ubx"), place, quality, 11);
    let host_ns = |time_s: f64| (1e9 * (5.0 + time_s)) as u64;
    let mut records = Vec::new();
    // Bytes of an epoch come 40 ms after it, together.
    let mut epoch_s = 0.0;
    for piece in pieces(&rover) {
        let Piece::Frame(found) = piece else { continue };
        if let Some(time) = epoch_time(&found) {
            epoch_s = time.seconds_since(start);
        }
        records.push(Record {
            kind: RecordKind::Gnss,
            at_ns: host_ns(epoch_s.max(0.0)),
            payload: rover[found.offset..found.offset + found.payload.len() + 8].to_vec(),
        });
    }
    let capture = &file("radar.mrm")[32..];
    let mut intake = Intake::default();
    let mut scans = 0_u32;
    for message in capture.chunks(acerra_radar::mrm::SCAN_MESSAGE_BYTES) {
        intake.take(message);
        let scan_s = f64::from(scans) * scene.radar.scan_interval_s;
        while intake.next_scan().is_some() {
            scans += 1;
        }
        records.push(Record {
            kind: RecordKind::Radio,
            at_ns: host_ns(scan_s),
            payload: message.to_vec(),
        });
    }
    records.sort_by_key(|record| record.at_ns);
    let [latitude, longitude, height_m] = scene.origin_deg_m;
    let text = format!(
        "[radio]\naddress = \"127.0.0.1:1\"\nlatency_ms = 0.0\n[gnss]\naddress = \"127.0.0.1:2\"\n\
         [live]\nx_m = [1, 5]\ny_m = [-0.5, 3.5]\npixel_m = 0.02\n{live}\n\
         [campaign.trajectory]\nlever_arm_m = [0.05, 0.0, -0.2]\n\
         origin_deg_m = [{latitude:?}, {longitude:?}, {height_m:?}]\n"
    );
    Sent {
        records,
        session: Session::parse(&text).unwrap(),
    }
}

/// Images everything; returns the pipeline and the largest number of pulses that waited after a step.
fn imaged(sent: &Sent) -> Pipeline {
    let mut pipeline = Pipeline::new(LiveSettings::of(&sent.session).unwrap());
    for record in &sent.records {
        pipeline.take(record, Instant::now());
        while pipeline.step(Control::default()).unwrap().is_some() {}
    }
    pipeline
}

/// Place of the strongest pixel (m), and its level (dB).
fn peak(pipeline: &Pipeline) -> ([f64; 2], f64) {
    let (grid, image) = pipeline.image().unwrap();
    let moduli = image.image().iter().map(|v| v.norm()).enumerate();
    let (k, largest) = moduli.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
    let place = [grid.x_m(k % grid.nx), grid.y_m(k / grid.nx)];
    (place, 20.0 * f64::from(largest).log10())
}

fn told(pipeline: &Pipeline) -> (Status, Vec<String>) {
    let status = pipeline.status();
    let doubts = doubts(&status, pipeline.settings().is_height_stated);
    (status, doubts)
}

#[test]
fn with_fixed_positions_the_target_stands_where_it_is() {
    let sent = sent(Quality::Fixed, "");
    let pipeline = imaged(&sent);
    let (status, doubts) = told(&pipeline);
    println!("{status:#?}\n{doubts:?}");
    let ([x_m, y_m], level_db) = peak(&pipeline);
    println!("{x_m:.3} {y_m:.3} m, {level_db:.2} dB");
    assert!(
        (x_m - 3.0).abs() < 0.06 && (y_m - 1.5).abs() < 0.1,
        "{x_m} {y_m}"
    );
    let pulses = status.pulses;
    assert_eq!(
        pulses.came,
        pulses.imaged
            + pulses.waiting
            + pulses.without_position
            + pulses.without_heading
            + pulses.too_low
            + pulses.not_cleaned
    );
    assert!(pulses.imaged > 150 && pulses.too_low > 20, "{pulses:?}");
    assert_eq!(status.position, Some("fixed"));
    assert_eq!(status.by_kind.fixed, pulses.imaged);
    assert!(doubts.is_empty(), "{doubts:?}");
    assert_eq!(status.waits_for, None);
}

#[test]
fn pulses_before_the_first_motion_wait_for_the_heading_and_are_imaged() {
    // The radar hangs ahead of the antenna, and the drone climbs straight up before it flies.
    let sent = sent(Quality::Fixed, "least_height_m = 0.5");
    let mut pipeline = Pipeline::new(LiveSettings::of(&sent.session).unwrap());
    let mut most_waited = 0;
    for record in &sent.records {
        pipeline.take(record, Instant::now());
        pipeline.drop_behind(256);
        while pipeline.step(Control::default()).unwrap().is_some() {}
        let status = pipeline.status();
        if status
            .waits_for
            .as_deref()
            .is_some_and(|w| w.contains("heading"))
        {
            most_waited = most_waited.max(status.pulses.waiting);
        }
    }
    let pulses = pipeline.status().pulses;
    println!("{pulses:?}, {most_waited} waited for the heading");
    assert!(most_waited > 20);
    assert_eq!((pulses.without_heading, pulses.too_many), (0, 0));
    assert!(pulses.imaged >= most_waited);
}

#[test]
fn single_positions_are_imaged_and_said_to_focus_nothing() {
    let sent = sent(Quality::Single, "");
    let pipeline = imaged(&sent);
    let (status, doubts) = told(&pipeline);
    assert_eq!(status.by_kind.other, status.pulses.imaged);
    assert!(status.pulses.imaged > 100);
    assert!(
        doubts.iter().any(|d| d.contains("cannot focus")),
        "{doubts:?}"
    );
    assert!(
        doubts
            .iter()
            .any(|d| d.contains("a quarter of the wavelength is 19 mm"))
    );
}

#[test]
fn every_scan_is_accounted_for_wherever_the_records_are_cut() {
    let mut sent = sent(Quality::Fixed, "");
    // The receiver is gone for 3 s, the radio restarts in the middle.
    let middle_ns = sent.records[sent.records.len() / 2].at_ns;
    sent.records.retain(|record| {
        record.kind != RecordKind::Gnss
            || !(middle_ns..middle_ns + 3_000_000_000).contains(&record.at_ns)
    });
    let mut pipeline = Pipeline::new(LiveSettings::of(&sent.session).unwrap());
    for (k, record) in sent.records.iter().enumerate() {
        let mut record = record.clone();
        if k % 97 == 0 {
            record.payload.truncate(k % 50);
        }
        if k % 101 == 0 {
            record.payload.iter_mut().for_each(|byte| *byte ^= 0x5A);
        }
        pipeline.take(&record, Instant::now());
        while pipeline.step(Control::default()).unwrap().is_some() {}
        let pulses = pipeline.status().pulses;
        assert_eq!(
            pulses.came,
            pulses.imaged
                + pulses.waiting
                + pulses.without_position
                + pulses.without_heading
                + pulses.too_low
                + pulses.not_cleaned
        );
    }
    let pulses = pipeline.status().pulses;
    println!("{pulses:?}");
    assert!(pulses.without_position > 0 && pulses.imaged > 50);
}
