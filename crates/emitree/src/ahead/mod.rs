//! Fewer rounds: points that a method is expected to need soon are requested with those that it waits for.
//!
//! A method needs the rates of one batch to choose the points of the next. Where a batch takes long, however
//! small it is, evaluations are traded for rounds. The method is repeated on the known rates and then goes on with
//! rates that are [interpolated](surrogate) between them: the points that it requests are requested now, as
//! many as the option allows. The method itself is unchanged, and sees evaluated rates alone: a point that
//! it requests later is known already, and one that it never requests has cost an evaluation and changes nothing. So the
//! result has the bits of a rendering without the option.
//!
//! Interpolated rates lead to other points than evaluated ones where the interpolant is wrong. After the first
//! repetition others follow, whose interpolated rates are disturbed a little, as long as there is room for
//! more points.

mod surrogate;

use crate::exchange::Batch;
use crate::known::{KnownRates, Point, point};
use crate::meter::Meter;
use crate::method::Running;
use crate::polling::advance;
use rustc_hash::FxHashSet;
use std::sync::{Arc, Mutex};
use surrogate::Surrogate;

/// The number of rounds for which expected points are as many as those that the method has requested: more
/// rounds with fewer of them, fewer with more.
const USUAL_ROUNDS: f64 = 6.0;
/// Points that are requested in addition to those in the first rounds, when the method has requested few.
const FIRST: f64 = 1000.0;
/// The least number of expected points of a round, at `USUAL_ROUNDS`: where many were in vain, rounds would
/// be as many as without the option.
const LEAST: f64 = 300.0;
/// The most points that may be in vain, as a share of all evaluations that are allowed: the rest has to suffice for
/// the method.
const SHARE_IN_VAIN: f64 = 0.25;
/// The most comparisons of places with known ones for one round, each of some nanoseconds: about ten seconds. Where
/// there are so many points, batches are large without others.
const MOST_COMPARISONS: u64 = 1 << 32;
/// The most repetitions of the method for one round.
const REPETITIONS: u64 = 8;
/// The share of an interpolated rate by which it is disturbed in repetitions after the first, at most.
const DISTURBANCE: f64 = 0.02;

/// What expects the next points of a rendering.
#[derive(Debug)]
pub(crate) struct Ahead {
    /// The number of rounds that is aimed at.
    rounds: u32,
    surrogate: Surrogate,
}

/// Evaluations that are allowed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Allowed {
    /// From now on.
    pub(crate) now: u64,
    /// In the whole rendering.
    pub(crate) altogether: u64,
}

/// A repetition of a method, with a meter of its own.
pub(crate) type Repetition<'a> = (Arc<Meter>, Running<'a>);

impl Ahead {
    pub(crate) fn new(rounds: u32) -> Self {
        Self { rounds, surrogate: Surrogate::default() }
    }

    /// The same for another number of rounds.
    pub(crate) fn with_rounds(self, rounds: u32) -> Self {
        Self { rounds, ..self }
    }

    /// Adds evaluated rates.
    pub(crate) fn add(&mut self, batch: &Batch) {
        self.surrogate.add(batch);
    }

    /// The batch `asked` with the points that are expected to follow. The method has requested so many points
    /// so far, `used`, of those that are `known`. `repeat` begins the method again, on rates that it may add to.
    pub(crate) fn extended<'a>(
        &self,
        asked: Batch,
        known: &KnownRates,
        used: u64,
        allowed: Allowed,
        repeat: impl Fn(Arc<Mutex<KnownRates>>) -> Repetition<'a>,
    ) -> Batch {
        let most = self.most(&asked, used, allowed);
        let mut wanted = Wanted::new(asked, most);
        let interpolant = self.surrogate.interpolant();
        let (mut interpolated, mut comparisons) = (KnownRates::default(), 0);
        for repetition in 0..REPETITIONS {
            let (meter, mut method) = repeat(Arc::new(Mutex::new(known.clone())));
            while advance(method.as_mut()).is_pending() {
                let Some(mut batch) = meter.exchange().take() else { break };
                if !wanted.add(&batch) {
                    return wanted.batch;
                }
                let mut new = interpolated.unknown(&batch);
                comparisons += (new.len() * self.surrogate.len()) as u64;
                if comparisons > MOST_COMPARISONS {
                    return wanted.batch;
                }
                new.rates = interpolant.rates(&new);
                interpolated.insert(&new);
                interpolated.fill(&mut batch);
                if repetition > 0 {
                    disturb(&mut batch, repetition);
                }
                meter.exchange().answer(Ok(batch));
            }
        }
        wanted.batch
    }

    /// The most points of a round.
    fn most(&self, asked: &Batch, used: u64, allowed: Allowed) -> u64 {
        let aggression = USUAL_ROUNDS / f64::from(self.rounds);
        let used = used as f64 + asked.len() as f64;
        let in_vain = self.surrogate.len() as f64 + asked.len() as f64 - used;
        let room = (aggression * (used + FIRST) - in_vain).max(aggression * LEAST);
        let room = room.min(SHARE_IN_VAIN * allowed.altogether as f64 - in_vain).max(0.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
        let room = room as u64;
        (asked.len() as u64 + room).min(allowed.now.max(asked.len() as u64))
    }
}

/// The points of a round.
struct Wanted {
    batch: Batch,
    points: FxHashSet<Point>,
    most: u64,
}

impl Wanted {
    fn new(batch: Batch, most: u64) -> Self {
        let points = (0..batch.len()).map(|i| point(&batch, i)).collect();
        Self { batch, points, most }
    }

    /// Adds the points of a batch that are new. Returns whether there was room for all.
    fn add(&mut self, batch: &Batch) -> bool {
        let mut new: Vec<usize> =
            (0..batch.len()).filter(|&i| self.points.insert(point(batch, i))).collect();
        let room =
            usize::try_from(self.most).unwrap_or(usize::MAX).saturating_sub(self.batch.len());
        let has_room = new.len() <= room;
        new.truncate(room);
        self.batch.append(batch.some(&new));
        has_room
    }
}

/// Changes each rate by a share of it that follows from its point.
fn disturb(batch: &mut Batch, repetition: u64) {
    for i in 0..batch.len() {
        let mix = |hash: u64, bits: u64| (hash ^ bits).wrapping_mul(MULTIPLIER).rotate_left(31);
        let hash = point(batch, i).into_iter().fold(repetition, mix);
        let of_unit = (hash >> 11) as f64 / (1_u64 << 53) as f64;
        batch.rates[i] *= 1.0 + DISTURBANCE * (2.0 * of_unit - 1.0);
    }
}

/// 2^64 over the golden ratio: multiples of it are spread evenly (Knuth, *Sorting and Searching*, section 6.4).
const MULTIPLIER: u64 = 0x9e37_79b9_7f4a_7c15;

#[cfg(test)]
mod tests;
