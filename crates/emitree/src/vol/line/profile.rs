//! Profiles: G on full lines at the depths that depth rules may use.

use crate::vol::dyadic::spacing;
use crate::vol::line::Line;
use crate::vol::tuning::TUNING;

/// The level of the lattice of the depths that a rule may use.
const DEPTH_LEVEL: u8 = 7;
/// The number of these depths.
pub(crate) const DEPTHS: usize = (1 << DEPTH_LEVEL) + 1;

/// A line for the fit of depth rules: G at all depths that a rule may use.
#[derive(Clone, Debug)]
pub(crate) struct Profile {
    pub(crate) rates: Vec<f64>,
    /// Which of the depths have been sampled; at the others G is interpolated.
    pub(crate) sampled: Vec<bool>,
    pub(crate) integral: f64,
    pub(crate) has_jump: bool,
}

/// Depth `k` of [`DEPTHS`].
pub(crate) fn depth_of(k: usize) -> u32 {
    crate::cell::to_u32(k) * spacing(DEPTH_LEVEL)
}

/// The number of levels by which depth `k` of [`DEPTHS`] is finer than the ends of the line.
pub(crate) fn level_of(k: usize) -> u32 {
    if k == 0 { 0 } else { u32::from(DEPTH_LEVEL).saturating_sub(k.trailing_zeros()) }
}

/// Whether a line has a resolved jump: no depth rule is fitted to it.
pub(crate) fn has_jump(line: &Line) -> bool {
    line.has_jump_within(spacing(TUNING.line.resolved_jump_level))
}

impl Profile {
    pub(crate) fn new(line: &Line) -> Self {
        let depth = |k: usize| depth_of(k);
        Self {
            rates: (0..DEPTHS).map(|k| line.rate(depth(k))).collect(),
            sampled: (0..DEPTHS).map(|k| line.has(depth(k))).collect(),
            integral: line.integral,
            has_jump: has_jump(line),
        }
    }
}
