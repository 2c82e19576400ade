//! Errors of lines, and depths taken from neighbouring lines.

group! {
    /// Errors of lines, and depths taken from neighbouring lines.
    Line {
        /// The least ratio of the slope of an interval with a jump to the sum of the slopes of both
        /// neighbours. Smaller values take steep smooth slopes for jumps; larger ones miss jumps
        /// and interpolate across them.
        jump_steepness: f64 = 4.0, 2.0..=8.0;
        /// The |error| of an interval with a jump, in units of its length times the jump. The
        /// trapezoid is wrong by at most 0.5 of these; the rest is for the image tree, in which
        /// errors of jumps appear as roughness.
        jump_error: f64 = 1.0, 0.5..=2.0;
        /// The smallest product of a jump and its interval, as a share of the tolerance of the
        /// line, that counts as a jump. Smaller steps do not matter as jumps.
        least_jump: f64 = 0.02, 0.01..=0.04;
        /// The length below which an interval with a small step is tested for a jump all the same:
        /// a jump has been bisected there, and no polynomial may cross it.
        always_tested_length: f64 = 0.002, 0.001..=0.004;
        /// Jumps are bisected until the expected error of the line is below this share of its
        /// tolerance. Smaller values take more bisections at once, larger ones more steps.
        bisection_goal: f64 = 0.9, 0.45..=0.95;
        /// The share of the error of a jump that one bisection is expected to remove: the interval
        /// becomes half as long.
        bisection_gain: f64 = 0.5, 0.25..=1.0;
        /// The smallest product of the length and the larger end of a segment with two samples, as
        /// a share of the tolerance, for which a sample inside is taken.
        short_segment: f64 = 0.25, 0.125..=0.5;
        /// The share of the intervals beside a sample next to the end of a segment over which its
        /// detail changes the integral: half of each, and half as much for the extrapolation.
        effect_at_end: f64 = 0.75, 0.375..=0.875;
        /// The share of the sum of |effects| that is added to the |sum| of effects of neighbouring
        /// samples, where they may cancel by accident.
        cancellation_guard: f64 = 0.1, 0.05..=0.2;
        /// The least share of a significance that remains beside a sample. Smaller values rely more
        /// on the observed decay.
        least_decay: f64 = 0.125, 0.0625..=0.25;
        /// The ratio of the share that remains to the observed ratio of significances to those of
        /// the coarser neighbours. It covers a decay that slows down.
        decay_margin: f64 = 3.0, 1.5..=6.0;
        /// Places with a remaining error above this share of the largest one are sampled in the
        /// same step. Smaller values take more samples than needed; larger ones take more steps.
        /// With 1 none would be above it.
        batch_share: f64 = 0.5, 0.25..=0.75;
        /// Places with a remaining error above this share of the tolerance are sampled in any step,
        /// so that lines end after few steps.
        negligible: f64 = 0.125, 0.0625..=0.25;
        /// The length of the shortest segment of two samples that is sampled inside, in steps of
        /// 2^−24. Shorter ones cannot be divided on a lattice.
        least_length: u32 = 16, 8..=32;
        /// The most coarser samples on each side that predict a sample. More would be further away,
        /// and the polynomial has room for six.
        predictors: usize = 3, 2..=3;
        /// The length of the longest interval with a jump whose ends count as ends of segments. A
        /// jump in a longer one may turn out to be a steep slope.
        resolved_interval: f64 = 0.03, 0.015..=0.06;
        /// The finest level of the depths near jumps that neighbouring lines are sampled at too.
        /// Finer ones follow the jump of this line; those of its neighbours are elsewhere.
        shared_jump_level: u8 = 6, 5..=7;
        /// The least significance of a sample, in tolerances of a line, whose depth is sampled on
        /// neighbouring lines too. Smaller values cost samples on each neighbour; larger ones end
        /// the tracking of narrow structure.
        shared_significance: f64 = 2.0, 1.0..=4.0;
        /// The least ratio of the interval of a neighbouring line around a depth to the spacing of
        /// the sample there for which the neighbour counts as coarse and is sampled.
        coarse_ratio: u32 = 4, 2..=8;
        /// The most steps from line to line in which structure is followed within one round. The
        /// next round continues.
        most_hops: usize = 6, 3..=12;
        /// The number of nearest full lines whose depths a new line starts with. More lines give
        /// depths that it may not need.
        starting_lines: usize = 4, 2..=8;
        /// The finest level of the depths that a new line takes from lines with jumps. Finer ones
        /// belong to their jumps.
        starting_level: u8 = 7, 6..=8;
        /// The least significance, as a share of the tolerance, of the samples whose depths a new
        /// line takes from lines with jumps. Less significant ones were sampled to bisect jumps or
        /// to verify a decay.
        starting_significance: f64 = 0.25, 0.125..=0.5;
        /// The level whose spacing is the longest interval of a resolved jump. No depth rule is
        /// fitted to lines with one: its weights would fit the places of the jumps.
        resolved_jump_level: u8 = 7, 6..=8;
    }
}
