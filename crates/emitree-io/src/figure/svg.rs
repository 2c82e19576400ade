//! A small builder of SVG: the few elements that figures are made of.

use super::font::{FAMILY, text_width};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::fmt::Write;

/// A colour as (red, green, blue).
pub(super) type Rgb = [u8; 3];

pub(super) const INK: Rgb = [34; 3];

/// A rectangle of the figure; y grows downwards, as in SVG.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rect {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) width: f64,
    pub(super) height: f64,
}

impl Rect {
    pub(super) fn right(&self) -> f64 {
        self.left + self.width
    }

    pub(super) fn bottom(&self) -> f64 {
        self.top + self.height
    }

    /// The upper left corner.
    pub(super) fn corner(&self) -> [f64; 2] {
        [self.left, self.top]
    }

    /// The rectangle with `margin` more on every side.
    pub(super) fn grown(&self, margin: f64) -> Self {
        Self {
            left: self.left - margin,
            top: self.top - margin,
            width: self.width + 2.0 * margin,
            height: self.height + 2.0 * margin,
        }
    }
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stroke {
    pub(super) colour: Rgb,
    pub(super) width: f64,
    /// Lengths of dashes and gaps, none for a solid line.
    pub(super) dashes: &'static str,
}

impl Stroke {
    pub(super) const fn solid(colour: Rgb, width: f64) -> Self {
        Self { colour, width, dashes: "" }
    }
}

/// Which point of a text its position is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// A line of text, centred on its position across the direction of reading.
#[derive(Clone, Copy, Debug)]
pub(super) struct Text<'a> {
    pub(super) text: &'a str,
    pub(super) size: f64,
    pub(super) anchor: Anchor,
    pub(super) colour: Rgb,
    /// Reading upwards, for labels of y axes.
    pub(super) upwards: bool,
    /// White around the letters, for text upon a grid.
    pub(super) halo: bool,
}

impl<'a> Text<'a> {
    pub(super) const fn new(text: &'a str, size: f64, anchor: Anchor) -> Self {
        Self { text, size, anchor, colour: INK, upwards: false, halo: false }
    }

    pub(super) fn width(&self) -> f64 {
        text_width(self.text, self.size)
    }
}

/// The elements drawn so far.
#[derive(Debug, Default)]
pub(super) struct Svg {
    body: String,
    clips: usize,
}

impl Svg {
    /// Adds a formatted element on a line of its own.
    fn element(&mut self, element: std::fmt::Arguments<'_>) {
        // Writing to a String cannot fail.
        let _ = writeln!(self.body, "{element}");
    }

    pub(super) fn line(&mut self, from: [f64; 2], to: [f64; 2], stroke: Stroke) {
        self.polyline(&[from, to], stroke);
    }

    pub(super) fn polyline(&mut self, points: &[[f64; 2]], stroke: Stroke) {
        let points: Vec<_> = points.iter().map(|[x, y]| format!("{x:.2},{y:.2}")).collect();
        let Stroke { colour, width, dashes } = stroke;
        let dashes = if dashes.is_empty() {
            String::new()
        } else {
            format!(r#" stroke-dasharray="{dashes}""#)
        };
        self.element(format_args!(
            r#"<polyline points="{}" fill="none" stroke="{}" stroke-width="{width}" stroke-linejoin="round"{dashes}/>"#,
            points.join(" "),
            hex(colour),
        ));
    }

    pub(super) fn polygon(&mut self, points: &[[f64; 2]], fill: Rgb) {
        let points: Vec<_> = points.iter().map(|[x, y]| format!("{x:.2},{y:.2}")).collect();
        self.element(format_args!(
            r##"<polygon points="{}" fill="{}" stroke="#ffffff" stroke-width="0.8"/>"##,
            points.join(" "),
            hex(fill)
        ));
    }

    pub(super) fn circle(&mut self, [x, y]: [f64; 2], radius: f64, fill: Rgb) {
        self.element(format_args!(
            r##"<circle cx="{x:.2}" cy="{y:.2}" r="{radius}" fill="{}" stroke="#ffffff" stroke-width="0.8"/>"##,
            hex(fill)
        ));
    }

    /// The ellipse that fills `rect`.
    pub(super) fn ellipse(&mut self, rect: Rect, fill: Option<Rgb>, stroke: Option<Stroke>) {
        let (fill, stroke) = paint(fill, stroke);
        let (rx, ry) = (0.5 * rect.width, 0.5 * rect.height);
        let (cx, cy) = (rect.left + rx, rect.top + ry);
        self.element(format_args!(
            r#"<ellipse cx="{cx:.2}" cy="{cy:.2}" rx="{rx:.2}" ry="{ry:.2}" fill="{fill}"{stroke}/>"#
        ));
    }

    pub(super) fn rect(&mut self, rect: Rect, fill: Option<Rgb>, stroke: Option<Stroke>) {
        let (fill, stroke) = paint(fill, stroke);
        let Rect { left, top, width, height } = rect;
        self.element(format_args!(
            r#"<rect x="{left:.2}" y="{top:.2}" width="{width:.2}" height="{height:.2}" fill="{fill}"{stroke}/>"#
        ));
    }

    pub(super) fn text(&mut self, [x, y]: [f64; 2], text: Text<'_>) {
        let anchor = match text.anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        // Half the height of a capital letter of this font puts its middle at the position.
        let (shift, size) = (0.36 * text.size, text.size);
        let halo = if text.halo {
            r##" stroke="#ffffff" stroke-width="3" stroke-linejoin="round" paint-order="stroke""##
        } else {
            ""
        };
        let turn = if text.upwards {
            format!(r#" transform="rotate(-90 {x:.2} {y:.2})""#)
        } else {
            String::new()
        };
        self.element(format_args!(
            r#"<text x="{x:.2}" y="{:.2}" font-size="{size}" text-anchor="{anchor}" fill="{}"{halo}{turn}>{}</text>"#,
            y + shift,
            hex(text.colour),
            escape(text.text)
        ));
    }

    /// A PNG stretched over `rect`; `crisp` keeps the edges of its pixels sharp.
    pub(super) fn image(&mut self, rect: Rect, png: &[u8], crisp: bool) {
        let Rect { left, top, width, height } = rect;
        let style = if crisp { r#" style="image-rendering:pixelated""# } else { "" };
        self.element(format_args!(
            r#"<image x="{left:.2}" y="{top:.2}" width="{width:.2}" height="{height:.2}" preserveAspectRatio="none"{style} href="data:image/png;base64,{}"/>"#,
            STANDARD.encode(png)
        ));
    }

    /// Draws what `draw` draws, cut off at the edges of `rect`.
    pub(super) fn clipped(&mut self, rect: Rect, draw: impl FnOnce(&mut Self)) {
        self.clipped_to(|svg| svg.rect(rect, Some(INK), None), draw);
    }

    /// Draws what `draw` draws, cut off at the ellipse that fills `rect`.
    pub(super) fn clipped_to_ellipse(&mut self, rect: Rect, draw: impl FnOnce(&mut Self)) {
        self.clipped_to(|svg| svg.ellipse(rect, Some(INK), None), draw);
    }

    fn clipped_to(&mut self, shape: impl FnOnce(&mut Self), draw: impl FnOnce(&mut Self)) {
        self.clips += 1;
        let clip = self.clips;
        self.element(format_args!(r#"<clipPath id="clip{clip}">"#));
        shape(self);
        self.element(format_args!(r#"</clipPath><g clip-path="url(#clip{clip})">"#));
        draw(self);
        self.element(format_args!("</g>"));
    }

    /// The whole document, on white.
    pub(super) fn finish(self, width: f64, height: f64) -> super::Figure {
        let svg = format!(
            r##"<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" font-family="{FAMILY}">
<rect width="{width}" height="{height}" fill="#ffffff"/>
{}</svg>
"##,
            self.body
        );
        super::Figure { svg, width, height }
    }
}

/// The attributes of a closed shape.
fn paint(fill: Option<Rgb>, stroke: Option<Stroke>) -> (String, String) {
    let fill = fill.map_or_else(|| "none".to_owned(), hex);
    let stroke = stroke
        .map(|s| format!(r#" stroke="{}" stroke-width="{}""#, hex(s.colour), s.width))
        .unwrap_or_default();
    (fill, stroke)
}

fn hex([red, green, blue]: Rgb) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped() {
        let mut svg = Svg::default();
        svg.text([0.0, 0.0], Text::new("a < b & c", 12.0, Anchor::Start));
        let figure = svg.finish(10.0, 10.0);
        assert!(figure.svg().contains(">a &lt; b &amp; c</text>"));
        assert!(figure.png(1.0).is_ok());
    }
}
