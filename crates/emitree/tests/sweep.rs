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

/// A torus in the unit cube.
#[derive(Clone, Copy, Debug)]
struct Torus {
    radius: f64,
    width: f64,
    tilt_rad: f64,
    brightness: f64,
}

impl Torus {
    fn rate(self, at: [f64; 3]) -> f64 {
        let ([x, y, z], (sine, cosine)) = (at.map(|x| x - 0.5), self.tilt_rad.sin_cos());
        let across = x.hypot(cosine * y + sine * z) - self.radius;
        let along = cosine * z - sine * y;
        self.brightness * (-(across * across + along * along) / self.width.powi(2)).exp()
    }

    fn parameters(self) -> Vec<f64> {
        vec![self.radius, self.width, self.tilt_rad, self.brightness]
    }
}

const TORUS: Torus = Torus { radius: 0.27, width: 0.08, tilt_rad: 0.25, brightness: 1.0 };

/// Images by numbers, how many converged, and all evaluations, counted by the emissions.
struct Swept {
    images: Vec<Option<Image>>,
    converged: usize,
    evaluations: u64,
}

#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn swept(tori: &[Torus], options: &RenderOptions<'_>) -> Swept {
    let calls = AtomicU64::new(0);
    let mut sweep = Sweep::new(&tori.iter().map(|of| of.parameters()).collect::<Vec<_>>());
    let mut images = vec![None; tori.len()];
    let (mut converged, mut of_renderings) = (0, 0);
    while let Some(number) = sweep.next_image() {
        let emission = FromFn(|at, _| {
            calls.fetch_add(1, Ordering::Relaxed);
            tori[number].rate(at)
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
fn error(image: &Image, torus: Torus) -> f64 {
    let intervals = 256;
    let along = |x: f64, y: f64| -> f64 {
        let weight = |k: u32| match k {
            0 => 1.0,
            k if k == intervals => 1.0,
            k if k % 2 == 1 => 4.0,
            _ => 2.0,
        };
        let at = |k: u32| weight(k) * torus.rate([x, y, f64::from(k) / f64::from(intervals)]);
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
#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn one_by_one(tori: &[Torus], options: &RenderOptions<'_>) -> u64 {
    let of_one = |of: &Torus| {
        render(&FromFn(|at, _| of.rate(at)), &Canonical, SHAPE, options).unwrap().stats.evaluations
    };
    tori.iter().map(of_one).sum()
}

fn over(count: u32, of: impl Fn(f64) -> Torus) -> Vec<Torus> {
    (0..count).map(|i| of(f64::from(i) / f64::from(count - 1))).collect()
}

/// Every image is within the tolerance, for a third of the evaluations.
#[test]
fn similar_values_take_a_third_of_the_evaluations() {
    let cases = [
        ("tilt", over(11, |at| Torus { tilt_rad: 0.2 + 0.1 * at, ..TORUS })),
        ("brightness", over(11, |at| Torus { brightness: 1.0 + 9.0 * at, ..TORUS })),
    ];
    for (name, tori) in cases {
        let of_sweep = swept(&tori, &vol(0.01));
        assert_eq!(of_sweep.converged, tori.len());
        for (image, torus) in of_sweep.images.iter().zip(&tori) {
            let error = error(image.as_ref().unwrap(), *torus);
            assert!(error < 0.01, "{name} {torus:?}: {error}");
        }
        let alone = one_by_one(&tori, &vol(0.01));
        let ratio = of_sweep.evaluations as f64 / alone as f64;
        assert!(3 * of_sweep.evaluations < alone, "{name}: {ratio}");
    }
}

/// Values far from each other: every image within the tolerance, and at most 15 % more than one by one, which evaluates
/// no point twice either.
#[test]
fn distant_values_are_rendered_anew() {
    let tori = over(7, |at| Torus { radius: 0.05 + 0.35 * at, width: 0.3 - 0.22 * at, ..TORUS });
    let of_sweep = swept(&tori, &vol(0.01));
    assert_eq!(of_sweep.converged, tori.len());
    for (image, torus) in of_sweep.images.iter().zip(&tori) {
        let error = error(image.as_ref().unwrap(), *torus);
        assert!(error < 0.01, "{torus:?}: {error}");
    }
    let alone = one_by_one(&tori, &vol(0.01));
    let ratio = of_sweep.evaluations as f64 / alone as f64;
    assert!(ratio < 1.15, "{ratio}");
}

/// Other methods have no meshes for other emissions: images are those of single renderings, bit by bit.
#[test]
fn lines_of_sight_are_rendered_one_by_one() {
    let tori = over(3, |at| Torus { radius: 0.2 + 0.1 * at, ..TORUS });
    let options = RenderOptions::new(Method::Los(LosOptions::default()));
    let of_sweep = swept(&tori, &options);
    for (image, of) in of_sweep.images.iter().zip(&tori) {
        let alone = render(&FromFn(|at, _| of.rate(at)), &Canonical, SHAPE, &options).unwrap();
        assert_eq!(image.as_ref(), Some(&alone.values));
    }
    assert_eq!(of_sweep.evaluations, one_by_one(&tori, &options));
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
    let tori = over(3, |at| Torus { radius: 0.24 + 0.02 * at, ..TORUS });
    let most = AtomicU64::new(0);
    let progress = |evaluations| {
        most.fetch_max(evaluations, Ordering::Relaxed);
        core::ops::ControlFlow::Continue(())
    };
    let of_sweep = swept(&tori, &vol(0.01).with_progress(&progress));
    assert_eq!(most.into_inner(), of_sweep.evaluations);
    let interrupt = |_| core::ops::ControlFlow::Break(());
    let options = vol(0.01).with_progress(&interrupt);
    let mut sweep = Sweep::new(&[vec![1.0], vec![2.0]]);
    let result = sweep.step(&FromFn(|at, _| TORUS.rate(at)), &Canonical, SHAPE, None, &options);
    assert_eq!(result.err(), Some(RenderError::Interrupted));
}
