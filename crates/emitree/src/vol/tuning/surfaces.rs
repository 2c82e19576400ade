//! Surfaces at which G jumps, found from samples.

group! {
    /// Surfaces at which G jumps, found from samples.
    Surfaces {
        /// The number of cells of the base lattice, about. Fewer miss small regions; more cost a
        /// sample each.
        base_cells: f64 = 512.0, 256.0..=1024.0;
        /// The number of levels below the base lattice at tolerances from `fine_below` on, and below
        /// that.
        levels: u8 = 7, 6..=8;
        fine_levels: u8 = 8, 7..=9;
        /// The tolerance below which `fine_levels` are allowed.
        fine_below: f64 = 5e-3, 2e-3..=1e-2;
        /// The scattered samples at the beginning. They detect regions between the corners of the
        /// base lattice.
        scattered: usize = 1024, 512..=2048;
        /// The least number of scattered points for each tile of a view of several. With `scattered` points for all
        /// twelve faces of a sky, one of two shapes was missed that image trees find.
        scattered_of_tile: usize = 512, 256..=1024;
        /// Differences of G that change no line of sight by more than this share of T are negligible.
        negligible: f64 = 0.1, 0.05..=0.2;
        /// The nearest samples that decide the region of another, and the most of one region.
        nearest_samples: usize = 32, 16..=64;
        samples_of_region: usize = 12, 8..=24;
        /// A value belongs to a region if it differs from the prediction by so many times the
        /// expected error.
        misfit: f64 = 6.0, 3.0..=12.0;
        /// The least expected error of a prediction, as a share of the value.
        least_spread: f64 = 0.02, 0.01..=0.04;
        /// The same as a share of the differences of the nearest samples of the region.
        spread_share: f64 = 0.25, 0.1..=0.5;
        /// Two regions are one if so small a share of their difference along an edge is left in the
        /// bracket of its change.
        slope_left: f64 = 0.15, 0.1..=0.25;
        /// A jump leaves so many times more of a difference in a bracket than a constant slope.
        slope_excess: f64 = 3.0, 2.0..=5.0;
        /// Two regions are one if edges between them that do not jump are more than so many times those that
        /// do.
        rare_jumps: usize = 3, 2..=6;
        /// Regions between which so many edges jump remain two, however many do not: the jump fades out
        /// along a part of the surface.
        sure_jumps: usize = 40, 20..=80;
        /// A difference along an edge is a slope if neighbouring differences predict it with an
        /// error below this share of it.
        slope_share: f64 = 0.5, 0.25..=0.6;
        /// The number of times that the steepest half of an edge is divided before a difference is a
        /// jump, and the share of it that the last two of them leave.
        halvings: usize = 5, 4..=7;
        jump_share: f64 = 0.6, 0.5..=0.7;
        /// The most regions: more of them are no regions but structure.
        most_regions: usize = 24, 12..=48;
        /// The least 1 − tilt between the direction of a point's jump and a normal, before and after
        /// the normal is known: points with another orientation belong to another wall.
        first_tilt: f64 = 0.3, 0.15..=0.5;
        second_tilt: f64 = 0.1, 0.05..=0.2;
        /// The number of points whose mean is the first centre of a patch.
        centre_points: usize = 8, 4..=12;
        /// The distance of the points of a patch from the centre of its cell, in sizes of the cell.
        reach: f64 = 2.6, 2.0..=3.2;
        /// The most points of a patch. Those further away would bend it.
        most_points: usize = 60, 40..=90;
        /// The first planes from which several patches of a wall are chosen: all pairs are compared.
        wall_planes: usize = 20, 12..=32;
        /// The distance from the centre of a cell up to which all points have to be on its patches, in
        /// sizes of the cell; the distance from the patches up to which others belong to them, in sizes
        /// too, first tightly and then loosely; and the weight of those in the choice of planes. Other
        /// walls may pass beside the cell.
        wall_near: f64 = 1.0, 0.9..=1.3;
        wall_belongs: f64 = 0.1, 0.05..=0.2;
        wall_belongs_loosely: f64 = 0.4, 0.2..=0.6;
        wall_far_weight: f64 = 0.2, 0.1..=0.4;
        /// The least angle between the normals of two patches of a wall, in radians. With less they are
        /// parts of one smooth surface, and of two fits to fewer points each the errors are too small.
        wall_least_turn: f64 = 0.2, 0.1..=0.4;
        /// The same while points are still assigned to the nearest patch: patches that turn by less are seldom an edge
        /// in the end, and their fits are most of the time of a search.
        wall_least_first_turn: f64 = 0.1, 0.05..=0.2;
        /// The error of a single patch, as a share of the one wanted, from which several patches are tried, since a
        /// smooth patch rounds an edge, where its largest error is far above the mean one.
        wall_from: f64 = 0.25, 0.1..=1.0;
        /// The error, as a share of the one wanted, below which a patch of several has no higher degree:
        /// beyond its points a lower one is safer.
        wall_enough: f64 = 0.7, 0.4..=1.0;
        /// The largest relative difference of the jumps of pairs of regions that one surface separates.
        same_jump: f64 = 0.02, 0.01..=0.04;
        /// The largest error of a patch, in sizes of its cell, with which it is a guess for the children
        /// of the cell, or better than no patch if the cell is not divided.
        guess_error: f64 = 0.35, 0.2..=0.5;
        /// A corner of a cell is in the region on its side of the patches of the parent, without an
        /// evaluation, if its distance from them is so many times their error, and this share of the cell.
        inferred_errors: f64 = 4.0, 2.0..=8.0;
        inferred_share: f64 = 0.1, 0.05..=0.2;
        /// The ratio of the error of a patch to its leave-one-out residuals.
        patch_margin: f64 = 1.5, 1.0..=2.0;
        /// The share of T that the displacement of one patch may change a line of sight by.
        patch_share: f64 = 0.2, 0.1..=0.3;
        /// The ratio of the displacement that patches were accepted with to the one allowed now, above which their cell is
        /// looked at again.
        loose: f64 = 1.5, 1.2..=2.0;
        /// The width to which points of a surface are bracketed, as a share of the displacement
        /// allowed.
        root_share: f64 = 0.3, 0.15..=0.5;
        /// The half width of the distribution of a surface about the patch that is expected to contain it, in errors of the
        /// patch: that of the distances measured.
        expected_errors: f64 = 0.45, 0.2..=1.0;
        /// The batches in which the points of a level are found: patches that fit after the first
        /// ones need no more.
        batches: usize = 3, 2..=4;
        /// The distance of the two evaluations of a check from a patch, in errors of the patch, and its least
        /// and largest value, in displacements allowed. A check at the displacement allowed passes
        /// patches whose errors are far larger than estimated, in the part of a cell that has no points.
        check_errors: f64 = 4.0, 3.0..=8.0;
        check_least: f64 = 0.5, 0.3..=1.0;
        check_distance: f64 = 1.5, 1.0..=2.0;
        /// The distance at which regions on both sides of a face have to agree, in displacements allowed.
        face_distance: f64 = 3.0, 2.0..=4.0;
        /// The same where a smooth patch is on each side. Patches that meet at edges seldom agree that closely, and their
        /// cells are divided for nothing.
        smooth_face_distance: f64 = 1.0, 0.5..=2.0;
        /// The points along each axis of a face at which they are compared; and the same where patches meet,
        /// since an edge passes through a part of a face between fewer.
        face_points: usize = 6, 4..=8;
        face_points_beside_edges: usize = 18, 12..=24;
        /// The most rounds of refinement after comparisons of faces.
        rounds: usize = 40, 20..=60;
        /// A cell whose regions change no pixel by more than this share of T remains unresolved.
        unresolved_share: f64 = 0.1, 0.05..=0.2;
        /// The number of cells on a line in which a jump may have faded out.
        faded_cells: f64 = 8.0, 4.0..=16.0;
        /// The share of T that the polynomials of the regions may change a line of sight by.
        piece_share: f64 = 0.25, 0.15..=0.5;
        /// The variance of a polynomial, in units of that of a value, above which it is extrapolated: the
        /// leave-one-out residuals of samples at the border of a box know less than this.
        piece_variance: f64 = 9.0, 4.0..=16.0;
        /// A sample for a polynomial is of another region if it differs from its own by so many times the
        /// error allowed, and less from the other one.
        piece_foreign: f64 = 4.0, 2.0..=8.0;
        /// The number of polynomials on a line that have equal shares of it.
        piece_boxes: f64 = 16.0, 8.0..=32.0;
        /// The ratio of the samples of a polynomial to its coefficients.
        piece_samples: f64 = 1.35, 1.2..=1.7;
        /// The checks of a polynomial.
        piece_checks: usize = 2, 1..=4;
        /// The distance of its samples from surfaces, in displacements allowed.
        piece_clearance: f64 = 3.0, 2.0..=5.0;
        /// The most levels of the tree of polynomials.
        piece_levels: u8 = 24, 18..=30;
        /// The ratio of the error of a polynomial to its leave-one-out residuals.
        piece_margin: f64 = 1.5, 1.0..=2.0;
        /// The ratio of the error of a crossing to what the displacement allowed changes there, since patches are
        /// wrong by more between their points.
        crossing_margin: f64 = 1.5, 1.2..=2.0;
        /// The same for smooth patches.
        smooth_margin: f64 = 1.2, 1.0..=1.5;
        /// The ratio of the displacement of a surface that counts as the error of a requested line to the error of its
        /// patch: a line meets it at one place, and not at the places of a pixel.
        line_margin: f64 = 2.0, 1.0..=4.0;
        /// The times that the leaves at the largest errors are refined; the share of the error allowed
        /// of the pixels, and that of patches on a line, from which they are, which decreases each time
        /// by a factor; and the factor on what is allowed in them.
        improvements: usize = 5, 3..=8;
        improved_from: f64 = 0.85, 0.5..=0.9;
        improved_first: f64 = 0.45, 0.3..=0.6;
        improved_step: f64 = 0.65, 0.5..=0.8;
        improved_share: f64 = 0.4, 0.25..=0.6;
        /// The largest error that is accepted, as a share of T.
        accepted_share: f64 = 0.9, 0.8..=1.0;
        /// The smallest tolerance at which surfaces are searched for. Below it patches of degree 4 cost
        /// much time.
        least_tolerance: f64 = 5e-4, 2e-4..=1e-3;
        /// The lines of sight that verify the surfaces, and the most verifications.
        lines: usize = 32, 16..=64;
        verifications: usize = 8, 4..=12;
        /// The largest difference of a sample from the pieces that passes, as a share of T on a line
        /// that is in one piece.
        piece_disagreement: f64 = 1.0, 0.5..=2.0;
        /// The largest share of the budget that the search takes. The rest has to suffice for the
        /// image tree.
        most_budget_share: f64 = 0.25, 0.125..=0.5;
        /// The most evaluations at 1 %, and the power of T with which they grow.
        most_evaluations: f64 = 1.5e5, 1e5..=2e5;
        growth: f64 = 0.5, 0.3..=0.7;
        /// The share of T that the surfaces and the pieces at the first energy of a cube may take; the
        /// share that the pieces of all further energies may take; and the largest error that is accepted.
        cube_share: f64 = 0.75, 0.6..=0.85;
        channel_share: f64 = 0.5, 0.25..=0.75;
        cube_accepted_share: f64 = 1.0, 0.9..=1.0;
        /// The points with spectra of all regions of a cube together, and the fewest of a region; and the
        /// scattered points among which they are chosen.
        spectral_points: usize = 32, 16..=64;
        least_spectral_points: usize = 6, 4..=10;
        spectral_candidates: usize = 4096, 2048..=8192;
        /// The samples, each at a place and an energy of its own, that the energies are compared with. A shape in
        /// 3 % of the view with a line in 3 % of the band has 4 of them.
        spectral_checks: usize = 4096, 2048..=8192;
        /// The most evaluations of further energies, in terms of those of the search at the first one.
        channel_evaluations: f64 = 0.5, 0.25..=1.0;
    }
}
