//! The part of rayon's interface that this crate uses, without threads.
//!
//! Names, and the meaning of each method, are rayon's. [`Serial`] is no [`Iterator`]: rayon's
//! `fold` and `reduce` take other arguments than those of the standard library.

use core::cmp::Ordering;
use core::iter::{Enumerate, Filter, FilterMap, FlatMap, Map, Once, Zip};
use core::slice::{Chunks, ChunksExact, ChunksMut, Iter, IterMut};

/// What rayon's prelude has: methods of slices and of everything that can be iterated over.
pub(crate) mod prelude {
    pub(crate) use super::{IntoSerial as _, SerialSlice as _};
}

/// The number of threads of a loop.
pub(crate) fn current_num_threads() -> usize {
    1
}

/// A loop that is run in order.
pub(crate) struct Serial<I>(I);

impl<I: Iterator> IntoIterator for Serial<I> {
    type Item = I::Item;
    type IntoIter = I;

    fn into_iter(self) -> I {
        self.0
    }
}

pub(crate) trait IntoSerial: IntoIterator + Sized {
    fn into_par_iter(self) -> Serial<Self::IntoIter> {
        Serial(self.into_iter())
    }
}

impl<T: IntoIterator> IntoSerial for T {}

pub(crate) trait SerialSlice<T> {
    fn par_iter(&self) -> Serial<Iter<'_, T>>;
    fn par_iter_mut(&mut self) -> Serial<IterMut<'_, T>>;
    fn par_chunks(&self, size: usize) -> Serial<Chunks<'_, T>>;
    fn par_chunks_exact(&self, size: usize) -> Serial<ChunksExact<'_, T>>;
    fn par_chunks_mut(&mut self, size: usize) -> Serial<ChunksMut<'_, T>>;
    fn par_sort_unstable(&mut self)
    where
        T: Ord;
    fn par_sort_unstable_by(&mut self, compare: impl Fn(&T, &T) -> Ordering);
}

impl<T> SerialSlice<T> for [T] {
    fn par_iter(&self) -> Serial<Iter<'_, T>> {
        Serial(self.iter())
    }

    fn par_iter_mut(&mut self) -> Serial<IterMut<'_, T>> {
        Serial(self.iter_mut())
    }

    fn par_chunks(&self, size: usize) -> Serial<Chunks<'_, T>> {
        Serial(self.chunks(size))
    }

    fn par_chunks_exact(&self, size: usize) -> Serial<ChunksExact<'_, T>> {
        Serial(self.chunks_exact(size))
    }

    fn par_chunks_mut(&mut self, size: usize) -> Serial<ChunksMut<'_, T>> {
        Serial(self.chunks_mut(size))
    }

    fn par_sort_unstable(&mut self)
    where
        T: Ord,
    {
        self.sort_unstable();
    }

    fn par_sort_unstable_by(&mut self, compare: impl Fn(&T, &T) -> Ordering) {
        self.sort_unstable_by(compare);
    }
}

impl<I: Iterator> Serial<I> {
    pub(crate) fn with_min_len(self, _: usize) -> Self {
        self
    }

    pub(crate) fn enumerate(self) -> Serial<Enumerate<I>> {
        Serial(self.0.enumerate())
    }

    pub(crate) fn zip<J: IntoIterator>(self, other: J) -> Serial<Zip<I, J::IntoIter>> {
        Serial(self.0.zip(other))
    }

    pub(crate) fn filter<F: Fn(&I::Item) -> bool>(self, keep: F) -> Serial<Filter<I, F>> {
        Serial(self.0.filter(keep))
    }

    pub(crate) fn map<R, F: Fn(I::Item) -> R>(self, f: F) -> Serial<Map<I, F>> {
        Serial(self.0.map(f))
    }

    pub(crate) fn filter_map<R, F: Fn(I::Item) -> Option<R>>(
        self,
        f: F,
    ) -> Serial<FilterMap<I, F>> {
        Serial(self.0.filter_map(f))
    }

    pub(crate) fn flat_map_iter<R: IntoIterator, F: Fn(I::Item) -> R>(
        self,
        f: F,
    ) -> Serial<FlatMap<I, R, F>> {
        Serial(self.0.flat_map(f))
    }

    pub(crate) fn map_init<S, R>(
        self,
        init: impl Fn() -> S,
        f: impl Fn(&mut S, I::Item) -> R,
    ) -> Serial<impl Iterator<Item = R>> {
        let mut state = init();
        Serial(self.0.map(move |item| f(&mut state, item)))
    }

    pub(crate) fn all(mut self, f: impl Fn(I::Item) -> bool) -> bool {
        self.0.all(f)
    }

    pub(crate) fn count(self) -> usize {
        self.0.count()
    }

    pub(crate) fn for_each(self, f: impl Fn(I::Item)) {
        self.0.for_each(f);
    }

    pub(crate) fn for_each_init<S>(self, init: impl Fn() -> S, f: impl Fn(&mut S, I::Item)) {
        let mut state = init();
        self.0.for_each(|item| f(&mut state, item));
    }

    /// One result for each thread, so one.
    pub(crate) fn fold<S>(
        self,
        new: impl Fn() -> S,
        f: impl Fn(S, I::Item) -> S,
    ) -> Serial<Once<S>> {
        Serial(core::iter::once(self.0.fold(new(), f)))
    }

    pub(crate) fn reduce(
        self,
        new: impl Fn() -> I::Item,
        f: impl Fn(I::Item, I::Item) -> I::Item,
    ) -> I::Item {
        self.0.fold(new(), f)
    }

    pub(crate) fn collect<C: FromIterator<I::Item>>(self) -> C {
        self.0.collect()
    }
}
