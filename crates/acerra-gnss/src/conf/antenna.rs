//! Settings of the antennas.

use super::outcome::{FOLLOWED, Outcome, UNKNOWN};
use super::pending::Pending;
use super::requested::{NotFollowedReason, RtklibConf};
use super::setting::Setting;

/// Keys that begin with `ant1-` or `ant2-`.
pub(super) fn antenna(s: &Setting, conf: &mut RtklibConf, pending: &mut Pending) -> Outcome {
    let options = &mut conf.options;
    match s.key.as_str() {
        "ant1-antdele" => options.rover_antenna_m[0] = s.number()?,
        "ant1-antdeln" => options.rover_antenna_m[1] = s.number()?,
        "ant1-antdelu" => options.rover_antenna_m[2] = s.number()?,
        "ant2-antdele" => options.base_antenna_m[0] = s.number()?,
        "ant2-antdeln" => options.base_antenna_m[1] = s.number()?,
        "ant2-antdelu" => options.base_antenna_m[2] = s.number()?,
        "ant1-anttype" => conf.inputs.rover_antenna.clone_from(&s.value),
        "ant2-anttype" => conf.inputs.base_antenna.clone_from(&s.value),
        "ant2-postype" => {
            let names = [
                "llh",
                "xyz",
                "single",
                "posfile",
                "rinexhead",
                "rtcm",
                "raw",
            ];
            pending.base_kind = match s.choice(&names) {
                Some(kind @ (0 | 1 | 2 | 4)) => kind as u32,
                Some(_) => return Err(s.unsupported()),
                None => return Err(s.wrong("llh, xyz, single or rinexhead")),
            };
            pending.base_line = s.line;
        }
        "ant2-pos1" => pending.base_values[0] = s.number()?,
        "ant2-pos2" => pending.base_values[1] = s.number()?,
        "ant2-pos3" => pending.base_values[2] = s.number()?,
        // The rover's position is the result.
        "ant1-postype" | "ant1-pos1" | "ant1-pos2" | "ant1-pos3" => {}
        "ant2-maxaveep" | "ant2-initrst" => {
            return Ok(Some(NotFollowedReason::NotForPostProcessing));
        }
        _ => return UNKNOWN,
    }
    FOLLOWED
}
