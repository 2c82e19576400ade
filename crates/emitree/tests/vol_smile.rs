//! Method `vol` on the soft X-rays of the magnetosheath from random viewpoints, with the Earth: magnetopause and
//! bow shock are found, although the jump at the bow shock fades out on the flanks.

use emitree::{FromFn, RenderOptions, VolOptions, render};
use emitree_problems::relative_error;
use emitree_problems::smile::random_smile;

const TOLERANCE: f64 = 0.01;
const SHAPE: [usize; 2] = [12, 12];

/// A scene, and its evaluations.
#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn check(seed: u64, evaluations: u64) {
    let scene = random_smile(seed);
    let exact = scene.reference_image(SHAPE);
    let options = RenderOptions::new(VolOptions::new(TOLERANCE));
    let emission = FromFn(|position, _| scene.rate(position));
    let rendering = render(&emission, &*scene.camera(), SHAPE, &options).unwrap();
    let error = relative_error(&rendering.values, &exact.image);
    assert!(exact.error < 0.015, "{}", exact.error);
    assert!(rendering.converged() && error <= TOLERANCE, "{error}");
    assert!(rendering.surfaces.is_some());
    assert_eq!(rendering.stats.evaluations, evaluations);
}

#[test]
fn jorgensen_from_the_dayside() {
    check(3, 5949);
}

#[test]
fn cmem_in_an_equirectangular_view() {
    check(5, 38_112);
}
