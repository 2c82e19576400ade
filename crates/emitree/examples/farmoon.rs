//! Moon through the geocorona.
#![allow(clippy::all, clippy::print_stdout)]
use emitree::projection::Ellipsoid;
use emitree::{
    FromFn, Method, Perspective, Projection, RenderOptions, Viewpoint, VolOptions, render,
};
use std::error::Error;
fn main() -> Result<(), Box<dyn Error>> {
    let up = [0.0, 0.0, 1.0];
    for (name, obs, g, far) in [
        (
            "geocorona",
            [10.0, 0.0, 0.0],
            (|p: [f64; 3]| (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).max(1.0).powf(-1.5))
                as fn([f64; 3]) -> f64,
            f64::INFINITY,
        ),
        (
            "geocorona100",
            [10.0, 0.0, 0.0],
            (|p: [f64; 3]| (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).max(1.0).powf(-1.5))
                as fn([f64; 3]) -> f64,
            200.0,
        ),
        (
            "blob",
            [0.0, 0.0, 0.0],
            (|p: [f64; 3]| {
                (-((p[0] - 20.0).powi(2) + p[1] * p[1] + p[2] * p[2]) / (2.0 * 4.0)).exp()
            }) as fn([f64; 3]) -> f64,
            f64::INFINITY,
        ),
        (
            "smallblob",
            [0.0, 0.0, 0.0],
            (|p: [f64; 3]| {
                (-((p[0] - 20.0).powi(2) + (p[1] - 0.1).powi(2) + p[2] * p[2]) / (2.0 * 0.01)).exp()
            }) as fn([f64; 3]) -> f64,
            f64::INFINITY,
        ),
        (
            "behind",
            [0.0, 0.0, 0.0],
            (|p: [f64; 3]| {
                (-((p[0] - 120.0).powi(2) + p[1] * p[1] + p[2] * p[2]) / (2.0 * 4.0)).exp()
            }) as fn([f64; 3]) -> f64,
            f64::INFINITY,
        ),
        (
            "moonatm",
            [0.0, 0.0, 0.0],
            (|p: [f64; 3]| {
                let r = ((p[0] - 60.0).powi(2) + p[1] * p[1] + p[2] * p[2]).sqrt();
                (-(r - 0.27) / 0.03).exp()
            }) as fn([f64; 3]) -> f64,
            f64::INFINITY,
        ),
        ("uniform", [0.0, 0.0, 0.0], (|_p: [f64; 3]| 1.0) as fn([f64; 3]) -> f64, 80.0),
    ] {
        if std::env::args().nth(1).is_some_and(|n| n != name) {
            continue;
        }
        let fov = 1f64.to_radians();
        let m = [60.0, 0.0, 0.0];
        let rm = 0.27;
        let cam =
            Perspective::new(Viewpoint { position: obs, target: m, up }, [fov, fov], [0.0, far])?
                .with_occulters(vec![Ellipsoid::sphere(m, rm)?])?;
        let line = |x: f64, y: f64| -> f64 {
            let o = cam.world_from_canonical([x, y, 0.0]).position;
            let _ = o;
            // direction from mapped point deep
            let q = cam.world_from_canonical([x, y, 0.5]);
            let d = q.direction.map(|c| -c);
            let oc = [obs[0] - m[0], obs[1] - m[1], obs[2] - m[2]];
            let b = oc[0] * d[0] + oc[1] * d[1] + oc[2] * d[2];
            let disc = b * b - (oc[0] * oc[0] + oc[1] * oc[1] + oc[2] * oc[2] - rm * rm);
            let end = if disc > 0.0 { -b - disc.sqrt() } else { far.min(1e4) };
            // piecewise Gauss by many panels graded
            let mut s = 0.0;
            let mut edges = vec![];
            let n = 40000usize;
            for k in 0..=n {
                let f = k as f64 / n as f64;
                edges.push(if end > 1000.0 {
                    let c = 60.0;
                    if f < 0.9 {
                        f / 0.9 * 2.0 * c
                    } else {
                        2.0 * c * ((f - 0.9) / 0.1 * (end / (2.0 * c)).ln()).exp()
                    }
                } else {
                    f * end
                });
            }
            for w in edges.windows(2) {
                let h = w[1] - w[0];
                for (x, wt) in [(-0.577350269189626, 0.5), (0.577350269189626, 0.5)] {
                    let t = 0.5 * (w[0] + w[1]) + 0.5 * h * x;
                    s += wt * h * g([obs[0] + t * d[0], obs[1] + t * d[1], obs[2] + t * d[2]]);
                }
            }
            s
        };
        let n = 32usize;
        for t in [1e-2, 1e-3] {
            let f = FromFn(|p: [f64; 3], _: [f64; 3]| g(p));
            let o = RenderOptions::new(Method::Vol(VolOptions::new(t)));
            let r = match render(&f, &cam, [n, n], &o) {
                Ok(r) => r,
                Err(e) => {
                    println!("{name} {t:e} error {e}");
                    continue;
                }
            };
            let max = r.values.min_max().1;
            let mut worst = 0.0f64;
            let mut at = (0, 0);
            let mut truth_max = 0.0f64;
            for j in (0..n).step_by(3) {
                for i in (0..n).step_by(3) {
                    // skip pixels at the limb
                    let (x, y) = ((i as f64 + 0.5) / n as f64, (j as f64 + 0.5) / n as f64);
                    let dist = {
                        let q = cam.world_from_canonical([x, y, 0.5]);
                        let d = q.direction;
                        let a = [m[0] - obs[0], m[1] - obs[1], m[2] - obs[2]];
                        let an = (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]).sqrt();
                        let c = -(a[0] * d[0] + a[1] * d[1] + a[2] * d[2]) / an;
                        an * (1.0 - c * c).max(0.0).sqrt()
                    };
                    let px = (m[0] - obs[0]) * fov / n as f64;
                    if (dist - rm).abs() < 2.0 * px {
                        continue;
                    }
                    // 3-point Gauss mean over the pixel
                    let mut tr = 0.0;
                    for (a, wa) in [
                        (-0.774596669241483, 5.0 / 18.0),
                        (0.0, 8.0 / 18.0),
                        (0.774596669241483, 5.0 / 18.0),
                    ] {
                        for (b, wb) in [
                            (-0.774596669241483, 5.0 / 18.0),
                            (0.0, 8.0 / 18.0),
                            (0.774596669241483, 5.0 / 18.0),
                        ] {
                            tr += wa * wb * line(x + 0.5 * a / n as f64, y + 0.5 * b / n as f64);
                        }
                    }
                    truth_max = truth_max.max(tr);
                    let e = (r.values[(j, i)] - tr).abs();
                    if e > worst {
                        worst = e;
                        at = (j, i)
                    }
                }
            }
            println!(
                "{name} {t:e} {} max {max:.3e} true max {truth_max:.3e} worst {:.1e} at {at:?} converged {}",
                r.stats.evaluations,
                worst / truth_max.max(1e-300),
                r.converged()
            );
        }
    }
    Ok(())
}
