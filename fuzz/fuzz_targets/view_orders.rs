//! Any text as an order of the viewer's page: settings that it changes make a campaign that can be
//! read again and an image of a few traces, or an error, whatever their numbers.
#![no_main]

use acerra_chain::campaign::Campaign;
use acerra_view::engine::ImageOrder;
use libfuzzer_sys::fuzz_target;

#[path = "shared/small_flight.rs"]
mod small_flight;

const RUN: &str = "[radar]\nfile = 'a.npz'\ndelay_ns = 1.0\n[trajectory]\nfile = 'a.csv'\n\
                   time_offset_s = 0.0\n[image]\nx_m = [0, 1]\ny_m = [0, 1]\nz_m = 0\n";

fuzz_target!(|text: &str| {
    let Ok(order) = serde_json::from_str::<ImageOrder>(text) else {
        return;
    };
    let run = Campaign::parse(RUN).expect("a campaign");
    if let Ok(edited) = order.edits.apply(&run, &[]) {
        let written = toml::to_string(&edited).expect("a campaign is written");
        Campaign::parse(&written).expect("and read again");
        let Some(prepared) = small_flight::prepared(&edited) else {
            return;
        };
        if let Ok(pixels) = order.view.pixels(&prepared.scene) {
            small_flight::image(&prepared, &edited.image_request(pixels));
        }
    }
});
