//! Samples at the border of one part, as samples of the part beside it.

use super::{TILES, engine};
use crate::projection::{Chart, MappedPoint};
use crate::vol::dyadic::{STEPS, unit};
use crate::vol::engine::borders::border_samples;
use crate::vol::engine::coverage::Coverage;
use crate::vol::testing::{PANE, answered, assert_close, meter, part_of};
use crate::vol::view::part::Parts;
use crate::vol::view::scattered::PartSamples;

/// The error allowed.
const TARGET: f64 = 0.01;

/// The cube beside the unit cube along x, with half the path per depth: z is 2 at its far end.
#[derive(Debug)]
struct Beside;

impl Chart for Beside {
    fn world_from_chart(&self, [x, y, z]: [f64; 3]) -> MappedPoint {
        let position = [1.0 + x, y, 2.0 * z];
        MappedPoint { position, direction: [0.0, 0.0, -1.0], path_per_depth: 2.0 }
    }

    fn chart_from_world(&self, [x, y, z]: [f64; 3]) -> Option<[f64; 3]> {
        Some([x - 1.0, y, 0.5 * z])
    }

    fn density(&self, _xy: [f64; 2]) -> f64 {
        1.0
    }

    fn image_place(&self, uv: [f64; 2]) -> (usize, [f64; 2]) {
        (0, uv)
    }
}

/// The unit cube and the one beside it.
fn two_parts() -> Parts<'static> {
    let mut view = super::whole_view(1);
    let scale = view.parts[0].scale.clone();
    let mut beside = part_of(PANE);
    (beside.chart, beside.scale) = (Box::new(Beside), scale);
    view.parts.push(beside);
    view
}

/// A column on the border of both, between the lines of the base lattice.
fn column([x, y, z]: [f64; 3], _energy: f64) -> f64 {
    let is_lit = (x - 1.0).hypot(y - 0.28125) < 0.01 && z < 1.0;
    if is_lit { 3.0 } else { 0.0 }
}

#[test]
fn what_a_part_has_at_its_border_is_compared_with_the_part_beside_it() {
    let meter = meter(1_000_000);
    let view = two_parts();
    let mut engine = engine(&meter, &TILES, &view, 3, None);
    engine.coverage = Coverage::new(None, None, (0..2).map(|_| PartSamples::default()).collect());
    engine.products = vec![None, None];
    assert_eq!(answered(&meter, column, engine.sample_at_all_energies()), Ok(true));
    assert_eq!(engine.sheets.len(), 2);
    let lines = answered(&meter, column, engine.verify_samples(TARGET)).unwrap();
    assert!(lines.iter().all(Vec::is_empty));
    // A node of the first part meets the column.
    let on_border = [[STEPS, STEPS / 32 * 9]];
    let guarded = vec![0.0; engine.sheets[0].scan.tree.len()];
    let sampled = engine.sheets[0].sample_nodes(&on_border, &guarded, 1e-3);
    answered(&meter, column, sampled).unwrap();
    let known = border_samples(&engine.sheets);
    assert!(known[0].points.is_empty() && !known[1].points.is_empty());
    for (&[x, y, z], &rate) in known[1].points.iter().zip(&known[1].rates) {
        assert!(x == 0.0 && z <= 0.5);
        assert_close(y, 0.28125, 1e-12);
        assert_close(rate, 3.0 * 2.0, 1e-12);
    }
    let before = meter.evaluations();
    let lines = answered(&meter, column, engine.verify_samples(TARGET)).unwrap();
    assert_eq!(meter.evaluations(), before);
    let places: Vec<[f64; 2]> = lines[1].iter().map(|(place, _)| place.map(unit)).collect();
    assert!(lines[0].is_empty() && places == [[0.0, 0.28125]], "{places:?}");
}
