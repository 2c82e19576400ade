//! Images of known radiances from the charts of a view, and beside the rim of a disc.

use crate::image::Image;
use crate::projection::{
    Bounds, Camera, Chart, DiscMapping, Ellipsoid, ImagePlane, Projection, Sight, ViewGeometry,
};
use crate::tile::Tile;
use crate::vol::testing::{assert_close, uniform};
use crate::vol::view::division::atlas;
use crate::vol::view::part::{Footing, Parts, parts};
use crate::vol::view::quadrature::Quadrature;
use crate::{Fisheye, Orthographic, Perspective, Viewpoint};
use core::f64::consts::{PI, TAU};

const OBSERVER: [f64; 3] = [0.0, -6.0, 0.0];

fn viewpoint(target: [f64; 3]) -> Viewpoint {
    Viewpoint { position: OBSERVER, target, up: [0.0, 0.0, 1.0] }
}

/// The parts of the view of a camera, on an image of one tile.
fn see<T>(projection: &dyn Projection, shape: [usize; 2], look: impl FnOnce(&Parts<'_>) -> T) -> T {
    let tiles = [Tile { projection, shape, place: (0, 1) }];
    let atlas = atlas(&tiles, &[]);
    look(&parts(&tiles, atlas.as_ref(), None))
}

/// The means of a function over the cells of a raster, by `fine`² × 4 Gauss–Legendre nodes.
fn means([rows, columns]: [usize; 2], fine: usize, value: impl Fn([f64; 2]) -> f64) -> Vec<f64> {
    let half = 0.5 / 3.0_f64.sqrt();
    let offsets: Vec<f64> = (0..fine)
        .flat_map(|k| [0.5 - half, 0.5 + half].map(|at| (k as f64 + at) / fine as f64))
        .collect();
    let mut means = Vec::with_capacity(rows * columns);
    for row in 0..rows {
        for column in 0..columns {
            let mut sum = 0.0;
            for y in &offsets {
                for x in &offsets {
                    let along = |k: usize, at: f64, cells: usize| (k as f64 + at) / cells as f64;
                    sum += value([along(column, *x, columns), along(row, *y, rows)]);
                }
            }
            means.push(sum / (offsets.len() * offsets.len()) as f64);
        }
    }
    means
}

/// The same by the midpoints of cells, which are small.
fn midpoints([rows, columns]: [usize; 2], value: impl Fn([f64; 2]) -> f64) -> Vec<f64> {
    let middle = |k: usize, cells: usize| (k as f64 + 0.5) / cells as f64;
    let place = |k: usize| [middle(k % columns, columns), middle(k / columns, rows)];
    (0..rows * columns).map(|k| value(place(k))).collect()
}

/// Places evenly in a pixel, `count` along each axis.
fn in_pixel(
    pixel: usize,
    [height, width]: [usize; 2],
    count: usize,
) -> impl Iterator<Item = [f64; 2]> {
    (0..count * count).map(move |k| {
        let along = |corner: usize, k: usize, pixels: usize| {
            (corner as f64 + (k as f64 + 0.5) / count as f64) / pixels as f64
        };
        [along(pixel % width, k % count, width), along(pixel / width, k / count, height)]
    })
}

fn is_on_disc([x, y]: [f64; 2]) -> bool {
    (2.0 * x - 1.0).powi(2) + (2.0 * y - 1.0).powi(2) <= 1.0
}

/// The image of a radiance on the plane of a camera with a rim.
fn image_on_plane(
    camera: &Fisheye,
    shape: [usize; 2],
    radiance: impl Fn([f64; 2]) -> f64,
) -> (Image, Vec<usize>) {
    see(camera, shape, |Parts { parts, outside, .. }| {
        assert_eq!(parts.len(), 1);
        let chart = &parts[0].chart;
        let of_raster = |raster: [usize; 2]| {
            let fine = 64_usize.div_ceil(raster[0].min(raster[1]));
            means(raster, fine, |xy| chart.density(xy) * radiance(xy))
        };
        let (first_row, image) = parts[0].footing.image(of_raster, &parts[0].scale);
        assert_eq!(first_row, 0);
        (image, outside.clone())
    })
}

#[test]
fn a_constant_radiance_is_that_of_all_pixels_on_a_disc() {
    let fisheye =
        |fov: f64, mapping| Fisheye::new(viewpoint([0.0; 3]), fov, mapping, [0.1, 9.0]).unwrap();
    for camera in [
        fisheye(PI, DiscMapping::Equidistant),
        fisheye(0.8 * TAU, DiscMapping::Equidistant),
        fisheye(TAU, DiscMapping::EqualArea),
    ] {
        for shape in [[5, 7], [64, 64], [300, 200], [1, 1], [1, 9], [3, 2]] {
            let (image, outside) = image_on_plane(&camera, shape, |_| 1.0);
            let mut is_in_image = vec![true; shape[0] * shape[1]];
            outside.into_iter().for_each(|pixel| is_in_image[pixel] = false);
            for (pixel, value) in image.pixels().iter().enumerate() {
                if !is_in_image[pixel] {
                    // The rim may touch a corner.
                    let share = in_pixel(pixel, shape, 12).filter(|xy| is_on_disc(*xy)).count();
                    assert!(share < 2, "{shape:?}: pixel {pixel} is not outside");
                } else {
                    assert!((value - 1.0).abs() < 1e-6, "{camera:?} {shape:?} {pixel}: {value}");
                }
            }
        }
    }
}

#[test]
fn a_pixel_on_the_rim_is_the_mean_of_its_part_of_the_disc() {
    let camera = Fisheye::new(viewpoint([0.0; 3]), PI, DiscMapping::EqualArea, [0.1, 9.0]).unwrap();
    let radiance = |[x, y]: [f64; 2]| 1.0 + 3.0 * x - 2.0 * y * y;
    for shape in [[5, 7], [24, 31]] {
        let (image, outside) = image_on_plane(&camera, shape, radiance);
        let mut crossed = 0;
        for (pixel, value) in image.pixels().iter().enumerate() {
            let on_disc: Vec<[f64; 2]> =
                in_pixel(pixel, shape, 100).filter(|xy| is_on_disc(*xy)).collect();
            // The sampled mean of a small corner is not known well.
            if on_disc.len() < 100 || outside.contains(&pixel) {
                continue;
            }
            crossed += usize::from(on_disc.len() < 10_000);
            let sum: f64 = on_disc.iter().map(|xy| radiance(*xy)).sum();
            let size = 1.0 / shape[0].min(shape[1]) as f64;
            assert_close(*value, sum / on_disc.len() as f64, 0.01 * size);
        }
        assert!(crossed > 10, "{crossed}");
    }
}

/// An ellipsoid along the axes of the world.
#[derive(Clone, Copy)]
struct Shape {
    centre: [f64; 3],
    semi_axes: [f64; 3],
}

impl Shape {
    fn sphere(centre: [f64; 3], radius: f64) -> Self {
        Self { centre, semi_axes: [radius; 3] }
    }

    fn ellipsoid(&self) -> Ellipsoid {
        Ellipsoid::new(self.centre, self.semi_axes).unwrap()
    }

    /// The distances of both crossings, from the quadratic equation of the line.
    fn crossing(&self, origin: [f64; 3], direction: [f64; 3]) -> Option<[f64; 2]> {
        let (mut a, mut half_b, mut c) = (0.0, 0.0, -1.0);
        for k in 0..3 {
            let [o, d] = [origin[k] - self.centre[k], direction[k]].map(|v| v / self.semi_axes[k]);
            a += d * d;
            half_b += o * d;
            c += o * o;
        }
        let discriminant = half_b * half_b - a * c;
        (discriminant > 0.0)
            .then(|| [-1.0, 1.0].map(|sign| (-half_b + sign * discriminant.sqrt()) / a))
    }
}

/// The length of the path inside `bounds` from distance 0 up to a body.
fn path(bounds: Shape, bodies: &[Shape], Sight { origin, direction }: Sight) -> f64 {
    let Some([enter, leave]) = bounds.crossing(origin, direction) else { return 0.0 };
    let from = enter.max(0.0);
    let hits = bodies.iter().filter_map(|body| body.crossing(origin, direction));
    let end = hits.filter(|hit| hit[1] > from).fold(leave, |end, hit| end.min(hit[0]));
    (end - from).max(0.0)
}

/// The length of the piece at (u, v) of a chart.
fn length(chart: &dyn Chart, [u, v]: [f64; 2]) -> f64 {
    let [from, to] = [0.0, 1.0].map(|z| chart.world_from_chart([u, v, z]).position);
    (0..3).map(|k| (to[k] - from[k]).powi(2)).sum::<f64>().sqrt()
}

/// Compares the image of a uniform emission with the mean path of lines evenly in each pixel;
/// `line` are the lines of the camera.
fn compare<P: ImagePlane>(
    camera: Camera<P>,
    line: impl Fn([f64; 2]) -> Sight,
    bounds: Shape,
    bodies: &[Shape],
    shape: [usize; 2],
    allowed: f64,
) {
    let camera = camera.with_bounds(Bounds::Ellipsoid(bounds.ellipsoid()));
    let camera = camera.with_occulters(bodies.iter().map(Shape::ellipsoid).collect()).unwrap();
    let image = see(&camera, shape, |Parts { parts, outside, .. }| {
        let mut image = Image::zeros(shape[0], shape[1]);
        for part in parts {
            let of_raster = |raster| midpoints(raster, |uv| length(&*part.chart, uv));
            let (first_row, of_part) = part.footing.image(of_raster, &part.scale);
            image.add_rows(first_row, &of_part, 1.0);
        }
        outside.iter().for_each(|&pixel| image.pixels_mut()[pixel] = f64::NAN);
        image
    });
    let largest = image.largest();
    let count = 100;
    for (pixel, value) in image.pixels().iter().enumerate().filter(|(_, value)| !value.is_nan()) {
        let (mut sum, mut of_weights) = (0.0, 0.0);
        for xy in in_pixel(pixel, shape, count) {
            let weight = camera.solid_angle_density(xy);
            if weight > 0.0 {
                sum += weight * path(bounds, bodies, line(xy));
                of_weights += weight;
            }
        }
        let (row, column) = (pixel / shape[1], pixel % shape[1]);
        let wrong = (value - sum / of_weights).abs() / largest;
        assert!(wrong < allowed, "{row} {column}: {value} {} ({wrong:.1e})", sum / of_weights);
    }
}

/// The lines of a pinhole camera that looks along y.
fn pinhole([x, y]: [f64; 2], width: f64) -> Sight {
    let [right, up] = [x, y].map(|along| (2.0 * along - 1.0) * (0.5 * width).tan());
    let norm = (1.0 + right * right + up * up).sqrt();
    Sight { origin: OBSERVER, direction: [right / norm, 1.0 / norm, up / norm] }
}

const BODY: Shape = Shape { centre: [0.0; 3], semi_axes: [1.0; 3] };

#[test]
fn pixels_of_a_pinhole_camera_are_mean_paths_around_a_sphere() {
    let bounds = Shape::sphere([0.0; 3], 2.5);
    let camera = Perspective::new(viewpoint([0.0; 3]), [0.9; 2], [0.0, 50.0]).unwrap();
    compare(camera, |xy| pinhole(xy, 0.9), bounds, &[BODY], [9, 12], 5e-4);
}

#[test]
fn pixels_of_parallel_lines_are_mean_paths_around_a_sphere() {
    let bounds = Shape::sphere([0.0; 3], 2.5);
    let camera = Orthographic::new(viewpoint([0.0; 3]), [5.5, 5.0], [-20.0, 30.0]).unwrap();
    let line = |[x, y]: [f64; 2]| Sight {
        origin: [5.5 * (x - 0.5), OBSERVER[1] - 20.0, 5.0 * (y - 0.5)],
        direction: [0.0, 1.0, 0.0],
    };
    compare(camera, line, bounds, &[BODY], [9, 12], 5e-4);
}

#[test]
fn the_body_and_the_bounds_may_be_ellipsoids_of_one_shape_beside_the_middle() {
    let centre = [0.6, 0.3, -0.4];
    let semi_axes = [1.0, 1.3, 0.7];
    let bounds = Shape { centre, semi_axes: semi_axes.map(|length| 2.0 * length) };
    let body = Shape { centre, semi_axes };
    let camera = Perspective::new(viewpoint([0.0; 3]), [0.8; 2], [0.0, 50.0]).unwrap();
    compare(camera, |xy| pinhole(xy, 0.8), bounds, &[body], [10, 10], 5e-4);
}

#[test]
fn bounds_beside_the_body_have_charts_of_their_own() {
    let bounds = Shape::sphere([0.5, 0.2, 0.3], 2.4);
    let camera = Perspective::new(viewpoint([0.0; 3]), [0.9; 2], [0.0, 50.0]).unwrap();
    compare(camera, |xy| pinhole(xy, 0.9), bounds, &[BODY], [9, 12], 5e-4);
}

#[test]
fn the_observer_may_be_inside_the_bounds() {
    let bounds = Shape::sphere([0.0; 3], 9.0);
    let camera = Perspective::new(viewpoint([0.0; 3]), [0.9; 2], [0.0, 50.0]).unwrap();
    compare(camera, |xy| pinhole(xy, 0.9), bounds, &[BODY], [9, 12], 5e-4);
}

#[test]
fn a_body_smaller_than_a_pixel_is_in_its_pixel() {
    let bounds = Shape::sphere([0.0; 3], 2.5);
    let body = Shape::sphere([0.11, -0.2, 0.07], 0.06);
    let camera = Perspective::new(viewpoint([0.0; 3]), [0.9; 2], [0.0, 50.0]).unwrap();
    compare(camera, |xy| pinhole(xy, 0.9), bounds, &[body], [7, 7], 5e-4);
}

#[test]
fn a_disc_with_a_body_at_its_rim_has_mean_paths_inside_of_it() {
    let (fov, bounds) = (0.9, Shape::sphere([1.0, 0.0, 1.5], 2.0));
    let body = Shape::sphere([1.8, 0.0, 1.3], 0.7);
    let mapping = DiscMapping::Equidistant;
    let camera = Fisheye::new(viewpoint([0.0; 3]), fov, mapping, [0.0, 50.0]).unwrap();
    let line = |[x, y]: [f64; 2]| {
        let [right, up] = [2.0 * x - 1.0, 2.0 * y - 1.0];
        let radius = right.hypot(up);
        let (sin, cos) = (0.5 * fov * radius).sin_cos();
        Sight { origin: OBSERVER, direction: [sin * right / radius, cos, sin * up / radius] }
    };
    compare(camera, line, bounds, &[body], [10, 9], 2e-3);
}

/// The part of each pixel that is in each part of a view.
fn shares(projection: &dyn Projection, shape: [usize; 2]) -> Vec<Image> {
    see(projection, shape, |Parts { parts, .. }| {
        let share = |footing: &Footing, raster: &Image| {
            footing.errors(uniform([raster.height(), raster.width()], 1.0))
        };
        parts.iter().map(|part| share(&part.footing, &part.scale)).collect()
    })
}

#[test]
fn a_body_has_its_solid_angle_and_the_sky_the_rest() {
    for (radius, target) in [(1.0, [0.0; 3]), (1.0, [0.7, 0.0, 0.9]), (0.02, [0.3, 0.0, 0.2])] {
        let body = Ellipsoid::sphere([0.0; 3], radius).unwrap();
        let camera = Perspective::new(viewpoint(target), [1.0, 0.9], [0.0, 50.0]).unwrap();
        let camera = camera.with_occulters(vec![body]).unwrap();
        let expected = TAU * (1.0 - (1.0 - (radius / 6.0_f64).powi(2)).sqrt());
        for shape in [[2, 2], [5, 7], [64, 64]] {
            let shares = shares(&camera, shape);
            assert_eq!(shares.len(), 2);
            let mut of_body = 0.0;
            for (pixel, share) in shares[0].pixels().iter().enumerate() {
                let corner = |row: usize, column: usize| {
                    [column as f64 / shape[1] as f64, row as f64 / shape[0] as f64]
                };
                let (row, column) = (pixel / shape[1], pixel % shape[1]);
                let solid_angle =
                    camera.solid_angle(corner(row, column), corner(row + 1, column + 1));
                of_body += share * solid_angle;
                assert_close(share + shares[1].pixels()[pixel], 1.0, 1e-12);
            }
            // Of a body below a part of a pixel, to so much of the pixel.
            let of_pixel = 0.9 / (shape[0] * shape[1]) as f64;
            assert_close(of_body, expected, (1e-5 * expected).max(1e-4 * of_pixel));
        }
    }
}

#[test]
fn windows_end_at_limbs_in_view_and_close_around_the_axis() {
    let body = Ellipsoid::sphere([0.0; 3], 1.0).unwrap();
    let around = |target: [f64; 3], width: f64| {
        let camera = Perspective::new(viewpoint(target), [width; 2], [0.0, 50.0]).unwrap();
        let camera = camera.with_occulters(vec![body]).unwrap();
        let tiles = [Tile { projection: &camera, shape: [32, 32], place: (0, 1) }];
        let atlas = atlas(&tiles, &[]).unwrap();
        let charts = Quadrature::new(Some(&atlas), &tiles).charts_in_view(&atlas).charts;
        charts.iter().map(|chart| (chart.chart, chart.window)).collect::<Vec<_>>()
    };
    let windows = around([0.0; 3], 0.6);
    // Chart 1 is behind the body.
    assert_eq!(windows.iter().map(|(chart, _)| *chart).collect::<Vec<_>>(), [0, 2]);
    let limb = (1.0_f64 / 6.0).acos();
    assert_close(windows[0].1.c[0], 0.0, 1e-300);
    assert_close(windows[0].1.c[1], limb, 1e-15);
    assert_close(windows[1].1.c[0], 0.0, 1e-300);
    // The corners are the farthest lines from the limb.
    let corner = (2.0_f64.sqrt() * 0.3_f64.tan()).atan() - (1.0_f64 / 6.0).asin();
    // The window extends a little beyond the nodes.
    let ratio = windows[1].1.c[1] / corner.sqrt();
    assert!(ratio <= 1.01 && ratio > 0.95, "{ratio}");
    assert!(windows.iter().all(|(_, window)| window.is_closed()));
    // Of a body to the left a part is in view, and on the sky less than half of the directions.
    let windows = around([2.0, 0.0, 0.0], 0.5);
    assert_eq!(windows.len(), 2);
    assert!(windows.iter().all(|(_, window)| window.azimuth_rad[1] < PI), "{windows:?}");
    assert!(windows[0].1.c[0] > 0.1, "{windows:?}");
    // Inside of the limb there is no sky.
    assert_eq!(around([0.0; 3], 0.2).len(), 1);
}

/// Pixels of a finer image are in the windows of a coarse one, and those beyond other windows are named.
#[test]
fn pixels_outside_windows_are_named() {
    let camera = Perspective::new(viewpoint([0.0; 3]), [0.6; 2], [1.0, 12.0]).unwrap();
    let body = Ellipsoid::sphere([0.0; 3], 1.0).unwrap();
    let camera = camera.with_occulters(vec![body]).unwrap();
    let [coarse, fine] =
        [32, 64].map(|pixels| [Tile { projection: &camera, shape: [pixels; 2], place: (0, 1) }]);
    let atlas = atlas(&coarse, &[]).unwrap();
    let charts = Quadrature::new(Some(&atlas), &coarse).charts_in_view(&atlas).charts;
    let windows: Vec<_> = charts.iter().map(|chart| (chart.chart, chart.window)).collect();
    let quadrature = Quadrature::new(Some(&atlas), &fine);
    let elsewhere = |windows: &[_]| quadrature.charts_in_windows(&atlas, windows).1;
    assert!(elsewhere(&windows).is_empty());
    // Without the chart of the sky its pixels are, of which the middle of the image is none.
    let beyond = elsewhere(&windows[..1]);
    assert!(beyond.contains(&0) && !beyond.contains(&(32 * 64 + 32)), "{}", beyond.len());
    let mut narrow = windows.clone();
    narrow[1].1.c[1] *= 0.8;
    let corners = elsewhere(&narrow);
    assert!(corners.contains(&0) && corners.len() < beyond.len(), "{}", corners.len());
}

#[test]
fn cells_in_view_have_the_largest_of_their_pixels() {
    let body = Ellipsoid::sphere([0.0; 3], 1.0).unwrap();
    let camera = Perspective::new(viewpoint([0.5, 0.0, 0.0]), [0.6; 2], [0.0, 50.0]).unwrap();
    let camera = camera.with_occulters(vec![body]).unwrap();
    let shape = [32, 32];
    let map = Image::from_pixels(32, 32, (0..1024).map(|pixel| 1.0 + f64::from(pixel)).collect());
    see(&camera, shape, |Parts { parts, outside, .. }| {
        assert!(outside.is_empty());
        for part in parts {
            let on_raster = part.on_raster(&map);
            let [rows, columns] = [part.scale.height(), part.scale.width()];
            assert_eq!([on_raster.height(), on_raster.width()], [rows, columns]);
            let mut seen = 0;
            for (cell, (value, scale)) in
                on_raster.pixels().iter().zip(part.scale.pixels()).enumerate()
            {
                assert!([0.0, 1.0].map(f64::to_bits).contains(&scale.to_bits()));
                if *value == 0.0 {
                    continue;
                }
                seen += 1;
                // Only what is in view has pixels, and one of the pixels around its middle.
                assert!(*scale > 0.0);
                let middle = [cell % columns, cell / columns];
                let middle = [
                    (middle[0] as f64 + 0.5) / columns as f64,
                    (middle[1] as f64 + 0.5) / rows as f64,
                ];
                let (tile, [x, y]) = part.chart.image_place(middle);
                let [row, column] = [y, x].map(|at| (32.0 * at).floor().min(31.0));
                let found = [((value - 1.0) / 32.0).floor(), (value - 1.0) % 32.0];
                let apart = (found[0] - row).abs().max((found[1] - column).abs());
                assert!(tile == 0 && apart <= 4.0, "{found:?} {row} {column}");
            }
            assert!(seen > 64, "{seen}");
        }
    });
}

#[test]
fn without_limbs_each_tile_is_a_part() {
    let camera = Perspective::new(viewpoint([0.0; 3]), [0.9; 2], [0.0, 50.0]).unwrap();
    let around = Bounds::Ellipsoid(Ellipsoid::sphere([0.0; 3], 9.0).unwrap());
    let camera = camera.with_bounds(around);
    let shape = [3, 4];
    let tiles = [0, 1].map(|number| Tile { projection: &camera, shape, place: (number, 2) });
    assert!(atlas(&tiles, &[]).is_none());
    let Parts { parts, outside, .. } = parts(&tiles, None, None);
    assert!(outside.is_empty() && parts.len() == 2);
    let map = Image::from_pixels(6, 4, (0..24).map(f64::from).collect());
    for (number, part) in parts.iter().enumerate() {
        let (first_row, image) =
            part.footing.image(|shape| vec![0.5; shape[0] * shape[1]], &part.scale);
        assert_eq!(first_row, 3 * number);
        let half = part.scale.pixels().iter().map(|scale| 0.5 * scale);
        assert_eq!(image, Image::from_pixels(3, 4, half.collect()));
        assert_eq!(part.on_raster(&map).pixels(), &map.pixels()[12 * number..12 * (number + 1)]);
        assert_eq!(part.chart.image_place([0.3, 0.4]), (number, [0.3, 0.4]));
        assert_eq!(part.pieces_of_line, 1);
    }
    assert!(ViewGeometry::surroundings(&camera).is_some());
}

#[test]
fn a_settled_quadrature_is_closer_to_the_mean_of_a_function_with_a_kink() {
    let body = Ellipsoid::sphere([0.0; 3], 1.0).unwrap();
    // All lines of the narrow image end at the body.
    let fov = [0.3 * 4.0 / 90.0, 0.3];
    let camera = Perspective::new(viewpoint([0.0; 3]), fov, [0.0, 50.0]).unwrap();
    let camera = camera.with_occulters(vec![body]).unwrap();
    let shape = [90, 4];
    let kinked = |u: f64| (u - 0.52).abs();
    let tiles = [Tile { projection: &camera, shape, place: (0, 1) }];
    let atlas = atlas(&tiles, &[]).unwrap();
    let view = parts(&tiles, Some(&atlas), None);
    assert_eq!(view.parts.len(), 1);
    // Exact means: half of the square of the distance from the kink is the integral.
    let integral = |u: f64| 0.5 * (u - 0.52) * (u - 0.52).abs();
    let of_raster = |[rows, columns]: [usize; 2]| -> Vec<f64> {
        let border = |k: usize| integral(k as f64 / columns as f64) * columns as f64;
        let row: Vec<f64> = (0..columns).map(|k| border(k + 1) - border(k)).collect();
        (0..rows).flat_map(|_| row.clone()).collect()
    };
    let image = |footing: &Footing| footing.image(of_raster, &view.parts[0].scale).1;
    let Footing::Nodes { window, .. } = &*view.parts[0].footing else {
        panic!("the part is the plane")
    };
    let allowed = 2e-6;
    let (footings, error) = view.settle(&|_, raster| of_raster(raster), allowed, None).unwrap();
    let [plain, settled] = [&view.parts[0].footing, &footings[0]].map(|footing| image(footing));
    let (mut before, mut after) = (0.0_f64, 0.0_f64);
    let mut pieces = Vec::new();
    for (pixel, settled) in settled.pixels().iter().enumerate() {
        let (mut sum, mut of_weights) = (0.0, 0.0);
        for xy in in_pixel(pixel, shape, 60) {
            let weight = camera.solid_angle_density(xy);
            atlas.pieces(&camera.line(xy).unwrap(), &mut pieces);
            sum += weight * kinked(window.unit(pieces[0].place)[0]);
            of_weights += weight;
        }
        let exact = sum / of_weights;
        before = before.max((plain.pixels()[pixel] - exact).abs());
        after = after.max((settled - exact).abs());
    }
    assert!(after < 0.3 * before, "{before} {after}");
    assert!(error.largest() > 0.0 && error.largest() < before, "{}", error.largest());
}
