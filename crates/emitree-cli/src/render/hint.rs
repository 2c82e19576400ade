//! What may be wrong with a rendering that is right: an image in which there is nothing.

use super::rendered::Rendered;
use crate::numbers::grouped;

/// The likely reasons why every pixel is 0; none if one is not.
pub(crate) fn nothing_in_view(rendered: &Rendered) -> Option<String> {
    let is_dark = rendered.map.cube().voxels().all(|value| value.is_nan() || value == 0.0);
    is_dark.then(|| reasons(rendered.stats.evaluations))
}

fn reasons(evaluations: u64) -> String {
    if evaluations == 0 {
        return "nothing is in view: no line of sight meets the bounds, or opaque bodies hide them \
                (check position, target, near, far and [bounds])"
            .to_owned();
    }
    let count = grouped(evaluations);
    format!(
        "nothing is in view: the emission rate is 0 at all {count} points evaluated (check position, \
         target, near, far and length_unit; a small source is found with [[seed]])"
    )
}

#[cfg(test)]
mod tests {
    use super::reasons;

    #[test]
    fn reasons_differ_for_bounds_and_rates() {
        assert!(reasons(0).contains("no line of sight meets the bounds"));
        assert!(reasons(1_530).contains("0 at all 1,530 points evaluated"));
    }
}
