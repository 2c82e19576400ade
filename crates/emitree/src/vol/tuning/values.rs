//! The values, with their reasons and the ranges in which their influence was measured.

use super::tuning;

tuning! {
    /// The loop: tolerances, levels and budgets.
    engine: Engine {
        /// Looser requests are met at this tolerance: a looser search does not find the structure.
        loosest_tolerance: f64 = 0.05, 0.025..=0.1;
        /// The share of the tolerance that a line or a depth rule may take.
        line_share: f64 = 0.2, 0.1..=0.4;
        /// Lines are integrated as for this tolerance if a looser one is asked for: looser lines step over peaks,
        /// and what some lines have and others have not looks like structure of the image, which is expensive. Of 60
        /// anisotropic peaks 3 cost more than 1.15 times a tighter tolerance at 2 to 10 %, 4 with lines for 2 %,
        /// and 10 without this; images to 10 % cost 8 % more for it.
        loosest_of_lines: f64 = 0.01, 0.005..=0.02;
        /// Nodes are no closer to each other than 2^−this of a pixel…
        below_pixel_levels: u32 = 4, 3..=5;
        /// …but on an image of few pixels may be as close as this level.
        fine_enough_level: u8 = 10, 9..=11;
        /// A budget below this many times the first look may be short: then the tolerance is approached in
        /// steps, so that the evaluations go into the whole image and not into the digits of its first lines.
        short_budget: u64 = 300, 150..=600;
        /// The largest estimate has to be within this share of the tolerance.
        stop: f64 = 0.85, 0.425..=0.925;
        /// If lines are all that is left to be improved, their share is halved this often.
        most_halvings: u32 = 4, 2..=8;
        /// A round may cost this much more for each node than the one before.
        cost_margin: f64 = 1.3, 0.65..=2.6;
        /// A round that the budget did not allow has cost this much more than was expected, at the least.
        overrun_factor: f64 = 3.0, 1.5..=6.0;
        /// An image whose pixels cancel below this share of ∫ |G| dz on a line is good enough if it is good to
        /// the tolerance of that.
        cancelled: f64 = 1e-6, 5e-07..=2e-06;
        /// A round of fewer nodes is not worth another one, when the budget is all but spent.
        least_round: usize = 8, 4..=16;
        /// Evaluations grow like the tolerance to the power of −this, roughly: a tenfold precision costs two
        /// to three times as many.
        cost_exponent: f64 = 0.4, 0.2..=0.8;
    }
    /// The final verification, and the scattered samples that take part in it.
    verification: Verification {
        /// Scattered lines of one exam, at the least, shared among the sheets of a view…
        least_lines: usize = 12, 6..=24;
        /// …and, with those of exams before, as many as this share of all evaluations so far pays for, if each costs
        /// this many times as much as those that are integrated in full.
        share_of_evaluations: f64 = 0.1, 0.05..=0.2;
        /// …
        cost_of_line: f64 = 2.0, 1.0..=4.0;
        /// Lines where the estimated error is largest, as a share of the scattered ones.
        worst_share: f64 = 0.5, 0.25..=1.0;
        /// Lines beside edges, where the image is continued from one side, as a share of the scattered ones.
        edge_share: f64 = 0.5, 0.25..=1.0;
        /// One ascent to larger differences for so many scattered lines…
        lines_per_ascent: usize = 8, 4..=16;
        /// …in so many steps.
        steps_of_ascent: usize = 3, 1..=6;
        /// After an exam that failed both numbers are doubled, up to this many times as many.
        most_lines: usize = 4, 2..=8;
        /// An ascent begins at a difference of more than this share of the error allowed.
        ascent_from: f64 = 0.2, 0.1..=0.4;
        /// A line fails if what it differs by is more than this share of the error allowed in a pixel.
        failed: f64 = 0.55, 0.275..=1.1;
        /// …and of the error estimated there, of which a line may have more than the mean over its pixel; but no
        /// line may differ by more than the error allowed.
        over_estimate: f64 = 1.5, 0.75..=3.0;
        /// If that changes the integral by more than this share of the error allowed in a pixel, all lines of the
        /// sheet are integrated more carefully (if two lines have to be changed, zodiacal light at 1 % is wrong by
        /// 1.02 %):…
        stepped_over: f64 = 0.4, 0.2..=0.8;
        /// …first to a tolerance stricter by this, where they have samples that lead on; that costs less than depths
        /// everywhere, which made a tolerance of 5 % up to 2.3 times as expensive as 2 %…
        stricter: f64 = 0.25, 0.125..=0.5;
        /// …then on a lattice of depths finer by so many levels at once, since the rules of all other nodes have to
        /// be learned anew each time…
        finer_at_once: u8 = 2, 1..=3;
        /// …and finer than that of the base by so many levels at the most.
        most_finer: u8 = 4, 3..=5;
        /// These are at least this far from each other, as a share of the image's edge.
        worst_apart: f64 = 0.08, 0.04..=0.16;
        /// Places in a pixel that an edge crosses, of which the first that is in view is taken.
        places_in_pixel: usize = 16, 8..=32;
        /// Once a line is integrated as a node would be, it is sampled at all depths of a lattice finer than
        /// that of nodes by so many levels…
        finer_depths: u8 = 1, 0..=2;
        /// …and one in so many scattered lines by this many more levels: what all others step over, it sees.
        dense_lines: usize = 3, 1..=6;
        /// …
        denser: u8 = 2, 1..=3;
        /// Samples of a line that failed are given to nodes nearby if their significance is beyond this share of
        /// the tolerance of a line.
        shared_significance: f64 = 0.25, 0.125..=0.5;
        /// Lines are put on a lattice finer than the finest nodes by so many levels, or on this one: values
        /// between nodes are predicted level by level.
        levels_below_nodes: u8 = 3, 2..=4;
        /// …
        coarsest_lattice: u8 = 10, 5..=20;
        /// Scattered samples of a view, at the least: they see a Gaussian of 1/40 of the cube's edge.
        least_samples: usize = 1024, 512..=2048;
        /// …and this share of all evaluations, so that expensive views are covered more finely.
        samples_of_evaluations: f64 = 0.05, 0.025..=0.1;
        /// Samples are doubled this often if a feature that was asked for is not covered.
        most_doublings: u32 = 3, 1..=6;
        /// No ascent begins below this share of the error allowed.
        sample_ascent_from: f64 = 0.02, 0.01..=0.04;
        /// What an ascent has found gets a line of the exam, or goes into an interpolant, from this share of the
        /// error allowed on.
        line_from: f64 = 0.2, 0.1..=0.4;
        /// A feature of which a sample has this share of its amplitude is seen, if the lines around agree among
        /// themselves: what more samples are made for when a smaller feature is asked for.
        seen_share: f64 = 4e-3, 0.002..=0.008;
        /// Levels of depths around a sample on its line, down to a part of the feature.
        feature_parts: f64 = 2.0, 1.0..=4.0;
        /// Samples near a place that may see a feature there.
        near: usize = 16, 8..=32;
        /// One ascent for so many scattered samples…
        samples_per_ascent: usize = 128, 64..=256;
        /// …in so many steps, each along all three axes…
        ascent_steps: usize = 4, 2..=8;
        /// …the first of which have this share of the distance of the samples.
        first_step: f64 = 0.4, 0.2..=0.8;
    }
    /// Energies of a cube.
    spectra: Spectra {
        /// The share of the tolerance that the energies may leave unexplained.
        energy_share: f64 = 0.1, 0.05..=0.2;
        /// New energies are learned until they leave this share of that: the next spectra differ a little.
        selected_share: f64 = 0.5, 0.25..=1.0;
        /// Spectra that nobody has sampled are worse explained than those that have been, by this much.
        unseen_margin: f64 = 1.5, 0.75..=3.0;
        /// Before anything is known G is sampled at so many points along each axis…
        initial_points: u32 = 4, 2..=8;
        /// …or at so many of each layer, if there are more layers than this…
        initial_points_of_many: u32 = 2, 1..=4;
        /// …
        many_layers: usize = 3, 1..=6;
        /// …and on the energy axis on the lattice of this level.
        initial_level: u8 = 2, 1..=3;
        /// Scouts on the base lines of the first energy.
        first_probes: usize = 24, 12..=48;
        /// Scouts on the base lines of each later one.
        later_probes: usize = 4, 2..=8;
        /// Scouts on the new lines of each round.
        round_probes: usize = 4, 2..=8;
        /// One scout in so many looks into every bin.
        full_probes: usize = 3, 1..=6;
        /// A third of the scouts are where lines are brightest, a third on lines beyond this share of the
        /// brightest one, and a third anywhere: at other energies they may be bright.
        dim: f64 = 1e-2, 0.005..=0.02;
        /// From line to line spot checks of dark lines go on by so many depths.
        depth_stride: usize = 5, 2..=10;
        /// Each line of the base is checked at one of so many energies.
        checked_parts: u32 = 8, 4..=16;
        /// The most energies: this many for each bin, and some more.
        energies_per_bin: usize = 2, 1..=4;
        /// …
        more_energies: usize = 16, 8..=32;
        /// An energy at which a spectrum has less than this share of its largest value is nothing to learn
        /// from: the function would be as many times too large elsewhere, and its rounding with it.
        least_pivot: f64 = 1e-3, 0.0005..=0.002;
        /// Share of a detail that guards those beside it.
        guard: f64 = 0.5, 0.25..=1.0;
        /// What is expected of the details that have not been looked at, from those above them.
        decay: f64 = 0.5, 0.25..=1.0;
        /// The finest lattice that looks into every bin; with more bins than that, into some of them.
        finest_full_level: u8 = 10, 9..=11;
        /// The lattice of spot checks, for few bins: a line is as narrow in a wide bin as in a narrow one…
        least_checked_level: u8 = 7, 6..=8;
        /// …is finer than the bins by so many levels…
        checked_levels: u8 = 2, 1..=3;
        /// …up to this one.
        finest_checked_level: u8 = 8, 7..=9;
        /// The most scouts that spot checks may send.
        most_followed: usize = 16, 8..=32;
        /// No spectrum has to be more precise than others by more than this.
        least_precision: f64 = 1e-4, 5e-05..=0.0002;
        /// What the refinement of a spectrum may leave, as a share of what its energies may.
        spectrum_share: f64 = 0.1, 0.05..=0.2;
    }
    /// The image tree: remaining errors and the choice of nodes.
    image: Image {
        /// Every pixel is to be expected below this share of the tolerance.
        goal: f64 = 0.7, 0.35..=0.85;
        /// What opening a node takes away of its contribution.
        expected_gain: f64 = 0.95, 0.475..=0.975;
        /// A contribution below this share of the tolerance is left alone.
        least_contribution: f64 = 1e-3, 0.0005..=0.002;
        /// Share of the details one spacing away that guards a node's own.
        next_guard: f64 = 0.5, 0.25..=1.0;
        /// Share of the details two spacings away: the side lobes of an unresolved peak lie there.
        second_guard: f64 = 0.3, 0.15..=0.6;
        /// What remains is at least this share of a guarded detail on the first level with any decay…
        first_least_decay: f64 = 0.4, 0.2..=0.8;
        /// …and this below it…
        least_decay: f64 = 0.15, 0.075..=0.3;
        /// …and else this times the decay from the coarser neighbours.
        decay_margin: f64 = 3.0, 1.5..=6.0;
        /// A missing child differs by this share of the details beside it, on its own level: they may have
        /// found the next part of a kink, of which coarser nodes chanced to see nothing…
        sibling_share: f64 = 0.25, 0.125..=0.5;
        /// …and by this share where g jumps, and kinks are expected.
        sibling_share_of_kinks: f64 = 0.5, 0.25..=1.0;
        /// Kinks leave this much more than their details tell: those do not shrink evenly with the level.
        kink_margin: f64 = 1.2, 0.6..=2.4;
        /// Beside an edge the image is extrapolated, which is so much worse than interpolation.
        edge_margin: f64 = 3.0, 1.5..=6.0;
        /// Once the diagonal children are there, what remains is their largest guarded detail, or this share
        /// of what remained before.
        after_diagonals: f64 = 0.1, 0.05..=0.2;
        /// The finest blocks that are tried: smaller ones have too few lines to learn from.
        finest_blocks: u8 = 3, 2..=4;
    }
    /// Errors of lines, and what neighbours share.
    line: Line {
        /// A jump is this much steeper than both neighbours together.
        jump_steepness: f64 = 4.0, 2.0..=8.0;
        /// |error| of an interval with a jump, in units of its length times the jump: the jump may be at
        /// either end, and then the trapezoid is wrong by half of this; the rest is for the image tree, to
        /// which what is left of jumps looks like roughness.
        jump_error: f64 = 1.0, 0.5..=2.0;
        /// A jump that is smaller than this share of the tolerance, times its interval, is none…
        least_jump: f64 = 0.02, 0.01..=0.04;
        /// …unless the interval is shorter than this: there a jump has been closed in on, and no polynomial
        /// may run through it…
        narrow: f64 = 0.002, 0.001..=0.004;
        /// Jumps are bisected until the error is expected to be this share of the tolerance…
        bisected: f64 = 0.9, 0.45..=0.95;
        /// …with this share of their own error gone for each bisection.
        bisection_gain: f64 = 0.5, 0.25..=1.0;
        /// A segment of two ends is sampled inside if more than this share of the tolerance is on it.
        short_segment: f64 = 0.25, 0.125..=0.5;
        /// Share of the intervals beside a sample next to the end of a segment that its detail can change:
        /// half of each, and half as much again.
        effect_at_end: f64 = 0.75, 0.375..=0.875;
        /// Share of the |effects| that is added to what is left of them when neighbours cancel: an
        /// accidental zero is not trusted.
        cancellation_guard: f64 = 0.1, 0.05..=0.2;
        /// What remains is at least this share of a significance…
        least_decay: f64 = 0.125, 0.0625..=0.25;
        /// …and else this times the decay from the coarser neighbours.
        decay_margin: f64 = 3.0, 1.5..=6.0;
        /// Of what remains, the largest are looked at together, down to this share of the largest…
        together: f64 = 0.5, 0.25..=1.0;
        /// …or to this share of the tolerance, if that is less.
        negligible: f64 = 0.125, 0.0625..=0.25;
        /// Segments of fewer steps are not divided.
        least_length: u32 = 16, 8..=32;
        /// Coarser neighbours that predict a sample on each side; more would only be further away.
        predictors: usize = 3, 2..=4;
        /// A jump in a longer interval may turn out to be a steep slope, and its ends are no ends then.
        closed_in: f64 = 0.03, 0.015..=0.06;
        /// Depths of a line beyond this level, if jumps are near, are its own: neighbours jump elsewhere.
        shared_jump_level: u8 = 6, 5..=7;
        /// A sample is looked for on neighbouring lines if its significance is beyond this many tolerances.
        shared_significance: f64 = 2.0, 1.0..=4.0;
        /// Neighbours that are coarser than this there, in units of the sample's own spacing.
        coarser: u32 = 4, 2..=8;
        /// Steps from line to line that something found is followed in one round.
        most_hops: usize = 6, 3..=12;
        /// Lines whose depths a new line starts with.
        nearest: usize = 4, 2..=8;
        /// If one of those has a jump, depths beyond this level are not taken from them…
        starting_level: u8 = 7, 6..=8;
        /// …nor samples with a significance below this share of the tolerance: they were made to close in on
        /// jumps, or to look whether there is more.
        starting_significance: f64 = 0.25, 0.125..=0.5;
        /// A jump within an interval as short as the spacing of this level has been resolved: lines with one
        /// have no rule, it would fit where the jumps happen to be.
        resolved_jump_level: u8 = 7, 6..=8;
    }
    /// Jumps of lines, and their extrapolation from line to line.
    jumps: Jumps {
        /// Jumps farther apart than this are not taken for the same, even if they are each other's nearest.
        farthest_match: f64 = 0.25, 0.125..=0.5;
        /// A jump has no partner on a line that has fewer of its sign within this distance…
        partners: f64 = 0.15, 0.075..=0.3;
        /// …than its own line has within this one, which is smaller as surfaces are slanted.
        own: f64 = 0.1, 0.05..=0.2;
        /// A sample this near to a jump was made because of it.
        caused: f64 = 0.1, 0.05..=0.2;
        /// The part of the gap of a pair on which a line without the pair should have a sample.
        probed_gap: f64 = 0.6, 0.3..=1.2;
        /// Full lines around a new one that are asked.
        neighbours: usize = 24, 12..=48;
        /// The line with the most jumps among as many of the nearest is the one that others are matched to.
        references: usize = 4, 2..=8;
        /// Half of a bracket, in units of the expected error of its middle. It is the error of the worst of
        /// the values: most are better, and a miss costs one sample or two.
        bracket: f64 = 0.5, 0.25..=1.0;
        /// Share of the width of the jumps on the neighbours that is added to the error: their middle is
        /// known no better.
        known_within: f64 = 0.5, 0.25..=1.0;
        /// Neighbours whose widths count.
        widths: usize = 6, 3..=12;
        /// Half brackets wider than this narrow nothing down: the jump is probed at its place and left to
        /// bisection.
        widest: f64 = 0.06, 0.03..=0.12;
        /// Probes of such a jump are made this near to its place.
        probed: f64 = 0.03, 0.015..=0.06;
        /// The half width of the probe between two jumps that may have met, at the least.
        closed: f64 = 0.01, 0.005..=0.02;
        /// A pair takes over from a jump's own fit only if that is worse than this share of the error of
        /// the middle.
        own_fit: f64 = 0.1, 0.05..=0.2;
        /// A sample may be farther from the jump than the end of the bracket by this share of half of it:
        /// coarse depths are those that other lines have too.
        slack: f64 = 0.5, 0.25..=1.0;
        /// After a miss, the search goes on this many brackets to the side on which the jump must be.
        stride: u32 = 3, 1..=6;
        /// Misses after which the jump is left to bisection.
        most_misses: u8 = 3, 1..=6;
    }
    /// Depth rules.
    rule: Rule {
        /// Lines to learn from, at the least.
        least_lines: usize = 12, 6..=24;
        /// Lines for each depth, at the least: fewer would be fitted rather than understood.
        lines_per_depth: usize = 3, 1..=6;
        /// Σ |w|: larger weights amplify what a rule gets wrong.
        largest_weights: f64 = 20.0, 10.0..=40.0;
        /// 1 − leverage, at the least: a line that a depth is all about can't be left out.
        least_independence: f64 = 1e-3, 0.0005..=0.002;
        /// A node's values are odd if the last depth changes more than this times what is usual…
        outlier_change: f64 = 1.25, 0.625..=2.5;
        /// …plus this share of the tolerance…
        outlier_tolerance: f64 = 0.5, 0.25..=1.0;
        /// …or if a value lies outside the range by this share of it, and that matters.
        outlier_range: f64 = 0.25, 0.125..=0.5;
        /// Lines around a block that are learned from too, as a share of its edge.
        training_margin: f64 = 0.26, 0.13..=0.52;
        /// A rule of more depths than this share of a full line's samples saves too little.
        most_depths: f64 = 0.7, 0.35..=0.85;
        /// Of n nodes of a rule, this many times √n get a full line.
        validated: f64 = 0.4, 0.2..=0.8;
        /// Nodes around a quarter in which a rule has failed that get what the quarter gets.
        failed_margin: f64 = 0.05, 0.025..=0.1;
        /// The most depths of a rule for a quarter in which another one has failed.
        most_depths_again: usize = 40, 20..=80;
        /// A rule has failed where it is wrong by this many tolerances.
        failure: f64 = 1.0, 0.5..=2.0;
        /// Lines are refined again if they are beyond the tolerance by more than this.
        again: f64 = 1.02, 0.51..=2.04;
    }
    /// Sheets, continued values and coverage fractions.
    view: View {
        /// If this share of the base lines has a jump, surfaces are tracked from line to line, and the image
        /// has kinks where they turn away…
        rough_share: f64 = 0.03, 0.015..=0.06;
        /// …and predictions of this order, which reach less far across them, are the better ones.
        rough_order: usize = 4, 3..=5;
        /// A jump within an interval as short as the spacing of this level is one; a loose tolerance leaves
        /// it no shorter.
        rough_jump_level: u8 = 5, 4..=6;
        /// With fewer open nodes on the base lattice than this, there is nothing to continue from: all are
        /// looked at.
        least_open: usize = 6, 3..=12;
        /// Of two degrees whose expected errors differ by less than this, the higher one: a smooth function is
        /// smooth beyond the values too. With 1, 4 % more evaluations in views with bodies and a limb along rows
        /// wrong by 1.4 times the tolerance; with 4, two of 160 views wrong at 0.1 %.
        higher_degree: f64 = 2.0, 1.0..=4.0;
        /// The square of the distance at which weights have fallen to a quarter, for a nearest value at 1.
        quarter_weight: f64 = 8.0, 4.0..=16.0;
        /// 1 − leverage, at the least: a value that a coefficient is all about can't be left out.
        least_independence: f64 = 0.1, 0.05..=0.2;
        /// The square of the distance at which weights have fallen to a quarter.
        fit_quarter_weight: f64 = 2.0, 1.0..=4.0;
        /// 1 − leverage, at the least: a value that a coefficient is all about can't be left out.
        fit_least_independence: f64 = 0.1, 0.05..=0.2;
        /// The origin is no better known than this, relative to the values: they are checked, it is not.
        fit_least_leverage: f64 = 0.5, 0.25..=1.0;
    }
    /// The low-rank approximation, its forecast and rehearsal.
    lowrank: Lowrank {
        /// The first forecast is made after so many evaluations…
        first_forecast: f64 = 600.0, 300.0..=1200.0;
        /// …or, as long as the error is more than this times the image…
        unknown: f64 = 1.5, 0.75..=3.0;
        /// …after so many: there is nothing to tell from before.
        first_if_unknown: f64 = 2000.0, 1000.0..=4000.0;
        /// And the next ones each time that the evaluations have grown by this.
        interval: f64 = 1.3, 0.65..=2.6;
        /// If the tree is expected to cost more than this many times what is rehearsed, which is at tolerances below
        /// 1 %…
        extrapolated: f64 = 1.4, 0.7..=2.8;
        /// …so many forecasts in a row have to be for it: the first ones know little of how the error falls. One
        /// made the random family 8 % more expensive at 0.1 %, and 13 % at 1e-4; two at 1 % cost nearly twice as much
        /// as the tree alone on one scene.
        forecasts_for_tree: u32 = 2, 1..=4;
        /// The rest of a search costs so much more than its course so far lets expect.
        safety_factor: f64 = 1.5, 0.75..=3.0;
        /// ln(error) falls by this for each rank, at the least.
        least_slope: f64 = 0.02, 0.01..=0.04;
        /// A tree is not rehearsed beyond so many times what the search would cost.
        rehearsed: f64 = 2.0, 1.0..=4.0;
        /// Changes below this share of the most that is left don't matter.
        of_interest: f64 = 0.3, 0.15..=0.6;
        /// The steepest stretch of a fiber is divided into so many parts…
        steep_parts: usize = 4, 2..=8;
        /// …this often…
        closer_steps: usize = 3, 1..=6;
        /// …and a jump keeps this share of the change in one part.
        steep_kept: f64 = 0.7, 0.35..=0.85;
        /// A budget below so many first looks of the image tree is left to the tree…
        least_budget: u64 = 4, 2..=8;
        /// …and no search takes more than this share of a budget, or of the time.
        most_of_budget: f64 = 0.25, 0.125..=0.5;
        /// While the search goes on, the image has no more pixels than this along a side.
        coarse_pixels: usize = 64, 32..=128;
        /// A rate at a scattered sample of less than this share of the error allowed along a unit of depth is not
        /// told from rounding and from what is left of the interpolant.
        least_pass: f64 = 0.02, 0.01..=0.04;
        /// More functions along an axis than this, and the tree is better.
        most_functions: usize = 60, 30..=120;
        /// …by this share of their amplitude: a probe that differs by more is noticed if the Gaussian matters. One
        /// whose column is 20 T times the largest pixel has an amplitude of 320 T of these at the last size, and
        /// the error of a part of the image with 16 probes is T if one of them differs by 0.4 % of that.
        noticed: f64 = 1e-3, 0.0005..=0.002;
        /// Twice as many for each level beyond this that fibers need: there may be more of what is so small.
        usual_level: u8 = 6, 5..=7;
        /// The error of a pixel over the root of the mean square that is left around it, at the most:
        /// somewhere in a cell more is left than on the average.
        margin: f64 = 3.0, 1.5..=6.0;
        /// The level of the places that fibers begin with.
        first_level: u8 = 4, 3..=5;
        /// The finest level for tolerances from this one on: with the other one the β model of a narrow field costs
        /// 40 % more at 1 %…
        moderate: f64 = 5e-3, 0.0025..=0.01;
        /// …
        finest_level_if_moderate: u8 = 7, 6..=8;
        /// …and for others.
        finest_level: u8 = 8, 7..=9;
        /// Probes to begin with.
        first_probes: usize = 128, 64..=256;
        /// Fibers are resolved to this share of the most that is left…
        resolved: f64 = 0.2, 0.1..=0.4;
        /// …and the first ones to this: they tell how fine the structure is.
        first_resolved: f64 = 0.05, 0.025..=0.1;
        /// A fiber of which at least this share of the most that is left is not explained adds a function.
        worthwhile: f64 = 0.1, 0.05..=0.2;
        /// If nothing is found to add, both are made smaller by this factor…
        closer: f64 = 0.3, 0.15..=0.6;
        /// …this often.
        most_closer: u32 = 4, 2..=8;
        /// The share of the highest coefficients that tells whether there should be more of them.
        tail: usize = 6, 3..=12;
        /// And their number, at the least: an even function has no odd ones.
        least_tail: usize = 3, 1..=6;
    }
}
