//! The lines of sight of a pixel, with those known from the image before: when some leaves are refined most
//! stay as they are, while the polynomials beside the surfaces change.

use crate::vol::surfaces::aim::Aim;
use crate::vol::surfaces::beam::Beam;
use crate::vol::surfaces::model::Model;
use crate::vol::surfaces::octree::{Cell, Label, Leaf, Octree, is_among};
use crate::vol::surfaces::rays::{LineIntegral, Ray, Segment};
use crate::vol::view::pixel_rule::RuleNode;

/// The most lines that are kept for the next image, about: 80 MB.
const MOST_KEPT: usize = 3 << 18;

/// The distance between leaves and pixels that both are at a line, in views.
const BESIDE: f64 = 1e-9;

/// Lines of a pixel without their polynomials, in the order in which they are asked for.
#[derive(Clone, Debug, Default)]
pub(super) struct PixelLines {
    /// The regions of all segments with the depths at which these end.
    segments: Vec<(Label, f64)>,
    /// For each line the number of segments up to its end, and the error of its surfaces.
    lines: Vec<(usize, f64)>,
    /// Whether none is kept for the next image.
    is_forgotten: bool,
}

impl PixelLines {
    fn clear(&mut self) {
        (self.segments, self.lines) = (Vec::new(), Vec::new());
    }

    fn add(&mut self, ray: &Ray) {
        self.segments.extend(ray.segments.iter().map(|of| (of.label, of.ends[1])));
        self.lines.push((self.segments.len(), ray.error_of_surfaces()));
    }

    /// The segments of a line, and the error of its surfaces.
    fn line(&self, number: usize) -> (impl Iterator<Item = Segment> + '_, f64) {
        let first = number.checked_sub(1).map_or(0, |before| self.lines[before].0);
        let (last, error) = self.lines[number];
        let mut from = 0.0;
        let segments = self.segments[first..last].iter().map(move |&(label, top)| {
            let ends = [from, top];
            from = top;
            Segment { label, ends }
        });
        (segments, error)
    }
}

/// The lines of all pixels through the leaves of one tree.
#[derive(Debug, Default)]
pub(super) struct KnownLines {
    leaves: Vec<(Cell, Leaf)>,
    /// For each pixel its first lines, and those of its lattices.
    pub(super) first: Vec<PixelLines>,
    pub(super) lattices: Vec<PixelLines>,
}

impl KnownLines {
    /// Forgets the lines of the pixels whose leaves have changed. With `per_pixel` lines in each pixel, those
    /// of the pixels beyond the most that are kept are forgotten as soon as they have been integrated.
    pub(super) fn keep_unchanged(&mut self, tree: &Octree, aim: &Aim<'_>, per_pixel: usize) {
        let (width, pixels) = (aim.scale.width(), aim.scale.pixels().len());
        if aim.sky.is_some() {
            // The pixels that see a leaf are not those of a rectangle.
            self.clear(pixels);
            return;
        }
        for lines in [&mut self.first, &mut self.lattices] {
            lines.resize_with(pixels, PixelLines::default);
            let beyond = lines.iter_mut().skip(MOST_KEPT / per_pixel);
            beyond.for_each(|of| of.is_forgotten = true);
        }
        let is_new = |leaf: &usize| !is_among(&self.leaves, &tree.leaves[*leaf]);
        for leaf in (0..tree.leaves.len()).filter(is_new) {
            let [x, y] = [0, 1].map(|axis| tree.ends(leaf, axis));
            // Lines at the border of a pixel are its own, too.
            let [first, last] =
                [(x[0], y[0], -BESIDE), (x[1], y[1], BESIDE)].map(|(x, y, beside)| {
                    let [u, v, _] = tree.grid.canonical([x, y, 0.0]);
                    aim.pixel([u + beside, v + beside])
                });
            for row in first / width..=last / width {
                let of_row = row * width + first % width..=row * width + last % width;
                for lines in [&mut self.first, &mut self.lattices] {
                    lines[of_row.clone()].iter_mut().for_each(PixelLines::clear);
                }
            }
        }
        self.leaves.clone_from(&tree.leaves);
    }

    /// Forgets all lines.
    fn clear(&mut self, pixels: usize) {
        for lines in [&mut self.first, &mut self.lattices] {
            lines.clear();
            lines
                .resize_with(pixels, || PixelLines { is_forgotten: true, ..PixelLines::default() });
        }
    }
}

/// A pixel whose lines are integrated.
pub(super) struct Pixel<'a> {
    model: &'a Model,
    aim: &'a Aim<'a>,
    number: usize,
    lines: &'a mut PixelLines,
    /// The number of lines that were asked for.
    asked: usize,
    /// What new lines follow, and one of them.
    beam: Option<Option<Beam<'a>>>,
    ray: Ray,
}

impl<'a> Pixel<'a> {
    pub(super) fn new(
        model: &'a Model,
        aim: &'a Aim<'a>,
        number: usize,
        lines: &'a mut PixelLines,
    ) -> Self {
        Self { model, aim, number, lines, asked: 0, beam: None, ray: Ray::default() }
    }

    /// The mean over the next lines, at places from 0 to 1 in the pixel with weights whose sum is 1.
    pub(super) fn mean(&mut self, nodes: &[RuleNode]) -> LineIntegral {
        let mut sum = LineIntegral::default();
        let mut whole = 0.0;
        for (place, weight) in nodes {
            let (xy, of_line) = self.model.line(self.aim, self.number, *place);
            let weight = weight * of_line;
            if self.asked == self.lines.lines.len() {
                let beam = || self.model.beam(self.aim, self.number);
                let beam = self.beam.get_or_insert_with(beam).as_ref();
                self.model.follow(&mut self.ray, self.aim, beam, xy);
                self.lines.add(&self.ray);
            }
            let (segments, error) = self.lines.line(self.asked);
            let line = self.model.integral(xy, segments, error);
            self.asked += 1;
            whole += weight;
            sum.value += weight * line.value;
            sum.error += weight * line.error;
        }
        if whole > 0.0 {
            sum = LineIntegral { value: sum.value / whole, error: sum.error / whole };
        }
        sum
    }
}

impl Drop for Pixel<'_> {
    fn drop(&mut self) {
        if self.lines.is_forgotten {
            self.lines.clear();
        }
    }
}
