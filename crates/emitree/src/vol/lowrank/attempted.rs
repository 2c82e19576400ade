//! The result of the searches on all parts of a view.

use crate::cube::Cube;
use crate::line_values::LineValues;
use crate::mesh::frozen::Frozen;
use crate::output::MethodOutput;
use crate::projection::charts::FittedDepth;
use crate::projection::charts::chart::Window;
use crate::projection::charts::stretch::Stretch;
use crate::radiance::map_of_rows;
use crate::tree::StopReason;
use crate::vol::VolOptions;
use crate::vol::error_weights::ErrorWeights;
use crate::vol::lowrank::divided_rows::{DividedProducts, ProductsOfChart};
use crate::vol::lowrank::interpolant::Interpolant;
use crate::vol::lowrank::maps::{Maps, shape_of};
use crate::vol::lowrank::rows::{Checked, PlaneProducts};
use crate::vol::lowrank::start::{CubeStart, Functions};
use crate::vol::lowrank::{Attempt, Probed};
use crate::vol::tuning::TUNING;
use crate::vol::view::frozen::FrozenView;
use crate::vol::view::lines::{FunctionOfPart, LinesInView};
use crate::vol::view::part::{Footing, Part, Parts, ProductImage};
use crate::vol::view::products::FrozenProducts;
use crate::vol::view::scattered::{KnownParts, PartSamples};
use std::sync::Arc;

/// The result of the searches.
pub(crate) struct Attempted {
    /// The image to the tolerance, or the best one for a part of the budget; `None` if the image
    /// tree is expected to cost less or G is not separable.
    pub(crate) found: Option<MethodOutput>,
    /// What is known of the parts.
    pub(crate) known: KnownParts,
    /// Where a chart had better end, in which case the search has stopped.
    pub(crate) kinks: Vec<Kink>,
    /// Whether the depths of charts had better be divided at the points nearest to a centre, in which case the search
    /// has stopped.
    pub(crate) prefers_halves: bool,
    /// Weights of the coordinates of depth that are better in some charts, in which case the search has stopped.
    pub(crate) depths: Vec<FittedDepth>,
    /// The first probes of the parts, if the search has stopped for other weights.
    pub(crate) probed: Vec<Probed>,
    /// The stretch of the depth of an image plane that is better, in which case the search has
    /// stopped.
    pub(crate) stretch: Option<Stretch>,
    /// Whether the view had better be divided by the faces of its bounds, in which case the search has stopped.
    pub(crate) prefers_faces: bool,
    /// Whether a search has ended since G jumps.
    pub(crate) has_jump: bool,
    /// Whether the functions of another G that a search began with are within the tolerance; if not, and if others
    /// may be used, the search has stopped.
    pub(crate) functions_suffice: bool,
    /// The functions of the parts, if a frozen quadrature is made.
    pub(crate) functions: Vec<Option<Functions>>,
    /// The frozen functions of the parts at one energy of a cube.
    pub(super) placed: Vec<Placed>,
    /// The scattered samples at the first energy of a cube, if products were searched for there.
    pub(crate) of_first: Option<Vec<PartSamples>>,
    /// What a cube leaves for those of other emissions.
    pub(crate) cube_start: Option<Arc<CubeStart>>,
    /// The products of the parts.
    pub(super) interpolants: Vec<Option<Arc<Interpolant>>>,
    /// The same with their residuals, if the image is to be made row by row.
    pub(super) checked: Vec<Option<Arc<Checked>>>,
    /// Why the image of a part is not complete, if one is not.
    ending: StopReason,
}

/// A cube, and what it leaves for those of other emissions.
pub(crate) struct FoundCube {
    pub(crate) output: MethodOutput,
    pub(crate) start: Option<Arc<CubeStart>>,
}

/// An azimuth at which G has a kink or a jump in a chart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Kink {
    /// The number of the chart in the atlas, and what is in view of it.
    pub(crate) chart: usize,
    pub(crate) window: Window,
    /// The place along the azimuth of the window.
    pub(crate) v: f64,
}

/// Frozen functions of a part, its number, and where it is in the image.
pub(super) type Placed = (FrozenProducts, usize, Arc<Footing>);

/// The frozen quadrature of functions, each group with its weight in the bins of the cube.
pub(super) fn frozen_of(
    parts: &Parts<'_>,
    groups: &[(Vec<Placed>, Vec<f64>)],
    shape: [usize; 3],
) -> Frozen {
    let mut view = FrozenView::new(&parts.outside);
    for (group, weights) in groups {
        for (of, part, footing) in group {
            view.add_products(of, &parts.parts[*part], footing, weights);
        }
    }
    view.finish(shape)
}

/// The radiances of the lines that the options name, of a view whose parts all have products.
fn lines_of(
    vol: &VolOptions,
    parts: &Parts<'_>,
    products: &[ProductImage],
    largest: f64,
) -> Option<LineValues> {
    let lines = LinesInView::new(parts, vol.lines.as_ref()?);
    let functions = products.iter().zip(&parts.parts);
    let functions: Vec<_> =
        functions.map(|(of, part)| FunctionOfPart::of_products(of, &part.scale)).collect();
    Some(lines.values(&functions, vol.tolerance * largest))
}

impl Attempted {
    /// Nothing is known.
    pub(crate) fn none(parts: &Parts<'_>) -> Self {
        Self {
            found: None,
            known: KnownParts::none(parts.parts.len()),
            kinks: Vec::new(),
            prefers_halves: false,
            depths: Vec::new(),
            probed: Vec::new(),
            stretch: None,
            prefers_faces: false,
            has_jump: false,
            functions_suffice: true,
            functions: vec![None; parts.parts.len()],
            placed: Vec::new(),
            of_first: None,
            cube_start: None,
            interpolants: vec![None; parts.parts.len()],
            checked: vec![None; parts.parts.len()],
            ending: StopReason::Complete,
        }
    }

    /// Takes the cube of these parts.
    pub(crate) fn take_cube(&mut self, found: Option<FoundCube>) {
        if let Some(FoundCube { output, start }) = found {
            self.found = Some(output);
            self.cube_start = start;
        }
    }

    /// How the view had better be divided, without what was found in these parts.
    pub(crate) fn division_alone(self, parts: &Parts<'_>) -> Self {
        Self {
            kinks: self.kinks,
            prefers_halves: self.prefers_halves,
            depths: self.depths,
            probed: self.probed,
            stretch: self.stretch,
            prefers_faces: self.prefers_faces,
            ..Self::none(parts)
        }
    }

    /// Whether the view had better be divided in another way.
    pub(crate) fn divides(&self) -> bool {
        self.prefers_faces
            || self.prefers_halves
            || self.stretch.is_some()
            || !self.depths.is_empty()
            || !self.kinks.is_empty()
    }

    /// Adds the image of a part, and makes the output when all parts have one.
    pub(super) fn add(
        &mut self,
        number: usize,
        attempt: &Attempt<'_>,
        maps: Maps,
        ending: StopReason,
        parts: &Parts<'_>,
    ) {
        let known = &mut self.known;
        known.largest = known.largest.max(maps.largest);
        known.smallest = match (known.smallest, attempt.smallest) {
            (Some(a), Some(b)) => Some(f64::max(a, b)),
            (a, b) => a.or(b),
        };
        let Maps { image, error, residuals, .. } = maps;
        let footing = &attempt.part.footing;
        if self.ending == StopReason::Complete {
            self.ending = ending;
        }
        let functions = attempt.meter.freezes().then(|| attempt.search.functions());
        let frozen = functions.as_ref().map(|functions| attempt.search.frozen(functions));
        self.functions[number] = functions;
        let mut placed: Vec<Placed> = Vec::new();
        let interpolant = Arc::new(attempt.search.interpolant.clone());
        self.interpolants[number] = Some(Arc::clone(&interpolant));
        let wants_rows = attempt.meter.rows_wanted().is_some();
        if wants_rows {
            let interpolant = Arc::clone(&interpolant);
            self.checked[number] = Some(Arc::new(Checked { interpolant, residuals }));
        }
        let is_image = footing.is_of_pixels() && parts.parts.len() == 1;
        let mut divided = None;
        let mut lines = None;
        let maps = if is_image {
            let means = |shape| attempt.search.interpolant.means(shape);
            let has_rim = !footing.is_raster_of_pixels();
            placed.extend(frozen.map(|of| (of, number, Arc::clone(footing))));
            let image = if has_rim { footing.image(means, &attempt.part.scale).1 } else { image };
            if attempt.vol.lines.is_some() {
                let function = interpolant;
                let product = ProductImage { function, errors: error.clone(), frozen: None };
                lines = lines_of(attempt.vol, parts, &[product], known.largest);
            }
            [image, error]
        } else {
            let function = interpolant;
            known.products[number] = Some(ProductImage { function, errors: error, frozen });
            let products: Option<Vec<ProductImage>> = known.products.iter().cloned().collect();
            let Some(products) = products else { return };
            lines = lines_of(attempt.vol, parts, &products, known.largest);
            let allowed = TUNING.view.quadrature_share * attempt.vol.tolerance;
            let (maps, footings) = match attempt.vol.is_uniform() {
                true => {
                    let allowed = allowed * known.largest;
                    if wants_rows {
                        let limits = [allowed, known.largest];
                        divided = divided_products(parts, &self.checked, limits);
                    }
                    parts.image_of_products(&products, allowed, None)
                }
                false => {
                    // The error allowed in a pixel depends on the image itself.
                    let ([image, error], _) =
                        parts.image_of_products(&products, f64::INFINITY, None);
                    let weights =
                        ErrorWeights::new(attempt.vol, &[[&image, &error]], &parts.outside);
                    let allowed = allowed * weights.largest;
                    let weights = weights.maps.into_iter().flatten().next();
                    parts.image_of_products(&products, allowed, weights.as_deref())
                }
            };
            for (part, (product, footing)) in products.iter().zip(&footings).enumerate() {
                placed.extend(product.frozen.clone().map(|of| (of, part, Arc::clone(footing))));
            }
            maps
        };
        let [cube, error] = maps.map(|mut map| {
            parts.outside.iter().for_each(|&pixel| map.pixels_mut()[pixel] = f64::NAN);
            Cube::from_bands(vec![map])
        });
        if attempt.shows() && !is_image {
            // The last frame is the image.
            attempt.meter.show([cube.clone(), error.clone()]);
        }
        let mut made = MethodOutput::new(cube, Some(error), self.ending);
        made.lines = lines;
        made.base_level = Some(attempt.vol.base_level);
        made.smallest_feature = known.smallest;
        let wants_model = attempt.meter.wants_model() || !attempt.vol.sums.is_empty();
        if is_image && footing.is_raster_of_pixels() && wants_model {
            made.model = Some(Arc::new(attempt.search.interpolant.clone()));
        }
        let checked: Option<Vec<_>> = self.checked.iter().cloned().collect();
        made.products = match (divided, checked) {
            (Some(divided), _) => Some(Arc::new(divided)),
            (None, Some(checked)) => Some(Arc::new(PlaneProducts::of_image(checked))),
            (None, None) => None,
        };
        if attempt.meter.freezes() && attempt.search.view.energies.is_empty() {
            made.frozen =
                Some(Arc::new(frozen_of(parts, &[(placed, vec![1.0])], made.cube.shape())));
        } else {
            self.placed = placed;
        }
        self.found = Some(made);
    }
}

/// The products of charts, if all parts are on charts, given the error of the quadrature allowed in a pixel and the
/// largest pixel of a part.
fn divided_products(
    parts: &Parts<'_>,
    products: &[Option<Arc<Checked>>],
    [allowed, largest]: [f64; 2],
) -> Option<DividedProducts> {
    let of_chart = |(part, product): (&Part<'_>, &Option<Arc<Checked>>)| {
        let product = product.as_ref()?;
        let Footing::Nodes { chart, window, .. } = *part.footing else { return None };
        // Not those of the image of the search, which are 0 where that has no pixels.
        let shape = shape_of(&part.scale);
        let of_rows = product.residuals.errors(shape);
        let errors = map_of_rows(shape, |row, values| of_rows.row(row, values));
        let interpolant = Arc::clone(&product.interpolant);
        Some(ProductsOfChart { chart, window, interpolant, errors })
    };
    let charts: Option<Vec<_>> = parts.parts.iter().zip(products).map(of_chart).collect();
    let (division, first) = (parts.division.clone(), parts.parts.first()?);
    let shape = first.footing.shape_of_image(&first.scale);
    let largest = largest * parts.parts.len() as f64;
    Some(DividedProducts { division, shape, charts: Arc::new(charts?), allowed, largest })
}
