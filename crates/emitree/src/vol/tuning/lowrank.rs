//! The low-rank approximation, its forecast and trial run.

group! {
    /// The low-rank approximation, its forecast and trial run.
    Lowrank {
        /// The error of products that is accepted beside other parts of the view, as a share of T.
        /// It is below `engine.stopping_share`, which errors of trees and of the quadrature of pixels
        /// have to reach with it.
        share_beside_parts: f64 = 0.8, 0.7..=0.83;
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
        /// The factor by which the evaluations of a former trial run exceed what is allowed in the next one, which is
        /// not made then. Smaller values take less time, and may miss that the tree is cheaper for a better interpolant.
        former_excess: f64 = 1.5, 1.0..=3.0;
        /// The factor by which the evaluations of a former trial run are below what is allowed in the next one, which
        /// is not made then. Smaller values take less time, and may miss that the tree is more expensive.
        former_saving: f64 = 4.0, 2.0..=8.0;
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
        /// The most places of a fiber along the azimuth that are tested for a kink or a jump when a
        /// search fails.
        most_bends: usize = 4, 2..=6;
        /// The least change of the slope at such a place, as a share of the largest one on the fiber.
        least_bend_share: f64 = 0.2, 0.1..=0.4;
        /// The number of times that an interval with a possible kink is halved: places to 1e-9, since a
        /// chart that ends beside a kink is not smooth.
        kink_halvings: usize = 24, 20..=28;
        /// The least share of the change of the slope in an interval that is at one place if there
        /// is a kink. A constant second derivative has at most half of it there, a cusp with a
        /// square root three quarters.
        kink_share: f64 = 0.65, 0.55..=0.72;
        /// The least change of the slope over the whole azimuth at a kink, as a share of the rate.
        least_kink: f64 = 0.01, 0.005..=0.02;
        /// The distance of the places beside a kink at which other fibers along the azimuth are
        /// compared. Larger ones confuse narrow bends with kinks.
        same_kink: f64 = 1e-6, 1e-7..=1e-5;
        /// The number of other fibers that have to have a kink at the same place, of three.
        kink_fibers: usize = 2, 1..=3;
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
        /// The exponent of the weights of errors in the choice of pivots, where these are not all 1. With 0
        /// and 1 errors by pixel cost a fifth more.
        pivot_weight: f64 = 0.5, 0.25..=1.0;
        /// The most probes from which the scaling is fitted. With 128 the K corona beside the limb has none, and takes
        /// 85,000 evaluations.
        scaling_probes: usize = 512, 256..=1024;
        /// The least ratio of the largest to the smallest scaling for which G is scaled: it is a gain only where the
        /// error allowed differs more than its estimates do.
        least_scaling: f64 = 10.0, 5.0..=20.0;
        /// The least share of the variance of the logarithm of the scaling that is wanted which a product explains. Rings and
        /// several peaks have none that serves: without this condition a torus costs four times as much.
        least_explained: f64 = 0.8, 0.6..=0.9;
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
        /// The factor by which fewer probes verify functions of another G, a power of two: its structure is
        /// expected to be of the same size. With a fixed number of 512, two of 60 scenes of the random
        /// family were wrong at 0.1 % and changes of 10 %.
        fewer_probes: usize = 4, 2..=8;
        /// The number of lines of sight along which their residual is integrated. Half of them are at the
        /// largest residuals, half are scattered.
        lines_of_functions: usize = 16, 8..=32;
        /// The ratio of the error of a pixel to that expected from these lines.
        lines_margin: f64 = 3.0, 2.0..=4.5;
        /// The largest error that probes show, in units of the error allowed, for which lines are integrated:
        /// they seldom show a smaller share of it.
        lines_most_excess: f64 = 10.0, 5.0..=20.0;
        /// The number of probes of a view that is dark at all of them, in units of the usual number. A
        /// small shape is the only emission of some views.
        dark_factor: usize = 8, 4..=16;
        /// The solid angle \[sr\] of a view with the usual number of probes, an eighth of the sky, about. A view without
        /// structure in any of them has as many for each solid angle, and `dark_factor` times as many of them.
        usual_solid_angle_sr: f64 = 1.57, 0.8..=3.2;
        /// Fibers are refined until the sum of their highest coefficients is below this share of
        /// the largest residual. Smaller values take more samples on each fiber.
        fiber_resolution: f64 = 0.2, 0.1..=0.4;
        /// That share at the finest level, in units of the usual one, if each pixel has a tolerance of its own, or if G at
        /// another energy has products: the residuals show whether what is left matters. With 1 the K corona to 8 radii
        /// takes 182,405 evaluations instead of 21,684. With one tolerance for all pixels, searches that fail anyway
        /// are longer: random views take a tenth more.
        left_at_finest_level: f64 = 5.0, 2.5..=10.0;
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
        /// How often a search goes on at another point after all fibers through that of the largest residual were in the
        /// span of others: at points that have two of its coordinates and one of a pivot.
        most_moves: usize = 2, 1..=4;
        /// The least residual at such a point, as a share of the largest one: that is a sum over pivots.
        least_moved_share: f64 = 0.01, 0.003..=0.03;
        /// One in this many coefficients of a fiber, the highest ones, shows whether it is
        /// resolved.
        tail_divisor: usize = 6, 3..=12;
        /// The fewest highest coefficients that show whether a fiber is resolved. Every second one
        /// of an even function is 0.
        least_tail_length: usize = 3, 1..=6;
    }
}
