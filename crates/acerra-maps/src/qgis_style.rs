//! A style for QGIS: colours of a band of levels, which QGIS takes from the file of the raster's name with `.qml`.

use std::fmt::Write as _;

/// The style of a single band whose levels run from `range[0]` to `range[1]` with evenly spaced `colours` between them.
/// Pixels without data stay transparent.
///
/// ```
/// let style = acerra_maps::qgis_style::qgis_style([-60.0, 0.0], &[[0, 0, 4], [252, 255, 164]], "dB");
/// assert!(style.contains("<item value=\"0\" label=\"0 dB\" color=\"#fcffa4\" alpha=\"255\"/>"));
/// ```
#[must_use]
pub fn qgis_style(range: [f64; 2], colours: &[[u8; 3]], unit: &str) -> String {
    let [low, high] = range;
    let last = colours.len().saturating_sub(1).max(1) as f64;
    let mut items = String::new();
    for (k, [red, green, blue]) in colours.iter().enumerate() {
        let value = low + (high - low) * k as f64 / last;
        let _ = writeln!(
            items,
            "     <item value=\"{value}\" label=\"{value:.0} {unit}\" color=\"#{red:02x}{green:02x}{blue:02x}\" alpha=\"255\"/>"
        );
    }
    format!(
        "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n\
         <qgis version=\"3.28\" styleCategories=\"Symbology\">\n \
         <pipe>\n  \
         <rasterrenderer type=\"singlebandpseudocolor\" band=\"1\" opacity=\"1\" alphaBand=\"-1\" nodataColor=\"\" \
         classificationMin=\"{low}\" classificationMax=\"{high}\">\n   \
         <rasterTransparency/>\n   \
         <rastershader>\n    \
         <colorrampshader colorRampType=\"INTERPOLATED\" classificationMode=\"1\" clip=\"0\" minimumValue=\"{low}\" \
         maximumValue=\"{high}\">\n\
         {items}    </colorrampshader>\n   \
         </rastershader>\n  \
         </rasterrenderer>\n  \
         <rasterresampler maxOversampling=\"2\" zoomedOutResampler=\"bilinear\"/>\n \
         </pipe>\n \
         <blendMode>0</blendMode>\n\
         </qgis>\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_style_is_well_formed_and_spans_the_levels() {
        let text = qgis_style(
            [-48.0, 0.0],
            &[[0, 0, 0], [128, 0, 0], [255, 255, 255]],
            "dB",
        );
        let values: Vec<f64> = text
            .split("<item value=\"")
            .skip(1)
            .map(|part| part.split('"').next().unwrap().parse().unwrap())
            .collect();
        assert_eq!(values, [-48.0, -24.0, 0.0]);
        for tag in [
            "qgis",
            "pipe",
            "rasterrenderer",
            "rastershader",
            "colorrampshader",
        ] {
            let opened = text.matches(&format!("<{tag} ")).count()
                + text.matches(&format!("<{tag}>")).count();
            assert_eq!(
                (opened, text.matches(&format!("</{tag}>")).count()),
                (1, 1),
                "{tag}"
            );
        }
    }
}
