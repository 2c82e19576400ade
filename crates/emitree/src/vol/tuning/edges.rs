//! The search for edges of the emission around bodies.

group! {
    /// The search for edges of the emission around bodies.
    Edges {
        /// The budget for the search has to be this many times what it may take.
        least_budget: u64 = 8, 4..=16;
        /// The number of lines of sight towards each body. Fewer mistake an edge that is no sphere
        /// for one.
        lines: usize = 16, 8..=32;
        /// The lines reach this share of the way to the limb in the chart of the body. Closer to it
        /// heights are not resolved by depths.
        reach: f64 = 0.9, 0.8..=0.95;
        /// The number of depths of each line on which the emission begins above the body.
        depths: usize = 33, 17..=65;
        /// The lowest depth z, from the surface: at the surface itself the path of the chart is 0.
        lowest_depth: f64 = 1e-4, 1e-5..=1e-3;
        /// A rate that contributes less than this share of T, relative to the brightest, is dark.
        negligible_share: f64 = 0.03, 0.01..=0.1;
        /// A rate below this share of the brightest one on its line is dark.
        dark_share: f64 = 0.01, 0.003..=0.03;
        /// The fewest lines on which the emission begins.
        least_lines: usize = 4, 2..=8;
        /// The number of bisections after which a jump is distinguished from a slope, and the number
        /// of those that follow for a jump: to rounding.
        first_bisections: usize = 10, 8..=12;
        last_bisections: usize = 28, 26..=32;
        /// A rate is beyond a jump if it is so many times the largest dark one.
        jump_ratio: f64 = 10.0, 3.0..=30.0;
        /// The largest relative difference of the radii found on all lines of an edge.
        same_radius: f64 = 1e-6, 1e-7..=1e-5;
    }
}
