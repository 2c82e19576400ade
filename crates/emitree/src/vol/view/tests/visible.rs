//! Which layers are in view, with a ball in the unit cube.

use crate::Orthographic;
use crate::image::Image;
use crate::meter::Meter;
use crate::projection::{Canonical, Ellipsoid, Layer, Projection};
use crate::radiance::radiance_per_density;
use crate::tile::Tile;
use crate::vol::dyadic::unit;
use crate::vol::line::node_lines::base_depths;
use crate::vol::testing::{assert_close, meter, sheet, uniform};
use crate::vol::view::sheet::Sheet;
use crate::vol::view::visible::{Visible, visible_layers};
use core::f64::consts::PI;

const SHAPE: [usize; 2] = [16, 16];

fn with_ball(centre: [f64; 3], radius: f64) -> Orthographic {
    let ball = Ellipsoid::sphere(centre, radius).unwrap();
    Orthographic::of_unit_cube().with_occulters(vec![ball]).unwrap()
}

fn see<T>(projections: &[&dyn Projection], look: impl Fn(&[Visible<'_>], &[Image]) -> T) -> T {
    let count = projections.len();
    let tiles: Vec<Tile<'_>> = projections
        .iter()
        .enumerate()
        .map(|(number, &projection)| Tile { projection, shape: SHAPE, place: (number, count) })
        .collect();
    let layers: Vec<Vec<Box<dyn Layer + '_>>> =
        tiles.iter().map(|tile| tile.projection.layers()).collect();
    let mut scales: Vec<Image> =
        tiles.iter().map(|tile| radiance_per_density(tile.projection, SHAPE)).collect();
    let visible = visible_layers(&tiles, &layers, &mut scales);
    look(&visible, &scales)
}

#[test]
fn a_view_without_edges_is_one_layer_that_reaches_every_pixel() {
    see(&[&Canonical], |visible, scales| {
        assert_eq!(visible.len(), 1);
        assert!(visible[0].fractions.is_none());
        assert_eq!((visible[0].tile, visible[0].layers_of_tile), (0, 1));
        assert_eq!(*visible[0].scale, uniform(SHAPE, 1.0));
        assert_eq!(scales[0], *visible[0].scale);
    });
}

#[test]
fn an_opaque_ball_has_two_layers_that_reach_its_disc() {
    see(&[&with_ball([0.5, 0.4, 0.5], 0.3)], |visible, scales| {
        assert_eq!(visible.len(), 3);
        assert!(visible.iter().all(|layer| layer.layers_of_tile == 3 && layer.tile == 0));
        let area = |layer: &Visible<'_>| layer.scale.pixels().iter().sum::<f64>() / 256.0;
        let disc = PI * 0.09;
        assert_close(area(&visible[0]), 1.0 - disc, 1e-4);
        assert_close(area(&visible[1]), disc, 1e-4);
        // Beside the disc is sky, and where there is no sky is the disc.
        for (pixel, scale) in scales[0].pixels().iter().enumerate() {
            let sum = visible[0].scale.pixels()[pixel] + visible[1].scale.pixels()[pixel];
            assert_close(sum, *scale, 1e-12);
        }
        assert_close(visible[1].scale[(6, 8)], 1.0, 1e-12);
        assert_close(visible[1].scale[(15, 8)], 0.0, 1e-12);
    });
}

#[test]
fn layers_without_a_visible_pixel_are_left_out() {
    // A ball beside the view, and one that fills it.
    see(&[&with_ball([3.0, 0.5, 0.5], 0.3)], |visible, _| assert_eq!(visible.len(), 1));
    see(&[&with_ball([0.5; 3], 3.0)], |visible, _| {
        assert!(visible.iter().all(|layer| layer.layers_of_tile == visible.len()));
        assert!(visible.len() < 3);
    });
}

/// A sheet of a visible layer, without samples.
fn sheet_of<'a>(meter: &'a Meter, visible: &'a Visible<'a>) -> Sheet<'a> {
    let mut sheet = sheet(meter, visible.layer, 3, SHAPE);
    (sheet.fractions, sheet.scale) = (visible.fractions.clone(), visible.scale.clone());
    sheet
}

#[test]
fn lines_at_an_edge_are_in_the_pixels_that_it_crosses() {
    let meter = meter(0);
    see(&[&with_ball([0.5, 0.4, 0.5], 0.3)], |visible, _| {
        for layer in &visible[..2] {
            let mut sheet = sheet_of(&meter, layer);
            let [first, second] = [(); 2].map(|()| sheet.edge_lines(20));
            assert!(first.len() > 10 && first.len() <= 20 && first != second);
            for (place, depths) in first.iter().chain(&second) {
                assert!(layer.layer.is_open(place.map(unit)));
                let [x, y] = place.map(unit);
                // No farther from the circle than a pixel is long, or at the landmark in its middle.
                let from_middle = (x - 0.5).hypot(y - 0.4);
                let is_near = |distance: f64| distance < 2.0_f64.sqrt() / 16.0;
                assert!(is_near((from_middle - 0.3).abs()) || is_near(from_middle));
                assert_eq!(*depths, base_depths(4));
            }
            sheet.fractions = None;
            assert!(sheet.edge_lines(20).is_empty());
        }
    });
}

#[test]
fn the_image_of_a_layer_is_its_radiance_times_the_coverage_fraction() {
    let meter = meter(0);
    see(&[&with_ball([0.5, 0.4, 0.5], 0.3)], |visible, scales| {
        let mut sheet = sheet_of(&meter, &visible[0]);
        let wanted = sheet.add_base();
        assert!(sheet.scan.skips_closed && wanted.len() < 81);
        for (i, _) in wanted {
            let line = &mut sheet.scan.node_lines.lines[i];
            (line.integral, line.error) = (2.0, 0.5);
        }
        sheet.set_values(&[], &[]);
        let (part, _) = sheet.assemble(&scales[0], 3);
        for (pixel, reach) in visible[0].scale.pixels().iter().enumerate() {
            assert_close(part.image.pixels()[pixel], 2.0 * reach, 1e-9);
            assert_close(part.of_lines.pixels()[pixel], 0.5 * reach, 1e-9);
        }
    });
}

#[test]
fn the_layers_of_several_tiles_follow_each_other() {
    let ball = with_ball([0.5, 0.4, 0.5], 0.3);
    see(&[&Canonical, &ball, &Canonical], |visible, _| {
        let tiles: Vec<usize> = visible.iter().map(|layer| layer.tile).collect();
        assert_eq!(tiles, [0, 1, 1, 1, 2]);
        let layers: Vec<usize> = visible.iter().map(|layer| layer.layers_of_tile).collect();
        assert_eq!(layers, [1, 3, 3, 3, 1]);
    });
}
