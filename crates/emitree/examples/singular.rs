//! Singular points and axes.
#![expect(clippy::print_stdout, reason = "this program prints tables")]
use emitree::projection::{Bounds, Ellipsoid, Singularity};
use emitree::{FromFn, Perspective, RenderOptions, Viewpoint, VolOptions, render};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let size: usize = arguments[0].parse()?;
    let tolerance: f64 = arguments[1].parse()?;
    let fov = (0.05 * size as f64).to_radians();
    let exact = [(0.0, 1.586246e20), (1e-2, 3.1741864e19), (1e-3, 1.2499728e20), (1e-4, 1.5485101e20), (1e-5, 1.5824306e20)];
    for (core, expected) in exact {
        let shape = |r: f64| 1.0 / (r / 20.0 * (1.0 + r / 20.0_f64).powi(2));
        let rho0 = 0.39 / shape(8.5);
        let emission = FromFn(|p: [f64; 3], _| {
            let r = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
            if r > 8.5 { return 0.0; }
            (rho0 * shape((r * r + core * core).sqrt())).powi(2)
        });
        let viewpoint = Viewpoint { position: [8.5, 0.0, 0.0], target: [0.0; 3], up: [0.0, 0.0, 1.0] };
        let camera = Perspective::new(viewpoint, [fov, fov], [0.0, 17.0])?.with_bounds(Bounds::Ellipsoid(Ellipsoid::sphere([0.0;3], 8.5)?)).with_singularities(vec![Singularity::point([0.0; 3])?]);
        let options = RenderOptions::new(VolOptions::new(tolerance)).with_max_evaluations(3_000_000);
        let start = std::time::Instant::now();
        let r = render(&emission, &camera, [size, size], &options);
        match r {
            Err(e) => println!("{core}: {e:?}"),
            Ok(r) => {
                let c = size / 2;
                let v = r.values.row(c)[c] * 3.0856775814913673e21;
                let a = fov / size as f64; let _ = a;
                let x = (0.5 * fov).tan() * 2.0 / size as f64;
                let omega = 4.0 * (x*x/4.0 / (1.0 + x*x/2.0).sqrt()).atan();
                let s = r.stats.evaluations;
                println!("{core} J {:.7e} expected {expected:.7e} ratio {:.6} evals {s} est {:?} {:?} {:.2}s", v * omega, v * omega / expected, r.estimated_error(), r.stats.ending, start.elapsed().as_secs_f64());
            }
        }
    }
    Ok(())
}
