//! Meaning of each key.

use super::antenna::antenna;
use super::error::ConfError;
use super::output::{file, miscellaneous, output};
use super::pending::Pending;
use super::positioning::{first_page, second_page, statistics};
use super::requested::{NotFollowed, NotFollowedReason, RtklibConf};
use super::setting::Setting;

/// Whether the key exists only in demo5 and RTKLIB-EX.
pub(super) fn is_demo5_key(key: &str) -> bool {
    matches!(
        key,
        "pos2-arfilter"
            | "pos2-arthresmin"
            | "pos2-arthresmax"
            | "pos2-varholdamb"
            | "pos2-gainholdamb"
            | "pos2-minfixsats"
            | "pos2-minholdsats"
            | "pos2-mindropsats"
            | "pos2-rejcode"
            | "pos2-dopthres"
            | "stats-errsnr"
            | "stats-snrmax"
            | "stats-errrcv"
    )
}

/// Applies all settings; the last one of a repeated key counts.
pub(super) fn apply(settings: &[Setting], conf: &mut RtklibConf) -> Result<(), ConfError> {
    let mut pending = Pending::of(&conf.options);
    for setting in settings {
        let outcome = match setting
            .key
            .split_once('-')
            .map_or("", |(section, _)| section)
        {
            "pos1" => first_page(setting, conf, &mut pending)?,
            "pos2" => second_page(setting, conf, &mut pending)?,
            "out" => output(setting, conf)?,
            "stats" => statistics(setting, conf, &mut pending)?,
            "ant1" | "ant2" => antenna(setting, conf, &mut pending)?,
            "misc" => miscellaneous(setting, conf)?,
            "file" => file(setting, conf)?,
            section
                if section.starts_with("inpstr")
                    || section.starts_with("outstr")
                    || section.starts_with("logstr")
                    || section == "console" =>
            {
                Some(NotFollowedReason::NotForPostProcessing)
            }
            _ => Some(NotFollowedReason::UnknownKey),
        };
        if let Some(reason) = outcome {
            conf.not_followed.push(NotFollowed {
                line: setting.line,
                key: setting.key.clone(),
                value: setting.value.clone(),
                reason,
            });
        }
    }
    pending.finish(&mut conf.options)
}
