//! The example program gives what it says.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use acerra_chain::Cancelled;
use acerra_chain::focus::plan::ImageError;

#[path = "../examples/image_in_memory.rs"]
#[allow(dead_code)] // its `main`
mod example;

#[test]
fn arrays_become_images_without_touching_the_disk() {
    let (maxima_m, cancelled) = example::run().unwrap();
    let [coarse_m, fine_m] = maxima_m.as_slice() else {
        panic!("two images, found {maxima_m:?}");
    };
    // The coarse grid has pixels on the reflector, the fine one tells 1 cm.
    for (found, truth) in coarse_m.iter().zip([0.3, 1.0, 0.0]) {
        assert!((found - truth).abs() < 1e-9, "{coarse_m:?}");
    }
    for (found, truth) in fine_m.iter().zip([0.3, 1.0, 0.0]) {
        assert!((found - truth).abs() < 0.011, "{fine_m:?}");
    }
    assert!(matches!(cancelled, ImageError::Cancelled(Cancelled)));
}
