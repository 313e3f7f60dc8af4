//! RTKLIB configurations.

use crate::common;

use acerra_gnss::conf::{ConfError, NotFollowedReason, RtklibConf, read_conf, rtklib_defaults};
use acerra_gnss::pos::{PosFrame, PosTime, PosTimeScale};
use acerra_gnss::{
    AmbiguityMode, BasePosition, FilterDirection, GlonassAmbiguity, PositioningMode, PpkOptions,
    RuleSet, System, SystemSet,
};

fn read(text: &str) -> RtklibConf {
    read_conf(text.as_bytes(), RuleSet::Rtklib).unwrap()
}

/// The configuration of the shared reference solutions means the preset that is named after it.
#[test]
fn reference_configurations() {
    for (name, direction, ratio) in [
        ("b34_fixhold_forward", FilterDirection::Forward, 100.0),
        ("ex251_eratio300_combined", FilterDirection::Combined, 300.0),
    ] {
        let Some(file) = common::open(&format!("gnss-walk-m8p/reference/{name}.conf")) else {
            return;
        };
        let conf = read_conf(std::io::BufReader::new(file), RuleSet::Rtklib).unwrap();
        assert_eq!(conf.not_followed, []);
        let mut expected = PpkOptions::rtklib();
        expected.direction = direction;
        expected.systems = SystemSet::GPS.with(System::Glonass);
        expected.glonass_ambiguity = GlonassAmbiguity::On;
        expected.code_phase_ratio[0] = ratio;
        expected.base_position = BasePosition::Header;
        assert_eq!(conf.options, expected, "{name}");
        assert_eq!(conf.format.frame, PosFrame::EnuBaseline);
    }
}

#[test]
fn values_by_name_and_by_number() {
    let conf = read(
        "# a comment\n\
         pos1-posmode       =2          # (0:single,1:dgps,2:kinematic)\r\n\
         pos1-frequency     =l1+l2+l5\n\
         pos1-soltype       =combined-nophasereset\n\
         pos1-elmask        =12.5       # (deg)\n\
         pos1-snrmask_r     =on\n\
         pos1-snrmask_L1    =10,20,30,35,35,35,35,35,35\n\
         pos1-dynamics      =on\n\
         stats-prnaccelh    =3\n\
         pos1-exclsats      =G05 R11\n\
         pos1-navsys        =41\n\
         pos1-posopt5       =on\n\
         pos2-armode        =0\n\
         pos2-bdsarmode     =off\n\
         pos2-maxage        =10\n\
         misc-timeinterp    =on\n\
         out-solformat      =xyz\n\
         out-timesys        =utc\n\
         out-timeform       =tow\n\
         out-timendec       =1\n\
         ant2-postype       =xyz\n\
         ant2-pos1          =4641949.6 # (m)\n\
         ant2-pos2          =1393045.4\n\
         ant2-pos3          =4133287.4\n\
         ant2-antdelu       =0.1\n",
    );
    let o = &conf.options;
    assert_eq!((o.mode, o.frequencies), (PositioningMode::Kinematic, 3));
    assert_eq!(o.direction, FilterDirection::CombinedWithoutReset);
    assert!((o.elevation_mask_rad.to_degrees() - 12.5).abs() < 1e-12);
    let mask = o.cn0_mask.unwrap();
    assert_eq!(
        (mask.rover, mask.base, mask.min_db_hz[0][3]),
        (true, false, 35.0)
    );
    assert_eq!(o.dynamics.unwrap().horizontal_noise, 3.0);
    assert_eq!(o.excluded_satellites.len(), 2);
    assert_eq!(
        o.systems.iter().collect::<Vec<_>>(),
        [System::Gps, System::Galileo, System::Beidou]
    );
    assert!(o.raim && o.interpolate_base && !o.beidou_ambiguity);
    assert_eq!((o.ambiguity, o.max_age_s), (AmbiguityMode::Off, 10.0));
    assert_eq!(
        o.base_position,
        BasePosition::Ecef([4_641_949.6, 1_393_045.4, 4_133_287.4])
    );
    assert_eq!(o.base_antenna_m, [0.0, 0.0, 0.1]);
    let f = conf.format;
    assert_eq!(
        (f.frame, f.time, f.scale, f.decimals),
        (PosFrame::Ecef, PosTime::WeekTow, PosTimeScale::Utc, 1)
    );
    assert_eq!(conf.not_followed, []);
}

#[test]
fn a_geodetic_base_is_in_degrees() {
    let conf = read("ant2-postype=llh\nant2-pos1=35\nant2-pos2=140\nant2-pos3=100\n");
    let BasePosition::Ecef(p) = conf.options.base_position else {
        panic!()
    };
    for (x, y) in p
        .iter()
        .zip([-4_006_802.166_763, 3_362_106.220_331, 3_637_924.267_022])
    {
        assert!((x - y).abs() < 1e-6);
    }
}

#[test]
fn missing_keys_mean_rtklibs_defaults() {
    assert_eq!(read("").options, rtklib_defaults(RuleSet::Rtklib));
    assert_eq!(read("").options.mode, PositioningMode::Single);
    // A key that only demo5 has brings its rules.
    let conf = read("pos2-varholdamb =0.2\n");
    assert_eq!(conf.options.rules, RuleSet::Demo5);
    assert_eq!(conf.options.hold_variance_cycles2, 0.2);
    assert_eq!(conf.options.max_outage_epochs, 20);
    let conf = read("stats-errsnr =0.003\nstats-snrmax =45\n");
    assert_eq!(conf.options.phase_error_cn0_m, 0.003);
    assert_eq!(conf.not_followed[0].key, "stats-snrmax");
}

#[test]
fn what_is_not_followed_is_named() {
    let conf = read(
        "pos1-tidecorr =on\npos1-ionoopt =est-stec\nout-degform=dms\nfoo =1\nmisc-bar=2\n\
         inpstr1-type =serial\npos1-tropopt=saas\nfile-satantfile =\n",
    );
    let got: Vec<(u64, &str, NotFollowedReason)> = conf
        .not_followed
        .iter()
        .map(|n| (n.line, n.key.as_str(), n.reason))
        .collect();
    use NotFollowedReason::{NotForPostProcessing, UnknownKey, Unsupported};
    assert_eq!(
        got,
        [
            (1, "pos1-tidecorr", Unsupported),
            (2, "pos1-ionoopt", Unsupported),
            (3, "out-degform", Unsupported),
            (4, "foo", UnknownKey),
            (5, "misc-bar", UnknownKey),
            (6, "inpstr1-type", NotForPostProcessing),
        ]
    );
    assert_eq!(
        conf.not_followed[0].to_string(),
        "line 1: pos1-tidecorr = on: not supported"
    );
}

#[test]
fn what_cannot_be_meant_is_an_error_with_its_line() {
    let error = |text: &str| read_conf(text.as_bytes(), RuleSet::Rtklib).unwrap_err();
    for (text, message) in [
        (
            "\npos1-elmask =abc\n",
            "line 2: pos1-elmask: expected a number, found \"abc\"",
        ),
        (
            "pos1-elmask =95\n",
            "line 1: pos1-elmask: expected degrees from 0 to below 90",
        ),
        (
            "pos1-posmode =ppp-kine\n",
            "line 1: pos1-posmode = ppp-kine is not supported",
        ),
        (
            "ant2-postype =rtcm\n",
            "line 1: ant2-postype = rtcm is not supported",
        ),
        (
            "pos1-sateph =brdc+sbas\n",
            "line 1: pos1-sateph = brdc+sbas is not supported",
        ),
        ("pos1-navsys =0\n", "line 1: pos1-navsys: expected"),
        (
            "pos2-maxage =nan\n",
            "line 1: pos2-maxage: expected a number",
        ),
        (
            "just words\n",
            "line 1: expected key = value, found \"just words\"",
        ),
        (
            "ant2-postype=llh\nant2-pos1=3774696\nant2-pos2=-596647\n",
            "line 1: ant2-pos1",
        ),
    ] {
        let found = error(text).to_string();
        assert!(found.starts_with(message), "{found}");
    }
    assert!(matches!(
        error("ant2-postype =raw"),
        ConfError::Unsupported { line: 1, .. }
    ));
}

#[test]
fn products_antennas_and_outputs_are_read() {
    let conf = read(
        "pos1-sateph =precise\nfile-rcvantfile =igs20.atx\nfile-geoidfile =WW15MGH.DAC\n\
         ant1-anttype =TRM57971.00 NONE\nant2-anttype =*\nout-outvel =on\nout-maxsolstd =0.5\n\
         out-outstat =residual\nout-solformat =nmea\nfile-satantfile =igs20.atx\n",
    );
    assert!(conf.inputs.precise_orbits);
    assert_eq!(
        conf.inputs.antenna_file.as_ref().map(|f| f.name.as_str()),
        Some("igs20.atx")
    );
    assert_eq!(conf.inputs.rover_antenna, "TRM57971.00 NONE");
    assert_eq!(conf.inputs.base_antenna, "*");
    assert_eq!(
        conf.outputs.geoid_file.as_ref().map(|f| f.name.as_str()),
        Some("WW15MGH.DAC")
    );
    assert!(!conf.outputs.geodetic_heights);
    assert!(read("out-height =geodetic\n").outputs.geodetic_heights);
    assert_eq!(conf.outputs.max_sigma_m, Some(0.5));
    assert!(conf.outputs.residuals && conf.outputs.nmea && conf.format.velocity);
    // Phase centres of the satellites' antennas are not modelled.
    let named: Vec<&str> = conf.not_followed.iter().map(|n| n.key.as_str()).collect();
    assert_eq!(named, ["file-satantfile"]);
    let off = read("out-maxsolstd =0\nout-outstat =off\nout-solformat =llh\nout-outvel =off\n");
    assert_eq!(off.outputs, read("").outputs);
    assert_eq!(off.not_followed, []);
}

#[test]
fn a_moving_base_and_the_length_of_its_baseline() {
    let read = |text: &str| read_conf(text.as_bytes(), RuleSet::Rtklib);
    let conf = read("pos1-posmode=movingbase\npos2-baselen=1.25\npos2-basesig=0.01\n").unwrap();
    assert_eq!(conf.options.mode, PositioningMode::MovingBase);
    let known = conf.options.baseline_length.unwrap();
    assert_eq!((known.length_m, known.sigma_m), (1.25, 0.01));
    assert!(conf.not_followed.is_empty());
    // The programs number their modes differently.
    let mode = |text: &str| read(text).map(|conf| conf.options.mode);
    assert_eq!(
        mode("pos1-posmode=4\n").unwrap(),
        PositioningMode::MovingBase
    );
    let ex = "pos2-arfilter=on\npos1-posmode=";
    assert!(mode(&format!("{ex}4\n")).is_err());
    assert_eq!(
        mode(&format!("{ex}5\n")).unwrap(),
        PositioningMode::MovingBase
    );
    // A base that stands has no such length.
    let conf = read("pos1-posmode=kinematic\npos2-baselen=1.25\n").unwrap();
    assert_eq!(conf.options.baseline_length, None);
}
