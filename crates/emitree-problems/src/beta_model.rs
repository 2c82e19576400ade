//! The β model: hot gas in a cluster of galaxies, with a narrow core and wide wings.
//!
//! g = (1 + r²/a²)^(−3β), r the distance from the centre and a the core radius (Cavaliere and
//! Fusco-Femiano 1976, A&A 49, 137, for the square of the density). The line of sight integral over a
//! finite depth is elementary whenever 6β is a whole number.

use crate::panels::{self, PanelAxis};
use emitree::Image;

/// Nodes of a panel: 12 give the same image to 2e-9, 16 to 2e-12, 36 to rounding.
const ACROSS: usize = 20;

/// A bound on the largest error of a pixel of [`BetaModel::exact_image`], relative to the largest
/// pixel.
pub const IMAGE_ERROR: f64 = 1e-12;

/// A β model; the default is the usual β = 2/3 with a core of 0.04 near the middle of the cube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BetaModel {
    /// The brightest point. Its depth is in \[0, 1\]; outside, digits of the image are lost.
    pub centre: [f64; 3],
    /// The core radius a.
    pub core_radius: f64,
    /// 6β: 3 for β = 1/2, 4 for β = 2/3, 6 for β = 1. It is the power of a/r that g falls with far
    /// from the core.
    pub six_beta: i32,
}

impl Default for BetaModel {
    fn default() -> Self {
        let centre = [2_f64.sqrt() / 3.0, core::f64::consts::PI / 6.0, 5_f64.sqrt() / 4.0];
        Self { centre, core_radius: 0.04, six_beta: 4 }
    }
}

impl BetaModel {
    /// The emission rate at a point.
    ///
    /// ```
    /// let cluster = emitree_problems::beta_model::BetaModel::default();
    /// let [x, y, z] = cluster.centre;
    /// assert!((cluster.rate([x, y, z + cluster.core_radius]) - 0.25).abs() < 1e-14);
    /// ```
    pub fn rate(&self, position: [f64; 3]) -> f64 {
        let square: f64 = (0..3).map(|i| (position[i] - self.centre[i]).powi(2)).sum();
        power(1.0 + square / self.core_radius.powi(2), -self.six_beta)
    }

    /// ∫ g dz over \[0, 1\] at a point of the image.
    ///
    /// ```
    /// let cluster = emitree_problems::beta_model::BetaModel { six_beta: 2, ..Default::default() };
    /// let [x, y, z] = cluster.centre;
    /// let a = cluster.core_radius;
    /// let exact = a * (((1.0 - z) / a).atan() + (z / a).atan());
    /// assert!((cluster.line(x, y) - exact).abs() < 1e-15);
    /// ```
    pub fn line(&self, x: f64, y: f64) -> f64 {
        let [cx, cy, cz] = self.centre;
        let across = (x - cx).powi(2) + (y - cy).powi(2);
        let scale = (self.core_radius.powi(2) + across).sqrt();
        let depth =
            primitive((1.0 - cz) / scale, self.six_beta) - primitive(-cz / scale, self.six_beta);
        (self.core_radius / scale).powi(self.six_beta) * scale * depth
    }

    /// The image of `shape` = \[height, width\] pixels in the canonical projection, to
    /// [`IMAGE_ERROR`]: closed along z, and by Gauss–Legendre quadrature over the pixels.
    ///
    /// ```
    /// let image = emitree_problems::beta_model::BetaModel::default().exact_image([32, 32]);
    /// assert_eq!(image.min_max().1, image[(16, 15)]);
    /// ```
    pub fn exact_image(&self, shape: [usize; 2]) -> Image {
        self.image(shape, ACROSS)
    }

    /// The image, with `across` nodes a panel.
    pub(crate) fn image(&self, [height, width]: [usize; 2], across: usize) -> Image {
        let axis =
            |i: usize, pixels| PanelAxis::graded(self.centre[i], self.core_radius, across, pixels);
        panels::image(&axis(0, width), &axis(1, height), |x, y| self.line(x, y))
    }
}

/// s^(`halves`/2), s > 0.
fn power(s: f64, halves: i32) -> f64 {
    if halves % 2 == 0 { s.powi(halves / 2) } else { s.sqrt().powi(halves) }
}

/// ∫ (1 + t²)^(−k/2) dt from 0 to t: arctan for k = 2, arsinh for k = 1, and from there two at a
/// time by parts (Gradshteyn and Ryzhik 2.147).
fn primitive(t: f64, k: i32) -> f64 {
    let (mut order, mut integral) = match k {
        ..=0 => (0, t),
        _ if k % 2 == 0 => (2, t.atan()),
        _ => (1, t.asinh()),
    };
    while order > 0 && order < k {
        let n = f64::from(order);
        integral = t * power(1.0 + t * t, -order) / n + (n - 1.0) / n * integral;
        order += 2;
    }
    integral
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gauss::Gauss;
    use crate::{brute, relative_error};

    #[test]
    fn pixels_agree_with_brute_force_for_each_exponent() {
        let shape = [40, 64];
        for six_beta in 1..=8 {
            let model = BetaModel { six_beta, ..BetaModel::default() };
            let exact = model.exact_image(shape);
            let (_, largest) = exact.min_max();
            for at in [[20, 30], [21, 30], [20, 33], [35, 12], [0, 63]] {
                let brute = brute::pixel(|position| model.rate(position), shape, at, 16);
                assert!((exact[at.into()] - brute).abs() < IMAGE_ERROR * largest);
            }
        }
    }

    /// A core much narrower than a pixel, another near the border, and one with more nodes.
    #[test]
    fn pixels_agree_with_brute_force_for_other_cores() {
        let narrow = BetaModel { core_radius: 1e-3, ..BetaModel::default() };
        let depth = Gauss::new(16);
        let lines = |x: f64, y: f64| {
            let (a, [_, _, cz]) = (narrow.core_radius, narrow.centre);
            // Of 1000 core radii along z, sinh makes 16.
            let (from, to) = ((-cz / a).asinh(), ((1.0 - cz) / a).asinh());
            depth.integrate_panels([from, to], 10, |u| {
                narrow.rate([x, y, cz + a * u.sinh()]) * a * u.cosh()
            })
        };
        let exact = narrow.exact_image([64, 64]);
        let brute = brute::mean([64, 64], [33, 30], &Gauss::new(160), lines);
        assert!((exact[(33, 30)] - brute).abs() < 1e-9 * exact.min_max().1);

        let border = BetaModel { centre: [0.01, 1.02, 0.98], ..BetaModel::default() };
        for model in [BetaModel::default(), narrow, border] {
            let finer = model.image([30, 50], 36);
            assert!(relative_error(&model.exact_image([30, 50]), &finer) < IMAGE_ERROR);
        }
    }

    /// Where the cube cuts nothing off: the projection over infinite depth for β = 2/3, π/2 times
    /// a (1 + R²/a²)^(−3/2).
    #[test]
    fn a_narrow_core_has_the_uncut_projection() {
        let model = BetaModel { core_radius: 1e-4, ..BetaModel::default() };
        let [x, y, _] = model.centre;
        let uncut = core::f64::consts::FRAC_PI_2 * 1e-4;
        assert!((model.line(x, y) / uncut - 1.0).abs() < 1e-9);
        assert!((model.line(x + 3e-4, y) / uncut - power(10.0, -3)).abs() < 1e-9);
    }
}
