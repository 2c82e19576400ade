//! The comparison of the quadrature of pixels with a finer one, which replaces it where they differ.

use crate::image::Image;
use crate::parallel::prelude::*;
use crate::projection::charts::chart::Window;
use crate::vol::view::chart_nodes::{ChartNode, ChartNodes};
use crate::vol::view::pixel_rule::Crossing;
use crate::vol::view::quadrature::Quadrature;
use crate::vol::view::raster::Raster;
use crate::vol::view::refined_raster::RefinedRaster;
use crate::vol::view::windows::{NaturalNode, in_window};

/// The most times that the sides of a pixel are halved.
const FINEST_LEVEL: u8 = 5;

/// The means of the function of a part, given its number, over a raster.
pub(crate) type MeansOfPart<'a> = dyn Fn(usize, [usize; 2]) -> Vec<f64> + 'a;

/// A chart in view and the nodes of pixels in it.
#[derive(Clone, Copy)]
pub(crate) struct NodesInView<'a> {
    /// The number of the chart.
    pub(crate) chart: usize,
    pub(crate) window: Window,
    pub(crate) nodes: &'a ChartNodes,
}

/// The error of the quadrature of pixels, after nodes have been added where it was large.
pub(crate) struct Settled {
    /// The nodes in each chart.
    pub(crate) nodes: Vec<ChartNodes>,
    /// The error of each pixel.
    pub(crate) error: Image,
}

/// The nodes of one pixel that replace others, and its remaining error.
struct SettledPixel {
    pixel: usize,
    replaced: Option<Vec<NaturalNode>>,
    error: f64,
}

impl Quadrature<'_> {
    /// Compares the quadrature of pixels with finer ones, and replaces it where they
    /// differ by more than `allowed`, divided by the weight of each pixel's error. Before, the rasters of
    /// the functions with these `means` are refined where their errors are larger.
    pub(crate) fn settle(
        &self,
        crossings: &[Crossing],
        charts: &[NodesInView<'_>],
        means: &MeansOfPart<'_>,
        allowed: f64,
        weights: Option<&Image>,
    ) -> Settled {
        let [height, width] = self.shape();
        let allowed = |pixel: usize| allowed / weights.map_or(1.0, |of| of.pixels()[pixel]);
        let mut error = Image::zeros(height, width);
        let mut present = Image::zeros(height, width);
        let refined = charts.iter().enumerate().map(|(part, of)| {
            let refined = RefinedRaster::new(of.nodes, &|shape| means(part, shape), &allowed);
            error.add_scaled(&refined.error, 1.0);
            present.add_scaled(&refined.image, 1.0);
            refined.raster
        });
        let rasters: Vec<Raster> = refined.collect();
        let in_charts = || charts.iter().zip(&rasters);
        // Whether a rule of one node would not do: of the middle, if that is one.
        let varies = |pixel: usize| {
            let of_one = in_charts().map(|(of, raster)| of.nodes.by_heaviest(pixel, raster));
            (of_one.sum::<f64>() - present.pixels()[pixel]).abs() > allowed(pixel)
        };
        let is_checked = |pixel: &usize| match crossings[*pixel] {
            Crossing::None => self.has_large_pixels() || varies(*pixel),
            Crossing::Outside => false,
            Crossing::Beside | Crossing::Crossed(_) => true,
        };
        let value_of = |node: &NaturalNode| {
            let of_chart = in_charts().find(|(of, _)| of.chart == node.chart);
            of_chart.map_or(0.0, |(of, raster)| {
                let place = in_window(&of.window, node).place.map(f64::from);
                node.weight * raster.value(place)
            })
        };
        let settled = |pixel: usize| {
            let mut value = present.pixels()[pixel];
            let (mut replaced, mut error) = (None, 0.0);
            // Where a structure is thinner than a pixel, two rules may agree by accident.
            let is_thin = charts.iter().any(|of| of.nodes.is_thin(pixel));
            let wanted = if is_thin && varies(pixel) { 2 } else { 1 };
            let (mut agreed, mut before) = (0, 0.0);
            for level in 1..=FINEST_LEVEL {
                let finer = self.nodes_of_pixel(pixel, crossings[pixel], level).nodes;
                let of_finer: f64 = finer.iter().map(value_of).sum();
                let change = (of_finer - value).abs();
                error = f64::max(change, before);
                agreed = if change <= allowed(pixel) { agreed + 1 } else { 0 };
                if agreed == wanted {
                    break;
                }
                before = if wanted > 1 { change } else { 0.0 };
                value = of_finer;
                if agreed == 0 {
                    replaced = Some(finer);
                }
            }
            SettledPixel { pixel, replaced, error }
        };
        let checked: Vec<usize> = (0..height * width).into_par_iter().filter(is_checked).collect();
        let pixels: Vec<SettledPixel> = checked.into_par_iter().map(settled).collect();
        for of_pixel in &pixels {
            error.pixels_mut()[of_pixel.pixel] += of_pixel.error;
        }
        let replaced: Vec<(u32, &Vec<NaturalNode>)> = pixels
            .iter()
            .filter_map(|of| Some((crate::cell::to_u32(of.pixel), of.replaced.as_ref()?)))
            .collect();
        let is_kept =
            |node: &&ChartNode| replaced.binary_search_by_key(&node.pixel, |of| of.0).is_err();
        let nodes = in_charts().map(|(of, raster)| {
            let kept = of.nodes.nodes.iter().filter(is_kept).copied();
            let new = replaced.iter().flat_map(|(_, new)| new.iter());
            let new = new.filter(|node| node.chart == of.chart);
            let new = new.map(|node| in_window(&of.window, node));
            let mut all: Vec<ChartNode> = kept.chain(new).collect();
            all.sort_by_key(|node| node.pixel);
            of.nodes.with_nodes(all, raster.shape)
        });
        Settled { nodes: nodes.collect(), error }
    }
}
