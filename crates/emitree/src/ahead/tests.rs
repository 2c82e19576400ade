use crate::image::Image;
use crate::projection::{Canonical, Projection};
use crate::{RenderOptions, Rendering, Session, VolOptions};

fn g([x, y, z]: [f64; 3]) -> f64 {
    let peak = |at: [f64; 3], width: f64| {
        let square = (x - at[0]).powi(2) + (y - at[1]).powi(2) + (z - at[2]).powi(2);
        (-square / (2.0 * width * width)).exp()
    };
    peak([0.4, 0.6, 0.5], 0.15) + 0.4 * peak([0.7, 0.3, 0.4], 0.1)
}

/// A rendering, and the number of batches that were told.
fn rendered(options: &RenderOptions<'_>) -> (Rendering, usize) {
    let camera: &dyn Projection = &Canonical;
    let mut session = Session::<Image>::new(camera, [32, 32], options).unwrap();
    let mut batches = 0;
    while let Some(points) = session.ask() {
        let rates: Vec<f64> = points.positions().iter().map(|at| g(*at)).collect();
        session.tell(&rates).unwrap();
        batches += 1;
    }
    (session.rendering().unwrap(), batches)
}

#[test]
fn fewer_rounds_take_more_evaluations_and_the_image_has_the_same_bits() {
    let options = RenderOptions::new(VolOptions::new(0.01));
    let (plain, of_plain) = rendered(&options);
    let (ahead, of_ahead) = rendered(&options.clone().with_rounds(6));
    assert_eq!(plain.values, ahead.values);
    assert_eq!(plain.error, ahead.error);
    assert_eq!(ahead.stats.batches, of_ahead as u64);
    assert!(plain.converged() && ahead.converged());
    let counts = [plain.stats.evaluations, ahead.stats.evaluations];
    assert_eq!((of_plain, of_ahead, counts), (13, 6, [1311, 3770]));
}

#[test]
fn no_more_than_the_largest_number_of_evaluations_are_made() {
    for rounds in [1, 6] {
        let options = RenderOptions::new(VolOptions::new(1e-4)).with_max_evaluations(3000);
        let (found, _) = rendered(&options.with_rounds(rounds));
        assert!(found.stats.evaluations <= 3000, "{}", found.stats.evaluations);
    }
}
