//! The one font of all figures, and how wide it runs.

use resvg::usvg;
use skrifa::instance::{LocationRef, Size};
use skrifa::{FontRef, MetadataProvider};

pub(super) const FAMILY: &str = "DejaVu Sans";

/// Options of the renderer with this font only.
pub(super) fn options() -> usvg::Options<'static> {
    let mut options = usvg::Options { font_family: FAMILY.to_owned(), ..Default::default() };
    options.fontdb_mut().load_font_data(dejavu::sans::regular().to_vec());
    options
}

/// The width of one line of text.
pub(super) fn text_width(text: &str, size: f64) -> f64 {
    // Half an em is a fair guess for what the font has no glyph for.
    let guess = 0.5 * size;
    let Ok(font) = FontRef::new(dejavu::sans::regular()) else {
        return guess * text.chars().map(|_| 1.0).sum::<f64>();
    };
    #[expect(clippy::cast_possible_truncation, reason = "fonts compute with f32")]
    let metrics = font.glyph_metrics(Size::new(size as f32), LocationRef::default());
    let glyphs = font.charmap();
    let advance = |c| glyphs.map(c).and_then(|glyph| metrics.advance_width(glyph));
    text.chars().map(|c| advance(c).map_or(guess, f64::from)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_add_up_and_scale() {
        let width = text_width("10⁻³ sr", 12.0);
        assert!(width > 30.0 && width < 60.0, "{width}");
        assert!((text_width("10⁻³ sr", 24.0) - 2.0 * width).abs() < 1e-3);
        assert!(text_width("", 12.0).abs() < 1e-9);
    }
}
