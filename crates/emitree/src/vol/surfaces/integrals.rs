//! Integrals of polynomials along many lines: those of one polynomial are found side by side.
//!
//! The lines of a pixel pass the same few polynomials one after the other. So the terms of all lines are
//! collected first, with the order in which they add up, and then each polynomial is integrated on all of its
//! lines.

use crate::vol::surfaces::polynomial::{LANES, Lanes, Polynomial, integrate};

/// The integral of one polynomial along a part of a line.
#[derive(Clone, Copy, Debug)]
struct Term {
    /// The value and its error.
    sum: [f64; 2],
    /// How often the last two sums become one after it.
    additions: usize,
}

/// A polynomial with the terms that it has.
#[derive(Debug)]
struct Group<'a> {
    polynomial: &'a Polynomial,
    /// For each of its terms x, y and both ends along z, and the number of the term.
    parts: Vec<([f64; 4], usize)>,
}

/// Lines of sight with the polynomials on them.
#[derive(Debug, Default)]
pub(super) struct Integrals<'a> {
    terms: Vec<Term>,
    /// For each line the number of terms up to its end, and the error that it has besides theirs.
    lines: Vec<(usize, f64)>,
    groups: Vec<Group<'a>>,
    /// The group of the last term: the next is likely to be of that which followed it on the line before.
    last: usize,
}

impl<'a> Integrals<'a> {
    /// Adds a polynomial on a part of the present line.
    pub(super) fn add(&mut self, of: &'a Polynomial, [x, y]: [f64; 2], [from, to]: [f64; 2]) {
        let part = ([x, y, from, to], self.terms.len());
        self.terms.push(Term { sum: [0.0, (to - from) * of.error], additions: 0 });
        let count = self.groups.len();
        let mut turns = (1..=count).map(|step| (self.last + step) % count);
        let known = turns.find(|&group| core::ptr::eq(self.groups[group].polynomial, of));
        self.last = known.unwrap_or(count);
        match self.groups.get_mut(self.last) {
            Some(group) => group.parts.push(part),
            None => self.groups.push(Group { polynomial: of, parts: vec![part] }),
        }
    }

    /// After the last term, the last two sums become one.
    pub(super) fn add_up(&mut self) {
        if let Some(term) = self.terms.last_mut() {
            term.additions += 1;
        }
    }

    /// Ends the present line, with an error that it has besides those of its terms.
    pub(super) fn end_line(&mut self, error: f64) {
        self.lines.push((self.terms.len(), error));
    }

    /// The sums of all lines with their errors, in their order. None of them is left.
    pub(super) fn take(&mut self) -> Vec<[f64; 2]> {
        for group in &mut self.groups {
            for parts in group.parts.chunks(LANES) {
                // Lanes without a line repeat the first.
                let mut ends = [[0.0; LANES]; 4];
                for lane in 0..LANES {
                    let (part, _) = parts.get(lane).unwrap_or(&parts[0]);
                    (0..4).for_each(|k| ends[k][lane] = part[k]);
                }
                let [x, y, from, to] = &ends;
                let mut integrals: Lanes = [0.0; LANES];
                integrate(group.polynomial, x, y, from, to, &mut integrals);
                for ((_, term), integral) in parts.iter().zip(integrals) {
                    self.terms[*term].sum[0] = integral;
                }
            }
            group.parts.clear();
        }
        let mut first = 0;
        let mut open: Vec<[f64; 2]> = Vec::new();
        let of_line = |&(end, error): &(usize, f64)| {
            open.push([0.0, error]);
            for term in &self.terms[first..end] {
                open.push(term.sum);
                for _ in 0..term.additions {
                    let [value, error] = open.pop().unwrap_or_default();
                    if let Some(before) = open.last_mut() {
                        *before = [before[0] + value, before[1] + error];
                    }
                }
            }
            first = end;
            open.pop().unwrap_or_default()
        };
        let sums = self.lines.iter().map(of_line).collect();
        self.terms.clear();
        self.lines.clear();
        sums
    }
}
