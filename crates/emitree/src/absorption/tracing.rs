//! The integration of κ along parts of lines, in batches of all lines that need it.

use super::Absorption;
use super::jumps::Bracket;
use super::panels::{NODES, Panel};
use super::traced::Traced;
use crate::calls::Calls;
use crate::erased::AnyError;
use crate::error::RenderError;
use crate::exchange::Batch;
use crate::projection::path::{Path, Paths};
use crate::projection::{MappedPoint, Projection};

/// The error allowed in a panel, as a share of that of its line: only panels with kinks have errors of about
/// this size when they are no longer halved, and a line has few of them.
const SHARE_OF_PANEL: f64 = 0.125;
/// Panels of a line at the start: κ has 64 samples at the least, so that no layer is stepped over that is
/// thicker than a fortieth of the line.
const FIRST_PANELS: usize = 4;
/// Panels of one request, at most.
const PANELS_AT_ONCE: usize = 1 << 14;

/// A part of a line, by their numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct PartOfLine {
    pub(super) line: usize,
    pub(super) part: usize,
}

/// A panel whose samples are missing.
type Waiting = (PartOfLine, [f64; 2]);

/// What κ is integrated with.
pub(super) struct Tracing<'a, 'b> {
    pub(super) absorption: &'a mut Absorption,
    pub(super) calls: &'a Calls<'b>,
    pub(super) paths: Paths<'a>,
    pub(super) projection: &'a dyn Projection,
}

impl Tracing<'_, '_> {
    /// Integrates κ along these parts and those in front of them, as far as they are not known yet.
    pub(super) fn trace(
        &mut self,
        mut needed: Vec<PartOfLine>,
    ) -> Result<(), RenderError<AnyError>> {
        needed.sort_unstable();
        let lines = &self.absorption.lines;
        let of_line = |of: &[PartOfLine]| {
            let (line, last) = (of[0].line, of[of.len() - 1].part);
            (lines[line].known()..=last).map(move |part| PartOfLine { line, part })
        };
        let parts: Vec<PartOfLine> =
            needed.chunk_by(|a, b| a.line == b.line).flat_map(of_line).collect();
        let is_gap = |of: &PartOfLine| lines[of.line].path.is_inside_body(of.part);
        let (gaps, seen): (Vec<PartOfLine>, Vec<PartOfLine>) =
            parts.iter().copied().partition(is_gap);
        let mut panels = self.panels(&seen)?.into_iter().peekable();
        let mut depths = self.gaps(&gaps)?.into_iter();
        for of in parts {
            let line = &mut self.absorption.lines[of.line];
            if line.path.is_inside_body(of.part) {
                line.push_gap(depths.next().unwrap_or_default());
                continue;
            }
            let of_part = core::iter::from_fn(|| panels.next_if(|(other, _)| *other == of));
            line.push_panels(of_part.map(|(_, panel)| panel).collect());
            let error = line.error + self.absorption.model.as_ref().map_or(0.0, |of| of.error);
            self.absorption.error = self.absorption.error.max(error);
        }
        Ok(())
    }

    /// The panels of some parts in which κ is resolved, in the order of the parts.
    fn panels(
        &self,
        parts: &[PartOfLine],
    ) -> Result<Vec<(PartOfLine, Panel)>, RenderError<AnyError>> {
        let allowed = SHARE_OF_PANEL * self.absorption.tolerance;
        let first = |of: &PartOfLine| {
            let of = *of;
            let count = first_panels(&self.absorption.lines[of.line].path);
            let at = move |k: usize| k as f64 / count as f64;
            (0..count).map(move |k| (of, [at(k), at(k + 1)]))
        };
        let mut waiting: Vec<Waiting> = parts.iter().flat_map(first).collect();
        let mut resolved = Vec::with_capacity(waiting.len());
        while !waiting.is_empty() {
            let mut unresolved = Vec::new();
            for some in waiting.chunks(PANELS_AT_ONCE) {
                let values = self.values(some.iter().flat_map(|waiting| self.nodes(waiting)))?;
                for (&(of, ends), values) in some.iter().zip(values.chunks_exact(NODES)) {
                    let panel = self.absorption.rule.panel(ends, values);
                    if panel.is_resolved(allowed) {
                        resolved.push((of, panel));
                    } else {
                        let nodes: Vec<f64> = self.nodes(&(of, ends)).map(|(_, z)| z).collect();
                        unresolved.push((of, ends, Bracket::steepest(&nodes, values)));
                    }
                }
            }
            self.close_in(&mut unresolved, allowed)?;
            let parts = unresolved.iter().flat_map(|(of, [from, to], bracket)| {
                let border = bracket.jump().unwrap_or(0.5 * (from + to));
                [(*of, [*from, border]), (*of, [border, *to])]
            });
            waiting = parts.collect();
        }
        resolved.sort_by(|(of, panel), (other_of, other)| {
            of.cmp(other_of).then(panel.ends[0].total_cmp(&other.ends[0]))
        });
        Ok(resolved)
    }

    fn nodes(&self, &(of, [from, to]): &Waiting) -> impl Iterator<Item = (PartOfLine, f64)> {
        self.absorption.rule.nodes.iter().map(move |node| (of, from + node * (to - from)))
    }

    /// Halves the brackets of jumps until those are known well enough, and those of slopes until they are
    /// known to be slopes.
    fn close_in(
        &self,
        brackets: &mut [(PartOfLine, [f64; 2], Bracket)],
        allowed: f64,
    ) -> Result<(), RenderError<AnyError>> {
        loop {
            let mut open: Vec<&mut (PartOfLine, [f64; 2], Bracket)> =
                brackets.iter_mut().filter(|(_, _, bracket)| bracket.is_open(allowed)).collect();
            if open.is_empty() {
                return Ok(());
            }
            let middles = open.iter().map(|(of, _, bracket)| (*of, bracket.middle()));
            let values = self.values(middles.collect::<Vec<_>>().into_iter())?;
            open.iter_mut().zip(values).for_each(|((_, _, bracket), value)| bracket.halve(value));
        }
    }

    /// The optical depths of parts inside of opaque bodies, between κ at both ends: points behind a body continue
    /// those beside its limb, for pixels that see the latter.
    fn gaps(&self, gaps: &[PartOfLine]) -> Result<Vec<f64>, RenderError<AnyError>> {
        let lines = &self.absorption.lines;
        let ends = |of: &PartOfLine| {
            let PartOfLine { line, part } = *of;
            let before = part.checked_sub(1).map(|part| (PartOfLine { line, part }, 1.0));
            let behind = (part + 1 < lines[line].path.parts())
                .then_some((PartOfLine { line, part: part + 1 }, 0.0));
            [before.or(behind), behind.or(before)]
        };
        let coefficients = self.coefficients(gaps.iter().flat_map(ends).flatten())?;
        let mut coefficients = coefficients.into_iter();
        let depth = |of: &PartOfLine| {
            let known = ends(of).into_iter().flatten().count();
            let sum: f64 =
                coefficients.by_ref().take(known).map(|(coefficient, _)| coefficient).sum();
            0.5 * sum * lines[of.line].path.length(of.part)
        };
        Ok(gaps.iter().map(depth).collect())
    }

    /// κ ds/dz at these places.
    fn values(
        &self,
        places: impl Iterator<Item = (PartOfLine, f64)>,
    ) -> Result<Vec<f64>, RenderError<AnyError>> {
        let found = self.coefficients(places)?;
        Ok(found.into_iter().map(|(coefficient, weight)| coefficient * weight).collect())
    }

    /// κ and ds/dz at these places; where ds/dz is 0 κ is not evaluated, and 0.
    fn coefficients(
        &self,
        places: impl Iterator<Item = (PartOfLine, f64)>,
    ) -> Result<Vec<(f64, f64)>, RenderError<AnyError>> {
        let (mut batch, mut weights) = (Batch::default(), Vec::new());
        for (PartOfLine { line, part }, z) in places {
            let Traced { path, energy, .. } = &self.absorption.lines[line];
            let MappedPoint { position, direction, path_per_depth } =
                self.paths.point(path, part, z);
            weights.push(path_per_depth);
            if path_per_depth != 0.0 {
                batch.positions.push(position);
                batch.directions.push(direction);
                batch.energies.extend(energy);
            }
        }
        match &self.absorption.model {
            Some(model) => {
                batch.rates = model.coefficients(self.projection, &batch.positions);
            }
            None => {
                batch.rates.resize(batch.len(), 0.0);
                self.calls.absorption_coefficients(&mut batch)?;
            }
        }
        let mut coefficients = batch.rates.into_iter();
        let with_weight = |weight: f64| {
            let is_seen = weight != 0.0;
            (if is_seen { coefficients.next().unwrap_or_default() } else { 0.0 }, weight)
        };
        Ok(weights.into_iter().map(with_weight).collect())
    }
}

/// Panels of each part of a line at the start.
fn first_panels(path: &Path) -> usize {
    FIRST_PANELS.div_ceil(path.parts().max(1)).max(2)
}
