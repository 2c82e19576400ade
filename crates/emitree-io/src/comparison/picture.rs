//! The picture of a comparison: the first image, and the difference in colours about white.

use super::{Comparison, Difference, StoredImage};
use crate::colour::{ColourMap, ValueRange};
use crate::figure::{FigureError, Heatmap, Panel};
use emitree::Image;
use std::borrow::Cow;
use std::path::Path;

/// Device pixels in a unit of a figure.
const SCALE: f64 = 2.0;

impl Comparison {
    /// The bytes of a PNG file: the first image, and second minus first, red where the second one is larger. Of a
    /// cube the band in which they differ most.
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
            Image::from_pixels(height, width, pixels.copied().collect())
        };
        let (image, difference) = (of_band(&first.values), of_band(&self.differences));
        let largest = self.largest.map_or(0.0, Difference::amount);
        let most = if largest > 0.0 { largest } else { 1.0 };
        let [first, second] = [first, second].map(|image| {
            let name = Path::new(&image.name).file_name().map(|name| name.to_string_lossy());
            name.map_or_else(|| image.name.clone(), Cow::into_owned)
        });
        let unit = if self.unit.is_empty() { "1" } else { &self.unit };
        let title = match bands {
            1 => format!("{second} minus {first}"),
            _ => format!("{second} minus {first}, band {band}"),
        };
        let of_first = Panel::new(&image).title(&first).colour_bar(format!("[{unit}]"));
        let of_difference = Panel::new(&difference)
            .title(title)
            .colour_map(ColourMap::BlueRed)
            .range(ValueRange { low: -most, high: most })
            .colour_bar(format!("difference [{unit}]"));
        Heatmap::new().panel(of_first).panel(of_difference).draw()?.png(SCALE)
    }
}
