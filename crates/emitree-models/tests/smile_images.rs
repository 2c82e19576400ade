//! The SMILE view by both methods of the paper, against images computed by
//! `reference/smile_view1.py`.
#![expect(clippy::unwrap_used, reason = "what fails here fails the test")]

use emitree::los::{LosOptions, Steps};
use emitree::refinement::Threshold;
use emitree::tree::BuildOptions;
use emitree::{Equirectangular, Image, Method, RenderOptions, Rendering, Viewpoint, render};
use emitree_models::build_model;
use std::collections::BTreeMap;

/// Pixels (row, column), converged and by the midpoint rule in steps of 0.5 R_E, centre lines.
fn reference() -> Vec<((usize, usize), f64, f64)> {
    let pixel = |line: &str| {
        let [row, column, converged, midpoint] =
            line.split(',').collect::<Vec<_>>().try_into().unwrap();
        let at = (row.parse().unwrap(), column.parse().unwrap());
        (at, converged.parse().unwrap(), midpoint.parse().unwrap())
    };
    include_str!("reference/smile_view1.csv").lines().skip(1).map(pixel).collect()
}

fn render_view_1(model: &str, method: Method) -> Rendering {
    let viewpoint =
        Viewpoint { position: [10.0, -30.0, 0.0], target: [6.0, 0.0, 0.0], up: [0.0, 0.0, 1.0] };
    let fov_rad = [16_f64.to_radians(), 27_f64.to_radians()];
    let camera = Equirectangular::new(viewpoint, fov_rad, [0.0, 80.0]).unwrap();
    let emission = build_model(model, &BTreeMap::new()).unwrap();
    render(&emission, &camera, [100, 50], &RenderOptions::new(method)).unwrap()
}

fn los(lines: usize, steps: usize) -> Method {
    Method::Los(LosOptions::new(lines, Steps::Fixed(steps)))
}

fn largest(image: &Image) -> f64 {
    image.min_max().1
}

/// What the community does: one line for each pixel, 160 steps of 0.5 R_E, 800 000 evaluations.
#[test]
fn lines_of_sight_give_the_image_of_the_community() {
    let rendering = render_view_1("cmem", los(1, 160));
    assert_eq!(rendering.stats.evaluations, 800_000);
    for (at, _, midpoint) in reference() {
        let pixel = rendering.values[at];
        assert!((pixel / midpoint - 1.0).abs() < 1e-12, "{at:?}: {pixel}, {midpoint}");
    }
    // The independent image has its largest pixel, 6.582783, at row 0, column 35.
    assert!((largest(&rendering.values) - 6.582_783).abs() < 1e-6);
    assert!((rendering.values[(0, 35)] - 6.582_783).abs() < 1e-6);
}

/// The largest mean over a pixel is 6.4742 in the independent image of 8 × 8 lines for each pixel.
#[test]
fn many_lines_converge_to_the_largest_pixel() {
    let rendering = render_view_1("cmem", los(4, 400));
    assert!((largest(&rendering.values) / 6.474_2 - 1.0).abs() < 2e-3);
}

/// The jumps at magnetopause and bow shock leave a few per cent at this finest level.
#[test]
fn the_paper_method_gives_the_same_image_to_a_few_per_cent() {
    let options =
        BuildOptions::new(Threshold::Relative(0.01)).with_base_level(4).with_finest_level(8);
    for model in ["cmem", "jorgensen"] {
        let rendering = render_view_1(model, Method::Paper(options));
        let lines = render_view_1(model, los(3, 240)).values;
        let scale = largest(&lines);
        let error = rendering.values.max_difference(&lines) / scale;
        assert!(error < 0.05, "{model}: {error}");
        let squares = rendering.values.pixels().iter().zip(lines.pixels());
        let square: f64 = squares.map(|(a, b)| (a - b).powi(2)).sum();
        let rms = (square / 5_000.0).sqrt() / scale;
        assert!(rms < 0.01, "{model}: {rms}");
        if model == "cmem" {
            for (at, converged, _) in reference() {
                let pixel = rendering.values[at];
                assert!((pixel - converged).abs() < 0.04 * scale, "{at:?}: {pixel}");
            }
        }
    }
}
