//! Cameras of scenes: their keys, and what is wrong with them.

use super::cameras;
use crate::fits::{Wcs, WcsAxis};
use crate::scene::{Scene, SceneError};
use crate::units::Unit;
use crate::words::alternatives;
use emitree::projection::{Edge, Ellipsoid, Region, Singularity};
use emitree::{Perspective, Viewpoint};

/// A scene with the given lines in `[projection]`, and tables after it.
fn scene(projection: &str, tables: &str) -> Result<Scene, SceneError> {
    let image = match projection.contains("healpix") {
        true => "nside = 4",
        false => "width = 4\nheight = 4",
    };
    let text = format!(
        "emission.expression = \"x\"\nimage = {{ {} }}\n[projection]\n{projection}\n{tables}",
        image.replace('\n', ", ")
    );
    Scene::parse("scene.toml", &text, &[])
}

const LOOKING: &str = "position = [10, 0, 0]\ntarget = [0, 0, 0]\n";

/// Line (of the projection and the tables), message and expectation of an error.
fn error(projection: &str, tables: &str) -> (usize, String, String) {
    let error = scene(projection, tables).unwrap_err();
    let (_, line) = error.line().unwrap();
    (line - 3, error.message().to_owned(), error.expected().to_owned())
}

#[test]
fn the_keys_of_every_camera_are_its_coordinates() {
    let of = |lines: &str| {
        let camera = scene(lines, "").unwrap().camera;
        (camera.description().name, camera.wcs(4, 4, &Unit::one()))
    };
    let with = |lines: &str| of(&format!("{LOOKING}{lines}"));
    assert_eq!(of("type = \"canonical\""), ("canonical", Some(Wcs::canonical(4, 4))));
    let camera = with("type = \"orthographic\"\nextent = [4, 2]\nnear = -inf\nfar = inf");
    let wcs = Wcs::orthographic(4, 4, [4.0, 2.0], &Unit::one());
    assert_eq!(camera, ("orthographic", Some(wcs)));
    let camera = with("type = \"perspective\"\nfield_of_view = [20, 10]\nfar = inf");
    assert_eq!(camera, ("perspective", Some(Wcs::perspective(4, 4, [20.0, 10.0]))));
    let camera = with("type = \"equirectangular\"\nfield_of_view = [360, 180]\nfar = 20");
    assert_eq!(camera, ("equirectangular", Some(Wcs::equirectangular(4, 4, [360.0, 180.0]))));
    for angle in ["120", "[120.0]"] {
        let camera = with(&format!("type = \"polar\"\nfield_of_view = {angle}\nfar = 20"));
        assert_eq!(camera, ("polar", Some(Wcs::polar(4, 4, 120.0))));
    }
    let disc = "type = \"fisheye\"\nfield_of_view = 120\nfar = 20";
    for (mapping, equal_area) in
        [("", false), ("equidistant", false), ("ARC", false), ("equal_area", true), ("ZEA", true)]
    {
        let key = if mapping.is_empty() { "" } else { &format!("\nmapping = \"{mapping}\"") };
        let camera = with(&format!("{disc}{key}"));
        assert_eq!(camera, ("fisheye", Some(Wcs::fisheye(4, 4, 120.0, equal_area))));
    }
    let sky = "type = \"healpix\"\nposition = [0, 0, 0]\nfar = 20";
    assert_eq!(of(sky), ("healpix", None));
    let sky = scene(sky, "").unwrap();
    assert_eq!((sky.height, sky.width), (48, 4));
}

#[test]
fn an_unknown_camera_is_refused_with_those_that_there_are() {
    let names = alternatives(cameras().iter().map(|camera| format!("`{}`", camera.name)));
    assert!(names.starts_with("`canonical`, ") && names.ends_with("` or `healpix`"), "{names}");
    let found = error("type = \"kanonical\"", "");
    assert_eq!(
        found,
        (1, "unknown projection `kanonical`".to_owned(), format!("expected {names}"))
    );
    let (_, message, expected) = error("", "");
    assert_eq!(message, "`projection.type` is missing");
    assert_eq!(expected, format!("expected `type` here: {names}"));
    let text = "emission.expression = \"x\"";
    let error = Scene::parse("scene.toml", text, &[]).unwrap_err();
    assert_eq!(error.message(), "the scene has no `[projection]`");
    let expected = format!("expected a table `[projection]` with `type` = {names}");
    assert_eq!(error.expected(), expected);
}

#[test]
fn bounds_make_depths_optional() {
    let camera = format!("{LOOKING}type = \"perspective\"\nfield_of_view = [20, 20]");
    for bounds in [
        "type = \"sphere\"\ncenter = [0, 0, 0]\nradius = 2",
        "type = \"ellipsoid\"\ncenter = [0, 0, 0]\nsemi_axes = [2, 3, 4]\npole = [0, 1, 0]",
        "type = \"box\"\nmin = [-2, -2, -2]\nmax = [2, 2, 2]",
    ] {
        let scene = scene(&camera, &format!("[bounds]\n{bounds}")).unwrap();
        let middle = scene.camera.projection().world_from_canonical([0.5, 0.5, 0.5]);
        assert!(middle.position[0].abs() < 1e-6, "{bounds}: {middle:?}");
        assert!((middle.path_per_depth - 4.0).abs() < 1e-6, "{bounds}: {middle:?}");
    }
    // Parallel lines have all of the bounds, also what lies behind the viewpoint's plane.
    let camera = format!("{LOOKING}type = \"orthographic\"\nextent = [4, 4]");
    let bounds = "[bounds]\ntype = \"sphere\"\ncenter = [20, 0, 0]\nradius = 2";
    let scene = scene(&camera, bounds).unwrap();
    let middle = scene.camera.projection().world_from_canonical([0.5, 0.5, 0.5]);
    assert!((middle.position[0] - 20.0).abs() < 1e-6, "{middle:?}");
}

#[test]
fn bodies_hide_what_lies_behind() {
    let camera = format!("{LOOKING}type = \"perspective\"\nfield_of_view = [60, 60]\nfar = 30");
    let bodies = "[[occulter]]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 2\n\
                  [[occulter]]\ntype = \"ellipsoid\"\ncenter = [5, 0, 2]\nsemi_axes = [1, 1, 0.5]";
    let scene = scene(&camera, bodies).unwrap();
    let geometry = scene.camera.projection().view_geometry().unwrap();
    let region = |y: f64| geometry.region([0.5, y]);
    // In the order of the scene: the ellipsoid is above the middle.
    assert_eq!(region(0.5), Region::Body(0));
    assert_eq!(region(0.84), Region::Body(1));
    assert_eq!(region(0.1), Region::Sky);
    let cube =
        scene_of_cube("[[occulter]]\ntype = \"sphere\"\ncenter = [0.5, 0.5, 0.5]\nradius = 0.2");
    let geometry = cube.camera.projection().view_geometry().unwrap();
    assert_eq!(geometry.region([0.5, 0.5]), Region::Body(0));
    assert_eq!(cube.camera.description().name, "canonical");
}

#[test]
fn edges_of_the_scene_are_those_of_the_camera() {
    let keys = format!("{LOOKING}type = \"perspective\"\nfield_of_view = [60, 60]\nfar = 30");
    let edges = "[[edge]]\ntype = \"sphere\"\ncenter = [9, 0, 1]\nradius = 2\n\
                 [[edge]]\ntype = \"ellipsoid\"\ncenter = [5, 0, 2]\nsemi_axes = [1, 2, 0.5]\n\
                 pole = [0, 1, 0]\n\
                 [[edge]]\ntype = \"plane\"\nposition = [1, 2, 3]\nnormal = [0, 0, -2]";
    let edged = scene(&keys, edges).unwrap();
    let [position, target, up] = [[10.0, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0]];
    let viewpoint = Viewpoint { position, target, up };
    let camera = Perspective::new(viewpoint, [60_f64.to_radians(); 2], [0.0, 30.0]).unwrap();
    let ellipsoid = Ellipsoid::new([5.0, 0.0, 2.0], [1.0, 2.0, 0.5]).unwrap();
    let expected = camera.with_edges(vec![
        // Around the observer.
        Edge::Ellipsoid(Ellipsoid::sphere([9.0, 0.0, 1.0], 2.0).unwrap()),
        Edge::Ellipsoid(ellipsoid.oriented([0.0, 1.0, 0.0], [1.0, 0.0, 0.0]).unwrap()),
        Edge::plane([1.0, 2.0, 3.0], [0.0, 0.0, -1.0]).unwrap(),
    ]);
    // What is behind `dyn Projection` is compared by its fields.
    assert_eq!(format!("{:?}", edged.camera.projection()), format!("{expected:?}"));
    let bare = scene(&keys, "").unwrap();
    assert_ne!(format!("{:?}", bare.camera.projection()), format!("{expected:?}"));
}

#[test]
fn singularities_of_the_scene_are_those_of_the_camera() {
    let keys = format!("{LOOKING}type = \"perspective\"\nfield_of_view = [60, 60]\nfar = 30");
    let tables = "[[singularity]]\ntype = \"point\"\nposition = [1, 0, 2]\nexponent = 1.5\n\
                  [[singularity]]\ntype = \"axis\"\nposition = [0, 1, 0]\ndirection = [0, 0, 3]";
    let found = scene(&keys, tables).unwrap();
    let [position, target, up] = [[10.0, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0]];
    let viewpoint = Viewpoint { position, target, up };
    let camera = Perspective::new(viewpoint, [60_f64.to_radians(); 2], [0.0, 30.0]).unwrap();
    let point = Singularity::point([1.0, 0.0, 2.0]).unwrap().with_exponent(1.5).unwrap();
    let axis = Singularity::axis([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]).unwrap();
    let expected = camera.with_singularities(vec![point, axis]);
    assert_eq!(format!("{:?}", found.camera.projection()), format!("{expected:?}"));
    let is = |tables: &str, message: &str, expected: &str| {
        let found = error(&keys, &format!("[[singularity]]\n{tables}"));
        assert_eq!((found.1.as_str(), found.2.as_str()), (message, expected));
    };
    is(
        "type = \"ring\"\nposition = [0, 0, 0]",
        "unknown singularity `ring`",
        "expected `point` or `axis`",
    );
    is(
        "type = \"axis\"\nposition = [0, 0, 0]\ndirection = [0, 0, 0]",
        "`direction` is [0.0, 0.0, 0.0]: expected a finite vector that is not zero",
        "",
    );
    is(
        "type = \"point\"\nposition = [0, 0, 0]\nexponent = 3",
        "`exponent` is 3: expected a number from 0 to below 3, so that the integral is finite",
        "",
    );
}

/// The spheres of a model are edges in the unit of the scene, but for the surface of a body.
#[test]
fn edges_of_a_model_are_those_of_the_camera() {
    let camera = |tables: &str| {
        let text = format!(
            "emission.model = \"geocorona\"\nimage = {{ width = 4, height = 4 }}\n[projection]\n\
             type = \"perspective\"\nlength_unit = \"km\"\nposition = [95565, 0, 0]\ntarget = [0, 0, 0]\n\
             field_of_view = [60, 60]\nfar = 1e6\n{tables}"
        );
        let scene = Scene::parse("scene.toml", &text, &[]).unwrap();
        format!("{:?}", scene.camera.projection())
    };
    let [position, target, up] = [[95565.0, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0]];
    let viewpoint = Viewpoint { position, target, up };
    let bare = Perspective::new(viewpoint, [60_f64.to_radians(); 2], [0.0, 1e6]).unwrap();
    let sphere = |radius| Ellipsoid::sphere([0.0; 3], radius).unwrap();
    // 1 R_E is 6371 km here, and one in the other direction is rounded.
    let of_radii = |radii: &[f64]| {
        let factor = 1.0 / 6371.0;
        radii.iter().map(|radius| Edge::Ellipsoid(sphere(radius / factor))).collect::<Vec<_>>()
    };
    let edged = bare.clone().with_edges(of_radii(&[1.08, 12.0]));
    assert_eq!(camera(""), format!("{edged:?}"));
    let exobase = 1.08 * 6371.0;
    let table =
        |key: &str| format!("{key}\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = {exobase}");
    let bodied = bare.with_occulters(vec![sphere(exobase)]).unwrap();
    let bodied = bodied.with_edges(of_radii(&[12.0]));
    assert_eq!(camera(&table("[[occulter]]")), format!("{bodied:?}"));
    let found = camera(&table("[[edge]]"));
    assert_eq!(found.matches("Ellipsoid(").count(), 2, "{found}");
}

fn scene_of_cube(tables: &str) -> Scene {
    scene("type = \"canonical\"", tables).unwrap()
}

#[test]
fn keys_are_checked_where_they_stand() {
    let camera = |lines: &str| format!("type = \"perspective\"\n{LOOKING}{lines}");
    let is = |found: (usize, String, String), line, message: &str, expected: &str| {
        assert_eq!(found, (line, message.to_owned(), expected.to_owned()));
    };
    let angles = "expected two angles [width, height] in degrees";
    let found = error(&camera("field_of_view = 20\nfar = 3"), "");
    is(found, 4, "`projection.field_of_view` is an integer", angles);
    let found = error(&camera("field_of_view = [20, 180]\nfar = 3"), "");
    let message = "`[projection]`: `field_of_view` is 180: expected a width and a height above 0 \
                   and at most 178 degrees, since a flat screen is too wide beyond (for more of \
                   the sky: `fisheye` or `equirectangular`)";
    is(found, 4, message, "");
    let found = error(&camera("field_of_view = [20, 20]\nnear = -1\nfar = 3"), "");
    is(found, 5, "`[projection]`: `near` is -1: expected a finite depth of 0 or more", "");
    let found = error(&camera("field_of_view = [20, 20]\nfar = nan"), "");
    is(found, 5, "`projection.far` is NaN", "expected a finite number");
    let found = error(&camera("field_of_view = [20, 20]"), "");
    assert_eq!(found.1, "`projection.far` is missing");
    let disc = format!("type = \"fisheye\"\n{LOOKING}field_of_view = 120\nfar = 3\n");
    let found = error(&format!("{disc}mapping = \"stereographic\""), "");
    let mappings = "expected `equidistant` (ARC) or `equal_area` (ZEA)";
    is(found, 6, "unknown mapping `stereographic`", mappings);
}

#[test]
fn shapes_are_checked_where_they_stand() {
    let camera = format!("type = \"perspective\"\n{LOOKING}field_of_view = [20, 20]\nfar = 30");
    let of_shape = |tables: &str| {
        let (line, message, expected) = error(&camera, tables);
        (line - 5, message, expected)
    };
    let is = |found: (usize, String, String), line, message: &str, expected: &str| {
        assert_eq!(found, (line, message.to_owned(), expected.to_owned()));
    };
    let body = "[[occulter]]\ntype = \"cube\"";
    is(of_shape(body), 2, "unknown body `cube`", "expected `sphere` or `ellipsoid`");
    let body = "[[occulter]]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = -1";
    is(of_shape(body), 4, "`radius` is -1: expected a finite length above 0", "");
    let body = "[[occulter]]\ntype = \"sphere\"\ncenter = [9, 0, 0]\nradius = 2";
    let message = "the observer at [10.0, 0.0, 0.0] is inside occulter 1, or on its surface: \
                   expected a position outside of all opaque bodies";
    is(of_shape(body), 1, message, "");
    let body = "[[occulter]]\ntype = \"ellipsoid\"\ncenter = [0, 0, 0]\nsemi_axes = [1, 2, 3]\n\
                pole = [1, 0, 0]";
    let message = "`meridian` is [1.0, 0.0, 0.0]: expected a direction across `pole`";
    is(of_shape(body), 5, message, "");
    let bounds = "[bounds]\ntype = \"box\"\nmin = [0, 0, 0]\nmax = [1, -1, 1]";
    let message = "`max` is [1.0, -1.0, 1.0]: expected three finite coordinates, each above that \
                   of `min`";
    is(of_shape(bounds), 4, message, "");
    let bounds = "[bounds]\ntype = \"cylinder\"";
    is(of_shape(bounds), 2, "unknown shape `cylinder`", "expected `sphere`, `ellipsoid` or `box`");
    let (_, message, _) = of_shape("[[occulter]]\ntype = \"sphere\"\nradius = 2");
    assert_eq!(message, "`occulter[0].center` is missing");
}

#[test]
fn edges_are_checked_where_they_stand() {
    let camera = format!("type = \"perspective\"\n{LOOKING}field_of_view = [20, 20]\nfar = 30");
    for (lines, line, message, expected) in [
        ("type = \"box\"", 2, "unknown edge `box`", "expected `sphere`, `ellipsoid` or `plane`"),
        (
            "center = [0, 0, 0]",
            1,
            "`edge[0].type` is missing",
            "expected `type` here: `sphere`, `ellipsoid` or `plane`",
        ),
        (
            "type = \"sphere\"\ncenter = [0, 0, 0]\nradius = 0",
            4,
            "`radius` is 0: expected a finite length above 0",
            "",
        ),
        (
            "type = \"plane\"\nnormal = [0, 0, 1]",
            1,
            "`edge[0].position` is missing",
            "expected `position` here: three numbers [x, y, z] in `length_unit`",
        ),
        (
            "type = \"plane\"\nposition = [0, 0, 0]",
            1,
            "`edge[0].normal` is missing",
            "expected `normal` here: three numbers [x, y, z]",
        ),
        (
            "type = \"plane\"\nposition = [0, 0, 0]\nnormal = [0, 0, 0]",
            4,
            "`normal` is [0.0, 0.0, 0.0]: expected a finite vector that is not zero",
            "",
        ),
        (
            "type = \"plane\"\nposition = [0, 0, 0]\nnormal = [0, 1]",
            4,
            "`edge[0].normal` is an array of 2",
            "expected three numbers [x, y, z]",
        ),
        (
            "type = \"plane\"\nposition = 3\nnormal = [0, 0, 1]",
            3,
            "`edge[0].position` is an integer",
            "expected three numbers [x, y, z] in `length_unit`",
        ),
        (
            "type = \"plane\"\nposition = [0, 0, 0]\nnormal = [0, 0, 1]\nradius = 1",
            5,
            "unknown key `edge[0].radius`",
            "expected one of `type`, `position`, `normal`",
        ),
    ] {
        let (found, text, label) = error(&camera, &format!("[[edge]]\n{lines}"));
        assert_eq!((found - 5, text, label), (line, message.to_owned(), expected.to_owned()));
    }
    let (_, message, expected) = error(&camera, "[edge]\ntype = \"plane\"");
    assert_eq!(message, "`edge` is a table");
    assert_eq!(expected, "expected tables `[[edge]]`, each with a `type`");
}

#[test]
fn a_sky_has_its_own_image() {
    let sky = "type = \"healpix\"\nposition = [0, 0, 0]\nfar = 20";
    let text = |image: &str| {
        format!("emission.expression = \"x\"\nimage = {{ {image} }}\n[projection]\n{sky}")
    };
    let message = |image: &str| {
        let error = Scene::parse("scene.toml", &text(image), &[]).unwrap_err();
        (error.message().to_owned(), error.expected().to_owned())
    };
    let expected = "expected a power of two, 1 to 2^13: pixels along the edge of a face".to_owned();
    assert_eq!(message("nside = 12"), ("`image.nside` is 12".to_owned(), expected));
    let (found, _) = message("width = 4, height = 4");
    assert_eq!(found, "`image.nside` is missing");
}

fn world(axis: &WcsAxis, pixel: f64) -> f64 {
    axis.crval + axis.cdelt * (pixel - axis.crpix)
}

#[test]
fn corners_of_the_canonical_image_are_zero_and_one() {
    let wcs = Wcs::canonical(3, 7);
    for (axis, pixels) in wcs.axes.iter().zip([7.0, 3.0]) {
        assert!(world(axis, 0.5).abs() < 1e-15);
        assert!((world(axis, pixels + 0.5) - 1.0).abs() < 1e-15);
    }
}

#[test]
fn edges_of_the_equirectangular_image_are_half_the_field_of_view() {
    let wcs = Wcs::equirectangular(100, 50, [16.0, 27.0]);
    for (axis, (pixels, extent)) in wcs.axes.iter().zip([(50.0, 16.0), (100.0, 27.0)]) {
        assert!((world(axis, 0.5) + extent / 2.0).abs() < 1e-14);
        assert!((world(axis, pixels + 0.5) - extent / 2.0).abs() < 1e-14);
    }
}

#[test]
fn edges_of_a_perspective_image_are_tangents() {
    let wcs = Wcs::perspective(60, 100, [100.0, 60.0]);
    for (axis, (pixels, half_fov_deg)) in wcs.axes.iter().zip([(100.0, 50.0_f64), (60.0, 30.0)]) {
        let tangent = world(axis, pixels + 0.5).to_radians();
        assert!((tangent - half_fov_deg.to_radians().tan()).abs() < 1e-15);
        assert!((world(axis, 0.5).to_radians() + tangent).abs() < 1e-15);
    }
}

#[test]
fn the_rim_of_a_fisheye_is_at_half_the_field_of_view() {
    for (fov_deg, radius_deg) in [(180.0, 2_f64.sqrt().to_degrees()), (360.0, 2_f64.to_degrees())] {
        let wcs = Wcs::fisheye(40, 30, fov_deg, true);
        for (axis, pixels) in wcs.axes.iter().zip([30.0, 40.0]) {
            assert!((world(axis, pixels + 0.5) - radius_deg).abs() < 1e-13);
        }
    }
    let wcs = Wcs::fisheye(40, 30, 220.0, false);
    assert!((world(&wcs.axes[1], 40.5) - 110.0).abs() < 1e-13);
}

#[test]
fn polar_axes_start_at_zero() {
    let wcs = Wcs::polar(40, 30, 220.0);
    for (axis, (pixels, end)) in wcs.axes.iter().zip([(30.0, 360.0), (40.0, 110.0)]) {
        assert!(world(axis, 0.5).abs() < 1e-13);
        assert!((world(axis, pixels + 0.5) - end).abs() < 1e-13);
    }
}

#[test]
fn pure_numbers_have_no_unit() {
    let wcs = Wcs::orthographic(10, 10, [2.0, 2.0], &Unit::one());
    assert_eq!(wcs.axes[1].cunit, None);
    assert!((world(&wcs.axes[1], 10.5) - 1.0).abs() < 1e-15);
}
