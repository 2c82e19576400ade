//! Planet and moon.
#![allow(clippy::all, clippy::print_stdout)]
use emitree::projection::{Bounds, Ellipsoid};
use emitree::{
    FromFn, Method, Orthographic, Perspective, Projection, RenderOptions, Viewpoint, VolOptions,
    render,
};
use std::error::Error;
use std::sync::atomic::{AtomicU64, Ordering};
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
fn g(p: [f64; 3]) -> f64 {
    let r = dot(p, p).sqrt().max(1.0);
    let m = p.map(|x| x / r);
    let n = r.powf(-5.932648149262418);
    let v = [
        ([-0.75313675, 0.5551685, 0.35294896], -0.21846924864337758),
        ([0.77984419, 0.28340481, -0.55814402], 0.0435859639462996),
        ([-0.34045643, -0.36048254, -0.86841336], -0.054050728710910545),
    ];
    n * (1.0
        + v.iter().map(|(v, a)| a * dot(m, *v)).sum::<f64>()
        + 0.013299866464020982
            * (dot(m, [-0.12066367, 0.66328458, -0.73857555]).powi(2) - 1.0 / 3.0))
}
fn main() -> Result<(), Box<dyn Error>> {
    let c = [0.0, -1.6, 0.75];
    let rm = 0.4;
    let up = [0.0, 0.0, 1.0];
    let bodies = vec![Ellipsoid::sphere([0.0; 3], 1.0)?, Ellipsoid::sphere(c, rm)?];
    let bounds = Bounds::Ellipsoid(Ellipsoid::sphere([0.0; 3], 8.0)?);
    let fov = 50f64.to_radians();
    for (name, which) in [("persp", 0), ("ortho", 1)] {
        let camera: Box<dyn Projection> = if which == 0 {
            Box::new(
                Perspective::new(
                    Viewpoint { position: [0., -5., 1.], target: [0., 0., 0.2], up },
                    [fov, fov],
                    [0.0, f64::INFINITY],
                )?
                .with_bounds(bounds)
                .with_occulters(bodies.clone())?,
            )
        } else {
            Box::new(
                Orthographic::new(
                    Viewpoint { position: [0., -20., 0.], target: [0.; 3], up },
                    [4.0, 4.0],
                    [0.0, f64::INFINITY],
                )?
                .with_bounds(bounds)
                .with_occulters(bodies.clone())?,
            )
        };
        let reference = {
            let o = RenderOptions::new(Method::Vol(VolOptions::new(2e-6)))
                .with_max_evaluations(30_000_000);
            if std::env::args().nth(1).is_some() {
                Some(render(&FromFn(|p: [f64; 3], _: [f64; 3]| g(p)), &*camera, [64, 64], &o)?)
            } else {
                None
            }
        };
        for t in [1e-2, 1e-3] {
            let inside = AtomicU64::new(0);
            let f = FromFn(|p: [f64; 3], _: [f64; 3]| {
                if dot(
                    [p[0] - c[0], p[1] - c[1], p[2] - c[2]],
                    [p[0] - c[0], p[1] - c[1], p[2] - c[2]],
                ) < rm * rm * (1.0 - 1e-6)
                {
                    inside.fetch_add(1, Ordering::Relaxed);
                }
                g(p)
            });
            let o = RenderOptions::new(Method::Vol(VolOptions::new(t)));
            let t0 = std::time::Instant::now();
            let r = render(&f, &*camera, [64, 64], &o)?;
            let e = reference
                .as_ref()
                .map_or(f64::NAN, |x| x.values.max_difference(&r.values) / x.values.min_max().1);
            println!(
                "{name} {t:e} {} inside {} true {e:.1e} converged {} {:.2}s",
                r.stats.evaluations,
                inside.load(Ordering::Relaxed),
                r.converged(),
                t0.elapsed().as_secs_f64()
            );
        }
    }
    Ok(())
}
