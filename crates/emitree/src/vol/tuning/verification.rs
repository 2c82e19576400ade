//! The final verification, and the scattered samples that take part in it.

group! {
    /// The final verification, and the scattered samples that take part in it.
    Verification {
        /// The fewest scattered lines of one verification, shared among the sheets of a view. More
        /// lines detect errors on smaller parts of the image.
        least_lines: usize = 12, 6..=24;
        /// The error of the image of a fixed mesh, in units of the largest difference of a line of the
        /// verification beyond the error estimated there. Nodes are not added where a line differs,
        /// and other lines may differ more.
        fixed_margin: f64 = 2.0, 1.0..=4.0;
        /// The share of all evaluations so far that scattered lines of all verifications may cost.
        /// Smaller values verify expensive images with few lines; larger ones add to the cost of
        /// every image.
        share_of_evaluations: f64 = 0.1, 0.05..=0.2;
        /// The assumed cost of a line of the verification, in units of the mean cost of a full line
        /// of the tree: it is integrated a second time from finer depths.
        cost_of_line: f64 = 2.0, 1.0..=4.0;
        /// The number of lines at the largest estimated errors, as a share of that of scattered
        /// lines. It divides the cost between places where errors are expected and others.
        worst_share: f64 = 0.5, 0.25..=1.0;
        /// The number of scattered lines for each ascent to larger differences. Smaller values
        /// search beside more lines, at the cost of up to four lines for each step.
        lines_per_ascent: usize = 8, 4..=16;
        /// The number of steps of an ascent from a line. More steps reach maxima that are further
        /// away.
        line_ascent_steps: usize = 3, 1..=6;
        /// The most by which the number of lines is multiplied: it is doubled after each failed
        /// verification. Larger values are more certain and more expensive where verifications
        /// fail.
        most_line_factor: usize = 4, 2..=8;
        /// The smallest difference that an ascent from a line begins at, as a share of the error
        /// allowed. Smaller differences seldom belong to an error beyond it.
        line_ascent_from: f64 = 0.2, 0.1..=0.4;
        /// The largest difference of a line from the tree that passes in any case, as a share of
        /// the error allowed in a pixel. Smaller values refine images that meet T; larger ones pass
        /// images that do not.
        failure_share: f64 = 0.55, 0.275..=1.0;
        /// The largest difference of a line that passes, in units of the error estimated for its
        /// pixel. A line may have more than the mean over its pixel, but never more than the error
        /// allowed.
        estimate_margin: f64 = 1.5, 1.0..=3.0;
        /// The smallest change of an integral by finer depths that makes all lines of the sheet be
        /// integrated more carefully, as a share of the error allowed in a pixel. If two lines have
        /// to change, zodiacal light at 1 % is wrong by 1.02 %.
        depth_change_share: f64 = 0.4, 0.2..=0.8;
        /// The factor on the tolerance of all lines after the first verification in which finer
        /// depths changed an integral. It costs less than finer depths on all lines, which made a
        /// tolerance of 5 % up to 2.3 times as expensive as 2 %.
        stricter_factor: f64 = 0.25, 0.125..=0.5;
        /// The number of levels by which the lattice of depths of all lines becomes finer in each
        /// later such verification. All depth rules are fitted again each time, so that few large
        /// steps cost less than many small ones.
        depth_levels_per_step: u8 = 2, 1..=3;
        /// A lattice of depths that is finer than that of the base by this number of levels or more
        /// is not refined again. More levels resolve narrower peaks on every line.
        most_depth_levels: u8 = 4, 2..=6;
        /// The least distance along x or y of the lines at the largest estimated errors, as a
        /// fraction of the edge of the image. Smaller distances verify one maximum several times.
        worst_line_distance: f64 = 0.08, 0.04..=0.16;
        /// The number of levels by which the depths of a line of the verification are finer than
        /// those of nodes. With 0 it would have the same depths and could not detect what they step
        /// over.
        extra_depth_levels: u8 = 1, 0..=2;
        /// One in this many scattered lines has the depths of `dense_extra_levels`. Smaller values
        /// detect narrow peaks more often, at a higher cost.
        dense_line_stride: usize = 3, 1..=6;
        /// The number of further levels by which the depths of every scattered line that
        /// `dense_line_stride` selects are finer. Such lines detect peaks that all other lines step
        /// over.
        dense_extra_levels: u8 = 2, 1..=3;
        /// The least significance of a sample of a failed line whose depth is sampled on the nodes
        /// nearby, as a share of the tolerance of a line. Smaller values sample depths that do not
        /// matter there.
        shared_significance: f64 = 0.25, 0.125..=0.5;
        /// The number of levels by which the lattice of the lines of the verification is finer than
        /// the finest node. Values between nodes are predicted level by level, so that a finer
        /// lattice costs time.
        levels_below_nodes: u8 = 3, 2..=4;
        /// The coarsest level of the lattice of the lines of the verification. Coarser lattices
        /// would place them near nodes.
        coarsest_line_level: u8 = 10, 9..=11;
        /// The fewest scattered samples of a view. At 1024, 99 % of all Gaussians with a standard
        /// deviation of 1/40 of the edge of the cube have a value above 0.1 % of their amplitude at
        /// one of them.
        least_samples: usize = 1024, 512..=2048;
        /// The number of scattered samples as a share of all evaluations, so that expensive views
        /// are covered more finely at the same relative cost.
        sample_share: f64 = 0.05, 0.025..=0.1;
        /// The number of times that scattered samples are doubled if they do not cover the smallest
        /// feature that the options name. Each doubling doubles their cost and makes the size
        /// covered 1.26 times smaller.
        most_doublings: u32 = 3, 1..=6;
        /// The smallest effect on a pixel that an ascent from a scattered sample begins at, as a
        /// share of the error allowed. Smaller values follow rounding and errors of interpolation.
        sample_ascent_from: f64 = 0.02, 0.01..=0.04;
        /// The smallest effect on a pixel, as a share of the error allowed, from which the end of
        /// an ascent gets a line of the verification, or makes an interpolant be refined.
        sample_line_from: f64 = 0.2, 0.1..=0.4;
        /// The share of the amplitude of the smallest feature above which a sample detects it, if
        /// the lines around agree among themselves. It determines the number of samples for a
        /// requested feature size.
        detection_share: f64 = 4e-3, 0.002..=0.008;
        /// The least ratio of the size that samples detect to the finest spacing of the depths
        /// around a sample on its line. Larger values resolve the feature better, with more
        /// samples.
        feature_parts: f64 = 2.0, 1.0..=4.0;
        /// The number of nearest samples that may detect a Gaussian at a given place. Samples
        /// further away detect it only if it is so large that a nearer one does too.
        nearest_samples: usize = 16, 8..=32;
        /// The number of scattered samples for each ascent. Smaller values follow more of the
        /// largest differences, with up to 24 evaluations for each.
        samples_per_ascent: usize = 128, 64..=256;
        /// The number of steps of an ascent from a sample, each along all three axes. More steps
        /// reach the maximum of a feature from further down its slope.
        sample_ascent_steps: usize = 4, 2..=8;
        /// The length of the first step of an ascent, in units of the mean distance N^(−1/3) of N
        /// samples. Steps are halved when they find nothing larger.
        sample_ascent_step: f64 = 0.4, 0.2..=0.8;
    }
}
