//! Axes.
#![expect(clippy::print_stdout, reason = "this program prints tables")]
use emitree::projection::Singularity;
use emitree::{FromFn, Perspective, Orthographic, Projection, RenderOptions, Viewpoint, VolOptions, render};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let size: usize = arguments[0].parse()?;
    let tolerance: f64 = arguments[1].parse()?;
    let norm = |a: [f64; 3]| (a[0]*a[0]+a[1]*a[1]+a[2]*a[2]).sqrt();
    for exponent in [std::env::var("EXP").map_or(1.0, |e| e.parse().unwrap_or(1.0))] {
        for (k, direction) in [[0.0, 0.0, 1.0], [0.3, 0.5, 1.0], [1.0, 0.2, 0.4]].into_iter().enumerate() {
            let a = direction.map(|x: f64| x / norm(direction));
            let position = [0.03, 0.1, 0.02];
            let rate = move |p: [f64; 3]| {
                let d = [0, 1, 2].map(|i| p[i] - position[i]);
                let along = d[0]*a[0]+d[1]*a[1]+d[2]*a[2];
                let rho = norm([0, 1, 2].map(|i| d[i] - along * a[i]));
                rho.powf(-exponent) * (-(norm(p).powi(2))).exp()
            };
            let emission = FromFn(|p: [f64; 3], _| rate(p));
            let viewpoint = Viewpoint { position: [0.2, -6.0, 0.3], target: [0.0; 3], up: [0.0, 0.0, 1.0] };
            let s = Singularity::axis(position, direction)?.with_exponent(exponent)?;
            let cameras: [Box<dyn Projection>; 2] = [Box::new(Orthographic::new(viewpoint, [2.0, 2.0], [0.0, 12.0])?.with_singularities(vec![s])),
                Box::new(Perspective::new(viewpoint, [0.33, 0.33], [0.0, 12.0])?.with_singularities(vec![s]))];
            for camera in cameras {
            let options = RenderOptions::new(VolOptions::new(tolerance)).with_max_evaluations(3_000_000);
            let start = std::time::Instant::now();
            let r = render(&emission, &*camera, [size, size], &options)?;
            let time = start.elapsed().as_secs_f64();
            // Reference: radiance at places of pixels by lines with sinh, pixel means by brute force about the axis.
            let radiance = |xy: [f64; 2]| {
                // geometry of the line
                let p0 = camera.world_from_canonical([xy[0], xy[1], 0.0]).position;
                let p1 = camera.world_from_canonical([xy[0], xy[1], 1.0]).position;
                let d = [0, 1, 2].map(|i| (p1[i] - p0[i]));
                let len = norm(d);
                let d = d.map(|x| x / len);
                let da = d[0]*a[0]+d[1]*a[1]+d[2]*a[2];
                let lv = [0,1,2].map(|i| d[i] - da * a[i]);
                let f = [0,1,2].map(|i| p0[i] - position[i]);
                let sq = lv[0]*lv[0]+lv[1]*lv[1]+lv[2]*lv[2];
                let s0 = -(f[0]*lv[0]+f[1]*lv[1]+f[2]*lv[2]) / sq;
                let q = [0,1,2].map(|i| f[i] + s0 * d[i]);
                let qa = q[0]*a[0]+q[1]*a[1]+q[2]*a[2];
                let b = norm([0,1,2].map(|i| q[i] - qa * a[i])) / sq.sqrt();
                let b = b.max(1e-14);
                let t = |s: f64| ((s - s0) / b).asinh();
                let (t0, t1) = (t(0.0), t(len));
                let n = 400;
                // Gaussian rule by midpoints in t: smooth, decays
                (0..n).map(|k| { let u = t0 + (t1 - t0) * (k as f64 + 0.5) / n as f64; let s = s0 + b * u.sinh();
                    let p = [0,1,2].map(|i| p0[i] + s * d[i]); rate(p) * b * u.cosh() * (t1 - t0) / n as f64 }).sum::<f64>()
            };
            // pixels: a few
            let mut worst: f64 = 0.0;
            let largest = r.values.pixels().iter().copied().fold(0.0, f64::max);
            let worst_est = r.error.as_ref().map(|e| e.pixels().iter().copied().fold(0.0, f64::max)).unwrap_or(0.0) / largest;
            let mut at = 0;
            for row in [15] { for column in [12, 13, 14, 15, 16, 17] {
                // integral over x by adaptive splitting in x at the axis: sign of the side via misses is unknown: use composite with sinh clustering by bisection on the max of radiance
                let m = 200;
                let mut sum = 0.0;
                let mut wsum = 0.0;
                for j in 0..4 {
                    let gy = [0.06943184420297371, 0.33000947820757187, 0.6699905217924281, 0.9305681557970262][j];
                    let wy = [0.17392742256872692, 0.32607257743127307, 0.32607257743127307, 0.17392742256872692][j];
                    let y = (row as f64 + gy) / size as f64;
                    // find the place of the largest radiance in the pixel by ternary search
                    let f = |x: f64| radiance([(column as f64 + x) / size as f64, y]);
                    let (mut lo, mut hi) = (0.0_f64, 1.0_f64);
                    for _ in 0..60 { let (u, v) = (lo + (hi - lo) / 3.0, hi - (hi - lo) / 3.0); if f(u) < f(v) { lo = u } else { hi = v } }
                    let c = 0.5 * (lo + hi);
                    for (e0, e1) in [(c, 0.0), (c, 1.0)] {
                        for q in 0..m {
                            let v = (q as f64 + 0.5) / m as f64;
                            // graded x = e0 + (e1-e0) v^6 
                            let x = e0 + (e1 - e0) * v.powi(6);
                            let w = (e1 - e0).abs() * 6.0 * v.powi(5) / m as f64 * wy * camera.solid_angle_density([(column as f64 + x) / size as f64, y]);
                            sum += w * f(x); wsum += w;
                        }
                    }
                }
                let e = (sum / wsum - r.values.row(row)[column]).abs() / largest;
                if e > worst { worst = e; at = row * size + column; }
            } }
            println!("γ {exponent} axis {k}: evals {} est {worst_est:.1e} true {worst:.1e} at {:?} {:?} {time:.2}s", r.stats.evaluations, (at / size, at % size), r.stats.ending);
            }
        }
    }
    Ok(())
}
