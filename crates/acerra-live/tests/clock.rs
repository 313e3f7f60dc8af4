//! Pulses per second take a latency that nobody stated out of the live picture, and nothing tears it.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed
#![allow(clippy::print_stdout)] // figures

use std::sync::OnceLock;
use std::time::Instant;

use acerra_geo::time::GpsTime;
use acerra_gnss::ubx::epoch_time;
use acerra_gnss::ubx::frame::{Piece, pieces};
use acerra_imaging::Control;
use acerra_live::{LiveSettings, Pipeline};
use acerra_record::emulate::{Quality, with_solutions};
use acerra_record::log::{Record, RecordKind};
use acerra_record::session::Session;
use acerra_simulate::scene::Scene;
use acerra_simulate::write::simulate_campaign;

/// 1.5 m/s for 20 s: 60 ms of the receiver's latency are 9 cm.
const SCENE: &str = "seed = 3\nrecord = \"flight\"\n\
    [flight]\ntrack_start_m = [0, 0]\ntrack_end_m = [30, 0]\nheight_m = 4\ntrack_duration_s = 20\n\
    [radar]\nsamples = 960\n[ground]\nfacets_per_m2 = 1\nextent_m = 2\n[gnss]\n\
    [[corner]]\nposition_m = [27, 1.5, 0]\n";

/// Time from an epoch to its first byte (s), which no session states.
const LATENCY_S: f64 = 0.060;
const HOST_BEGAN_S: f64 = 5.0;

/// Records without pulses, the GPS second of the first pulse and the host time of its edge, and the session's campaign.
struct Recorded {
    records: Vec<Record>,
    first_pulse_s: f64,
    end_s: f64,
    campaign: String,
}

fn at_ns(time_s: f64) -> u64 {
    (1e9 * (HOST_BEGAN_S + time_s)) as u64
}

fn recorded() -> &'static Recorded {
    static ONCE: OnceLock<Recorded> = OnceLock::new();
    ONCE.get_or_init(|| {
        let scene = Scene::parse(SCENE).unwrap();
        let made = simulate_campaign(&scene).unwrap();
        let file = |name: &str| &made.files.iter().find(|f| f.name == name).unwrap().bytes;
        let (flight, frame, start) = (scene.fly().unwrap(), scene.frame(), scene.start().unwrap());
        let place = |time: GpsTime| {
            let pose = flight.pose_at(time.seconds_since(start));
            Some(frame.ecef_from_enu(pose.position_m))
        };
        let rover = with_solutions(file("rover.ubx"), place, Quality::Fixed, 11);
        let mut records = Vec::new();
        let mut epoch_s = 0.0_f64;
        for piece in pieces(&rover) {
            let Piece::Frame(found) = piece else { continue };
            if let Some(time) = epoch_time(&found) {
                epoch_s = time.seconds_since(start);
            }
            records.push(Record {
                kind: RecordKind::Gnss,
                at_ns: at_ns(epoch_s.max(0.0) + LATENCY_S),
                payload: rover[found.offset..found.offset + found.payload.len() + 8].to_vec(),
            });
        }
        let capture = &file("radar.mrm")[32..];
        for (message, bytes) in capture
            .chunks(acerra_radar::mrm::SCAN_MESSAGE_BYTES)
            .enumerate()
        {
            // Scans of 960 samples are three messages, which come together.
            let scan_s = (message / 3) as f64 * scene.radar.scan_interval_s;
            records.push(Record {
                kind: RecordKind::Radio,
                at_ns: at_ns(scan_s),
                payload: bytes.to_vec(),
            });
        }
        records.sort_by_key(|record| record.at_ns);
        let [latitude, longitude, height_m] = scene.origin_deg_m;
        Recorded {
            records,
            first_pulse_s: 1.0 - start.fraction(),
            end_s: epoch_s,
            campaign: format!(
                "[campaign.trajectory]\norigin_deg_m = [{latitude:?}, {longitude:?}, {height_m:?}]\n"
            ),
        }
    })
}

/// Pulses of the seconds that `kept` keeps, among the other records.
fn with_pulses(recorded: &Recorded, kept: impl Fn(f64) -> bool) -> Vec<Record> {
    let mut records = recorded.records.clone();
    for second in 0..recorded.end_s as u32 {
        let time_s = recorded.first_pulse_s + f64::from(second);
        if kept(time_s) {
            records.push(Record {
                kind: RecordKind::Pulse,
                at_ns: at_ns(time_s),
                payload: format!("{}.000000000#{second}\n", 1_700_000_000 + second).into_bytes(),
            });
        }
    }
    records.sort_by_key(|record| record.at_ns);
    records
}

fn session(recorded: &Recorded, gnss: &str) -> Session {
    let campaign = &recorded.campaign;
    Session::parse(&format!(
        "[radio]\naddress = \"127.0.0.1:1\"\nlatency_ms = 0.0\n[gnss]\naddress = \"127.0.0.1:2\"\n{gnss}\
         [live]\nx_m = [25, 29]\ny_m = [-0.5, 3.5]\npixel_m = 0.02\n{campaign}"
    ))
    .unwrap()
}

/// Images records and gives up what is too old, as the thread that images does.
fn imaged(session: &Session, records: &[Record], mut after: impl FnMut(&Pipeline)) -> Pipeline {
    let mut pipeline = Pipeline::new(LiveSettings::of(session).unwrap());
    for record in records {
        pipeline.take(record, Instant::now());
        pipeline.drop_behind(256);
        while pipeline.step(Control::default()).unwrap().is_some() {}
        after(&pipeline);
    }
    let pulses = pipeline.status().pulses;
    assert_eq!(
        pulses.came,
        pulses.imaged
            + pulses.begun_anew
            + pulses.waiting
            + pulses.without_position
            + pulses.too_low
            + pulses.not_cleaned
            + pulses.too_many,
        "{pulses:?}"
    );
    pipeline
}

/// Where the strongest pixel is along the track (m).
fn peak_x_m(pipeline: &Pipeline) -> f64 {
    let (grid, image) = pipeline.image().unwrap();
    let moduli = image.image().iter().map(|v| v.norm()).enumerate();
    let (k, _) = moduli.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
    grid.x_m(k % grid.nx)
}

const WIRED: &str = "pps = \"/dev/pps0\"\n";

#[test]
fn pulses_wait_for_the_better_clock_and_stand_where_they_are() {
    let recorded = recorded();
    let records = with_pulses(recorded, |_| true);
    let mut waited = 0;
    let pipeline = imaged(&session(recorded, WIRED), &records, |pipeline| {
        let status = pipeline.status();
        if let Some(told) = &status.waits_for
            && told.starts_with("the better clock, 30 s at most: pulses per second: expected 16")
        {
            waited = waited.max(status.pulses.waiting);
        }
    });
    let status = pipeline.status();
    println!("{status:#?}, {waited} waited");
    assert!(waited > 200, "{waited}");
    assert_eq!(status.clock, Some("pulses per second"));
    assert_eq!((status.pulses.begun_anew, status.pulses.too_many), (0, 0));
    assert_eq!((status.clock_doubt, status.begun_anew), (None, None));
    let x_m = peak_x_m(&pipeline);
    assert!((x_m - 27.0).abs() < 0.03, "{x_m}");

    // Without the wire the same flight is displaced by as much as it flies in the latency.
    let without = imaged(&session(recorded, ""), &recorded.records, |_| {});
    assert_eq!(without.status().clock, Some("times of arrival"));
    let x_m = peak_x_m(&without);
    println!("{x_m} m without pulses");
    assert!((x_m - 27.0).abs() > 0.06, "{x_m}");
}

#[test]
fn a_better_clock_that_comes_late_begins_the_picture_anew() {
    let recorded = recorded();
    let records = with_pulses(recorded, |_| true);
    // The session does not say that there are pulses: nothing waits for them.
    let mut imaged_before = 0;
    let pipeline = imaged(&session(recorded, ""), &records, |pipeline| {
        let status = pipeline.status();
        if status.clock == Some("times of arrival") {
            imaged_before = status.pulses.imaged;
        }
    });
    let status = pipeline.status();
    println!("{status:#?}");
    assert!(imaged_before > 100);
    assert_eq!(status.pulses.begun_anew, imaged_before);
    assert_eq!(status.clock, Some("pulses per second"));
    let again = status.begun_anew.unwrap();
    assert_eq!(again.before, "times of arrival");
    assert!((again.change_ms.abs() - 60.0).abs() < 5.0, "{again:?}");
    assert!((0.07..0.12).contains(&again.moved_m), "{again:?}");
    let (_, image) = pipeline.image().unwrap();
    assert_eq!(image.pulses(), status.pulses.imaged);
    let told = acerra_live::status::doubts(&status, true);
    assert!(told.iter().any(|d| d.contains("started again")), "{told:?}");
    let x_m = peak_x_m(&pipeline);
    assert!((x_m - 27.0).abs() < 0.03, "{x_m}");
}

#[test]
fn nothing_jumps_where_the_pulses_end() {
    let recorded = recorded();
    let records = with_pulses(recorded, |time_s| time_s < 19.0);
    let pipeline = imaged(&session(recorded, WIRED), &records, |_| {});
    let status = pipeline.status();
    // What the pulses measured holds.
    assert_eq!(status.clock, Some("pulses per second"));
    assert_eq!((status.pulses.begun_anew, status.clock_doubt), (0, None));
    let x_m = peak_x_m(&pipeline);
    assert!((x_m - 27.0).abs() < 0.03, "{x_m}");
}

#[test]
fn pulses_that_never_come_are_waited_for_no_longer_than_said_and_doubted() {
    let recorded = recorded();
    let is_early = |record: &&Record| record.at_ns < at_ns(25.0);
    let mut records: Vec<Record> = (recorded.records.iter())
        .filter(is_early)
        .cloned()
        .collect();
    let held = imaged(&session(recorded, WIRED), &records, |_| {}).status();
    assert_eq!(held.pulses.imaged, 0);
    assert!(held.waits_for.unwrap().starts_with("the better clock"));
    // Something else comes when the patience is over.
    records.push(Record {
        kind: RecordKind::Note,
        at_ns: at_ns(40.0),
        payload: Vec::new(),
    });
    let pipeline = imaged(&session(recorded, WIRED), &records, |_| {});
    let status = pipeline.status();
    println!("{status:#?}");
    assert!(status.pulses.imaged > 200);
    assert_eq!(status.clock, Some("times of arrival"));
    let told = acerra_live::status::doubts(&status, true);
    let doubt = "times rest on times of arrival";
    assert!(told.iter().any(|d| d.starts_with(doubt)), "{told:?}");
    assert!(
        told.iter().any(|d| d.contains("expected 16 pulses")),
        "{told:?}"
    );
}
