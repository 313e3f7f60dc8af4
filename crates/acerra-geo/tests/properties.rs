//! What holds for anything: round trips, order, and readers that never panic.

use acerra_geo::geodesy::{EnuFrame, Geodetic, ecef_from_geodetic, geodetic_from_ecef};
use acerra_geo::interpolate::{Flag, InterpolationOptions, Interpolator};
use acerra_geo::matrix::distance;
use acerra_geo::read::{ReadOptions, read_trajectory, sniff};
use acerra_geo::time::{Calendar, GpsTime};
use acerra_geo::trajectory::{Attitude, Fix, Frame, SolutionStatus, TimeOrigin, Trajectory};
use acerra_geo::write::write_trajectory_csv;
use proptest::prelude::*;

fn fixes() -> impl Strategy<Value = Vec<Fix>> {
    let one = (
        1e-3..5.0f64,
        prop::array::uniform3(-5e3..5e3f64),
        prop::option::of(prop::array::uniform3(1e-4..10.0f64)),
        prop::option::of(prop::array::uniform4(0.1..1.0f64)),
        0usize..8,
        prop::option::of((0u16..99, -30.0..30.0f64, 0.0..999.9f64)),
    );
    prop::collection::vec(one, 1..40).prop_map(|rows| {
        let mut time_s = -3.0;
        rows.into_iter()
            .map(|(step, position_m, sd, q, status, details)| {
                time_s += step;
                let mut fix = Fix::new(time_s, position_m);
                // Squares of these roots are exact, so that the deviations come back as they were.
                fix.covariance_m2 = sd.map(|sd| {
                    let mut c = [[0.0; 3]; 3];
                    for (i, sd) in sd.iter().enumerate() {
                        c[i][i] = f64::from(*sd as f32) * f64::from(*sd as f32);
                    }
                    c
                });
                fix.attitude = q.and_then(|[w, x, y, z]| Attitude::from_quaternion(w, x, y, z));
                fix.status = SolutionStatus::ALL[status];
                if let Some((n, age, ratio)) = details {
                    fix.satellites = Some(n);
                    fix.age_s = Some(age);
                    fix.ratio = Some(ratio);
                }
                fix
            })
            .collect()
    })
}

proptest! {
    #[test]
    fn calendars_return(seconds in 0i64..3_786_825_600, fraction in 0.0..1.0f64) {
        let t = GpsTime::new(seconds, fraction);
        prop_assert_eq!(GpsTime::from_calendar(&t.to_calendar()), t);
        prop_assert_eq!(GpsTime::from_utc(&t.to_utc()), Ok(t));
        prop_assert_eq!(GpsTime::from_glonass(&t.to_glonass()), Ok(t));
        prop_assert!((GpsTime::from_week_tow(t.week(), t.tow_s()) - t).abs() < 1e-9);
        let bdt = GpsTime::from_bdt_week_sow(t.week() - 1356, t.tow_s());
        prop_assert!((bdt - t - 14.0).abs() < 1e-9);
    }

    #[test]
    fn printed_times_are_within_half_a_digit(
        seconds in 0i64..3_786_825_600, fraction in 0.0..1.0f64, decimals in 0usize..10,
    ) {
        let t = GpsTime::new(seconds, fraction);
        let text = t.format_calendar(decimals);
        let number = |r: std::ops::Range<usize>| text[r].parse::<u8>().expect("digits");
        let second: f64 = text[17..].parse().expect("seconds");
        let back = Calendar::new(
            text[..4].parse().expect("year"), number(5..7), number(8..10), number(11..13),
            number(14..16), second,
        ).expect("a date");
        let error = GpsTime::from_calendar(&back) - t;
        prop_assert!(error.abs() <= 0.5000001 * 10f64.powi(-(decimals as i32)) + 1e-13, "{text}");
    }

    #[test]
    fn steps_add_up(seconds in 0i64..4_000_000_000, fraction in 0.0..1.0f64, step in -1e7..1e7f64) {
        let t = GpsTime::new(seconds, fraction);
        let moved = t + step;
        prop_assert!((moved - t - step).abs() <= 1e-9 * (1.0 + step.abs() * 1e-6));
        prop_assert!((0.0..1.0).contains(&moved.fraction()));
        prop_assert_eq!(moved > t, moved - t > 0.0);
    }

    #[test]
    fn geodetic_returns(lat in -90.0..90.0f64, lon in -180.0..180.0f64, h in -1e4..4e7f64) {
        let place = Geodetic::from_degrees(lat, lon, h);
        let p = ecef_from_geodetic(&place);
        let back = geodetic_from_ecef(p);
        prop_assert!((back.latitude_rad - place.latitude_rad).abs() < 1e-12);
        prop_assert!((back.height_m - h).abs() < 3e-8);
        prop_assert!(distance(ecef_from_geodetic(&back), p) < 5e-8);
    }

    #[test]
    fn frames_return(
        lat in -90.0..90.0f64, lon in -180.0..180.0f64, p in prop::array::uniform3(-1e5..1e5f64),
    ) {
        let frame = EnuFrame::new(Geodetic::from_degrees(lat, lon, 100.0));
        prop_assert!(distance(frame.enu_from_ecef(frame.ecef_from_enu(p)), p) < 1e-8);
    }

    /// What is written comes back to the last bit.
    #[test]
    fn written_trajectories_come_back(fixes in fixes(), placed: bool, dated: bool) {
        let frame = if placed {
            Frame::Enu(EnuFrame::new(Geodetic::from_degrees(40.5, 14.25, 60.0)))
        } else {
            Frame::Local
        };
        let origin = if dated {
            TimeOrigin::Gps(GpsTime::from_week_tow(2100, 1_234.5))
        } else {
            TimeOrigin::Relative
        };
        let track = Trajectory::new(frame, origin, fixes).expect("a trajectory");
        let mut text = Vec::new();
        write_trajectory_csv(&mut text, &track).expect("memory");
        let (back, report) = read_trajectory(&text[..], &ReadOptions::default()).expect("readable");
        prop_assert_eq!(report.skipped_total(), 0);
        prop_assert_eq!(back.time_origin(), origin);
        prop_assert_eq!(back.frame().enu().is_some(), placed);
        for (a, b) in track.fixes().iter().zip(back.fixes()) {
            prop_assert_eq!((a.time_s, a.position_m, a.status), (b.time_s, b.position_m, b.status));
            prop_assert_eq!(a.standard_deviation_m(), b.standard_deviation_m());
            prop_assert_eq!((a.satellites, a.age_s, a.ratio), (b.satellites, b.age_s, b.ratio));
            let parts = |f: &Fix| f.attitude.map(|a| a.quaternion());
            if let (Some(a), Some(b)) = (parts(a), parts(b)) {
                prop_assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-15));
            }
        }
    }

    /// On every fix the curve is the fix; everywhere it is finite, and flagged by what it is
    /// between.
    #[test]
    fn curves_go_through_their_fixes(fixes in fixes(), shares in prop::collection::vec(0.0..1.0f64, 20)) {
        let track = Trajectory::new(Frame::Local, TimeOrigin::Relative, fixes).expect("one");
        let at = Interpolator::new(&track, &InterpolationOptions::default());
        for fix in track.fixes() {
            let p = at.at(fix.time_s);
            prop_assert_eq!(p.position_m, fix.position_m);
            prop_assert_eq!(p.flag == Flag::Ok, fix.status.is_fixed());
        }
        for share in shares {
            let t = track.start_s() + share * (track.end_s() - track.start_s());
            let p = at.at(t);
            prop_assert!(p.position_m.iter().chain(&p.velocity_m_s).all(|v| v.is_finite()));
            let i = track.fixes().partition_point(|f| f.time_s <= t) - 1;
            if let Some(next) = track.fixes().get(i + 1) && t > track.fixes()[i].time_s {
                let gap = next.time_s - track.fixes()[i].time_s > at.max_gap_s();
                prop_assert_eq!(gap, p.flag == Flag::InGap);
            }
        }
    }

    /// Any bytes: an answer or an error.
    #[test]
    fn bytes_do_not_panic(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        let _ = sniff(&bytes);
        let _ = read_trajectory(&bytes[..], &ReadOptions::default());
    }

    /// Files that begin well and go wrong somewhere: cut, or with a few bytes replaced.
    #[test]
    fn spoilt_files_do_not_panic(
        which in 0usize..4, cut in 0.0..1.0f64,
        spoilt in prop::collection::vec((0.0..1.0f64, any::<u8>()), 0..6),
    ) {
        let mut bytes = SAMPLES[which].as_bytes().to_vec();
        for (place, byte) in spoilt {
            let at = (place * bytes.len() as f64) as usize;
            bytes[at] = byte;
        }
        bytes.truncate((cut * bytes.len() as f64) as usize);
        let read = read_trajectory(&bytes[..], &ReadOptions::default());
        if let Ok((track, _)) = read {
            prop_assert!(track.fixes().iter().all(|f| f.position_m.iter().all(|v| v.is_finite())));
        }
    }
}

const SAMPLES: [&str; 4] = [
    "% ref pos   : 35.132057068  139.624306577    73.9077\n%\n\
     %  GPST                  e-baseline(m)  n-baseline(m)  u-baseline(m)   Q  ns   sde(m)\n\
     2005/04/02 00:57:00.000      -954.1014      3197.3012        -3.3166   2   5   1.0837   5.0495  13.0224  -2.0677   8.0059  -3.3747   0.01    1.2\n\
     2005/04/02 00:56:30.000      -953.8738      3195.9236        -6.3574   2   6   0.4380   0.9100   2.0567  -0.0496   1.0569  -0.2997   0.01    1.2\n",
    "# origin_deg_m: 40.5 14.25 60\n# second_zero_gps_week_tow_s: 2100 0\n\
     time_s,lat,lon,height,sdn,sde,sdu,q,qw,qx,qy,qz\n\
     1.5,40.51,14.26,61,0.01,0.01,0.02,1,1,0,0,0\n2.5,40.51,14.26,62,0.01,0.01,0.02,1,1,0,0,0\n",
    "$GNRMC,235959.00,A,5316.961,N,00858.930,W,0.1,0.0,081018,,,R*6A\r\n\
     $GNGGA,235959.00,5316.96100,N,00858.93000,W,4,12,0.7,40.000,M,57.3,M,1.0,0000\r\n\
     $GNGST,235959.00,1.0,,,,0.020,0.010,0.030\r\n\
     $GNGGA,000000.00,5316.96100,N,00858.93000,W,5,12,0.7,40.000,M,57.3,M,1.0,0000\r\n",
    "Format Version,1.23,Take Name,A,Total Exported Frames,3,Length Units,Meters\r\n\r\n\
     ,Type,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body\r\n\
     ,Name,R,R,R,R,R,R,R\r\n,ID,1,1,1,1,1,1,1\r\n\
     ,,Rotation,Rotation,Rotation,Rotation,Position,Position,Position\r\n\
     Frame,Time (Seconds),X,Y,Z,W,X,Y,Z\r\n0,0.0,0,0,0,1,1,2,3\r\n1,0.01,,,,,,,\r\n\
     2,0.02,0,0,0,1,1.1,2,3\r\n",
];

#[test]
fn the_samples_are_good_before_they_are_spoilt() {
    for sample in SAMPLES {
        let (track, _) = read_trajectory(sample.as_bytes(), &ReadOptions::default()).expect(sample);
        assert_eq!(track.fixes().len(), 2);
    }
}
