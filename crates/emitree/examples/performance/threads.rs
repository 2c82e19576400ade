//! Two threads against one: the same renderings of a g that costs a microsecond or ten at each point.

use crate::table::Table;
use emitree::los::{LosOptions, Steps};
use emitree::refinement::Threshold;
use emitree::tree::BuildOptions;
use emitree::{Canonical, FromFn, Image, Method, RenderOptions, Rendering, VolOptions, render};
use emitree_problems::{equation8, nebula::Nebula, shell};
use rayon::ThreadPool;
use std::hint;
use std::time::{Duration, Instant};

const SHAPE: [usize; 2] = [64, 64];
/// What g may cost at each point, its own value included; all scenes have the first…
const COSTS_US: [u64; 2] = [1, 10];
/// Renderings of which the fastest counts.
const REPETITIONS: usize = 3;
/// 1/e half width of the sheet: it has no low-rank approximation in x, y and z.
const SHEET_WIDTH: f64 = 0.005;

struct Scene {
    name: &'static str,
    rate: Box<dyn Fn([f64; 3]) -> f64 + Send + Sync>,
    method: Method,
}

/// One row for each scene: the seconds of one thread and of two.
pub(crate) fn tables() -> Result<Vec<Table>, String> {
    let columns =
        ["scene", "method", "evaluations", "g in µs", "1 thread s", "2 threads s", "ratio"];
    let [one, two] = [1, 2].map(pool);
    let mut rows = Vec::new();
    for scene in scenes() {
        // …and those whose overhead is not negligible the others too.
        let is_vol = matches!(scene.method, Method::Vol(_));
        let costs = COSTS_US.into_iter().take(if is_vol { COSTS_US.len() } else { 1 });
        rows.extend(costs.map(|cost_us| row(&scene, cost_us, &one, &two)));
    }
    let title = "Two threads against one";
    Ok(vec![Table { title, columns: columns.to_vec(), rows }])
}

fn scenes() -> Vec<Scene> {
    let vol = |tolerance| Method::Vol(VolOptions::new(tolerance));
    let build = BuildOptions::new(Threshold::Relative(0.01)).with_finest_level(7);
    let los = LosOptions::new(1, Steps::Fixed(64));
    let nebula = Nebula::default();
    vec![
        Scene { name: "eq8 by products", rate: Box::new(eq8), method: vol(1e-3) },
        Scene { name: "shell by products", rate: Box::new(shell::rate), method: vol(1e-3) },
        Scene { name: "thin sheet by a tree", rate: Box::new(sheet), method: vol(1e-2) },
        Scene {
            name: "nebula by surfaces",
            rate: Box::new(move |position| nebula.rate(position)),
            method: vol(1e-2),
        },
        Scene { name: "shell", rate: Box::new(shell::rate), method: Method::Paper(build) },
        Scene { name: "shell", rate: Box::new(shell::rate), method: Method::Los(los) },
    ]
}

fn eq8(position: [f64; 3]) -> f64 {
    equation8::rate(position, equation8::ALPHA)
}

/// A slanted sheet through the middle of the cube, with a Gaussian profile.
fn sheet([x, y, z]: [f64; 3]) -> f64 {
    let distance = 0.6 * (x - 0.5) + 0.48 * (y - 0.5) + 0.64 * (z - 0.5);
    (-(distance / SHEET_WIDTH).powi(2)).exp() * (1.0 + x * y)
}

#[expect(clippy::expect_used, reason = "without threads there is nothing to be measured")]
fn pool(threads: usize) -> ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads can be started")
}

/// The fastest of some renderings with one thread and with two, in turn: other load of the machine
/// then affects both.
fn row(scene: &Scene, cost_us: u64, one: &ThreadPool, two: &ThreadPool) -> Vec<String> {
    let mut seconds = [f64::INFINITY; 2];
    let mut evaluations = 0;
    for _ in 0..REPETITIONS {
        let renderings = [one, two].map(|pool| pool.install(|| rendered(scene, cost_us)));
        for (least, rendering) in seconds.iter_mut().zip(&renderings) {
            *least = least.min(rendering.stats.total_time.as_secs_f64());
        }
        let [one, two] = &renderings;
        assert_eq!(bits(&one.values), bits(&two.values), "{}: the images differ", scene.name);
        assert_eq!(one.stats.evaluations, two.stats.evaluations, "{}", scene.name);
        let errors = [one, two].map(|rendering| rendering.error.as_ref().map(bits));
        assert_eq!(errors[0], errors[1], "{}: the errors differ", scene.name);
        evaluations = one.stats.evaluations;
    }
    let [one, two] = seconds;
    vec![
        scene.name.to_owned(),
        scene.method.name().to_owned(),
        evaluations.to_string(),
        cost_us.to_string(),
        format!("{one:.4}"),
        format!("{two:.4}"),
        format!("{:.2}", one / two),
    ]
}

#[expect(clippy::expect_used, reason = "the scenes have all that is needed")]
fn rendered(scene: &Scene, cost_us: u64) -> Rendering {
    let cost = Duration::from_micros(cost_us);
    let emission = FromFn(|position, _| {
        let start = Instant::now();
        let rate = (scene.rate)(position);
        while start.elapsed() < cost {
            hint::spin_loop();
        }
        rate
    });
    let options = RenderOptions::new(scene.method.clone());
    render(&emission, &Canonical, SHAPE, &options).expect("the scene can be rendered")
}

fn bits(image: &Image) -> Vec<u64> {
    image.pixels().iter().map(|pixel| pixel.to_bits()).collect()
}
