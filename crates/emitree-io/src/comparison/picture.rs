//! The picture of a comparison: the first image, and the difference in colours about white.

use super::{Comparison, Difference, StoredImage};
use crate::colour::{ColourMap, ValueRange};
use crate::figure::{FigureError, Heatmap, Panel};
use crate::fits::nside_of;
use crate::mollweide::picture_of_map;
use emitree::Image;
use std::borrow::Cow;
use std::path::Path;

/// Device pixels in a unit of a figure.
const SCALE: f64 = 2.0;
/// Rows of the ellipse of a sky.
const SKY_ROWS: usize = 512;

impl Comparison {
    /// The bytes of a PNG file: the first image, and second minus first, red where the second one is larger. Of a
    /// cube the band in which they differ most. Of a sky Mollweide's ellipse, as it is seen from inside.
    ///
    /// # Errors
    ///
    /// [`FigureError`]: an image without pixels, or with too many.
    pub fn picture(
        &self,
        first: &StoredImage,
        second: &StoredImage,
    ) -> Result<Vec<u8>, FigureError> {
        let [bands, height, width] = self.shape;
        let band = self.largest.map_or(0, |largest| largest.place[0]);
        let of_band = |values: &[f64]| {
            let pixels = values.iter().skip(band * height * width).take(height * width);
            let pixels: Vec<f64> = pixels.copied().collect();
            match nside_of(pixels.len()).filter(|_| self.is_sky) {
                Some(nside) => picture_of_map(nside, &pixels, SKY_ROWS),
                None => Image::from_pixels(height, width, pixels),
            }
        };
        let (image, difference) = (of_band(&first.values), of_band(&self.differences));
        let largest = self.largest.map_or(0.0, Difference::amount);
        let most = if largest > 0.0 { largest } else { 1.0 };
        let [first, second] = [first, second].map(|image| {
            let name = Path::new(&image.name).file_name().map(|name| name.to_string_lossy());
            name.map_or_else(|| image.name.clone(), Cow::into_owned)
        });
        let unit = &self.unit;
        let title = match bands {
            1 => format!("{second} minus {first}"),
            _ => format!("{second} minus {first}, band {band}"),
        };
        let unit = if unit.is_empty() { String::new() } else { format!(" [{unit}]") };
        let of_first = Panel::new(&image).title(&first).colour_bar(format!("value{unit}"));
        let of_difference = Panel::new(&difference)
            .title(title)
            .colour_map(ColourMap::BlueRed)
            .range(ValueRange { low: -most, high: most })
            .colour_bar(format!("difference{unit}"));
        let panels = [of_first, of_difference];
        let panels = panels.map(|panel| if self.is_sky { panel.ellipse() } else { panel });
        panels.into_iter().fold(Heatmap::new(), Heatmap::panel).draw()?.png(SCALE)
    }
}
