//! The search for the generator, and Monte Carlo tests of the structure that the points detect.

use super::*;
use crate::cell::whole;
use nalgebra::Vector3;

const FIRST_LEVEL: u32 = FEWEST.ilog2();
const LAST_LEVEL: u32 = 24;
/// The number of generators that the search keeps from level to level.
const KEPT: usize = 200;

/// The covering radius of the lattice {k **g** / N} + ℤ³ in units of N^(−1/3), N = 2^level.
///
/// Selling's reduction gives four vectors of sum 0 with no acute angle between any two. The
/// tetrahedra along them in all orders fill space and are those of Delaunay (Conway and Sloane
/// 1992, doi:10.1098/rspa.1992.0004). The largest circumsphere is the largest empty ball.
fn covering_radius(level: u32, generator: [u64; 3]) -> f64 {
    let number = (1_u64 << level) as f64;
    let first = Vector3::from(generator.map(|g| (g % (1 << level)) as f64));
    let [second, third] = [number * Vector3::y(), number * Vector3::z()];
    let mut superbase = [first, second, third, -(first + second + third)];
    let pairs = || (0..4).flat_map(|i| (i + 1..4).map(move |j| (i, j)));
    let acute = |base: &[Vector3<f64>; 4]| {
        let products = pairs().map(|(i, j)| (base[i].dot(&base[j]), i, j));
        products.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|largest| largest.0 > 0.0)
    };
    while let Some((_, i, j)) = acute(&superbase) {
        let turned = superbase[i];
        (0..4).filter(|k| *k != i && *k != j).for_each(|k| superbase[k] += turned);
        superbase[i] = -turned;
    }
    let mut largest = 0.0_f64;
    for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))).filter(|(i, j)| i != j) {
        for k in (0..4).filter(|&k| k != i && k != j) {
            let a = superbase[i];
            let b = a + superbase[j];
            largest = largest.max(circumradius(a, b, b + superbase[k]));
        }
    }
    largest / number * number.cbrt()
}

/// The radius of the sphere through 0 and three other points.
fn circumradius(a: Vector3<f64>, b: Vector3<f64>, c: Vector3<f64>) -> f64 {
    let centre = a.norm_squared() * b.cross(&c)
        + b.norm_squared() * c.cross(&a)
        + c.norm_squared() * a.cross(&b);
    centre.norm() / (2.0 * a.dot(&b.cross(&c))).abs()
}

#[test]
fn the_covering_radius_of_a_body_centred_lattice_is_exact() {
    // (1, 1, 1) / 2 is body-centred: √5 / 4 edges, with two points for each cube.
    let body_centred = covering_radius(1, [1, 1, 1]);
    assert!((body_centred - 5.0_f64.sqrt() / 4.0 * 2.0_f64.cbrt()).abs() < 1e-12);
}

/// A generator, its largest covering radius up to this level, and the sum over the levels.
type Candidate = ([u64; 3], f64, f64);

/// Begins with all odd generators of the first level and extends the best ones by each choice of
/// the next bit.
#[test]
fn the_generator_is_what_the_search_finds() {
    let odd_numbers = || (1..1_u64 << FIRST_LEVEL).step_by(2);
    let pairs = odd_numbers().flat_map(|second| odd_numbers().map(move |third| [1, second, third]));
    let mut best: Vec<Candidate> =
        pairs.filter(|[_, second, third]| second <= third).map(|g| (g, 0.0, 0.0)).collect();
    for level in FIRST_LEVEL..=LAST_LEVEL {
        let judged = |(generator, largest, sum): Candidate| {
            let radius = covering_radius(level, generator);
            (generator, largest.max(radius), sum + radius)
        };
        best = best.into_iter().map(judged).collect();
        best.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.2.total_cmp(&b.2)));
        best.truncate(KEPT);
        if level < LAST_LEVEL {
            let bit = 1 << level;
            let longer = |(g, largest, sum): Candidate| {
                [[0, 0], [bit, 0], [0, bit], [bit, bit]]
                    .map(|[second, third]| ([1, g[1] + second, g[2] + third], largest, sum))
            };
            best = best.into_iter().flat_map(longer).collect();
        }
    }
    let (generator, largest, _) = best[0];
    assert_eq!(generator, GENERATOR);
    assert!(largest < 0.7936, "{largest}");
}

/// Random places in the unit cube (xorshift; Marsaglia 2003, doi:10.18637/jss.v008.i14).
fn places(count: usize) -> Vec<[f64; 3]> {
    let mut state = 88_172_645_463_325_252_u64;
    let mut uniform = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        fraction(state)
    };
    (0..count).map(|_| [uniform(), uniform(), uniform()]).collect()
}

#[test]
fn gaussians_of_the_smallest_size_are_detected_with_99_percent() {
    const SHARE: f64 = 0.01;
    for points in [1024, 4096, 16_384] {
        let lattice: Vec<[f64; 3]> = (0..points).map(point).collect();
        let size = smallest_detected(points, SHARE);
        let places = places(4000);
        let is_detected = |place: &&[f64; 3]| {
            let square = |point: &[f64; 3]| -> f64 {
                point.iter().zip(*place).map(|(p, c)| (p - c).powi(2)).sum()
            };
            let nearest = lattice.iter().map(square).fold(f64::INFINITY, f64::min);
            (-0.5 * nearest / (size * size)).exp() > SHARE
        };
        let detected = places.iter().filter(is_detected).count() as f64 / places.len() as f64;
        assert!(detected >= 0.99, "{points} {detected}");
    }
}

#[test]
fn twice_the_points_are_a_lattice_too_and_none_lies_on_dyadic_planes() {
    for level in [7, 10, 14] {
        let number = 1_usize << level;
        let mut cells = [(); 3].map(|()| vec![0; number]);
        for at in (0..number).map(point) {
            for (along, cells) in at.into_iter().zip(&mut cells) {
                let scaled = along * number as f64;
                assert!((0.3..0.7).contains(&scaled.fract()), "{scaled}");
                cells[whole(scaled)] += 1;
            }
        }
        // Each slice along each axis contains one point.
        assert!(cells.iter().flatten().all(|&count| count == 1));
    }
}

#[test]
fn more_points_detect_smaller_structures() {
    assert!(smallest_detected(127, 0.01).is_infinite());
    assert_eq!(smallest_detected(2047, 0.01).to_bits(), smallest_detected(1024, 0.01).to_bits());
    assert!(smallest_detected(2048, 0.01) < smallest_detected(1024, 0.01));
    assert!(smallest_detected(1024, 0.001) < smallest_detected(1024, 0.01));
    for size in [0.04, 0.025, 0.01] {
        let points = points_to_detect(size, 0.01);
        assert!(
            smallest_detected(points, 0.01) <= size && smallest_detected(points / 2, 0.01) > size
        );
    }
    assert_eq!(points_to_detect(1.0, 0.01), FEWEST);
    assert_eq!(points_to_detect(0.0, 0.01), usize::MAX);
}
