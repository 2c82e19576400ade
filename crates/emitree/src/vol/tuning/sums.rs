//! Sums over regions: the lines of sight that their errors are estimated from.

group! {
    /// Sums over regions: the lines of sight that their errors are estimated from.
    Sums {
        /// The number of pairs of lines in a region before its error is estimated. Fewer pairs make
        /// the standard error itself uncertain; more of them add to the cost of every sum.
        first_pairs: usize = 16, 8..=32;
        /// The number of points in a region before its error is estimated, where the image has a function
        /// of three coordinates. Fewer points make the standard error itself uncertain.
        first_points: usize = 256, 128..=512;
        /// The error in standard errors of the mean residual, which is added to the |mean|. Smaller values are
        /// exceeded more often; larger ones need more lines, in proportion to their square.
        deviations: f64 = 2.0, 1.5..=3.0;
        /// The error of the lines, as a share of that allowed in the sum. Smaller values
        /// take more evaluations for each line.
        line_share: f64 = 0.1, 0.05..=0.2;
        /// The level of the lattice of depths that each line begins with. A finer one detects thinner
        /// structure on lines, in twice as many evaluations.
        depth_level: u8 = 4, 3..=5;
        /// The share of all evaluations so far that more lines of a sum may cost before its pixels
        /// are refined instead. Smaller values refine pixels that are good enough; larger ones spend
        /// lines on residuals that refinement would reduce.
        share_of_evaluations: f64 = 0.5, 0.25..=1.0;
        /// The largest |mean residual| for which more lines are taken, as a share of the error allowed. More
        /// lines do not reduce it.
        mean_share: f64 = 0.5, 0.25..=0.75;
        /// The error aimed at by a refinement of the pixels, as a share of the error allowed. Smaller
        /// values refine too much; with larger ones another refinement is needed more often.
        goal: f64 = 0.5, 0.35..=0.7;
        /// The most by which one refinement divides the errors of pixels. Larger values trust the
        /// first estimate.
        most_tightening: f64 = 16.0, 8.0..=32.0;
    }
}
