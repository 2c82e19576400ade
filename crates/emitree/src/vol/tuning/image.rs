//! The image tree: remaining errors and the choice of nodes.

group! {
    /// The image tree: remaining errors and the choice of nodes.
    Image {
        /// Nodes are opened until the expected error of every pixel is below this share of T. It is
        /// below `stopping_share`, which allows for gains that are smaller than expected.
        pixel_goal: f64 = 0.7, 0.35..=0.85;
        /// The share of its contribution to the error map that opening a node is expected to
        /// remove. Smaller values open more nodes in a round, larger ones need more rounds.
        expected_gain: f64 = 0.95, 0.475..=0.975;
        /// The smallest contribution of a node to a pixel, as a share of T, for which it is opened.
        /// It saves time on nodes that do not matter.
        least_contribution: f64 = 1e-3, 0.0005..=0.002;
        /// The share of a detail one spacing away that the guarded detail of a node has at least.
        /// Smaller values end the refinement at accidentally small details; larger ones refine
        /// around structure.
        first_neighbour_guard: f64 = 0.5, 0.25..=1.0;
        /// The share of a detail two spacings away, where the side lobes of an unresolved peak lie,
        /// that the guarded detail of a node has at least.
        second_neighbour_guard: f64 = 0.3, 0.15..=0.6;
        /// The least share of a guarded detail that remains on the first level below the required
        /// ones. Smaller values rely more on the ratio to the guarded details of the required
        /// levels.
        first_least_decay: f64 = 0.4, 0.2..=0.8;
        /// The least share of a guarded detail that remains on all further levels. Smaller values
        /// rely more on the observed decay.
        least_decay: f64 = 0.15, 0.075..=0.3;
        /// The ratio of the share that remains to the observed ratio of guarded details to those of
        /// the coarser neighbours. It covers a decay that slows down.
        decay_margin: f64 = 3.0, 1.5..=6.0;
        /// The detail expected of a missing child, as a share of the largest detail beside it on
        /// its own level, or diagonally beside it on the next. Those may belong to a kink that is not
        /// in the details of coarser nodes, or to structure that continues beyond a resolved part.
        sibling_share: f64 = 0.25, 0.125..=0.5;
        /// The same share where g jumps, and kinks of the image are expected.
        sibling_share_of_kinks: f64 = 0.5, 0.25..=1.0;
        /// The factor on remaining errors where kinks are expected: their details do not decrease
        /// evenly with the level.
        kink_margin: f64 = 1.2, 1.0..=2.4;
        /// The least share of the remaining error of a node that remains once its diagonal children
        /// exist; otherwise their largest guarded detail does. Smaller values rely more on these
        /// four children.
        after_diagonals: f64 = 0.1, 0.05..=0.2;
        /// The finest level of the blocks for which depth rules are fitted. Smaller blocks have
        /// lower ranks but too few lines for a fit.
        finest_block_level: u8 = 3, 2..=4;
    }
}
