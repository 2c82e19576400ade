//! The depth of a chart, stretched where the emission is.
//!
//! If depths reach far beyond the emission, most places of z are dark. The density dt/dz of places is
//! the sum of a Lorentzian where the emission is and of the uniform density, so that no depth is without
//! samples. Both are analytic, with the nearest singularity as far from the interval as the Lorentzian
//! is wide: G is as smooth along t as it is along z.

/// The map from t to the depth z, both in \[0, 1\], with more places around a centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stretch {
    centre: f64,
    /// Half of the width of the Lorentzian at half of its maximum.
    width: f64,
    /// The share of places that are uniform.
    pub(crate) uniform: f64,
    /// The arc tangents of the distances of both ends from the centre, in units of the width.
    ends: [f64; 2],
}

impl Stretch {
    /// More places around the depth `centre`, and a share `uniform` of all places everywhere.
    pub(crate) fn about(centre: f64, width: f64, uniform: f64) -> Self {
        let ends = [0.0, 1.0].map(|end| ((end - centre) / width).atan());
        Self { centre, width, uniform, ends }
    }

    /// The share of the places about the centre for each radian of the arc tangent.
    fn share_of_radian(&self) -> f64 {
        let [from, to] = self.ends;
        (1.0 - self.uniform) / (to - from)
    }

    /// The place t of the depth z, beyond \[0, 1\] if z is.
    pub(crate) fn place_of(&self, z: f64) -> f64 {
        let x = (z - self.centre) / self.width;
        self.uniform * z + self.share_of_radian() * (x.atan() - self.ends[0])
    }

    /// dt/dz at the depth z.
    fn density(&self, z: f64) -> f64 {
        let x = (z - self.centre) / self.width;
        self.uniform + self.share_of_radian() / (self.width * (1.0 + x * x))
    }

    /// dz/dt at the depth z.
    pub(crate) fn slope_at(&self, z: f64) -> f64 {
        1.0 / self.density(z)
    }

    /// The depth z at the place t, and dz/dt.
    pub(crate) fn at(&self, t: f64) -> (f64, f64) {
        /// As many bisections find z to rounding; Newton's steps need about five.
        const MOST_STEPS: usize = 60;
        if t <= 0.0 || t >= 1.0 {
            let z = t.clamp(0.0, 1.0);
            return (z, self.slope_at(z));
        }
        let (mut low, mut high) = (0.0, 1.0);
        let [from, to] = self.ends;
        let lorentzian = self.centre + self.width * (from + t * (to - from)).tan();
        let mut z = lorentzian.clamp(0.0, 1.0);
        for _ in 0..MOST_STEPS {
            let (place, density) = (self.place_of(z), self.density(z));
            if place < t {
                low = z;
            } else {
                high = z;
            }
            let next = z - (place - t) / density;
            let next = if next > low && next < high { next } else { 0.5 * (low + high) };
            let is_found = (next - z).abs() <= f64::EPSILON;
            z = next;
            if is_found {
                break;
            }
        }
        (z, self.slope_at(z))
    }
}

/// The parts of the unit interval at whose ends the map is computed in advance: most samples of lines are at
/// dyadic places, and Newton's steps take longer than a cheap g.
const PARTS: usize = 1024;

/// A stretch, with its map at the multiples of a part.
#[derive(Clone, Debug)]
pub(crate) struct StretchTable {
    stretch: Stretch,
    known: Vec<(f64, f64)>,
}

impl StretchTable {
    pub(crate) fn new(stretch: Stretch) -> Self {
        let known = (0..=PARTS).map(|k| stretch.at(k as f64 / PARTS as f64)).collect();
        Self { stretch, known }
    }

    /// As [`Stretch::at`].
    pub(super) fn at(&self, t: f64) -> (f64, f64) {
        let parts = t * PARTS as f64;
        let is_known = (0.0..=PARTS as f64).contains(&parts) && parts.fract() == 0.0;
        if is_known { self.known[crate::cell::whole(parts)] } else { self.stretch.at(t) }
    }

    /// As [`Stretch::place_of`].
    pub(super) fn place_of(&self, z: f64) -> f64 {
        self.stretch.place_of(z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_stay_and_places_are_inverted() {
        for (centre, width) in [(0.2, 0.02), (0.9, 0.3), (0.5, 0.015)] {
            let stretch = Stretch::about(centre, width, 0.2);
            assert!(stretch.at(0.0).0.abs() < 1e-14 && (stretch.at(1.0).0 - 1.0).abs() < 1e-14);
            for t in (0..=20).map(|i| f64::from(i) / 20.0) {
                let (z, slope) = stretch.at(t);
                assert!((stretch.place_of(z) - t).abs() < 1e-12, "{t}");
                assert!((stretch.slope_at(z) / slope - 1.0).abs() < 1e-12, "{t}");
                let step = 1e-5;
                let [below, above] = [t - step, t + step].map(|t| stretch.at(t).0);
                if (step..=1.0 - step).contains(&t) {
                    let difference = (above - below) / (2.0 * step);
                    assert!((difference / slope - 1.0).abs() < 1e-6, "{t}");
                }
            }
        }
    }

    #[test]
    fn a_tenth_of_the_depth_has_a_third_of_the_places() {
        let stretch = Stretch::about(0.3, 0.05, 0.5);
        let share = stretch.place_of(0.35) - stretch.place_of(0.25);
        assert!((0.3..0.35).contains(&share), "{share}");
    }
}
