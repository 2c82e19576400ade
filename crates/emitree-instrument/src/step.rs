//! The steps from radiance to counts, each with a sum to check it by.

/// A step from radiance to counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Step {
    /// Radiance times solid angle, width of bin and exposure: photons cm⁻². Lost are radiances below
    /// 0, a negative sum: a rendering may have some, within its error, and they count as 0.
    Photons,
    /// Times the mean area over each bin: photons. Before is the same from the sums of the bins alone.
    Area,
    /// The point-spread function. Lost is what leaves the field.
    Psf,
    /// The energies of the redistribution matrix. Lost is what is beyond them, or between its rows.
    Energies,
    /// The redistribution into channels: counts. Lost is what rows leave uncounted. Of a matrix that
    /// includes the area, before is what the sums of its rows make of the sums of the bins.
    Redistribution,
    /// The background. Added is its rate times the exposure.
    Background,
}

impl Step {
    /// The name that reports have for it.
    ///
    /// ```
    /// assert_eq!(emitree_instrument::Step::Psf.name(), "psf");
    /// ```
    pub fn name(self) -> &'static str {
        match self {
            Self::Photons => "photons",
            Self::Area => "area",
            Self::Psf => "psf",
            Self::Energies => "energies",
            Self::Redistribution => "redistribution",
            Self::Background => "background",
        }
    }
}

/// The sum over all bins or channels and pixels at a step: `before + added = after + lost`.
///
/// `after` is the sum of the voxels that the step made, and the others come from what it was given, so
/// that the two sides are equal to rounding only if the step is right. Pixels outside of the field are
/// left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepSum {
    /// The step.
    pub step: Step,
    /// What it was given, in the unit of what it makes.
    pub before: f64,
    /// What it adds.
    pub added: f64,
    /// What is lost.
    pub lost: f64,
    /// What it has made.
    pub after: f64,
}

impl StepSum {
    /// The difference of the two sides, as a fraction of the larger; 0 if both are 0.
    ///
    /// ```
    /// use emitree_instrument::{Step, StepSum};
    ///
    /// let sum = StepSum { step: Step::Psf, before: 8.0, added: 0.0, lost: 1.0, after: 6.0 };
    /// assert_eq!(sum.imbalance(), 0.125);
    /// ```
    pub fn imbalance(&self) -> f64 {
        let [given, made] = [self.before + self.added, self.after + self.lost];
        let scale = given.abs().max(made.abs());
        if scale == 0.0 { 0.0 } else { (given - made).abs() / scale }
    }
}
