//! Depth rules.

group! {
    /// Depth rules.
    Rule {
        /// The fewest lines that a depth rule is fitted to. Rules of fewer lines fail more often.
        least_lines: usize = 12, 6..=24;
        /// The fewest lines for each depth of a rule. With fewer the weights reproduce the lines of
        /// the fit but no others.
        lines_per_depth: usize = 3, 2..=6;
        /// The largest Σ |w| of the weights of a rule. Larger weights amplify rates that the rule
        /// does not represent.
        largest_weights: f64 = 20.0, 10.0..=40.0;
        /// The least value that is used for 1 − the leverage of a line. A line that determines a
        /// weight alone has no residual when it is left out.
        least_independence: f64 = 1e-3, 0.0005..=0.002;
        /// The largest change of the integral of a node by the last depth, in units of the largest
        /// one on the lines of the fit, beyond which the node is an outlier and is integrated in
        /// full.
        outlier_change: f64 = 1.25, 1.0..=2.5;
        /// The share of the tolerance that is added to that limit, and that a rate outside the
        /// range of the fit has to change the integral by. Smaller values integrate more nodes in
        /// full.
        outlier_tolerance: f64 = 0.5, 0.25..=1.0;
        /// The largest distance of a rate from the range of the rates of the fit, as a share of
        /// that range, for which a node is no outlier.
        outlier_range: f64 = 0.25, 0.125..=0.5;
        /// The margin around a block from which lines are used for its rule, as a share of its
        /// edge. Larger margins give more lines, and rules that have to hold on a larger part of
        /// the image.
        training_margin: f64 = 0.26, 0.13..=0.52;
        /// The factor for each level of a depth on its square sum among those from which the next
        /// depth of a rule is chosen. With 1 rules for different tolerances have few depths in common.
        finer_depth: f64 = 0.8, 0.6..=1.0;
        /// The most depths of a rule, as a share of the mean number of samples of a full line.
        /// Longer rules save too little.
        most_depths_share: f64 = 0.7, 0.35..=0.85;
        /// Of n nodes of a rule, this many times √n are integrated in full to validate it. More
        /// cost more; fewer detect failures later.
        validation_factor: f64 = 0.4, 0.2..=0.8;
        /// The margin around a quarter of a block in which a rule has failed, as a share of the
        /// edge of the quarter, whose nodes are integrated anew with it.
        failure_margin: f64 = 0.05, 0.025..=0.1;
        /// The most depths of a rule for a quarter in which another one has failed. Longer rules
        /// than usual still cost less than full lines.
        most_depths_after_failure: usize = 40, 20..=80;
        /// The smallest error on a validation line, in tolerances of a line, by which a rule fails.
        failure_tolerance: f64 = 1.0, 0.5..=2.0;
        /// The error of a rule on a later full line beside a node, in tolerances of a line, beyond which
        /// the node is integrated in full. Smaller values integrate nodes whose rule holds; with larger
        /// ones structure that the rule does not represent remains.
        contradiction: f64 = 2.0, 1.0..=4.0;
        /// Older lines are refined again if their error exceeds the tolerance by this factor. The
        /// tolerance changes a little in each round, with the largest pixel.
        refinement_margin: f64 = 1.02, 1.0..=2.04;
        /// The error of a rule of another emission, in units of its largest error on the full lines
        /// around. It was fitted to lines at these places, though not to these rates.
        given_rule_margin: f64 = 1.5, 1.0..=3.0;
    }
}
