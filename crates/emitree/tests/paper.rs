//! What the paper states of eq. (8) on 64 × 64 pixels: its Figures 9, 10 and 11, and design facts.

use emitree::tree::BuildOptions;
use emitree::{
    Canonical, FromFn, LosOptions, Method, RenderOptions, Rendering, Steps, Threshold, render,
};
use emitree_problems::{equation8, relative_error};

#[expect(clippy::unwrap_used, reason = "a helper of tests")]
fn render_equation8(method: Method) -> (Rendering, f64) {
    let emission = FromFn(|position, _| equation8::rate(position, equation8::ALPHA));
    let rendering = render(&emission, &Canonical, [64, 64], &RenderOptions::new(method)).unwrap();
    let exact = equation8::exact_image(equation8::ALPHA, [64, 64]);
    let error = relative_error(&rendering.image, &exact);
    (rendering, error)
}

fn paper(base_level: u8, threshold: f64) -> (Rendering, f64) {
    let threshold = Threshold::Absolute(threshold);
    render_equation8(Method::Paper(BuildOptions {
        base_level,
        threshold,
        ..BuildOptions::default()
    }))
}

fn los(lines: usize, steps: usize) -> (Rendering, f64) {
    render_equation8(Method::Los(LosOptions {
        lines,
        steps: Steps::Fixed(steps),
    }))
}

/// Fig. 9: "only 4032 function evaluations (less than one per pixel) gives a 6% error".
#[test]
fn figure_9_six_per_cent_for_less_than_one_evaluation_a_pixel() {
    let (rendering, error) = paper(2, 0.038);
    assert_eq!(rendering.evaluations, 4_032);
    assert!(error <= 0.06, "{error}");
}

/// Fig. 10: 1 % for 20 000 evaluations, and the numbers of the design's prototype.
#[test]
fn figure_10_one_per_cent_for_twenty_thousand_evaluations() {
    let expected = [
        (0.02, 11_328, 0.012),
        (0.01, 19_136, 0.006_1),
        (0.001, 272_000, 0.001),
    ];
    for (threshold, evaluations, largest_error) in expected {
        let (rendering, error) = paper(3, threshold);
        assert_eq!(rendering.evaluations, evaluations, "threshold {threshold}");
        assert!(
            error <= 1.05 * largest_error,
            "threshold {threshold}: {error}"
        );
    }
}

/// Fig. 10: lines of sight in equal steps need about ten times as many for 1 %.
#[test]
fn figure_10_lines_of_sight_need_eight_times_as_many() {
    let cheapest_los = [8, 9, 10, 11, 12, 13, 14, 16]
        .map(|steps| los(1, steps))
        .into_iter()
        .find(|(_, error)| *error <= 0.01);
    let thresholds = (0..24).map(|i| 0.3 * 0.8_f64.powi(i));
    let cheapest_paper = thresholds
        .map(|threshold| paper(2, threshold))
        .find(|(_, error)| *error <= 0.01);
    let evaluations = |found: Option<(Rendering, f64)>| found.unwrap().0.evaluations;
    let (los, paper) = (evaluations(cheapest_los), evaluations(cheapest_paper));
    assert!(los >= 8 * paper, "los {los}, paper {paper}");
}

/// Fig. 11: the error falls steadily with the threshold.
#[test]
fn figure_11_the_error_falls_with_the_threshold() {
    let errors: Vec<f64> = [0.1, 0.03, 0.01, 0.003, 0.001]
        .iter()
        .map(|&threshold| paper(3, threshold).1)
        .collect();
    assert!(
        errors.windows(2).all(|pair| pair[1] < pair[0]),
        "{errors:?}"
    );
    assert!(errors[0] / errors[4] > 20.0, "{errors:?}");
}

/// The design's measurements of the fixed-step line of sight.
#[test]
fn equal_steps_have_the_errors_of_the_prototype() {
    for (lines, steps, evaluations, expected) in [
        (1, 8, 32_768, 0.041),
        (1, 16, 65_536, 0.004_3),
        (2, 16, 262_144, 0.001_1),
    ] {
        let (rendering, error) = los(lines, steps);
        assert_eq!(rendering.evaluations, evaluations);
        assert!(
            (error / expected - 1.0).abs() < 0.05,
            "{evaluations}: {error}"
        );
    }
}
