//! The driver against the emulated radio, over UDP on the loopback interface.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed
#![allow(clippy::print_stdout)] // figures, and why a test is skipped

use std::net::{SocketAddr, UdpSocket};
use std::time::{Duration, Instant};

use acerra_radar::Scan;
use acerra_radar::mrm::RadarConfig;
use acerra_record::driver::{
    Driver, DriverError, Event, LinkCounts, RequestOptions, Setup, WatchOptions, Watched,
};
use acerra_record::emulate::{
    EmulatedRadio, EmulatorCounts, EmulatorOptions, Impairments, Pattern, Recorded, ScanSource as _,
};
use acerra_record::host::HostClock;
use acerra_record::link::UdpLink;

const LOOPBACK: ([u8; 4], u16) = ([127, 0, 0, 1], 0);

/// 672 samples: two messages a scan.
fn config() -> RadarConfig {
    RadarConfig {
        scan_start_ps: 10_000,
        scan_stop_ps: 10_000 + 41_015,
        ..RadarConfig::default()
    }
}

fn quick() -> RequestOptions {
    RequestOptions {
        timeout: Duration::from_millis(100),
        attempts: 5,
    }
}

fn watch() -> WatchOptions {
    WatchOptions {
        silence: Duration::from_millis(300),
        retry: Duration::from_millis(50),
        status_every: Duration::from_millis(700),
    }
}

fn driver(peer: SocketAddr) -> Driver<UdpLink> {
    Driver::new(UdpLink::open(peer, HostClock::start()).unwrap(), quick())
}

/// What a flight brought.
struct Flight {
    scans: Vec<Scan>,
    counts: LinkCounts,
    emulated: EmulatorCounts,
    silences: usize,
    restarts: usize,
    temperatures: Vec<f64>,
}

/// Records until the source has no more.
fn fly(scans: u64, interval_us: u32, options: EmulatorOptions) -> Flight {
    let radio =
        EmulatedRadio::start(LOOPBACK.into(), Box::new(Pattern::new(scans)), options).unwrap();
    let setup = Setup::raw(config(), interval_us);
    let mut watched = Watched::start(driver(radio.address()), setup, watch()).unwrap();
    let mut flight = Flight {
        scans: Vec::new(),
        counts: LinkCounts::default(),
        emulated: EmulatorCounts::default(),
        silences: 0,
        restarts: 0,
        temperatures: Vec::new(),
    };
    let began = Instant::now();
    loop {
        assert!(began.elapsed() < Duration::from_secs(120), "stalled");
        match watched.next_event(Duration::from_millis(20)) {
            Some(Event::Scan(scan)) => flight.scans.push(scan),
            Some(Event::Status(status)) => flight.temperatures.push(status.temperature_c()),
            Some(Event::Silent(_)) if radio.counts().exhausted => break,
            Some(Event::Silent(_)) => flight.silences += 1,
            Some(Event::Resumed { restarted, .. }) => flight.restarts += usize::from(restarted),
            Some(Event::Message(_)) | None => {}
        }
    }
    for event in watched.stop() {
        if let Event::Scan(scan) = event {
            flight.scans.push(scan);
        }
    }
    flight.counts = watched.counts();
    flight.emulated = radio.counts();
    flight
}

/// Numbers of the pattern's scans in the order they came; each must be one of them exactly, and none
/// may come twice.
fn pattern_numbers(scans: &[Scan]) -> Vec<u64> {
    let mut newest = 0_u64;
    let mut found = std::collections::BTreeSet::new();
    let mut numbers = Vec::new();
    for scan in scans {
        let is_it = |k: &u64| (0..4).all(|i| Pattern::sample(*k, i) == scan.samples[i]);
        // A scan may overtake others by the few that are under way at once.
        let number = (newest.saturating_sub(16)..newest + 20_000)
            .find(is_it)
            .expect("a scan of the pattern");
        let sound = |i: usize| scan.samples[i] == Pattern::sample(number, i);
        assert!((0..scan.samples.len()).all(sound), "scan {number}");
        assert!(found.insert(number), "scan {number} came twice");
        newest = newest.max(number);
        numbers.push(number);
    }
    numbers
}

#[test]
fn a_good_link_brings_every_scan_once() {
    let options = EmulatorOptions {
        speed: 20.0,
        ..EmulatorOptions::default()
    };
    let flight = fly(2_000, 10_000, options);
    assert_eq!(flight.emulated.scans, 2_000);
    let numbers = pattern_numbers(&flight.scans);
    let counts = flight.counts;
    assert_eq!(numbers.len() as u64, counts.whole_scans);
    assert_eq!(counts.scans_made(), 2_000);
    assert!(counts.whole_scans >= 1_990, "{counts}");
    assert_eq!(
        (counts.restarts, counts.undecodable, counts.repeated),
        (0, 0, 0)
    );
    assert_eq!(flight.temperatures.first(), Some(&38.0));
}

/// Ten minutes at 100 scans a second, in ten seconds.
#[test]
fn loss_repetition_reordering_and_a_restart_are_survived_and_counted() {
    let options = EmulatorOptions {
        speed: 60.0,
        impairments: Impairments {
            loss: 0.01,
            repetition: 0.005,
            reordering: 0.02,
            held_back_s: 0.03,
            delay_s: 0.002,
            jitter_s: 0.001,
            seed: 14,
        },
        reboot_at_s: vec![300.0],
        ..EmulatorOptions::default()
    };
    let flight = fly(60_000, 10_000, options);
    let (counts, emulated) = (flight.counts, flight.emulated);
    println!("{counts}\n{emulated:?}");
    let numbers = pattern_numbers(&flight.scans);
    assert_eq!(numbers.len() as u64, counts.whole_scans);
    assert_eq!((emulated.reboots, counts.restarts), (1, 1));
    assert_eq!((flight.silences, flight.restarts), (1, 1));
    let dropped_by_system = emulated.datagrams - counts.packets;
    println!("{dropped_by_system} datagrams dropped by the system");
    // Unknown to the driver are only scans of which nothing came at the end and before the restart:
    // those on their way then, and what the system dropped there.
    let unknown = emulated.scans - counts.scans_made();
    assert!(
        unknown <= 8 + dropped_by_system / 2,
        "{unknown} scans are not accounted for"
    );
    assert_eq!(counts.scans_under_way, 0);
    assert!(counts.reordered > 0 && counts.incomplete_scans > 0 && counts.retries < 20);
    let scans_heard = counts.scan_messages - counts.repeated - counts.late;
    // Messages missing for whole scans: each is of a scan that is counted incomplete or lost.
    let missing = 2 * counts.scans_made() - scans_heard;
    assert_eq!(missing, counts.incomplete_scans + 2 * counts.lost_scans);
    // Every scan that was sent whole is kept, but for those of which the system dropped a message, or
    // brought one when eight later scans had come (those are counted as late), and those of which one was
    // on its way when the radio restarted.
    let not_kept = emulated.scans_sent_whole.checked_sub(counts.whole_scans);
    let not_kept = not_kept.expect("no scan more than were sent");
    let excused = dropped_by_system + counts.late + emulated.channel.lost_on_restart;
    assert!(not_kept <= excused, "{not_kept}");
    assert!(
        counts.late <= emulated.channel.held_back / 20,
        "{}",
        counts.late
    );
}

#[test]
fn a_wrong_port_is_named() {
    let free = UdpSocket::bind(SocketAddr::from(LOOPBACK))
        .unwrap()
        .local_addr()
        .unwrap();
    let error = driver(free).status().unwrap_err();
    let text = error.to_string();
    assert!(
        text.ends_with(
            "no program listens there; expected a radio, whose port is 21210 (check address and port)"
        ),
        "{text}"
    );
}

#[test]
fn a_silent_radio_is_named() {
    let deaf = UdpSocket::bind(SocketAddr::from(LOOPBACK)).unwrap();
    let error = driver(deaf.local_addr().unwrap()).status().unwrap_err();
    let text = error.to_string();
    assert!(
        text.contains("no answer to GET_STATUSINFO_REQUEST in 5 attempts of 0.1 s"),
        "{text}"
    );
}

#[test]
fn a_refused_setting_is_named() {
    let mut pattern = Pattern::new(10);
    let made: Vec<Vec<u8>> = (0..10)
        .flat_map(|_| pattern.next_scan(&config(), 10_000).unwrap().messages)
        .collect();
    let capture = made.concat();
    let recorded = Recorded::from_capture(&capture).unwrap().unwrap();
    assert_eq!((recorded.remaining(), recorded.interval_us()), (10, 10_000));
    let options = EmulatorOptions::default();
    let radio = EmulatedRadio::start(LOOPBACK.into(), Box::new(recorded), options).unwrap();
    let mut driver = driver(radio.address());
    assert!(driver.set_up(&Setup::raw(config(), 10_000)).is_ok());
    let other = RadarConfig {
        scan_stop_ps: 90_000,
        ..config()
    };
    let error = driver.set_up(&Setup::raw(other, 10_000)).unwrap_err();
    assert!(matches!(error, DriverError::Refused { .. }));
    let text = error.to_string();
    assert!(
        text.ends_with("the radio refuses SET_CONFIG_REQUEST: unsupported value (status 3)"),
        "{text}"
    );
}

/// A second client takes the scans away; the driver has them back, and says that they were gone.
#[test]
fn a_second_client_is_survived() {
    let source = Box::new(Pattern::new(100_000));
    let radio = EmulatedRadio::start(LOOPBACK.into(), source, EmulatorOptions::default()).unwrap();
    let setup = Setup::raw(config(), 5_000);
    let mut first = Watched::start(driver(radio.address()), setup, watch()).unwrap();
    let until_scan = |watched: &mut Watched<UdpLink>| {
        let began = Instant::now();
        while began.elapsed() < Duration::from_secs(20) {
            if let Some(Event::Scan(_)) = watched.next_event(Duration::from_millis(20)) {
                return true;
            }
        }
        false
    };
    assert!(until_scan(&mut first));
    driver(radio.address()).start(5_000).unwrap();
    let began = Instant::now();
    let silent = loop {
        assert!(began.elapsed() < Duration::from_secs(20));
        if let Some(Event::Silent(why)) = first.next_event(Duration::from_millis(20)) {
            break why;
        }
    };
    assert!(silent.starts_with("no scan for 0."), "{silent}");
    assert!(until_scan(&mut first));
    let counts = first.counts();
    assert_eq!((counts.silences, counts.restarts), (1, 0));
}
