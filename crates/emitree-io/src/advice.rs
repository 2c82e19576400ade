//! What to do next if a rendering has not met its tolerance, or if its data do not allow it.

use crate::account::Account;
use crate::forecast::CostLaw;
use crate::grouped::grouped;

/// An exponent that hardly any scene exceeds: as many times the evaluations as accuracy.
const STEEPEST: f64 = 1.0;
/// A base lattice of this level or a coarser one shows little of the structure of an image.
const COARSE_LEVEL: u8 = 2;
/// Looser tolerances are met at this one.
const LOOSEST_TOLERANCE: f64 = 0.05;
/// Evaluations with which the usual base lattice is refined once.
const FEWEST_EVALUATIONS: u64 = 5_000;

/// The advice for a rendering that a limit has ended; none if it has met its tolerance, or if its limit is the finest
/// level.
pub(crate) fn advice(account: &Account) -> Option<String> {
    let is_time = account.ending == "time";
    if account.converged() || !(is_time || account.ending == "budget") {
        return None;
    }
    let limit = if is_time { "max_seconds" } else { "max_evaluations" };
    match account.method.as_str() {
        "vol" => {}
        "paper" => {
            return Some(format!(
                "try a larger `{limit}`, a larger `threshold` or a lower `finest_level`"
            ));
        }
        _ => {
            return Some(format!(
                "try a larger `{limit}`, a larger `tolerance`, fewer pixels or fewer `lines`"
            ));
        }
    }
    let at = |factor: f64| match is_time {
        true => two_digits(account.total_seconds * factor).to_string(),
        false => grouped_digits(account.evaluations as f64 * factor),
    };
    if account.base_level.is_some_and(|level| level < COARSE_LEVEL) {
        let factor = FEWEST_EVALUATIONS as f64 / account.evaluations.max(1) as f64;
        return Some(format!(
            "there are too few samples for an image: try `{limit}` = {} or more",
            at(factor.max(2.0))
        ));
    }
    let of_sums = account.sums.iter().filter(|sum| sum.error > sum.allowed && sum.allowed > 0.0);
    let of_sums = of_sums.map(|sum| (sum.error / sum.allowed, Some(&sum.name)));
    let of_pixels = account.error_over_allowed.map(|share| (share, None));
    let worst = of_sums.chain(of_pixels).max_by(|(a, _), (b, _)| a.total_cmp(b));
    let (share, sum) = worst.filter(|(share, _)| share.is_finite() && *share > 1.0)?;
    let law = CostLaw::from(account.evaluations, share)?;
    let least = law.evaluations_for(1.0) as f64 / account.evaluations as f64;
    let most = share.powf(STEEPEST);
    let whose =
        sum.map_or_else(|| "the error".to_owned(), |name| format!("the error of the sum `{name}`"));
    let looser = looser_tolerance(account).filter(|_| sum.is_none());
    let looser = looser.map_or_else(String::new, |tolerance| {
        format!(", or `tolerance` = {tolerance}, twice the error of this image")
    });
    Some(format!(
        "{whose} is {} times the error allowed: try `{limit}` = {} ({} to {} are expected to suffice){looser}",
        two_digits(share),
        at(most),
        at(least),
        at(most),
    ))
}

/// That interpolation changes the image by more than the tolerance, if it does, and what to do.
pub(crate) fn of_data(account: &Account) -> Option<String> {
    let (error, tolerance) = (account.data_error?, account.tolerance?);
    (error > tolerance).then(|| {
        format!(
            "linear interpolation between the data makes an error of some {:.1} % of the largest pixel, more than \
             the tolerance, which no error estimate contains; where the data are smooth, that of `interpolation` = \
             \"cubic\" is smaller",
            100.0 * error
        )
    })
}

/// Twice the error of the image, with two digits, if one tolerance is that of all pixels.
fn looser_tolerance(account: &Account) -> Option<f64> {
    let is_uniform = account.by_pixel.is_none() && !account.is_weighted && !account.per_band;
    let error = account.estimated_error.filter(|error| is_uniform && *error > 0.0)?;
    // With room for a verification.
    let twice = two_digits(2.0 * error);
    (twice <= LOOSEST_TOLERANCE).then_some(twice)
}

/// A number of two digits.
fn two_digits(number: f64) -> f64 {
    format!("{number:.1e}").parse().unwrap_or(number)
}

/// The same of a number of evaluations.
fn grouped_digits(number: f64) -> String {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
    let whole = two_digits(number) as u64;
    grouped(whole)
}

#[cfg(test)]
mod tests {
    use crate::{RenderedScene, Scene};

    /// Eq. (8) of Holmström's paper, and a ball with a jump.
    const SMOOTH: &str = "(sin(5*x) * sin(7*y) * sin(11*z) / 10)^2 + exp(-100*((x - 0.47)^2/sqrt(2) + \
                          (y - 0.53)^2*sqrt(2) + (z - 0.49)^2*sqrt(3)))";
    const BALL: &str = "if((x-0.4)^2 + (y-0.5)^2 + (z-0.45)^2 < 0.09, 1 + sin(9*x*y), 0)";

    /// The hint of a rendering with these settings.
    fn hint(emission: &str, render: &str) -> Option<String> {
        let text = format!(
            "emission.expression = \"{emission}\"\nprojection.type = \"canonical\"\n\
             image = {{ width = 32, height = 32 }}\n[render]\n{render}\n"
        );
        let scene = Scene::parse("scene.toml", &text, &[]).unwrap();
        let found = scene.render(&scene.emission, &scene.render_options()).unwrap();
        RenderedScene::new(&scene, &found).hint()
    }

    #[test]
    fn limits_are_told_with_the_values_that_are_expected_to_suffice() {
        let found =
            hint(BALL, "tolerance = 1e-3\nbase_level = 4\nmax_evaluations = 20000").unwrap();
        assert!(found.starts_with("the error is "), "{found}");
        assert!(found.contains(" times the error allowed: try `max_evaluations` = "), "{found}");
        // No tolerance that would be met: above 5 % it would be one of 5 %.
        assert!(found.ends_with(" are expected to suffice)"), "{found}");
        let found = hint(BALL, "tolerance = 1e-3\nmax_evaluations = 40").unwrap();
        let few = "there are too few samples for an image: try `max_evaluations` = 5,000 or more";
        assert_eq!(found, few);
        let paper = hint(BALL, "method = \"paper\"\nthreshold = 1e-6\nmax_evaluations = 20000");
        let expected =
            "try a larger `max_evaluations`, a larger `threshold` or a lower `finest_level`";
        assert_eq!(paper.unwrap(), expected);
        let los =
            hint(BALL, "method = \"los\"\ntolerance = 1e-9\nmax_evaluations = 150000").unwrap();
        assert!(los.starts_with("try a larger `max_evaluations`, a larger `tolerance`"), "{los}");
        assert_eq!(hint(BALL, "tolerance = 0.05"), None);
    }

    #[test]
    fn sums_are_named() {
        let sum = "tolerance = 0.05\nbase_level = 4\nmax_evaluations = 20000\n\
                   sums = { on = { box = { min = [2, 2], max = [20, 20] }, tolerance = 1e-7 } }";
        let found = hint(BALL, sum).unwrap();
        assert!(found.starts_with("the error of the sum `on` is "), "{found}");
        assert!(found.ends_with(" are expected to suffice)"), "{found}");
    }

    #[test]
    fn a_looser_tolerance_is_twice_the_error_of_the_image() {
        let found =
            hint(SMOOTH, "tolerance = 1e-5\nbase_level = 4\nmax_evaluations = 9000").unwrap();
        assert!(found.ends_with(", twice the error of this image"), "{found}");
    }
}
