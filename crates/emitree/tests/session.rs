//! Sessions: held, inspected and continued.

use emitree::los::{LosOptions, Steps};
use emitree::projection::Ellipsoid;
use emitree::tree::BuildOptions;
use emitree::{
    Canonical, Cube, Emission, EnergyAxis, EnergyScale, Equirectangular, FromFn, FromSpectralFn,
    Image, Method, Orthographic, Projection, RenderError, RenderOptions, Samples, Session,
    StopReason, Viewpoint, VolOptions, render, render_cube,
};
use emitree_problems::family::random_scene;
use emitree_problems::planets::random_planet;
use std::sync::{Arc, Mutex};

const CAMERA: &dyn Projection = &Canonical;

fn vol(tolerance: f64) -> RenderOptions<'static> {
    RenderOptions::new(VolOptions::new(tolerance))
}

fn peak([x, y, z]: [f64; 3]) -> f64 {
    let square = (x - 0.3_f64).powi(2) + (y - 0.6_f64).powi(2) + (z - 0.4_f64).powi(2);
    0.1 + (-square / 0.02).exp()
}

/// Answers all requests; returns the number of rates.
#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn answer(session: &mut Session<'_>, rate: impl Fn([f64; 3]) -> f64) -> u64 {
    let mut answered = 0;
    while let Some(points) = session.ask() {
        let rates: Vec<f64> = points.positions().iter().map(|&at| rate(at)).collect();
        answered += rates.len() as u64;
        session.tell(&rates).unwrap();
    }
    answered
}

#[test]
fn ask_and_tell_give_what_render_gives() {
    let adaptive = LosOptions::new(1, Steps::Adaptive(1e-3));
    let methods = [
        vol(0.01).method,
        Method::Paper(BuildOptions::default()),
        Method::Los(LosOptions::default()),
        Method::Los(adaptive),
    ];
    for method in methods {
        let options = RenderOptions::new(method);
        let at_once = render(&FromFn(|at, _| peak(at)), CAMERA, [16, 24], &options).unwrap();
        let mut session = Session::<Image>::new(CAMERA, [16, 24], &options).unwrap();
        let answered = answer(&mut session, peak);
        let rendering = session.rendering().unwrap();
        assert_eq!(rendering.values, at_once.values);
        assert_eq!(rendering.error, at_once.error);
        assert_eq!(rendering.stats.ending, StopReason::Complete);
        assert_eq!(rendering.stats.evaluations, answered);
        assert_eq!(at_once.stats.evaluations, answered);
    }
}

/// The fibers of products cross each other, and searches in other charts begin again.
#[test]
fn a_rendering_evaluates_none_of_its_first_points_twice() {
    let occulter = Ellipsoid::sphere([0.5, 0.5, 0.5], 0.2).unwrap();
    let viewpoint = Viewpoint { position: [0.5, 0.5, -3.0], target: [0.5; 3], up: [0.0, 1.0, 0.0] };
    let with_body = Orthographic::new(viewpoint, [1.0; 2], [2.5, 4.5]).unwrap();
    let with_body = with_body.with_occulters(vec![occulter]).unwrap();
    for camera in [CAMERA, &with_body] {
        let points = Mutex::new(Vec::new());
        let glow = FromFn(|at: [f64; 3], _| {
            points.lock().unwrap().push(at.map(f64::to_bits));
            peak(at)
        });
        let rendering = render(&glow, camera, [32, 32], &vol(1e-3)).unwrap();
        let mut points = points.into_inner().unwrap();
        assert_eq!(points.len() as u64, rendering.stats.evaluations);
        let per_pixel = rendering.stats.evaluations_per_pixel.to_image();
        let of_pixels: f64 = per_pixel.pixels().iter().sum();
        assert_eq!(of_pixels.to_bits(), (points.len() as f64).to_bits());
        points.sort_unstable();
        points.dedup();
        assert_eq!(points.len() as u64, rendering.stats.evaluations);
    }
}

#[test]
fn a_cube_is_sampled_at_its_energies() {
    let axis = EnergyAxis::new(1.0, 10.0, 6, EnergyScale::Log).unwrap();
    let rate = |at: [f64; 3], energy: f64| peak(at) * (-energy * (1.0 + at[0])).exp();
    let options = vol(0.01);
    let emission = FromSpectralFn(|at, _, energy| rate(at, energy));
    let at_once = render_cube(&emission, CAMERA, [8, 8], &axis, &options).unwrap();
    let mut session = Session::<Cube>::with_energies(CAMERA, [8, 8], Some(axis), &options).unwrap();
    while let Some(points) = session.ask() {
        let both = points.positions().iter().zip(points.energies());
        let rates: Vec<f64> = both.map(|(&at, &energy)| rate(at, energy)).collect();
        session.tell(&rates).unwrap();
    }
    let rendering = session.rendering().unwrap();
    assert_eq!(rendering.values, at_once.values);
    assert_eq!(rendering.stats.energies, at_once.stats.energies);
}

/// A session continued to 0.1 % gives the result of 0.1 % at once, for at most 1.1 times its evaluations.
#[test]
fn a_tighter_tolerance_gives_what_it_gives_at_once() {
    let (mut together, mut alone) = (0, 0);
    for seed in [0, 1, 2, 3, 4, 5, 240, 241, 242, 243, 244, 245] {
        let scene = random_scene(seed);
        let emission = FromFn(|at, _| scene.rate(at));
        let at_once = render(&emission, CAMERA, [32, 32], &vol(1e-3)).unwrap();
        let mut session = Session::<Image>::new(CAMERA, [32, 32], &vol(0.01)).unwrap();
        for options in [vol(0.01), vol(1e-3)] {
            session.resume([32, 32], &options).unwrap();
            while !session.is_done() {
                session.step(&emission).unwrap();
            }
        }
        let rendering = session.rendering().unwrap();
        assert_eq!(rendering.values, at_once.values, "{}", scene.name());
        assert_eq!(rendering.error, at_once.error, "{}", scene.name());
        together += rendering.stats.evaluations;
        alone += at_once.stats.evaluations;
    }
    assert_eq!((together, alone), (498_069, 459_932));
    assert!(together as f64 <= 1.1 * alone as f64);
}

/// A shape that one point alone meets is found again although the session knows many points of it by then.
#[test]
fn a_small_shape_is_in_both_images_of_a_session() {
    let scene = random_planet(31);
    let owned = scene.camera();
    let camera: &dyn Projection = &*owned;
    let emission = FromFn(|at, _| scene.rate(at));
    let at_once = render(&emission, camera, [64, 64], &vol(0.02)).unwrap();
    assert!(at_once.surfaces.is_some());
    let mut session = Session::<Image>::new(camera, [64, 64], &vol(0.02)).unwrap();
    for _ in 0..2 {
        session.resume([64, 64], &vol(0.02)).unwrap();
        while !session.is_done() {
            session.step(&emission).unwrap();
        }
        assert_eq!(session.rendering().unwrap().values, at_once.values);
    }
}

#[test]
fn more_pixels_and_a_larger_budget_use_stored_rates() {
    let emission = FromFn(|at, _| peak(at));
    let run = |session: &mut Session<'_>| {
        while !session.is_done() {
            session.step(&emission).unwrap();
        }
        session.rendering().unwrap()
    };
    let short = vol(0.01).with_max_evaluations(900);
    let mut session = Session::<Image>::new(CAMERA, [16, 16], &short).unwrap();
    let poor = run(&mut session);
    assert_eq!((poor.stats.ending, poor.stats.evaluations <= 900), (StopReason::Budget, true));
    session.resume([16, 16], &vol(0.01)).unwrap();
    let good = run(&mut session);
    let at_once = render(&emission, CAMERA, [16, 16], &vol(0.01)).unwrap();
    assert_eq!(good.values, at_once.values);
    session.resume([64, 64], &vol(0.01)).unwrap();
    let large = run(&mut session);
    let at_once = render(&emission, CAMERA, [64, 64], &vol(0.01)).unwrap();
    assert_eq!(large.values, at_once.values);
    // Pixels are integrals of the stored rates.
    assert_eq!(large.stats.evaluations, good.stats.evaluations);
    assert_eq!(large.stats.batches, good.stats.batches);
}

#[test]
fn intermediate_images_can_be_read() {
    let scene = random_scene(3);
    let mut session = Session::<Image>::new(CAMERA, [16, 16], &vol(1e-3)).unwrap();
    let mut seen = Vec::new();
    assert!(session.rendering().is_none(), "nothing is known yet");
    while !session.is_done() {
        session.step(&FromFn(|at, _| scene.rate(at))).unwrap();
        seen.extend(session.rendering().filter(|_| !session.is_done()));
    }
    let last = session.rendering().unwrap();
    assert!(seen.len() > 3 && last.converged());
    for early in &seen {
        assert_eq!(early.stats.ending, StopReason::Unfinished);
        assert!(!early.converged());
    }
    let first = seen.first().unwrap().estimated_error().unwrap();
    assert!(first > last.estimated_error().unwrap());
}

#[test]
fn a_session_owns_its_camera_and_moves_to_another_thread() {
    let viewpoint = Viewpoint { position: [4.0, 0.0, 0.0], target: [0.0; 3], up: [0.0, 0.0, 1.0] };
    let camera = Equirectangular::new(viewpoint, [0.8, 0.6], [0.0, 8.0]).unwrap();
    let camera: Arc<dyn Projection + Send + Sync> = Arc::new(camera);
    struct Held(Arc<dyn Projection + Send + Sync>);
    impl core::borrow::Borrow<dyn Projection> for Held {
        fn borrow(&self) -> &(dyn Projection + 'static) {
            &*self.0
        }
    }
    let mut session = Session::<Image>::new(Held(camera), [8, 8], &vol(0.01)).unwrap();
    let worker = std::thread::spawn(move || {
        answer(&mut session, peak);
        session.rendering().unwrap().converged()
    });
    assert!(worker.join().unwrap());
}

/// The time limit ends sessions with `tell` too.
#[test]
fn a_time_limit_ends_a_session() {
    let los = Method::Los(LosOptions::new(1, Steps::Fixed(8)));
    let options = RenderOptions::new(los).with_max_seconds(0.05);
    let options = options.with_batch_size(16);
    let mut session = Session::<Image>::new(CAMERA, [8, 8], &options).unwrap();
    let ended = loop {
        let Some(points) = session.ask() else { break Ok(()) };
        let rates = vec![1.0; points.len()];
        std::thread::sleep(std::time::Duration::from_millis(5));
        if let Err(error) = session.tell(&rates) {
            break Err(error);
        }
    };
    assert!(matches!(ended, Err(RenderError::Time { .. })), "{ended:?}");
}

/// g that fails once.
struct Fails(std::sync::atomic::AtomicBool);

impl Emission for Fails {
    type Error = std::fmt::Error;

    fn emission_rates(&self, samples: &Samples<'_>, rates: &mut [f64]) -> Result<(), Self::Error> {
        if self.0.swap(false, std::sync::atomic::Ordering::Relaxed) {
            return Err(std::fmt::Error);
        }
        for (rate, &at) in rates.iter_mut().zip(samples.positions()) {
            *rate = peak(at);
        }
        Ok(())
    }
}

#[test]
fn wrong_answers_are_named_and_a_failed_step_can_be_repeated() {
    let mut session = Session::<Image>::new(CAMERA, [8, 8], &vol(0.01)).unwrap();
    let wanted = session.ask().unwrap().len();
    let refused = session.tell(&[1.0]).unwrap_err().to_string();
    assert_eq!(
        refused,
        format!("1 rates were given: expected {wanted}, one for each point of `ask`")
    );
    let emission = Fails(true.into());
    assert!(matches!(session.step(&emission), Err(RenderError::Emission(_))));
    while !session.is_done() {
        session.step(&emission).unwrap();
    }
    assert!(session.rendering().unwrap().converged());
    let refused = session.tell(&[1.0]).unwrap_err().to_string();
    assert_eq!(refused, "1 rates were given: expected none, as the session waits for no rates");

    session.resume([8, 8], &vol(1e-7)).unwrap();
    let nan = vec![f64::NAN; session.ask().map_or(0, |points| points.len())];
    let refused = session.tell(&nan).unwrap_err().to_string();
    assert!(refused.starts_with("the emission rate is NaN at position"), "{refused}");
    assert!(!session.is_done(), "the session still waits");
    answer(&mut session, peak);
    let rendering = session.rendering().unwrap();
    assert!(rendering.converged() && rendering.estimated_error() < Some(1e-7));

    // A session that can't be continued is as it was.
    let refused = session.resume([8, 8], &vol(0.01).with_max_evaluations(10));
    assert!(matches!(refused, Err(RenderError::Budget { allowed: 10, .. })), "{refused:?}");
    assert_eq!(session.rendering().unwrap().values, rendering.values);

    let wide = Session::<Image>::new(CAMERA, [0, 8], &vol(0.01)).unwrap_err();
    assert_eq!(
        wide.to_string(),
        "the image has 0 x 8 pixels (height x width): expected at least 1 x 1"
    );
}
