//! What image trees leave for renderings of other emissions: the places of their nodes, and the depths of
//! each line with their weights.

use crate::energy::EnergyAxis;
use crate::vol::dyadic::Place;
use crate::vol::image::block::Block;
use crate::vol::line::node_lines::{LineSource, Wanted};
use crate::vol::rule::scan::Scan;
use crate::vol::sampling::Stop;
use crate::vol::spectrum::energies::Energies;
use crate::vol::view::part::ProductImage;
use crate::vol::view::sheet::{Sheet, SheetId};

/// The image trees of a view, without values.
#[derive(Clone, Debug)]
pub(crate) struct TreeStart {
    /// The energy axis of a cube.
    pub(crate) axis: Option<EnergyAxis>,
    pub(crate) energies: Energies,
    /// In the order of the engine: all parts at the first energy, then all at the second, and so on.
    pub(crate) sheets: Vec<SheetStart>,
}

/// One image tree, without values.
#[derive(Clone, Debug)]
pub(crate) struct SheetStart {
    pub(crate) id: SheetId,
    base_level: u8,
    depth_level: u8,
    /// The order of the predictions.
    order: usize,
    tracks_jumps: bool,
    /// The number of scattered lines that verified it: those of another emission come after them.
    scattered: usize,
    nodes: Vec<Place>,
    lines: Vec<LineStart>,
    /// The depths of each depth rule with their weights.
    rules: Vec<Vec<(u32, f64)>>,
}

/// The line of a node.
#[derive(Clone, Debug)]
enum LineStart {
    /// Depths with their weights.
    Full(Vec<(u32, f64)>),
    /// The number of its rule, and the block that this one is for.
    Rule(usize, Block),
}

impl TreeStart {
    /// The number of depths of all lines.
    pub(crate) fn samples(&self) -> usize {
        let of_line = |sheet: &SheetStart, line: &LineStart| match line {
            LineStart::Full(depths) => depths.len(),
            LineStart::Rule(rule, _) => sheet.rules[*rule].len(),
        };
        let of_sheet =
            |sheet: &SheetStart| sheet.lines.iter().map(|line| of_line(sheet, line)).sum::<usize>();
        self.sheets.iter().map(of_sheet).sum()
    }

    /// Whether its trees are those of the parts without products.
    pub(crate) fn is_of(&self, products: &[Option<ProductImage>]) -> bool {
        let of_parts = products.iter().enumerate().filter(|(_, of_part)| of_part.is_none());
        let mut parts = of_parts.map(|(part, _)| part);
        parts.clone().count() * self.energies.len() == self.sheets.len()
            && parts.all(|part| self.has_part(part))
    }

    /// Whether it has a tree of a part, at each energy.
    pub(crate) fn has_part(&self, part: usize) -> bool {
        self.sheets.iter().filter(|sheet| sheet.id.part == part).count() == self.energies.len()
    }
}

impl SheetStart {
    /// That of a finished sheet.
    pub(crate) fn of(sheet: &Sheet<'_>) -> Self {
        let Scan { base_level, depth_level, tree, node_lines, .. } = &sheet.scan;
        let line = |(i, source): (usize, &LineSource)| match source {
            LineSource::Rule { block, rule, .. } => LineStart::Rule(*rule, *block),
            LineSource::Full | LineSource::Unknown => LineStart::Full(node_lines.weights(i)),
        };
        Self {
            id: sheet.id,
            base_level: *base_level,
            depth_level: *depth_level,
            order: tree.order(),
            tracks_jumps: node_lines.tracks_jumps,
            scattered: sheet.verification.scattered,
            nodes: tree.nodes().iter().map(|node| node.place).collect(),
            lines: node_lines.sources.iter().enumerate().map(line).collect(),
            rules: node_lines.rules.clone(),
        }
    }
}

impl Sheet<'_> {
    /// Samples all depths of another tree, in one batch. If `is_fixed` the integrals are those with its
    /// weights.
    pub(crate) async fn sample_start(
        &mut self,
        start: &SheetStart,
        is_fixed: bool,
    ) -> Result<(), Stop> {
        self.verification.scattered = start.scattered;
        let scan = &mut self.scan;
        (scan.base_level, scan.depth_level) = (start.base_level, start.depth_level);
        scan.tree.set_order(start.order);
        scan.add(&start.nodes);
        scan.node_lines.tracks_jumps = start.tracks_jumps;
        scan.node_lines.rules.clone_from(&start.rules);
        let mut wanted: Wanted = Vec::with_capacity(start.lines.len());
        for (i, line) in start.lines.iter().enumerate() {
            let (source, weighted) = match line {
                LineStart::Full(weighted) => (LineSource::Full, weighted),
                LineStart::Rule(rule, block) => {
                    let source = LineSource::Rule { block: *block, error: 0.0, rule: *rule };
                    (source, &start.rules[*rule])
                }
            };
            scan.node_lines.sources[i] = source;
            wanted.push((i, weighted.iter().map(|(depth, _)| *depth).collect()));
        }
        if is_fixed {
            let fixed = |line: &LineStart| match line {
                LineStart::Full(weighted) => weighted.clone(),
                LineStart::Rule(..) => Vec::new(),
            };
            scan.node_lines.fixed = start.lines.iter().map(fixed).collect();
        }
        let Scan { view, tree, node_lines, .. } = scan;
        node_lines.sample(view, tree, &wanted).await?;
        scan.node_lines.integrate_all();
        Ok(())
    }
}
