//! The values, with their reasons and the ranges in which their influence was measured.
//!
//! T is the tolerance, relative to the largest |pixel|. Depths and widths of lines are fractions of the
//! line, distances in the image plane fractions of its edge. Levels are those of dyadic lattices: one
//! level finer halves the spacing.

use super::tuning;

tuning! {
    /// The loop: tolerances, levels and budgets.
    engine: Engine {
        /// The loosest tolerance of a search. Looser requests are met at this one: with larger
        /// tolerances narrow structure stays undetected; smaller ones make loose requests more
        /// expensive.
        loosest_tolerance: f64 = 0.05, 0.025..=0.1;
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
    /// The final verification, and the scattered samples that take part in it.
    verification: Verification {
        /// The fewest scattered lines of one verification, shared among the sheets of a view. More
        /// lines detect errors on smaller parts of the image.
        least_lines: usize = 12, 6..=24;
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
        /// The number of lines in pixels that an edge crosses, where the image is continued from
        /// one side, as a share of that of scattered lines.
        edge_share: f64 = 0.5, 0.25..=1.0;
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
        /// The number of places tried in a pixel that an edge crosses, of which the first one in
        /// view is sampled. Fewer places miss narrow visible parts.
        places_in_pixel: usize = 16, 8..=32;
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
    /// Energies of a cube.
    spectra: Spectra {
        /// The share of T that the selected energies may leave unexplained in a voxel. Smaller
        /// values select more energies; larger ones leave less of T for the images.
        energy_share: f64 = 0.1, 0.05..=0.2;
        /// Once a spectrum exceeds `energy_share`, energies are selected until this share of it is
        /// met, so that the next spectra, which differ a little, do not each add one.
        selection_share: f64 = 0.5, 0.25..=1.0;
        /// The assumed ratio of the largest residual of all spectra to that of the sampled ones,
        /// which are explained best.
        unsampled_margin: f64 = 1.5, 1.0..=3.0;
        /// The number of points along each axis of a layer at which the first energy is searched
        /// for. More points meet smaller sources; their cube times the number of energies is the
        /// cost.
        initial_points: u32 = 4, 2..=8;
        /// The same number where there are more than `many_layers` layers, which together have
        /// enough points.
        initial_points_of_many: u32 = 2, 1..=4;
        /// The most layers that `initial_points` is used for. It keeps the cost of the first energy
        /// below that of the base lattice.
        many_layers: usize = 3, 1..=6;
        /// The level of the lattice on the energy axis on which the first energy is searched for.
        /// Finer lattices meet narrower spectra at a higher cost.
        initial_level: u8 = 2, 1..=3;
        /// The number of spectral probes on the base lines at the first energy. Fewer may miss a
        /// kind of spectrum; each costs 9 evaluations or more.
        first_probes: usize = 24, 12..=48;
        /// The number of spectral probes on the base lines for each later energy.
        later_probes: usize = 4, 2..=8;
        /// The number of spectral probes on the new lines of each round. Fewer detect new kinds of
        /// spectra later.
        round_probes: usize = 4, 2..=8;
        /// One in this many spectral probes samples every bin. Smaller values detect narrow lines
        /// more often, at the cost of a sample for each bin.
        full_probe_stride: usize = 3, 1..=6;
        /// The share of the brightest line above which a third of the spectral probes is chosen; a
        /// third is on the brightest lines and a third on any lines, since dark ones may be bright
        /// at other energies.
        dim_share: f64 = 1e-2, 0.005..=0.02;
        /// The number of depths by which spot checks of dark lines move from line to line. It has
        /// no common divisor with 9, the number of depths of the base, so that lines one after the
        /// other use all depths.
        depth_stride: usize = 5, 2..=10;
        /// Each base line has spot checks at one in this many energies of their lattice, other ones
        /// than its neighbours. Smaller values cost more evaluations.
        checked_parts: u32 = 8, 4..=16;
        /// The most selected energies for each bin; `more_energies` are added. Smaller values may
        /// leave spectra unexplained; each energy costs its base lines.
        energies_per_bin: usize = 2, 1..=4;
        /// The most selected energies in addition to those for each bin, for cubes of few bins.
        more_energies: usize = 16, 8..=32;
        /// The least value of a spectrum at the place of a new energy, as a share of its largest
        /// value. With a smaller one the normalised function, and its rounding, would be large
        /// elsewhere.
        least_pivot: f64 = 1e-3, 0.0005..=0.002;
        /// The share of a detail of a spectrum that is expected at the places one and two spacings
        /// away. It prevents an accidentally small detail from ending the refinement.
        neighbour_guard: f64 = 0.5, 0.25..=1.0;
        /// The ratio of the details of the next level to those of this one that is expected where
        /// they have not been sampled.
        decay: f64 = 0.5, 0.25..=1.0;
        /// The finest lattice of a spectrum that samples every bin; with more than 1024 bins only
        /// some of them are sampled.
        finest_full_level: u8 = 10, 9..=11;
        /// The coarsest lattice of spot checks. Emission lines are as narrow in few wide bins as in
        /// many narrow ones.
        least_checked_level: u8 = 7, 6..=8;
        /// The number of levels by which the lattice of spot checks is finer than one with a place
        /// in each bin. More levels detect narrower lines at a higher cost.
        checked_levels: u8 = 2, 1..=3;
        /// The finest lattice of spot checks, unless the bins themselves need a finer one. It
        /// limits the cost.
        finest_checked_level: u8 = 8, 7..=9;
        /// The most spectral probes that unexplained spot checks add. Several of them usually
        /// belong to one kind of spectrum.
        most_followed_checks: usize = 16, 8..=32;
        /// The least factor on the allowed error of a spectrum that becomes a function, whose
        /// errors are amplified where the volume is brighter. Smaller values refine spectra of
        /// faint points further.
        least_precision: f64 = 1e-4, 5e-05..=0.0002;
        /// The error that the refinement of a spectrum may leave, as a share of what the selected
        /// energies may leave unexplained. Larger values add errors of spectra to the residuals.
        spectrum_share: f64 = 0.1, 0.05..=0.2;
    }
    /// The image tree: remaining errors and the choice of nodes.
    image: Image {
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
        /// its own level. Those may belong to a kink that is not in the details of coarser nodes.
        sibling_share: f64 = 0.25, 0.125..=0.5;
        /// The same share where g jumps, and kinks of the image are expected.
        sibling_share_of_kinks: f64 = 0.5, 0.25..=1.0;
        /// The factor on remaining errors where kinks are expected: their details do not decrease
        /// evenly with the level.
        kink_margin: f64 = 1.2, 1.0..=2.4;
        /// The factor on remaining errors beside an edge, where the image is extrapolated and not
        /// interpolated.
        edge_margin: f64 = 3.0, 1.5..=6.0;
        /// The least share of the remaining error of a node that remains once its diagonal children
        /// exist; otherwise their largest guarded detail does. Smaller values rely more on these
        /// four children.
        after_diagonals: f64 = 0.1, 0.05..=0.2;
        /// The finest level of the blocks for which depth rules are fitted. Smaller blocks have
        /// lower ranks but too few lines for a fit.
        finest_block_level: u8 = 3, 2..=4;
    }
    /// Errors of lines, and depths taken from neighbouring lines.
    line: Line {
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
    /// Jumps of lines, and their extrapolation from line to line.
    jumps: Jumps {
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
    /// Depth rules.
    rule: Rule {
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
        /// Older lines are refined again if their error exceeds the tolerance by this factor. The
        /// tolerance changes a little in each round, with the largest pixel.
        refinement_margin: f64 = 1.02, 1.0..=2.04;
    }
    /// Sheets, continued values and coverage fractions.
    view: View {
        /// The least share of the base lines with a jump from which jumps are tracked from line to
        /// line, and kinks of the image are expected where surfaces turn away.
        rough_share: f64 = 0.03, 0.015..=0.06;
        /// The order of the predictions of such an image tree. Shorter stencils reach less far
        /// across kinks. Only even orders have symmetric stencils, and 6 is the order of smooth
        /// images.
        rough_order: usize = 4, 2..=6;
        /// The level whose spacing is the longest interval with a jump that counts for
        /// `rough_share`. A loose tolerance bisects jumps no further.
        rough_jump_level: u8 = 5, 4..=6;
        /// The fewest open nodes of the base lattice for which closed nodes are not evaluated.
        /// Fewer determine no continuation.
        least_open: usize = 6, 3..=12;
        /// A higher degree of the continuation is used if its expected error is below this many
        /// times that of the best lower one: a smooth function is smooth beyond the values too.
        /// With 1, views with bodies took 4 % more evaluations and a limb along rows was wrong by
        /// 1.4 times T; with 4, two of 160 views were wrong at 0.1 %.
        degree_preference: f64 = 2.0, 1.0..=4.0;
        /// The square of the distance at which the weight of a value of the continuation is a
        /// quarter, in units of the square of the nearest distance. Larger values use farther
        /// values more.
        quarter_weight: f64 = 8.0, 4.0..=16.0;
        /// The least value that is used for 1 − the leverage of a value of the continuation. A
        /// value that determines a coefficient alone has no residual when it is left out.
        least_independence: f64 = 0.1, 0.05..=0.2;
        /// The square of the distance at which the weight of a value of a local fit is a quarter,
        /// in units of the square of the nearest distance.
        fit_quarter_weight: f64 = 2.0, 1.0..=4.0;
        /// The least value that is used for 1 − the leverage of a value of a local fit. A value
        /// that determines a coefficient alone has no residual when it is left out.
        fit_least_independence: f64 = 0.1, 0.05..=0.2;
        /// The least ratio of the expected error at the origin of a local fit to the largest
        /// residual. The values are compared with the fit, the origin is not.
        fit_least_leverage: f64 = 0.5, 0.25..=1.0;
    }
    /// The low-rank approximation, its forecast and trial run.
    lowrank: Lowrank {
        /// The number of evaluations after which the first forecast is made. Earlier ones are based
        /// on too few ranks; later ones waste evaluations where the image tree is better.
        first_forecast: f64 = 600.0, 300.0..=1200.0;
        /// The estimated error, in units of the largest pixel, above which no forecast is made
        /// before `first_forecast_if_unknown` evaluations: it does not show a decrease yet.
        unknown_error: f64 = 1.5, 0.75..=3.0;
        /// The number of evaluations after which the first forecast is made if the error is above
        /// `unknown_error`.
        first_forecast_if_unknown: f64 = 2000.0, 1000.0..=4000.0;
        /// The factor by which evaluations grow from one forecast to the next. Smaller values take
        /// more time for trial runs; larger ones find later that the image tree is cheaper.
        forecast_interval: f64 = 1.3, 1.15..=2.6;
        /// The largest ratio of the expected cost of the image tree to that of its trial run for
        /// which one forecast decides. It is exceeded at tolerances below 1 %.
        extrapolation_ratio: f64 = 1.4, 1.0..=2.8;
        /// The number of forecasts in a row that have to prefer the image tree beyond that ratio.
        /// One made the random family 8 % more expensive at 0.1 %, and 13 % at 1e-4; two at 1 %
        /// cost nearly twice as much as the tree alone on one scene.
        forecasts_for_tree: u32 = 2, 1..=4;
        /// The ratio of the cost of the rest of a search to its extrapolation. Larger values prefer
        /// the image tree earlier.
        safety_factor: f64 = 1.5, 1.0..=3.0;
        /// The least decrease of ln(error) for each rank that a forecast assumes. It bounds the
        /// extrapolated rank.
        least_slope: f64 = 0.02, 0.01..=0.04;
        /// The most evaluations of a trial run, scaled to T, in units of the extrapolated cost of
        /// the rest of the search. A tree that costs more than `safety_factor` times the rest is
        /// not preferred in any case, so that larger values only take time.
        trial_run_limit: f64 = 2.0, 1.5..=4.0;
        /// The smallest change along an interval of a fiber, as a share of the largest residual,
        /// that is tested for a jump.
        least_steep_share: f64 = 0.3, 0.15..=0.6;
        /// The number of equal parts that the steepest interval of a fiber is divided into. On a
        /// smooth function each part soon has an equal share of the change.
        steep_parts: usize = 4, 2..=8;
        /// The number of times that the steepest part is divided. More steps distinguish steeper
        /// slopes from jumps.
        steep_steps: usize = 3, 1..=6;
        /// The least share of the change of an interval that one part has if there is a jump.
        jump_share: f64 = 0.7, 0.35..=0.85;
        /// The smallest budget for which a low-rank approximation is tried, in initial samplings of
        /// the image tree. Smaller budgets are left to the tree.
        least_budget: u64 = 4, 2..=8;
        /// The largest share of the budget, and of the time, that the search takes. The rest has to
        /// suffice for the image tree.
        most_budget_share: f64 = 0.25, 0.125..=0.5;
        /// The most pixels along a side of the image on which the error is estimated during the
        /// search. It limits the time for each rank.
        coarse_pixels: usize = 64, 32..=128;
        /// The smallest rate at a scattered sample that counts as detected, in units of the rate
        /// along a unit of depth that is the error allowed. Smaller ones are not distinguished from
        /// rounding and residuals.
        least_detected_rate: f64 = 0.02, 0.01..=0.04;
        /// The most functions along an axis. The cost grows with the cube of the rank, and the
        /// image tree is cheaper.
        most_functions: usize = 60, 30..=120;
        /// The share of the amplitude of a Gaussian that a probe has to have for its detection. A
        /// Gaussian whose column is 20 T times the largest pixel has an amplitude of 320 T of these
        /// at the smallest size that is required, and the error of a cell of the image with 16
        /// probes is T if one of them differs by 0.4 % of that.
        probe_detection_share: f64 = 1e-3, 0.0005..=0.002;
        /// The level of fibers beyond which the number of probes is doubled for each level: where G
        /// needs finer fibers, there may be more structure of that size.
        usual_fiber_level: u8 = 6, 5..=7;
        /// The ratio of the error of a pixel to the root mean square residual of its cell. The
        /// largest residual in a cell is larger than the mean.
        error_margin: f64 = 3.0, 1.5..=6.0;
        /// The level of the first places of fibers. With a finer one smooth fibers cost more; with
        /// a coarser one narrow peaks are missed.
        first_fiber_level: u8 = 4, 3..=5;
        /// The tolerance from which `finest_fiber_level_if_moderate` is used. With the finer level
        /// the β model of a narrow field costs 40 % more at 1 %.
        moderate_tolerance: f64 = 5e-3, 0.0025..=0.01;
        /// The finest level of fibers for tolerances from `moderate_tolerance` on. G that needs
        /// finer fibers is left to the image tree.
        finest_fiber_level_if_moderate: u8 = 7, 6..=8;
        /// The finest level of fibers for tolerances below `moderate_tolerance`.
        finest_fiber_level: u8 = 8, 7..=9;
        /// The number of probes at the beginning. It doubles when the error is within the
        /// tolerance.
        first_probes: usize = 128, 64..=256;
        /// Fibers are refined until the sum of their highest coefficients is below this share of
        /// the largest residual. Smaller values take more samples on each fiber.
        fiber_resolution: f64 = 0.2, 0.1..=0.4;
        /// The same share for the first fibers, which show how fine the structure is.
        first_fiber_resolution: f64 = 0.05, 0.025..=0.1;
        /// The least residual of a fiber, as a share of the largest residual, that adds a function.
        /// Smaller values add functions that reduce the error little.
        least_new_share: f64 = 0.1, 0.05..=0.2;
        /// The factor on the resolution and on the least residual of fibers when no fiber is
        /// refined and no function is added.
        threshold_reduction: f64 = 0.3, 0.15..=0.6;
        /// The number of thresholds that are tried for one cross, each reduced by
        /// `threshold_reduction`. If no fiber is refined and no function is added with the last
        /// one, G is not separable.
        most_reductions: u32 = 4, 2..=8;
        /// One in this many coefficients of a fiber, the highest ones, shows whether it is
        /// resolved.
        tail_divisor: usize = 6, 3..=12;
        /// The fewest highest coefficients that show whether a fiber is resolved. Every second one
        /// of an even function is 0.
        least_tail_length: usize = 3, 1..=6;
    }
}
