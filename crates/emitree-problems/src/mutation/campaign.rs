//! How many mutants a test makes, and what it does with one that never ends.

use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

/// The seconds that a campaign lasts, instead of its number of cases.
const SECONDS: &str = "EMITREE_FUZZ_SECONDS";
/// The seed of the first case.
const SEED: &str = "EMITREE_FUZZ_SEED";
/// The first seed when none is given.
const DEFAULT_SEED: u64 = 2026;

/// The seeds of the cases of a test.
///
/// By default there is a fixed number of them, always the same, but no new one is begun after a time that
/// keeps the test short on a busy machine. With `EMITREE_FUZZ_SECONDS` in the environment there are as
/// many as there is time for, from the seed `EMITREE_FUZZ_SEED` on; to run one case again, give its seed
/// and 0 seconds.
#[derive(Clone, Copy, Debug)]
pub struct Campaign {
    first: u64,
    cases: u64,
    end: Instant,
}

impl Campaign {
    /// A campaign of so many cases, no more than so many seconds long.
    ///
    /// # Panics
    ///
    /// If the environment has something else than a number: a test can't report it in another way.
    #[expect(clippy::panic, reason = "only tests call it")]
    pub fn new(cases: u64, seconds: f64) -> Self {
        let number = |name: &str| std::env::var(name).ok().map(|text| (name.to_owned(), text));
        let parsed = |(name, text): (String, String)| match text.trim().parse::<f64>() {
            Ok(number) if (0.0..=1e15).contains(&number) => number,
            _ => panic!("{name} is {text}: expected a number"),
        };
        let lasting = number(SECONDS).map(parsed);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "checked above"
        )]
        let first = number(SEED).map_or(DEFAULT_SEED, |seed| parsed(seed) as u64);
        let cases = if lasting.is_some() { u64::MAX } else { cases };
        let end = Instant::now() + Duration::from_secs_f64(lasting.unwrap_or(seconds));
        Self { first, cases, end }
    }

    /// The seeds, one at least.
    pub fn seeds(self) -> impl Iterator<Item = u64> {
        let in_time = move |number: &u64| *number == 0 || Instant::now() < self.end;
        (0..self.cases).take_while(in_time).map(move |number| self.first.wrapping_add(number))
    }
}

/// Runs a case, and returns what it returns.
///
/// # Errors
///
/// Why there is no result: the case panicked, or it has not ended within `limit`. What has not ended goes
/// on in a thread whose result is ignored.
pub fn watched<T: Send + 'static>(
    limit: Duration,
    case: impl FnOnce() -> T + Send + 'static,
) -> Result<T, String> {
    let (sender, receiver) = channel();
    thread::spawn(move || {
        // The receiver is gone if it took too long.
        let _ = sender.send(case());
    });
    receiver.recv_timeout(limit).map_err(|error| match error {
        RecvTimeoutError::Timeout => format!("it has not ended in {} s", limit.as_secs_f64()),
        RecvTimeoutError::Disconnected => "it panicked".to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cases_end_with_a_result_or_a_reason() {
        let limit = Duration::from_secs(5);
        assert_eq!(watched(limit, || 7), Ok(7));
        let none = watched(Duration::from_millis(1), || thread::sleep(Duration::from_millis(300)));
        assert_eq!(none, Err("it has not ended in 0.001 s".to_owned()));
        let quiet = || std::panic::resume_unwind(Box::new("no message"));
        assert_eq!(watched::<()>(limit, quiet), Err("it panicked".to_owned()));
    }

    #[test]
    fn a_campaign_has_one_case_at_least_and_so_many_at_most() {
        let seeds: Vec<u64> =
            Campaign { first: 5, cases: 3, end: Instant::now() + Duration::from_secs(60) }
                .seeds()
                .collect();
        assert_eq!(seeds, [5, 6, 7]);
        let over = Campaign { first: 5, cases: 3, end: Instant::now() };
        assert_eq!(over.seeds().collect::<Vec<_>>(), [5]);
    }
}
