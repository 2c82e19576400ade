//! Sweeps: images of one model for many values of its parameters.

use emitree::sweep::Sweep;
use emitree::{
    Canonical, Emission, FromFn, Image, Method, RenderError, RenderOptions, Samples, VolOptions,
    los::LosOptions, render,
};
use std::sync::atomic::{AtomicU64, Ordering};

const SHAPE: [usize; 2] = [32, 40];

fn vol(tolerance: f64) -> RenderOptions<'static> {
    RenderOptions::new(VolOptions::new(tolerance))
}

/// A torus in the unit cube; its radius, width and brightness.
fn torus([radius, width, brightness]: [f64; 3]) -> impl Fn([f64; 3]) -> f64 {
    move |[x, y, z]: [f64; 3]| {
        let across = (x - 0.5).hypot(0.6 * (y - 0.5) + 0.8 * (z - 0.5)) - radius;
        let along = 0.8 * (y - 0.5) - 0.6 * (z - 0.5);
        brightness * (-(across * across + along * along) / (width * width)).exp()
    }
}

/// Images by numbers, how many converged, and all evaluations, counted by the emissions.
struct Swept {
    images: Vec<Option<Image>>,
    converged: usize,
    evaluations: u64,
}

fn swept(parameters: &[[f64; 3]], options: &RenderOptions<'_>) -> Swept {
    let calls = AtomicU64::new(0);
    let mut sweep = Sweep::new(&parameters.iter().map(|of| of.to_vec()).collect::<Vec<_>>());
    let mut images = vec![None; parameters.len()];
    let (mut converged, mut of_renderings) = (0, 0);
    while let Some(number) = sweep.next_image() {
        let rate = torus(parameters[number]);
        let emission = FromFn(|at, _| {
            calls.fetch_add(1, Ordering::Relaxed);
            rate(at)
        });
        let found = sweep.step(&emission, &Canonical, SHAPE, None, options).unwrap();
        let Some(found) = found else { continue };
        converged += usize::from(found.converged());
        of_renderings += found.stats.evaluations;
        assert!(images[number].is_none(), "image {number} twice");
        images[number] = Some(found.values.bands()[0].clone());
    }
    let evaluations = sweep.evaluations();
    assert_eq!(evaluations, calls.into_inner());
    assert_eq!(evaluations, of_renderings, "the sum of those of all images");
    Swept { images, converged, evaluations }
}

/// The largest error over the largest pixel, by lines of sight: Simpson's rule on 256 intervals of depth and 4
/// Gauss points across a pixel, whose error is below 1e-6 here.
fn error(image: &Image, parameters: [f64; 3]) -> f64 {
    let rate = torus(parameters);
    let intervals = 256;
    let along = |x: f64, y: f64| -> f64 {
        let weight = |k: u32| match k {
            0 => 1.0,
            k if k == intervals => 1.0,
            k if k % 2 == 1 => 4.0,
            _ => 2.0,
        };
        let at = |k: u32| weight(k) * rate([x, y, f64::from(k) / f64::from(intervals)]);
        (0..=intervals).map(at).sum::<f64>() / (3.0 * f64::from(intervals))
    };
    let [height, width] = SHAPE;
    let offsets = [0.5 - 0.75_f64.sqrt() / 3.0, 0.5 + 0.75_f64.sqrt() / 3.0];
    let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
    for row in (0..height).step_by(3) {
        for column in (0..width).step_by(3) {
            let nodes = offsets.iter().flat_map(|v| offsets.iter().map(move |u| [*u, *v]));
            let values = nodes.map(|[u, v]| {
                along((column as f64 + u) / width as f64, (row as f64 + v) / height as f64)
            });
            let exact = values.sum::<f64>() / 4.0;
            worst = worst.max((image[(row, column)] - exact).abs());
            largest = largest.max(exact);
        }
    }
    worst / largest
}

/// The evaluations of images one by one.
fn one_by_one(parameters: &[[f64; 3]], options: &RenderOptions<'_>) -> u64 {
    let of_one = |of: &[f64; 3]| {
        let rate = torus(*of);
        render(&FromFn(|at, _| rate(at)), &Canonical, SHAPE, options).unwrap().stats.evaluations
    };
    parameters.iter().map(of_one).sum()
}

fn over(count: u32, of: impl Fn(f64) -> [f64; 3]) -> Vec<[f64; 3]> {
    (0..count).map(|i| of(f64::from(i) / f64::from(count - 1))).collect()
}

/// Every image is within the tolerance, for a third of the evaluations.
#[test]
fn similar_values_take_a_third_of_the_evaluations() {
    let cases = [
        ("radius", over(11, |at| [0.24 + 0.03 * at, 0.12, 1.0])),
        ("brightness", over(11, |at| [0.25, 0.12, 1.0 + 9.0 * at])),
    ];
    for (name, parameters) in cases {
        let of_sweep = swept(&parameters, &vol(0.01));
        assert_eq!(of_sweep.converged, parameters.len());
        for (image, parameters) in of_sweep.images.iter().zip(&parameters) {
            let error = error(image.as_ref().unwrap(), *parameters);
            assert!(error < 0.01, "{name} {parameters:?}: {error}");
        }
        let alone = one_by_one(&parameters, &vol(0.01));
        let ratio = of_sweep.evaluations as f64 / alone as f64;
        assert!(3 * of_sweep.evaluations < alone, "{name}: {ratio}");
    }
}

/// Values far from each other: every image within the tolerance, and little more than one by one.
#[test]
fn distant_values_are_rendered_anew() {
    let parameters = over(7, |at| [0.05 + 0.35 * at, 0.3 - 0.22 * at, 1.0]);
    let of_sweep = swept(&parameters, &vol(0.01));
    assert_eq!(of_sweep.converged, parameters.len());
    for (image, parameters) in of_sweep.images.iter().zip(&parameters) {
        let error = error(image.as_ref().unwrap(), *parameters);
        assert!(error < 0.01, "{parameters:?}: {error}");
    }
    let alone = one_by_one(&parameters, &vol(0.01));
    let ratio = of_sweep.evaluations as f64 / alone as f64;
    assert!(ratio < 1.1, "{ratio}");
}

/// Other methods have no meshes for other emissions: images are those of single renderings, bit by bit.
#[test]
fn lines_of_sight_are_rendered_one_by_one() {
    let parameters = over(3, |at| [0.2 + 0.1 * at, 0.12, 1.0]);
    let options = RenderOptions::new(Method::Los(LosOptions::default()));
    let of_sweep = swept(&parameters, &options);
    for (image, of) in of_sweep.images.iter().zip(&parameters) {
        let rate = torus(*of);
        let alone = render(&FromFn(|at, _| rate(at)), &Canonical, SHAPE, &options).unwrap();
        assert_eq!(image.as_ref(), Some(&alone.values));
    }
    assert_eq!(of_sweep.evaluations, one_by_one(&parameters, &options));
}

/// A ball that fails at some widths.
struct Failing(f64);

#[derive(Debug, PartialEq, thiserror::Error)]
#[error("no rates of this width")]
struct NoRates;

impl Emission for Failing {
    type Error = NoRates;

    fn emission_rates(&self, samples: &Samples<'_>, rates: &mut [f64]) -> Result<(), NoRates> {
        if self.0 > 0.21 {
            return Err(NoRates);
        }
        for (rate, at) in rates.iter_mut().zip(samples.positions()) {
            *rate = (-at.iter().map(|x| (x - 0.5).powi(2)).sum::<f64>() / self.0.powi(2)).exp();
        }
        Ok(())
    }
}

/// An emission that fails has no image; the others have.
#[test]
fn an_emission_that_fails_is_left_out() {
    let widths = [0.18, 0.19, 0.2, 0.21, 0.22];
    let mut sweep = Sweep::new(&widths.map(|width| vec![width]));
    let mut found = Vec::new();
    while let Some(number) = sweep.next_image() {
        match sweep.step(&Failing(widths[number]), &Canonical, SHAPE, None, &vol(0.01)) {
            Ok(Some(rendering)) => {
                assert!(rendering.converged());
                found.push(number);
            }
            Ok(None) => {}
            Err(error) => {
                assert_eq!((number, error), (4, RenderError::Emission(NoRates)));
            }
        }
    }
    found.sort_unstable();
    assert_eq!(found, [0, 1, 2, 3]);
}

/// A callback may end a rendering, and receives the evaluations of all images.
#[test]
fn progress_is_that_of_all_images() {
    let parameters = over(3, |at| [0.24 + 0.02 * at, 0.12, 1.0]);
    let most = AtomicU64::new(0);
    let progress = |evaluations| {
        most.fetch_max(evaluations, Ordering::Relaxed);
        core::ops::ControlFlow::Continue(())
    };
    let of_sweep = swept(&parameters, &vol(0.01).with_progress(&progress));
    assert_eq!(most.into_inner(), of_sweep.evaluations);
    let interrupt = |_| core::ops::ControlFlow::Break(());
    let options = vol(0.01).with_progress(&interrupt);
    let mut sweep = Sweep::new(&[vec![1.0], vec![2.0]]);
    let rate = torus(parameters[0]);
    let result = sweep.step(&FromFn(|at, _| rate(at)), &Canonical, SHAPE, None, &options);
    assert_eq!(result.err(), Some(RenderError::Interrupted));
}
