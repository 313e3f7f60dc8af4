//! Any text as a campaign: settings that can be written and read again and make an image of a few traces, or an
//! error, whatever their numbers.
#![no_main]

use acerra_chain::campaign::Campaign;
use libfuzzer_sys::fuzz_target;

#[path = "shared/small_flight.rs"]
mod small_flight;

fuzz_target!(|text: &str| {
    let Ok(campaign) = Campaign::parse(text) else {
        return;
    };
    let written = toml::to_string(&campaign).expect("a campaign is written");
    Campaign::parse(&written).expect("and read again");
    let Some(prepared) = small_flight::prepared(&campaign) else {
        return;
    };
    let request = campaign.image_request(prepared.scene.pixels.clone());
    small_flight::image(&prepared, &request);
});
