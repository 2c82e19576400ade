//! The steps along all lines, for renderings of other emissions.

use super::{LosOptions, Steps, StepsTaken};
use crate::energy::EnergyAxis;
use crate::error::OptionError;
use crate::exchange::MethodError;
use crate::meter::Meter;
use crate::tile::Tile;

/// The steps along all lines of all tiles.
#[derive(Debug)]
pub(super) struct LinesStart {
    /// Height and width of each tile.
    shapes: Vec<[usize; 2]>,
    axis: Option<EnergyAxis>,
    /// The number of lines for each pixel is its square.
    per_side: usize,
    /// For each tile, the steps at one energy after the other.
    of_tiles: Vec<Vec<StepsTaken>>,
}

impl LinesStart {
    /// No steps yet.
    pub(super) fn new(tiles: &[Tile<'_>], axis: Option<&EnergyAxis>, options: &LosOptions) -> Self {
        Self {
            shapes: tiles.iter().map(|tile| tile.shape).collect(),
            axis: axis.copied(),
            per_side: options.lines,
            of_tiles: vec![Vec::new(); tiles.len()],
        }
    }

    /// Adds the steps at the next energy of a tile.
    pub(super) fn add(&mut self, tile: usize, mut steps: StepsTaken) {
        if let StepsTaken::Adaptive(panels) = &mut steps {
            panels.sort_by(|a, b| a.0.cmp(&b.0).then(a.1[0].total_cmp(&b.1[0])));
        }
        self.of_tiles[tile].push(steps);
    }

    /// The steps that a rendering begins with, if those of its mesh are of the same lines.
    pub(super) fn of<'a>(
        meter: &'a Meter,
        tiles: &[Tile<'_>],
        axis: Option<&EnergyAxis>,
        options: &LosOptions,
    ) -> Result<Option<&'a Self>, MethodError> {
        let Some(start) = meter.start() else { return Ok(None) };
        let of_lines = start.structure.as_ref().and_then(|structure| structure.of_method());
        let found = of_lines.filter(|of: &&Self| of.serves(tiles, axis, options));
        if start.is_fixed && found.is_none() {
            return Err(OptionError::FixedMesh.into());
        }
        Ok(found)
    }

    fn serves(&self, tiles: &[Tile<'_>], axis: Option<&EnergyAxis>, options: &LosOptions) -> bool {
        let are_alike = |steps: &StepsTaken| match (steps, options.steps) {
            (StepsTaken::Fixed(number), Steps::Fixed(of_options)) => *number == of_options,
            (StepsTaken::Adaptive(_), Steps::Adaptive(_)) => true,
            _ => false,
        };
        self.shapes.iter().copied().eq(tiles.iter().map(|tile| tile.shape))
            && self.axis.as_ref() == axis
            && self.per_side == options.lines
            && self.of_tiles.iter().flatten().all(are_alike)
    }

    /// The panels at an energy of a tile, by its number in the order of the bins, line after line.
    pub(super) fn panels(&self, tile: usize, energy: usize) -> Option<&[(usize, [f64; 2])]> {
        match self.of_tiles.get(tile)?.get(energy)? {
            StepsTaken::Adaptive(panels) => Some(panels),
            StepsTaken::Fixed(_) => None,
        }
    }
}
