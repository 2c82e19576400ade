//! The loop and its parts, on views of the unit cube with known images.

mod borders;
mod energies;
mod loops;
mod spectra_verification;
mod verification;

use super::*;
use crate::projection::Canonical;
use crate::vol::engine::first_energy::{EnergySearch, FirstEnergy};
use crate::vol::testing::{PANE, answered, assert_close, meter, uniform};
use crate::vol::view::part::parts;
use crate::vol::view::scattered::{KnownParts, PartSamples};
use std::sync::Arc;

const SHAPE: [usize; 2] = [16, 16];
const TILES: [Tile<'static>; 1] = [Tile { projection: &Canonical, shape: SHAPE, place: (0, 1) }];
const TOLERANCE: f64 = 0.01;

/// The unit cube as the only part of a view, with so many pieces of a line.
fn whole_view(pieces_of_line: usize) -> Parts<'static> {
    let mut view = parts(&TILES, None, None);
    let scale = Arc::new(uniform(SHAPE, 1.0));
    let part = view.parts.remove(0);
    view.parts.push(Part { chart: Box::new(PANE), scale, pieces_of_line, ..part });
    view
}

impl Engine<'_> {
    /// The energy at which the trees begin.
    async fn first_energy(&self) -> Result<Option<FirstEnergy>, MethodError> {
        let Some(spectra) = &self.spectra else { return Ok(None) };
        let &Self { meter, tiles, parts, vol, base_level, .. } = self;
        EnergySearch::new(meter, tiles, parts, spectra.axis(), vol).run(base_level).await.map(Some)
    }

    /// The first samples at the first energy and at all that the spectra require.
    async fn sample_at_all_energies(&mut self) -> Result<bool, MethodError> {
        let first = self.first_energy().await?;
        let first = self.sample_initially(first).await?;
        self.sample_further_energies(&first).await
    }

    /// The whole loop from the first samples on.
    async fn run_from_nothing(&mut self) -> Result<(CurrentImage, StopReason), MethodError> {
        let first = self.first_energy().await?;
        let first = self.sample_initially(first).await?;
        self.run(Beginning::Samples(first)).await
    }
}

/// The usual options.
fn default_options() -> &'static VolOptions {
    static OPTIONS: std::sync::OnceLock<VolOptions> = std::sync::OnceLock::new();
    OPTIONS.get_or_init(|| VolOptions::new(TOLERANCE))
}

/// An engine for the unit cube, with lines that may take a fifth of 1 %.
fn engine<'a>(
    meter: &'a Meter,
    tiles: &'a [Tile<'a>],
    view: &'a Parts<'a>,
    base_level: u8,
    axis: Option<&'a EnergyAxis>,
) -> Engine<'a> {
    Engine {
        meter,
        tiles,
        view,
        parts: &view.parts,
        footings: view.parts.iter().map(|part| part.footing.clone()).collect(),
        quadrature_error: None,
        of_exam: 0.0,
        is_fixed: false,
        vol: default_options(),
        sheets: Vec::new(),
        energies: Energies::none(),
        spectra: axis.map(|axis| Spectra::new(axis, &[])),
        first_hits: Vec::new(),
        requested: TOLERANCE,
        goal: TOLERANCE,
        tolerance: TOLERANCE,
        line_share: 0.2,
        is_strict: false,
        base_level,
        finest_level: 10,
        evaluations_before: 0,
        verification_lines: 1,
        coverage: Coverage::new(None, None, vec![PartSamples::default()]),
        products: vec![None],
        done: None,
        largest_done: 0.0,
    }
}

/// A function that trees and lines have exactly, and the mean of its image over a pixel.
fn plane([x, y, z]: [f64; 3], _energy: f64) -> f64 {
    1.0 + 2.0 * x - y + z
}

fn of_plane(row: usize, column: usize) -> f64 {
    let [x, y] = [column, row].map(|k| (k as f64 + 0.5) / 16.0);
    1.5 + 2.0 * x - y
}

fn assert_plane(image: &Image, allowed: f64) {
    for row in 0..16 {
        for column in 0..16 {
            assert_close(image[(row, column)], of_plane(row, column), allowed);
        }
    }
}

#[test]
fn a_base_has_a_sample_at_each_place_of_a_cubic_lattice() {
    assert_eq!([1, 2, 3, 7].map(base_evaluations), [27, 125, 729, 129 * 129 * 129]);
}

#[test]
fn the_base_is_the_finest_one_that_the_budget_allows() {
    for (sheets, allowed, expected) in [
        (1, 729, Some(3)),
        (1, 1_000_000, Some(3)),
        (1, 728, Some(2)),
        (1, 125, Some(2)),
        (1, 124, Some(1)),
        (1, 27, Some(1)),
        (1, 26, None),
        (2, 1458, Some(3)),
        (2, 1457, Some(2)),
        (5, 134, None),
    ] {
        let parts: Vec<Part<'_>> = (0..sheets).flat_map(|_| whole_view(1).parts).collect();
        match affordable_base_level(&parts, 3, allowed) {
            Ok(level) => assert_eq!(Some(level), expected, "{sheets} {allowed}"),
            Err(RenderError::Budget { needed, allowed: told, .. }) => {
                assert_eq!((expected, needed, told), (None, 27 * sheets, allowed));
            }
            Err(error) => panic!("{error}"),
        }
    }
}

#[test]
fn nodes_are_no_closer_than_a_sixteenth_of_a_pixel_of_the_longer_side() {
    for (shape, base_level, expected) in [
        ([1024, 512], 3, 14),
        ([512, 1024], 3, 14),
        ([1025, 1], 3, 15),
        ([64, 64], 3, 10),
        ([1, 1], 3, 10),
        ([1, 1], 9, 11),
        ([1 << 20, 1], 3, FINEST_LEVEL),
    ] {
        assert_eq!(finest_level(shape, base_level), expected, "{shape:?}");
    }
}

#[test]
fn a_budget_that_ends_is_no_failure() {
    assert_eq!(within_budget(Ok(())), Ok(true));
    assert_eq!(within_budget(Err(Stop::Budget)), Ok(false));
    let failed = RenderError::Time { seconds: 1.0 };
    assert_eq!(within_budget(Err(Stop::Failed(failed.clone()))), Err(failed));
}

#[test]
fn the_tolerance_of_lines_depends_on_their_weight() {
    let meter = meter(0);
    let parts = whole_view(1);
    let mut engine = engine(&meter, &TILES, &parts, 3, None);
    assert_close(engine.line_tolerances(0.5)[0], 0.2 * 0.5, 1e-16);
    for (weight, expected) in [(0.5, 0.2), (4.0, 0.025), (0.0, 0.1)] {
        engine.energies = Energies::unselected(0, 3, weight);
        assert_close(engine.line_tolerances(0.5)[0], expected, 1e-16);
    }
}

/// An image by image trees alone.
fn made(
    rate: impl Fn([f64; 3], f64) -> f64 + Sync,
    allowed: u64,
    vol: &VolOptions,
) -> (Result<MethodOutput, MethodError>, u64) {
    let meter = meter(allowed);
    let parts = whole_view(1);
    let tree = async {
        let known = KnownParts::none(1);
        Trees::begin(&meter, &TILES, &parts, None, vol, known, BeforeTrees::default())
            .await?
            .finish()
            .await
    };
    (answered(&meter, rate, tree), meter.evaluations())
}

#[test]
fn an_image_of_a_plane_is_exact_and_complete() {
    let (made, evaluations) = made(plane, 1_000_000, &VolOptions::default());
    let made = made.unwrap();
    assert_eq!((made.ending, made.base_level), (StopReason::Complete, Some(3)));
    assert_plane(&made.cube.bands()[0], 1e-12);
    // The base, and 1024 scattered samples.
    assert!(evaluations > 729 + 1024 && made.smallest_feature.is_some());
}

#[test]
fn an_image_from_a_base_coarser_than_requested_is_not_complete() {
    let (made, evaluations) = made(plane, 700, &VolOptions::default());
    let made = made.unwrap();
    assert_eq!((made.ending, made.base_level), (StopReason::Budget, Some(2)));
    assert!((125..=700).contains(&evaluations));
    assert_plane(&made.cube.bands()[0], 1e-9);
}

#[test]
fn a_requested_feature_size_is_covered_or_the_image_is_not_complete() {
    for (size, allowed, ending) in
        [(0.02, 1_000_000, StopReason::Complete), (0.002, 20_000, StopReason::Budget)]
    {
        let smallest_feature = Some(crate::vol::FeatureSize::Fraction(size));
        let vol = VolOptions { smallest_feature, ..VolOptions::default() };
        let made = made(plane, allowed, &vol).0.unwrap();
        assert_eq!(made.ending, ending);
        let is_covered = made.smallest_feature.is_some_and(|smallest| smallest <= size);
        assert_eq!(is_covered, ending == StopReason::Complete);
    }
}
