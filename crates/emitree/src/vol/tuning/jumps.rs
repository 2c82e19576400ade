//! Jumps of lines, and their extrapolation from line to line.

group! {
    /// Jumps of lines, and their extrapolation from line to line.
    Jumps {
        /// The largest distance of two jumps that are matched with each other. Larger ones match
        /// jumps of different surfaces.
        farthest_match: f64 = 0.25, 0.125..=0.5;
        /// A jump has no partner on a neighbouring line that has fewer jumps of its sign within
        /// this distance than its own line within `own_distance`.
        partner_distance: f64 = 0.15, 0.1..=0.3;
        /// The distance within which jumps of the same line are counted for `partner_distance`. It
        /// is smaller, since surfaces are slanted.
        own_distance: f64 = 0.1, 0.05..=0.15;
        /// The largest distance of a jump from a sample that is taken to result from it.
        cause_distance: f64 = 0.1, 0.05..=0.2;
        /// The share of the gap between the two jumps of a pair on which a neighbouring line
        /// without the pair has to have a sample.
        probed_gap: f64 = 0.6, 0.3..=1.0;
        /// The number of full lines around a new one from which its jumps are predicted. The local
        /// fit uses at most 14 of them for each jump.
        most_neighbours: usize = 24, 12..=48;
        /// The number of nearest lines among which the one with the most jumps is the reference
        /// that others are matched to.
        reference_lines: usize = 4, 2..=8;
        /// Half of the width of a bracket, in units of the expected error of its middle. That is
        /// the error of the worst value: most are smaller, and a miss costs one sample or two.
        bracket_scale: f64 = 0.5, 0.25..=1.0;
        /// The share of the width of the jumps on neighbouring lines that is added to the expected
        /// error: their depths are uncertain by that.
        width_share: f64 = 0.5, 0.25..=1.0;
        /// The number of nearest lines whose jumps determine the width.
        width_lines: usize = 6, 3..=12;
        /// Half of the width of the widest bracket. Wider ones save no bisection: the jump is then
        /// sampled on both sides of its expected depth and bisected.
        widest_bracket: f64 = 0.06, 0.03..=0.12;
        /// The distance from the expected depth at which a jump without a bracket is sampled on
        /// both sides.
        probe_distance: f64 = 0.03, 0.015..=0.06;
        /// The probe between two jumps that may have met is at the coarsest depth that is less than
        /// `slack` times this, or times the error of their middle if that is larger, below the
        /// middle.
        pair_probe_width: f64 = 0.01, 0.005..=0.02;
        /// A probe replaces the brackets of a pair that may have vanished only if the error of its
        /// first jump is above this share of the error of the middle of the pair.
        own_fit_share: f64 = 0.1, 0.05..=0.2;
        /// The distance by which an end of a bracket may be moved outwards to a coarser depth, as a
        /// share of half of its width. Coarse depths are sampled on other lines too.
        slack: f64 = 0.5, 0.25..=1.0;
        /// The length of the interval that is searched after a miss, on the side on which the jump
        /// must be, in lengths of the former one. Larger values take fewer misses and leave longer
        /// intervals.
        search_stride: u32 = 3, 1..=6;
        /// The number of misses after which a jump is left to bisection from the depths of the
        /// base.
        most_misses: u8 = 3, 1..=6;
    }
}
