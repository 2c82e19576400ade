//! The loop: tolerances, levels and budgets.

group! {
    /// The loop: tolerances, levels and budgets.
    Engine {
        /// The loosest tolerance of a search. Looser requests are met at this one: with larger
        /// tolerances narrow structure stays undetected; smaller ones make loose requests more
        /// expensive.
        loosest_tolerance: f64 = 0.05, 0.025..=0.1;
        /// The least weight of the error of a pixel, in terms of the largest one of the pixels beside it,
        /// where weights are given. With 0 the pixels beside a mask do not converge.
        weight_beside: f64 = 0.25, 0.125..=0.5;
        /// The error that a line or a depth rule may have, as a share of T. Smaller values take
        /// more evaluations for each line; larger ones leave less of T for the interpolation
        /// between lines.
        line_share: f64 = 0.2, 0.1..=0.4;
        /// The loosest tolerance that lines are integrated for. Lines for looser ones step over
        /// narrow peaks, and a peak that only some lines have is refined as structure of the image.
        /// Of 60 anisotropic peaks 3 cost more than 1.15 times a tighter tolerance at 2 to 10 %, 4
        /// with lines for 2 %, and 10 without this limit; images to 10 % cost 8 % more with it.
        loosest_line_tolerance: f64 = 0.01, 0.005..=0.02;
        /// The spacing of the finest nodes is the largest power of 1/2 that is no larger than a
        /// pixel, divided by 2 to the power of this. More levels resolve edges within a pixel;
        /// fewer end the refinement of an unbounded image earlier.
        below_pixel_levels: u32 = 4, 3..=5;
        /// The finest level of nodes is at least this, on images of few pixels too: a large pixel
        /// may contain structure that is far smaller.
        fine_enough_level: u8 = 10, 9..=11;
        /// A budget below this many initial samplings is spent in stages, the first at the loosest
        /// tolerance. Without stages a budget that does not suffice is spent on the first lines
        /// instead of the whole image; stages cost evaluations that a sufficient budget does not
        /// need.
        short_budget: u64 = 300, 150..=600;
        /// Refinement stops when the largest estimated error is below this share of T. The rest is
        /// a margin for errors that the estimate does not contain. Below `image.pixel_goal` no node
        /// would be opened for the rest.
        stopping_share: f64 = 0.85, 0.7..=0.925;
        /// The number of times that the share of lines is halved when no node is left to be opened.
        /// More halvings meet T where errors of lines dominate; fewer end a search that cannot
        /// succeed earlier.
        most_halvings: u32 = 4, 2..=8;
        /// The cost of a node in the next round, relative to that in the last one, that the budget
        /// has to suffice for. Larger values leave evaluations unused; smaller ones start rounds
        /// that the budget does not allow.
        cost_margin: f64 = 1.3, 1.0..=2.6;
        /// The factor by which the expected cost of a node grows after a round that the budget did
        /// not allow. Smaller values take several attempts; larger ones give up rounds that would
        /// have been possible.
        overrun_factor: f64 = 3.0, 1.5..=6.0;
        /// T is relative to the largest |pixel|, or to this share of the largest ∫ |G| dz of a line
        /// if that is larger. The latter is the case only where positive and negative rates cancel
        /// and rounding dominates relative errors.
        cancellation_share: f64 = 1e-6, 5e-07..=2e-06;
        /// The fewest nodes of a round when the budget is nearly spent. Smaller rounds cost an
        /// assembly of the image and improve it little.
        least_round: usize = 8, 4..=16;
        /// The exponent a in evaluations ∝ T^−a, from which stages and forecasts are extrapolated:
        /// a tenfold precision costs two to three times as many evaluations on random scenes.
        cost_exponent: f64 = 0.4, 0.2..=0.8;
    }
}
