//! The frozen image of a view: the linear map from values at nodes to pixels that its trees and products
//! are, without their values.

use crate::cube::Cube;
use crate::image::Image;
use crate::mesh::frozen::{Collector, Frozen, NodesToCube};
use crate::vol::dyadic::unit;
use crate::vol::image::pixels::pixel_means;
use crate::vol::image::tree::ImageTree;
use crate::vol::view::part::{Footing, Part};
use crate::vol::view::products::FrozenProducts;
use crate::vol::view::sheet::{Sheet, SheetId};
use rustc_hash::FxHashMap;
use std::sync::Arc;

/// Products with their place in the image.
#[derive(Debug)]
struct PlacedProducts {
    products: FrozenProducts,
    footing: Arc<Footing>,
    scale: Arc<Image>,
    /// Their weight in each bin.
    weights: Vec<f64>,
}

/// A tree with its place in the image.
#[derive(Debug)]
struct FrozenSheet {
    id: SheetId,
    tree: ImageTree,
    footing: Arc<Footing>,
    scale: Arc<Image>,
    /// How much of the sheet of the same part at each earlier energy is subtracted.
    of_earlier: Vec<f64>,
    /// The weight of the sheet in each bin.
    weights: Vec<f64>,
}

/// The frozen image of a view, while it is put together.
#[derive(Debug)]
pub(crate) struct FrozenView {
    image: FrozenImage,
    collector: Collector,
}

/// The map from nodes to the image of a view.
#[derive(Debug)]
struct FrozenImage {
    /// Bins, height and width.
    shape: [usize; 3],
    /// The numbers of the pixels that belong to no image.
    outside: Vec<usize>,
    products: Vec<PlacedProducts>,
    sheets: Vec<FrozenSheet>,
}

impl FrozenView {
    /// Nothing yet; the pixels with the numbers `outside` belong to no image.
    pub(crate) fn new(outside: &[usize]) -> Self {
        let image = FrozenImage {
            shape: [0; 3],
            outside: outside.to_vec(),
            products: Vec::new(),
            sheets: Vec::new(),
        };
        Self { image, collector: Collector::new() }
    }

    /// Adds the products of a part with their weight in each bin; all products come before all sheets.
    pub(crate) fn add_products(
        &mut self,
        products: &FrozenProducts,
        part: &Part<'_>,
        footing: &Arc<Footing>,
        weights: &[f64],
    ) {
        let nodes = products.nodes.iter();
        nodes.for_each(|terms| self.collector.node(terms.iter().copied()));
        self.image.products.push(PlacedProducts {
            products: products.clone(),
            footing: footing.clone(),
            scale: part.scale.clone(),
            weights: weights.to_vec(),
        });
    }

    /// Adds a sheet, after those at earlier energies.
    pub(crate) fn add_sheet(&mut self, sheet: &Sheet<'_>, of_earlier: &[f64], weights: &[f64]) {
        let scan = &sheet.scan;
        for (i, node) in scan.tree.nodes().iter().enumerate() {
            let density = scan.view.chart.density(node.place.map(unit));
            let depths = scan.node_lines.weights(i).into_iter();
            self.collector.node(depths.flat_map(|(depth, weight)| {
                let terms = scan.view.terms(node.place, depth).into_iter();
                terms.map(move |(site, of_site)| (site, density * weight * of_site))
            }));
        }
        self.image.sheets.push(FrozenSheet {
            id: sheet.id,
            tree: scan.tree.clone(),
            footing: sheet.footing.clone(),
            scale: sheet.scale.clone(),
            of_earlier: of_earlier.to_vec(),
            weights: weights.to_vec(),
        });
    }

    /// The quadrature of a cube of `shape` = \[bins, height, width\].
    pub(crate) fn finish(self, shape: [usize; 3]) -> Frozen {
        self.collector.finish(FrozenImage { shape, ..self.image })
    }
}

impl FrozenImage {
    /// The trees of all sheets with the values at their nodes.
    fn trees(&self, mut nodes: &[f64]) -> Vec<ImageTree> {
        let mut trees: Vec<ImageTree> = Vec::with_capacity(self.sheets.len());
        for sheet in &self.sheets {
            let mut tree = sheet.tree.clone();
            let of_part = self.sheets.iter().zip(&trees);
            let of_part = of_part.filter(|(earlier, _)| earlier.id.part == sheet.id.part);
            let earlier: Vec<(&ImageTree, f64)> =
                of_part.map(|(_, tree)| tree).zip(sheet.of_earlier.iter().copied()).collect();
            let mut ghosts = vec![FxHashMap::default(); earlier.len()];
            let (own, rest) = nodes.split_at(tree.len());
            for (i, value) in own.iter().enumerate() {
                let place = tree.nodes()[i].place;
                let parts = earlier.iter().zip(&mut ghosts);
                let value = parts.fold(*value, |value, ((tree, amount), ghosts)| {
                    value - amount * tree.value(place, ghosts)
                });
                tree.set(i, value);
            }
            tree.update_details();
            trees.push(tree);
            nodes = rest;
        }
        trees
    }
}

impl NodesToCube for FrozenImage {
    fn cube(&self, mut nodes: &[f64]) -> Cube {
        let [bins, height, width] = self.shape;
        let mut bands = vec![Image::zeros(height, width); bins];
        for PlacedProducts { products, footing, scale, weights } in &self.products {
            let (core, rest) = nodes.split_at(products.nodes.len());
            let (_, image) = footing.image(|shape| products.interpolant.means(core, shape), scale);
            for (band, weight) in bands.iter_mut().zip(weights) {
                band.add_scaled(&image, *weight);
            }
            nodes = rest;
        }
        for (sheet, tree) in self.sheets.iter().zip(&self.trees(nodes)) {
            let (first, image) =
                sheet.footing.image(|shape| pixel_means(tree, shape), &sheet.scale);
            for (band, weight) in bands.iter_mut().zip(&sheet.weights) {
                if *weight != 0.0 {
                    band.add_rows(first, &image, *weight);
                }
            }
        }
        for band in &mut bands {
            self.outside.iter().for_each(|&pixel| band.pixels_mut()[pixel] = f64::NAN);
        }
        Cube::from_bands(bands)
    }
}
