//! Any bytes as an RTKLIB configuration: options or an error that names a line.
#![no_main]

use acerra_gnss::RuleSet;
use acerra_gnss::conf::read_conf;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    for rules in [RuleSet::Rtklib, RuleSet::Demo5] {
        let Ok(conf) = read_conf(bytes, rules) else { continue };
        assert!((0.0..1.58).contains(&conf.options.elevation_mask_rad));
        assert!(!conf.options.systems.is_empty());
        assert!((1..=3).contains(&conf.options.frequencies));
    }
});
