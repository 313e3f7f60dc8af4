//! Thousands of damaged files: every reader answers or refuses, and what it passes on keeps its
//! promises. The fuzz targets (`fuzz/`) go on where this stops.

use acerra_geo::geoid::GeoidGrid;
use acerra_gnss::antex::read_antex;
use acerra_gnss::conf::read_conf;
use acerra_gnss::input::{Limits, Lines};

use acerra_gnss::ubx::frame::{Piece, encode, pieces};
use acerra_gnss::{EPOCH_TOLERANCE_S, Ephemeris, GnssFile, RuleSet, read_gnss, rtcm};

const SEEDS: [&[u8]; 18] = [
    include_bytes!("../../../../fuzz/seeds/rinex_obs/v2.rnx"),
    include_bytes!("../../../../fuzz/seeds/rinex_obs/v3.rnx"),
    include_bytes!("../../../../fuzz/seeds/rinex_nav/v2.nav"),
    include_bytes!("../../../../fuzz/seeds/rinex_nav/v3.nav"),
    include_bytes!("../../../../fuzz/seeds/rinex_nav/v4.nav"),
    include_bytes!("../../../../fuzz/seeds/crinex/2.11.crx"),
    include_bytes!("../../../../fuzz/seeds/crinex/3.04.crx"),
    include_bytes!("../../../../fuzz/seeds/ubx/all.ubx"),
    include_bytes!("../../../../fuzz/seeds/ubx/cut.ubx"),
    include_bytes!("../../../../fuzz/seeds/conf/all.conf"),
    include_bytes!("../../../../fuzz/seeds/rtcm/observations.rtcm3"),
    include_bytes!("../../../../fuzz/seeds/products/orbits.sp3"),
    include_bytes!("../../../../fuzz/seeds/products/clocks.clk"),
    include_bytes!("../../../../fuzz/seeds/products/antennas.atx"),
    include_bytes!("../../../../fuzz/seeds/unix_compress/aaa.Z"),
    include_bytes!("../../../../fuzz/seeds/geoid/part.gtx"),
    include_bytes!("../../../../fuzz/seeds/geoid/part.grd"),
    include_bytes!("../../../../fuzz/seeds/geoid/world.pgm"),
];

/// A small generator (SplitMix64), so that every run damages alike.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }
}

/// Changes, removes, repeats or swaps a few pieces.
fn damage(bytes: &mut Vec<u8>, random: &mut Random) {
    const LIKELY: &[u8] = b"0129-+.DEG>& \n\rR\xB5\x62\xFF\x00";
    for _ in 0..=random.below(4) {
        if bytes.is_empty() {
            return;
        }
        let at = random.below(bytes.len());
        let end = at + random.below(bytes.len() - at).min(90);
        match random.below(7) {
            0 => bytes[at] = LIKELY[random.below(LIKELY.len())],
            1 => bytes[at] ^= 1 << random.below(8),
            2 => bytes.truncate(at),
            3 => drop(bytes.drain(at..end)),
            4 => {
                let piece = bytes[at..end].to_vec();
                let to = random.below(bytes.len());
                bytes.splice(to..to, piece);
            }
            5 => bytes.insert(at, LIKELY[random.below(LIKELY.len())]),
            _ => bytes[at..end].fill(LIKELY[random.below(LIKELY.len())]),
        }
    }
}

fn check(file: &GnssFile) {
    if let Some(data) = &file.observations {
        for pair in data.epochs.windows(2) {
            assert!(pair[1].time - pair[0].time >= EPOCH_TOLERANCE_S);
        }
        for epoch in &data.epochs {
            assert!(
                epoch
                    .satellites
                    .windows(2)
                    .all(|w| w[0].satellite < w[1].satellite)
            );
            for satellite in &epoch.satellites {
                let system = satellite.satellite.system();
                for (slot, signal) in satellite.signals.iter().enumerate() {
                    let Some(signal) = signal else { continue };
                    assert_eq!(signal.code.slot(system), Some(slot));
                    let values = [signal.pseudorange_m, signal.phase_cycles, signal.doppler_hz];
                    assert!(
                        values
                            .into_iter()
                            .flatten()
                            .all(|v| v.is_finite() && v != 0.0)
                    );
                }
            }
        }
    }
    if let Some(precise) = file.navigation.as_ref().map(|n| &n.precise)
        && let Some((first, last)) = precise.span()
    {
        let middle = first + 0.5 * last.seconds_since(first);
        for satellite in precise.satellites() {
            if let Ok(state) = precise.state_at(satellite, middle) {
                assert!(state.position_ecef_m.iter().all(|x| x.is_finite()));
                assert!(state.clock_s.is_finite());
            }
        }
    }
    for ephemeris in file.navigation.iter().flat_map(|n| &n.ephemerides) {
        if let Ephemeris::Kepler(e) = ephemeris {
            assert!((0.0..1.0).contains(&e.eccentricity) && e.sqrt_semi_major_axis >= 1000.0);
            assert!((e.toe - e.toc).abs() <= 302_400.0);
        }
    }
}

/// Antenna calibrations that are passed on give finite ranges.
fn check_calibrations(bytes: &[u8]) {
    let Ok((antex, _)) = read_antex(&mut Lines::new(bytes, Limits::default())) else {
        return;
    };
    for calibration in antex.antennas.iter().flat_map(|a| a.frequencies.values()) {
        assert!(calibration.range_m(4.0, 0.6).is_finite());
    }
}

#[test]
fn damaged_files_are_read_or_refused() {
    let mut random = Random(1);
    let mut read = 0;
    for seed in SEEDS {
        for _ in 0..1500 {
            let mut bytes = seed.to_vec();
            damage(&mut bytes, &mut random);
            if let Ok(file) = read_gnss(bytes.as_slice(), Limits::default()) {
                check(&file);
                read += 1;
            }
            let _ = read_conf(bytes.as_slice(), RuleSet::Rtklib);
            check_calibrations(&bytes);
            let _ = GeoidGrid::from_reader(bytes.as_slice());
        }
    }
    assert!(
        read > 5000,
        "too few files survived to test anything: {read}"
    );
}

/// RTCM messages with right checksums and wrong contents.
#[test]
fn damaged_messages_in_whole_rtcm_frames() {
    let mut random = Random(3);
    let messages: Vec<Vec<u8>> = rtcm::frame::pieces(SEEDS[10])
        .filter_map(|piece| match piece {
            rtcm::frame::Piece::Frame(f) => Some(f.payload.to_vec()),
            _ => None,
        })
        .collect();
    assert!(messages.len() >= 7);
    let mut read = 0;
    for _ in 0..3000 {
        let mut log = Vec::new();
        for _ in 0..12 {
            let mut payload = messages[random.below(messages.len())].clone();
            if random.below(3) > 0 {
                damage(&mut payload, &mut random);
                payload.truncate(1023);
            }
            log.extend(rtcm::frame::encode(&payload).unwrap());
        }
        if let Ok(file) = read_gnss(log.as_slice(), Limits::default()) {
            check(&file);
            read += 1;
        }
    }
    assert!(read > 1000, "{read}");
}

/// Messages with right checksums and wrong contents.
#[test]
fn damaged_messages_in_whole_frames() {
    let mut random = Random(2);
    let messages: Vec<(u8, u8, Vec<u8>)> = pieces(SEEDS[7])
        .filter_map(|piece| match piece {
            Piece::Frame(f) => Some((f.class, f.id, f.payload.to_vec())),
            _ => None,
        })
        .collect();
    assert!(messages.len() >= 8);
    for _ in 0..3000 {
        let mut log = Vec::new();
        for _ in 0..12 {
            let (class, id, payload) = &messages[random.below(messages.len())];
            let mut payload = payload.clone();
            if random.below(3) > 0 {
                damage(&mut payload, &mut random);
            }
            log.extend(encode(*class, *id, &payload).unwrap());
        }
        check(&read_gnss(log.as_slice(), Limits::default()).unwrap());
    }
}
