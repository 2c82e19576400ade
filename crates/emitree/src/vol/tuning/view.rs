//! Sheets, the quadrature of pixels and the depths of charts.

group! {
    /// Sheets, the quadrature of pixels and the depths of charts.
    View {
        /// The least share of the base lines with a jump from which jumps are tracked from line to
        /// line, and kinks of the image are expected where surfaces turn away.
        rough_share: f64 = 0.03, 0.015..=0.06;
        /// The same of all nodes of a tree that has been refined, most of which may be at a small shape.
        rough_share_of_nodes: f64 = 0.25, 0.125..=0.5;
        /// The order of the predictions of such an image tree. Shorter stencils reach less far
        /// across kinks. Only even orders have symmetric stencils, and 6 is the order of smooth
        /// images.
        rough_order: usize = 4, 2..=6;
        /// The level whose spacing is the longest interval with a jump that counts for
        /// `rough_share`. A loose tolerance bisects jumps no further.
        rough_jump_level: u8 = 5, 4..=6;
        /// The error of the quadrature of a pixel that is allowed, as a share of T. It takes no
        /// evaluations, but time.
        quadrature_share: f64 = 0.02, 0.01..=0.04;
        /// A chart with less than this share of the pixels has a coarser base lattice, by one level.
        small_share: f64 = 0.0625, 0.03125..=0.125;
        /// The share of the usual weight of a coordinate of depth that it keeps when weights are
        /// fitted to samples. They show a part of the emission only.
        kept_weight: f64 = 0.2, 0.1..=0.4;
        /// The least ratio of the mean square of samples with the usual weights to that with fitted
        /// ones for which all charts are sampled anew.
        least_gain: f64 = 1.5, 1.2..=3.0;
        /// The least ratio of the mean square of samples along an image plane's own depth to that along
        /// a stretched one for which the view is sampled anew.
        least_stretch_gain: f64 = 5.0, 2.5..=10.0;
        /// The share of the places of a stretched depth that are uniform. With smaller ones features
        /// outside of the stretched part are missed.
        uniform_places: f64 = 0.5, 0.25..=0.75;
        /// The least cosine between the line of sight in the middle of the view and the normal of a declared plane from
        /// which the view is divided there if G does not jump. The sides of a plane seen at a grazing angle end within
        /// the image, which costs more than a kink: at 70° 18,425 evaluations instead of 7,334 of a Gaussian with a kink
        /// in bounds at 1 %, at 45° 6,468 instead of 10,408. Where G jumps, layers cost less at all angles.
        least_cosine_of_kinks: f64 = 0.5, 0.25..=0.75;
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
}
