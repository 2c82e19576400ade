//! Energies of a cube.

group! {
    /// Energies of a cube.
    Spectra {
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
        /// The same number where there are more than `many_parts` layers, which together have
        /// enough points.
        initial_points_of_many: u32 = 2, 1..=4;
        /// The most layers that `initial_points` is used for. It keeps the cost of the first energy
        /// below that of the base lattice.
        many_parts: usize = 3, 1..=6;
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
        /// The number of energies at which a line of the final verification is compared with the
        /// selected ones. More detect narrower lines, at the cost of an evaluation each.
        energies_per_line: u32 = 16, 8..=32;
        /// The share of all evaluations so far that these comparisons may cost. Smaller values detect
        /// narrow lines less often; larger ones add to the cost of every cube.
        verified_share: f64 = 0.06, 0.03..=0.12;
        /// The largest difference of such a sample that passes, as the error of a voxel with this
        /// spectrum, in units of the error allowed. A narrow line is far brighter at its middle than
        /// in the mean over a bin, so that the value has little influence on those detected.
        failure_share: f64 = 0.5, 0.25..=1.0;
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
        /// The most verifications of the energies of a cube of products or of surfaces. More follow
        /// spectra of more kinds.
        cube_rounds: usize = 5, 3..=8;
        /// The largest voxel that is expected of sampled spectra, as a share of the brightest of them: a line of
        /// sight may be brighter than a pixel.
        largest_share: f64 = 0.5, 0.25..=1.0;
        /// The error of products at one energy, as a share of T: those of several energies add up in a
        /// bin.
        channel_share: f64 = 0.5, 0.25..=0.75;
        /// The most evaluations of all further channels of a cube of products, in terms of those up to
        /// the first one. Larger values serve more kinds of spectra, and are lost where they do not.
        most_channels: u64 = 8, 4..=16;
        /// How often products are searched for again to a smaller error, if the errors of all energies
        /// add up to more than T.
        tighter_channels: usize = 2, 1..=3;
        /// The share of T that the sum of their errors is then aimed at.
        tighter_share: f64 = 0.7, 0.5..=0.85;
    }
}
