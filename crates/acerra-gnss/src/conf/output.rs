//! Settings of outputs, files and other subjects.

use super::outcome::{FOLLOWED, Outcome, UNKNOWN, UNSUPPORTED, only};
use super::requested::{NamedFile, NotFollowedReason, RtklibConf};
use super::setting::Setting;
use crate::pos::{PosFrame, PosTime, PosTimeScale};

/// Keys that begin with `out-`.
pub(super) fn output(s: &Setting, conf: &mut RtklibConf) -> Outcome {
    let format = &mut conf.format;
    match s.key.as_str() {
        "out-solformat" if matches!(s.value.as_str(), "nmea" | "3") => conf.outputs.nmea = true,
        "out-solformat" => {
            conf.outputs.nmea = false;
            format.frame = match s.named(PosFrame::ALL) {
                Some(frame) => frame,
                None => return UNSUPPORTED,
            };
        }
        "out-outhead" => format.header = s.switch()?,
        // The options are part of the header here.
        "out-outopt" => {
            s.switch()?;
        }
        "out-timesys" => {
            format.scale = s
                .named(PosTimeScale::ALL)
                .ok_or_else(|| s.wrong("gpst, utc or jst"))?;
        }
        "out-timeform" => {
            format.time = match s.choice(&["tow", "hms"]) {
                Some(0) => PosTime::WeekTow,
                Some(1) => PosTime::Calendar,
                _ => return Err(s.wrong("tow or hms")),
            };
        }
        "out-timendec" => format.decimals = s.count()?.min(9),
        "out-degform" => return only(s, &["deg", "0", ""]),
        "out-fieldsep" => return only(s, &[""]),
        "out-outsingle" => conf.options.output_single = s.switch()?,
        "out-outvel" => format.velocity = s.switch()?,
        "out-maxsolstd" if s.value.is_empty() => {}
        "out-maxsolstd" => {
            conf.outputs.max_sigma_m = Some(s.number()?).filter(|&largest_m| largest_m > 0.0);
        }
        "out-height" => match s.choice(&["ellipsoidal", "geodetic"]) {
            Some(kind) => conf.outputs.geodetic_heights = kind == 1,
            None => return only(s, &[""]),
        },
        // The kind of geoid grid is recognised from the file's content; no grid is built in.
        "out-geoid" => {}
        "out-solstatic" => return only(s, &["all", "0", ""]),
        "out-nmeaintv1" | "out-nmeaintv2" => {}
        "out-outstat" => match s.choice(&["off", "state", "residual"]) {
            Some(1) => return UNSUPPORTED,
            Some(kind) => conf.outputs.residuals = kind == 2,
            None => return only(s, &[""]),
        },
        _ => return UNKNOWN,
    }
    FOLLOWED
}

/// Files that post-processing reads; an empty value names no file.
pub(super) fn file(s: &Setting, conf: &mut RtklibConf) -> Outcome {
    let name = (!s.value.is_empty()).then(|| NamedFile {
        line: s.line,
        key: s.key.clone(),
        name: s.value.clone(),
    });
    match s.key.as_str() {
        "file-rcvantfile" => conf.inputs.antenna_file = name,
        "file-geoidfile" => conf.outputs.geoid_file = name,
        _ if name.is_none() => {}
        _ => return UNSUPPORTED,
    }
    FOLLOWED
}

/// Keys that begin with `misc-`.
pub(super) fn miscellaneous(s: &Setting, conf: &mut RtklibConf) -> Outcome {
    match s.key.as_str() {
        "misc-timeinterp" => conf.options.interpolate_base = s.switch()?,
        "misc-sbasatsel" => return only(s, &["0", "all", ""]),
        "misc-rnxopt1" | "misc-rnxopt2" | "misc-pppopt" => return only(s, &[""]),
        "misc-timeout" | "misc-reconnect" | "misc-nmeacycle" | "misc-buffsize"
        | "misc-navmsgsel" | "misc-proxyaddr" | "misc-fswapmargin" | "misc-svrcycle"
        | "misc-startcmd" | "misc-stopcmd" => {
            return Ok(Some(NotFollowedReason::NotForPostProcessing));
        }
        _ => return UNKNOWN,
    }
    FOLLOWED
}
